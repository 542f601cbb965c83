"""Slots: two half-round hollow walls joined by two flat ones."""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import CurveKind, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.taught.features.columns import NAMING_MM, FeatureColumns, label_equal
from wpcal.taught.features.reference import FeatureKind
from wpcal.taught.features.walls import WallEnds, Walls

HALF_TURN_SPREAD_RAD = 1e-3
"""A wall is half round if it extends half around within this: at a radius of 100 mm this is 0.1 mm."""
TANGENT_COS = 1 - 1e-6
"""Faces continue each other if their normals differ by less than 0.08 degrees: CAD systems model tangents to 1e-6."""


def find_slots(walls: Walls) -> FeatureColumns:
    """Find the slots with round ends.

    The point is the middle of the entry, and the direction points out of it. The diameter is the width; the length is
    the overall length.
    """
    graph = walls.coaxial.graph
    first, second, planes = _pairs(walls)
    body_of_face = np.full(graph.face_count, -1, dtype=np.int64)
    number = np.full(len(walls.first) + 1, -1, dtype=np.int64)
    number[first] = number[second] = np.arange(len(first))
    body_of_face[:] = number[walls.of_face]  # -1, no wall, is the last
    body_of_face[planes[:, 0]] = body_of_face[planes[:, 1]] = np.arange(len(first))
    axis = walls.axis[first]
    ends = WallEnds.of(graph, body_of_face, axis)
    below, above = ends.is_open()
    is_upper = above | ~below
    height = np.where(is_upper, ends.high, ends.low)
    apart = walls.foot[second] - walls.foot[first]
    faces = np.flatnonzero(body_of_face >= 0)
    return FeatureColumns(
        kind=FeatureKind.SLOT,
        p=(walls.foot[first] + walls.foot[second]) / 2 + height[:, None] * axis,
        solid=walls.solid[first],
        direction=np.where(is_upper, 1.0, -1.0)[:, None] * axis,
        diameter_mm=2.0 * walls.radius[first],
        length_mm=np.linalg.norm(apart, axis=1) + 2.0 * walls.radius[first],
        depth_mm=ends.high - ends.low,
        is_through=below & above,
        faces=[faces[body_of_face[faces] == k] for k in range(len(first))],
    )


def _pairs(walls: Walls) -> tuple[IntArray, IntArray, IntArray]:
    """Return the two round walls and the two plane faces, shape (n, 2), of every slot."""
    graph, ends = walls.coaxial.graph, walls.ends
    half = np.abs(walls.turn - np.pi) <= HALF_TURN_SPREAD_RAD
    rows = ends.is_border & (ends.beyond >= 0) & half[ends.body] & walls.is_hollow[ends.body]
    rows &= (graph.edge_kind[ends.edge] == CurveKind.LINE) & (graph.face_kind[ends.beyond] == SurfaceKind.PLANE)
    row = np.flatnonzero(rows)
    row = row[_is_tangent(walls, row)]
    wall, plane = np.unique(np.column_stack([ends.body[row], ends.beyond[row]]), axis=0).T
    two = np.flatnonzero((np.diff(wall) == 0) & (np.bincount(wall, minlength=1)[wall[:-1]] == 2))
    sides = np.column_stack([plane[two], plane[two + 1]])
    key = label_equal(sides, np.round(walls.radius[wall[two]] / NAMING_MM))
    order = np.argsort(key, kind="stable")
    at = np.flatnonzero((np.diff(key[order]) == 0) & (np.bincount(key, minlength=1)[key[order[:-1]]] == 2))
    first = two[order[at]]
    return wall[first], wall[two[order[at + 1]]], sides[order[at]]


def _is_tangent(walls: Walls, rows: IntArray) -> BoolArray:
    """Tell at which rows of the walls' ends the face beyond continues the wall."""
    graph, ends = walls.coaxial.graph, walls.ends
    edge, axis = ends.edge[rows], walls.axis[ends.body[rows]]
    p = evaluate_edges(graph, edge, graph.edge_range[edge].mean(axis=1))[0]
    inward = walls.foot[ends.body[rows]] - p
    inward -= np.einsum("ki,ki->k", inward, axis)[:, None] * axis
    normal: FloatArray = project_to_faces(graph, ends.beyond[rows], p).normal
    cos = np.einsum("ki,ki->k", inward, normal) / walls.radius[ends.body[rows]]
    return np.asarray(cos > TANGENT_COS)
