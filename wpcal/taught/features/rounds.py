"""Circular rims, holes, bosses, slots, spheres and cylinder axes."""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.taught.features.columns import (
    AXIS_ROUND,
    NAMING_MM,
    FeatureColumns,
    first_rows,
    label_equal,
    members_of,
    positive_axes,
    sums,
)
from wpcal.taught.features.reference import FeatureKind
from wpcal.taught.features.walls import FULL_TURN_RAD, Walls

HALF_TURN_RAD = np.pi - 1e-3
"""A wall that extends less than half around is a round between faces; its axis is not a datum."""


def find_circles(graph: BrepGraph) -> FeatureColumns:
    """Find the whole circles among the edges: the rims of holes, bosses and pipes."""
    arcs = np.flatnonzero((graph.edge_kind == CurveKind.CIRCLE) & (graph.edge_solid >= 0))
    centre, radius = graph.edge_frame[arcs, 0], graph.edge_param[arcs, 0]
    axis = positive_axes(graph.edge_frame[arcs, 3])
    label = label_equal(
        graph.edge_solid[arcs], np.round(centre / NAMING_MM), np.round(axis / AXIS_ROUND), np.round(radius / NAMING_MM)
    )
    first = first_rows(label)
    first = first[sums(label, np.ptp(graph.edge_range[arcs], axis=1), len(first)) >= FULL_TURN_RAD]
    return FeatureColumns(
        kind=FeatureKind.CIRCLE,
        p=centre[first],
        solid=graph.edge_solid[arcs[first]],
        direction=axis[first],
        diameter_mm=2.0 * radius[first],
    )


def find_spheres(graph: BrepGraph) -> FeatureColumns:
    """Find the spheres; faces on one sphere are one feature."""
    faces = np.flatnonzero(graph.face_kind == SurfaceKind.SPHERE)
    centre, radius = graph.face_frame[faces, 0], graph.face_param[faces, 0]
    label = label_equal(graph.face_solid[faces], np.round(centre / NAMING_MM), np.round(radius / NAMING_MM))
    first = first_rows(label)
    return FeatureColumns(
        kind=FeatureKind.SPHERE,
        p=centre[first],
        solid=graph.face_solid[faces[first]],
        diameter_mm=2.0 * radius[first],
        faces=members_of(label, faces),
    )


def find_bosses(walls: Walls) -> FeatureColumns:
    """Find the round outsides with a free whole rim: bosses, pins, shafts, the outsides of pipes.

    The point is the centre of the free rim; of two free rims, the upper one.
    """
    rims = walls.rims
    rows = np.flatnonzero(~walls.is_hollow[rims.wall] & (rims.looks_out | rims.meets_round))
    rows = best_rows(rims.wall[rows], rims.height[rows], rows)
    wall = rims.wall[rows]
    length = (walls.ends.high - walls.ends.low)[wall]
    return FeatureColumns(
        kind=FeatureKind.BOSS,
        p=rims.centre[rows],
        solid=walls.solid[wall],
        direction=np.where(rims.is_upper[rows], 1.0, -1.0)[:, None] * walls.axis[wall],
        diameter_mm=2.0 * walls.radius[wall],
        length_mm=length,
        faces=faces_of(walls, wall),
    )


def best_rows(group: IntArray, rank: FloatArray, rows: IntArray) -> IntArray:
    """Return the row of the highest rank in every group.

    Returns shape (k,). One of `rows` per group, in the order of the groups.

    `group`: shape (n,).
    `rank`: shape (n,).
    `rows`: shape (n,).
    """
    order = np.lexsort((rank, group))
    last = np.flatnonzero(np.diff(group[order], append=-1))
    return rows[order[last]]


def faces_of(walls: Walls, wall: IntArray) -> list[IntArray]:
    """Return the faces of each given wall; `wall` has the shape (n,)."""
    faces = np.flatnonzero(walls.of_face >= 0)
    of_wall = members_of(walls.of_face[faces], faces)
    return [of_wall[w] for w in wall]


def find_axes(walls: Walls) -> FeatureColumns:
    """Find the axes of cylinders that extend at least half around; walls of one cylinder have one axis.

    The point is the middle of the walls along the axis.
    """
    kept = np.flatnonzero(walls.turn >= HALF_TURN_RAD)
    label = label_equal(walls.line[kept], np.round(walls.radius[kept] / NAMING_MM), walls.is_hollow[kept])
    first = kept[first_rows(label)]
    low, high = np.full(len(first), np.inf), np.full(len(first), -np.inf)
    np.minimum.at(low, label, walls.ends.low[kept])
    np.maximum.at(high, label, walls.ends.high[kept])
    label_of_wall = np.full(len(walls.first), -1)
    label_of_wall[kept] = label
    faces = np.flatnonzero(walls.of_face >= 0)
    faces = faces[label_of_wall[walls.of_face[faces]] >= 0]
    return FeatureColumns(
        kind=FeatureKind.AXIS,
        p=walls.foot[first] + ((low + high) / 2)[:, None] * walls.axis[first],
        solid=walls.solid[first],
        direction=walls.axis[first],
        diameter_mm=2.0 * walls.radius[first],
        length_mm=high - low,
        faces=members_of(label_of_wall[walls.of_face[faces]], faces),
    )
