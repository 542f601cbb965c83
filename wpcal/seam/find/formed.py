"""Corners inside one solid that were formed or cut, not welded: bends of a sheet, corners of cuts through a wall."""

from __future__ import annotations

import numpy as np

from wpcal.brep.concavity import are_concave, inner_edges
from wpcal.brep.curves import edge_lengths, evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.built_up import SAME_THICKNESS, sampled_surface, way_out

THICKEST_BEND_MM = 6.5
"""Thicker sheets than 1/4 in are rarely bent to a sharp corner; two plates of one thickness that meet there may be
welded."""
THICKEST_COLLAR_MM = 4.0  #: Round a hole, a collar is drawn from sheets up to this; a thicker one is a piece of tube.
MOULDED_MM = 3.0  #: Walls of moulded cases are up to this thick.
CUT, CUT_COS = 0.5, 0.9
"""A wall that was cut is thinner than this share of its width; the corners of the cut are square to it within 25
degrees."""
FOLDS = 3  #: Along this many edges that meet, no sheet is folded.
BEND_STEP_MM = 0.5  #: Distance from an edge, and beyond an outer corner, at which the material is felt.
FULL = 0.35  #: A bend is full from this far inside its outer corner on, which may be round; a groove is deeper.
BEND_ENDS = (-0.5, 0.5, 1.5, 2.5)
"""Where the sides of a tube are felt: beyond the end of its inner corner, in thicknesses; the tube may have rounds."""
ARC_RAD = 1e-3  #: Arcs are a quarter or a whole circle within this.
BEND_KINDS = (CurveKind.LINE, CurveKind.CIRCLE)
"""Along such curves sheets are bent, and collars drawn. Where a tube opens into another one of the same thickness, its
wall goes over into the other one as that of a bent sheet does, but along neither. An arc is a corner of a tray, up to a
quarter, or a whole circle: along another one, a sheet meets the edge of a plate."""


def are_bends(graph: BrepGraph, trimmed: TrimmedFaces, edges: IntArray) -> BoolArray:
    """Tell which concave edges are the inner corner of one bent sheet.

    The edge is straight or round: the end of a tube on another one is neither. The material behind both faces has one
    thickness t of at most `THICKEST_BEND_MM`, or `THICKEST_COLLAR_MM` along a circle. Beyond the outer corner, where
    the two outer faces meet, there is nothing: not at the middle, and not at the ends, where a tube would have its
    sides; and the corner is full. No sheet is folded along three edges that meet: a solid with such a corner and walls
    thicker than moulded ones is a box of plates.

    `edges`: shape (k,). Concave edges between two faces of one solid.
    """
    low, high = graph.edge_range[edges].T
    p, slope = evaluate_edges(graph, edges, (low + high) / 2)
    x = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    n = [project_to_faces(graph, graph.edge_faces[edges, k], p).normal for k in (0, 1)]
    cos = np.einsum("ki,ki->k", n[0], n[1])[:, None]
    away = [n[1] - cos * n[0], n[0] - cos * n[1]]  # on each face, away from the edge
    away = [way / np.linalg.norm(way, axis=1, keepdims=True) for way in away]
    solid = graph.face_solid[graph.edge_faces[edges, 0]]
    thick = [
        way_out(graph, trimmed, solid, p + BEND_STEP_MM * (away[k] - n[k]), -n[k])[0] + BEND_STEP_MM for k in (0, 1)
    ]
    thick = [np.where(np.isfinite(own), own, np.nan) for own in thick]  # open surfaces of damaged files have none
    most_mm = np.where(graph.edge_kind[edges] == CurveKind.LINE, THICKEST_BEND_MM, THICKEST_COLLAR_MM)
    is_long_arc = (high - low > np.pi / 2 + ARC_RAD) & (high - low < 2.0 * np.pi - ARC_RAD)
    bent = np.isin(graph.edge_kind[edges], BEND_KINDS) & (thick[0] <= most_mm)
    bent &= ~((graph.edge_kind[edges] == CurveKind.CIRCLE) & is_long_arc)
    bent &= np.abs(thick[1] - thick[0]) <= SAME_THICKNESS * thick[0]
    rows = np.flatnonzero(bent)
    t, half = thick[0][rows, None], edge_lengths(graph)[edges[rows], None] / 2
    corner = p[rows] - t * (n[0] + n[1])[rows] / (1.0 + cos[rows])
    sin = np.sqrt(1.0 - cos[rows] ** 2)
    past = (t / 2 * cos[rows] + BEND_STEP_MM) / sin  # from the middle of one side until it is out of the other one
    bent[rows] &= are_inside(graph, trimmed, solid[rows], corner + FULL * (p[rows] - corner))
    for k in (0, 1):
        beyond = corner + t / 2 * n[1 - k][rows] - past * away[1 - k][rows]
        for along in (0.0 * half, *(sign * (half + share * t) for sign in (-1.0, 1.0) for share in BEND_ENDS)):
            bent[rows] &= ~are_inside(graph, trimmed, solid[rows], beyond + along * x[rows])
    folds = np.unique(edges[bent & (thick[0] > MOULDED_MM)])
    meeting = np.bincount(graph.edge_vertices[folds].ravel(), minlength=1)
    corners = np.flatnonzero(meeting >= FOLDS)
    boxes = solid[np.isin(graph.edge_vertices[edges], corners).any(axis=1)]
    return np.asarray(bent & ~np.isin(solid, boxes))


def is_cut(
    graph: BrepGraph, trimmed: TrimmedFaces, sides: tuple[int, int], middle: FloatArray, way: FloatArray
) -> bool:
    """Tell whether an inner corner, sharp or round, is that of a cut through a wall: a notch, a slot, a coped end.

    Such a corner runs across the wall, from one side to the other, and no other inner corner meets it at its ends. The
    two sides of the wall are much wider than it is thick: a strip on edge is not a wall, nor is a bar that bulges at
    both.

    `sides`: The faces beside the corner, of one solid.
    `middle`, `way`: shape (3,). The middle of the corner, in `part`, mm, and the direction along it.
    """
    solid = int(graph.face_solid[sides[0]])
    inner = inner_edges(graph, np.arange(len(graph.solid_names)) == solid)
    edge = _edge_between(graph, inner, sides, middle, way)
    if edge is None:
        return False
    ends = [_face_at(graph, inner, edge, vertex) for vertex in graph.edge_vertices[edge].tolist()]
    if None in ends:
        return False
    walls, p = np.array(ends), graph.vertex_p[graph.edge_vertices[edge]]
    is_bar = ((graph.face_kind[walls] != SurfaceKind.PLANE) & (graph.face_outward[walls] > 0)).all()
    along = p[1] - p[0]
    cos = project_to_faces(graph, walls, p).normal @ along / np.linalg.norm(along)
    surface = sampled_surface(graph, trimmed, solid)
    area_mm2 = np.bincount(surface.face, minlength=graph.face_count)[walls] * surface.mm2
    around = [edge_lengths(graph)[inner[(graph.edge_faces[inner] == face).any(axis=1)]].sum() for face in ends]
    is_wall = np.linalg.norm(along) <= CUT * np.min(2.0 * area_mm2 / around)
    return bool(is_wall and not is_bar and cos[0] < -CUT_COS and cos[1] > CUT_COS)


def _edge_between(
    graph: BrepGraph, inner: IntArray, sides: tuple[int, int], middle: FloatArray, way: FloatArray
) -> int | None:
    """Return the nearest straight edge between two faces, or beside a round between them, that runs along a way."""
    wall, base = (set(graph.edge_faces[inner[(graph.edge_faces[inner] == side).any(axis=1)]].ravel()) for side in sides)
    hollow = (graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward < 0)
    others = [sides[1], *(face for face in wall & base if hollow[face] and face not in sides)]
    pairs = graph.edge_faces[inner]
    own = inner[(pairs == sides[0]).any(axis=1) & np.isin(pairs, others).any(axis=1)]
    own = own[graph.edge_kind[own] == CurveKind.LINE]
    p = graph.vertex_p[graph.edge_vertices[own]]
    along = p[:, 1] - p[:, 0]
    is_along = np.abs(along @ way) > CUT_COS * np.maximum(np.linalg.norm(along, axis=1), BEND_STEP_MM)
    own, p = own[is_along], p[is_along]
    return int(own[np.argmin(np.linalg.norm(p.mean(axis=1) - middle, axis=1))]) if len(own) else None


def _face_at(graph: BrepGraph, inner: IntArray, edge: int, vertex: int) -> int | None:
    """Return the only other face at one end of an edge; None if there are more, or another inner corner."""
    at = inner[(graph.edge_vertices[inner] == vertex).any(axis=1) & (inner != edge)]
    others = set(graph.edge_faces[at].ravel().tolist()) - set(graph.edge_faces[edge].tolist())
    return others.pop() if len(others) == 1 and not are_concave(graph, at).any() else None


def are_inside(graph: BrepGraph, trimmed: TrimmedFaces, solid: IntArray, points: FloatArray) -> BoolArray:
    """Tell which points (k, 3) are inside a solid, one solid per point, shape (k,)."""
    inside = np.zeros(len(points), dtype=bool)
    point, around = find_solids_around(ExactMaterial(graph, trimmed), points)
    inside[point[around == solid[point]]] = True
    return inside
