"""Corners inside one solid that were formed, not welded: bends of a sheet, and roots of rolled or drawn profiles."""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import edge_lengths, evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.built_up import SAME_THICKNESS, way_out

THICKEST_BEND_MM = 6.5
"""Thicker sheets than 1/4 in are rarely bent to a sharp corner; two plates of one thickness that meet there may be
welded."""
THICKEST_COLLAR_MM = 4.0  #: Round a hole, a collar is drawn from sheets up to this; a thicker one is a piece of tube.
MOULDED_MM = 3.0  #: Walls of moulded cases are up to this thick.
FOLDS = 3  #: Along so many edges that meet, no sheet is folded.
BEND_STEP_MM = 0.5  #: Distance from an edge, and beyond an outer corner, at which the material is felt.
FULL = 0.35  #: A bend is full from so far inside its outer corner on, which may be round; a prepared groove is deeper.
BEND_ENDS = (-0.5, 0.5, 1.5, 2.5)
"""Where the sides of a tube are felt: beyond the end of its inner corner, in thicknesses; the tube may have rounds."""
BEND_KINDS = (CurveKind.LINE, CurveKind.CIRCLE)
"""Along such curves sheets are bent, and collars drawn. Where a tube opens into another one of the same thickness, its
wall goes over into the other one as that of a bent sheet does, but along neither."""


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
    bent = np.isin(graph.edge_kind[edges], BEND_KINDS) & (thick[0] <= most_mm)
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


def are_inside(graph: BrepGraph, trimmed: TrimmedFaces, solid: IntArray, points: FloatArray) -> BoolArray:
    """Tell which points (k, 3) are inside a solid, one solid per point, shape (k,)."""
    inside = np.zeros(len(points), dtype=bool)
    point, around = find_solids_around(ExactMaterial(graph, trimmed), points)
    inside[point[around == solid[point]]] = True
    return inside
