"""Strips of solids: hollow faces that run smoothly into two other faces at an angle, as beads and rounds do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.concavity import LEAST_TURN_SIN
from wpcal.brep.curves import edge_lengths, evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import BoolArray
from wpcal.seam.limits import LEAST_SEAM_MM

WIDEST_MM = 30.0  #: Largest width of the face of a bead: a fillet with 20 mm legs, laid in many runs, is 28 mm wide.
LEAST_CORNER_COS = 0.87
"""Faces beside a strip at an angle of less than 30 degrees are one bent sheet, not two members."""
STRIPS = (SurfaceKind.CYLINDER, SurfaceKind.TORUS, SurfaceKind.CONE, SurfaceKind.NURBS)
BENDS = (SurfaceKind.CYLINDER, SurfaceKind.TORUS)
SAME_AXIS_MM = 1e-3  #: The inside and the outside of a bend are about one axis within this.
ACROSS_POINTS = 513  #: Points along the other side of a strip, of which the nearest one is taken.
SAME_AXIS_SIN = 1e-6  #: Two bends are about one axis if the sine between their axes is below this.


@dataclass(frozen=True, slots=True)
class Strip:
    """A strip between two faces."""

    face: int
    sides: tuple[int, int]  #: The faces beside it.
    edges: tuple[tuple[int, ...], tuple[int, ...]]  #: The edges between the strip and each of these faces.


def find_strips(
    graph: BrepGraph, solids: BoolArray | None = None, *, min_length_mm: float = LEAST_SEAM_MM
) -> list[Strip]:
    """Find the concave strips that run smoothly into two other faces of their solid at an angle. By face.

    `solids`: shape (S,). Only these solids are searched; by default all.
    """
    edges = np.flatnonzero((graph.edge_faces >= 0).all(axis=1) & ~graph.is_seam_edge)
    edges = edges[graph.edge_kind[edges] != CurveKind.DEGENERATE]
    if solids is not None:
        edges = edges[solids[graph.edge_solid[edges]]]
    edges = edges[np.isin(graph.face_kind[graph.edge_faces[edges]], STRIPS).any(axis=1)]
    p = evaluate_edges(graph, edges, graph.edge_range[edges].mean(axis=1))[0]
    left, right = (project_to_faces(graph, graph.edge_faces[edges, k], p).normal for k in (0, 1))
    smooth = edges[np.linalg.norm(np.cross(left, right), axis=1) < LEAST_TURN_SIN]
    lengths = edge_lengths(graph)
    beside: dict[int, dict[int, list[int]]] = {}
    for edge in smooth.tolist():
        for face, other in (graph.edge_faces[edge].tolist(), graph.edge_faces[edge, ::-1].tolist()):
            if graph.face_kind[face] in STRIPS:
                beside.setdefault(face, {}).setdefault(other, []).append(edge)
    found = []
    for face, others in sorted(beside.items()):
        long = sorted(others, key=lambda other: (-float(lengths[others[other]].sum()), other))[:2]
        if len(long) == 2 and all(lengths[others[other]].sum() >= min_length_mm for other in long):
            found.append(Strip(face, (long[0], long[1]), (tuple(others[long[0]]), tuple(others[long[1]]))))
    corners = zip(found, _are_concave_corners(graph, found).tolist(), strict=True)
    return [strip for strip, is_corner in corners if is_corner and not _is_bend(graph, strip.face)]


def _is_bend(graph: BrepGraph, face: int) -> bool:
    """Tell whether a strip is the inside of a bent sheet: its solid has a larger convex face about the same axis."""
    o, z, radius = graph.face_frame[face, 0], graph.face_frame[face, 3], graph.face_param[face]
    same = (graph.face_solid == graph.face_solid[face]) & (graph.face_kind == graph.face_kind[face])
    outside = np.flatnonzero(same & (graph.face_outward > 0) & np.isin(graph.face_kind, BENDS))
    arm = graph.face_frame[outside, 0] - o
    turn = np.linalg.norm(np.cross(graph.face_frame[outside, 3], z), axis=1)
    if graph.face_kind[face] == SurfaceKind.CYLINDER:
        off = np.linalg.norm(arm - (arm @ z)[:, None] * z, axis=1)
        wider = graph.face_param[outside, 0] > radius[0]
    else:
        off = np.linalg.norm(arm, axis=1) + np.abs(graph.face_param[outside, 0] - radius[0])
        wider = graph.face_param[outside, 1] > radius[1]
    return bool(((turn <= SAME_AXIS_SIN) & (off <= SAME_AXIS_MM) & wider).any())


def _are_concave_corners(graph: BrepGraph, strips: list[Strip]) -> BoolArray:
    """Tell which strips are narrow, with sides at an angle, and their middles behind the chords across them."""
    first, second = np.array([[edges[0] for edges in strip.edges] for strip in strips], dtype=np.int64).reshape(-1, 2).T
    side = np.array([strip.sides for strip in strips], dtype=np.int64).reshape(-1, 2)
    p = evaluate_edges(graph, first, graph.edge_range[first].mean(axis=1))[0]
    at = np.linspace(graph.edge_range[second, 0], graph.edge_range[second, 1], ACROSS_POINTS, axis=1)
    across = evaluate_edges(graph, np.repeat(second, ACROSS_POINTS), at.ravel())[0].reshape(-1, ACROSS_POINTS, 3)
    nearest = np.argmin(np.linalg.norm(across - p[:, None], axis=2), axis=1)
    q = across[np.arange(len(strips)), nearest]
    n1, n2 = project_to_faces(graph, side[:, 0], p).normal, project_to_faces(graph, side[:, 1], q).normal
    middle, width = (p + q) / 2, np.linalg.norm(q - p, axis=1)
    foot = project_to_faces(graph, [strip.face for strip in strips], middle)
    behind = np.einsum("ki,ki->k", foot.p - middle, foot.normal) < 0
    at_an_angle = np.einsum("ki,ki->k", n1, n2) < LEAST_CORNER_COS
    return np.asarray(behind & (width > 0) & (width <= WIDEST_MM) & at_an_angle, dtype=bool)
