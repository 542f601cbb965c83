"""Holes: consecutive hollow walls around one axis, with their entry, depth and diameters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.brep.graph import SurfaceKind
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import linked_groups
from wpcal.taught.features.columns import NAMING_MM, FeatureColumns, first_rows, label_equal
from wpcal.taught.features.reference import FeatureKind, HoleForm, HoleStep
from wpcal.taught.features.rounds import faces_of
from wpcal.taught.features.walls import Coaxial, WallEnds, Walls


def find_holes(walls: Walls) -> FeatureColumns:
    """Find the holes with at least one whole circle as a rim, of the same radius as the wall.

    A counterbore, a countersink or a groove belongs to its hole: they are one feature. The entry is the rim that opens
    to free space; of several, the widest, then the upper one. The point is the centre of the entry, and the diameter is
    that of the wall there.
    """
    coaxial, rims = walls.coaxial, walls.rims
    label = _bodies(walls)
    body_of_face = np.full(coaxial.graph.face_count, -1, dtype=np.int64)
    of_wall = label[walls.first]
    with_rim = np.isin(label, of_wall[rims.wall[walls.is_hollow[rims.wall]]])
    body_of_face[coaxial.faces] = np.where(with_rim, label, -1)
    ends = _without_drill_points(
        WallEnds.of(coaxial.graph, body_of_face, coaxial.axis[first_rows(label)]), walls, of_wall
    )
    rows = _entries(walls, of_wall, ends)
    wall, way = rims.wall[rows], np.where(rims.is_upper[rows], 1.0, -1.0)
    body = of_wall[wall]
    steps = _steps(walls, of_wall, ends, body, way)
    before = np.where(way > 0, ends.high[body] - rims.height[rows], rims.height[rows] - ends.low[body])
    return FeatureColumns(
        kind=FeatureKind.HOLE,
        p=rims.centre[rows],
        solid=walls.solid[wall],
        direction=way[:, None] * walls.axis[wall],
        diameter_mm=2.0 * walls.radius[wall],
        depth_mm=(ends.high - ends.low)[body],
        is_through=np.logical_and(*ends.is_open())[body],
        form=_forms(steps, (before > NAMING_MM) & ~rims.meets_round[rows]),
        steps=steps,
        faces=faces_of(walls, wall),
    )


def _without_drill_points(ends: WallEnds, walls: Walls, body_of_wall: IntArray) -> WallEnds:
    """Limit bodies to their borders and cylindrical walls: the point of a drill does not count as depth."""
    low, high = np.full(len(ends.low), np.inf), np.full(len(ends.high), -np.inf)
    hollow = walls.is_hollow
    for body, least, greatest in (
        (ends.body[ends.is_border], ends.least[ends.is_border], ends.greatest[ends.is_border]),
        (body_of_wall[hollow], walls.ends.low[hollow], walls.ends.high[hollow]),
    ):
        np.minimum.at(low, body, least)
        np.maximum.at(high, body, greatest)
    return replace(ends, low=low, high=high)


def _bodies(walls: Walls) -> IntArray:
    """Number the groups of consecutive faces around one line, as in a hole; one number per row of `Coaxial`.

    The faces are hollow, or rounds. Neighbours share an edge, or the plane step of a counterbore.
    """
    coaxial, graph = walls.coaxial, walls.coaxial.graph
    hollow = graph.face_outward < 0
    takes_part = (coaxial.row >= 0) & (hollow | (graph.face_kind == SurfaceKind.TORUS))
    pairs = graph.edge_faces[(graph.edge_faces >= 0).all(axis=1)]
    a, b = coaxial.row[pairs[takes_part[pairs].all(axis=1)]].T
    joined = coaxial.line[a] == coaxial.line[b]
    a, b = a[joined], b[joined]
    label = linked_groups(len(coaxial.faces), a, b)
    first, second = _across_steps(coaxial, label, (coaxial.row >= 0) & hollow)
    return linked_groups(len(coaxial.faces), np.concatenate([a, first]), np.concatenate([b, second]))


def _across_steps(coaxial: Coaxial, label: IntArray, takes_part: BoolArray) -> tuple[IntArray, IntArray]:
    """Return pairs of rows of faces around one line that border the same plane face and are not in one group yet."""
    graph = coaxial.graph
    pairs = graph.edge_faces[(graph.edge_faces >= 0).all(axis=1)]
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    pairs = pairs[takes_part[pairs[:, 0]] & (graph.face_kind[pairs[:, 1]] == SurfaceKind.PLANE)]
    row = coaxial.row[pairs[:, 0]]
    step = label_equal(pairs[:, 1], coaxial.line[row])
    order = np.lexsort((label[row], step))
    row, step = row[order], step[order]
    follows = (step[1:] == step[:-1]) & (label[row[1:]] != label[row[:-1]])
    return row[:-1][follows], row[1:][follows]


def _entries(walls: Walls, body_of_wall: IntArray, ends: WallEnds) -> IntArray:
    """Return the entry rim of every body that is a hole: of the open rims the widest, then the upper one."""
    rims = walls.rims
    rows = np.flatnonzero(walls.is_hollow[rims.wall])
    body = body_of_wall[rims.wall[rows]]
    below, above = ends.is_open()
    opens = rims.looks_out[rows] | (rims.meets_round[rows] & np.where(rims.is_upper[rows], above[body], below[body]))
    size = np.round(walls.radius[rims.wall[rows]] / NAMING_MM)
    order = np.lexsort((np.round(rims.height[rows] / NAMING_MM), size, opens, body))
    return rows[order[np.flatnonzero(np.diff(body[order], append=-1))]]


def _steps(
    walls: Walls, body_of_wall: IntArray, ends: WallEnds, body: IntArray, way: FloatArray
) -> list[tuple[HoleStep, ...]]:
    """Return the diameters of each hole, from its entry on."""
    hollow = np.flatnonzero(walls.is_hollow)
    order = hollow[np.argsort(body_of_wall[hollow], kind="stable")]
    start = np.searchsorted(body_of_wall[order], body)
    stop = np.searchsorted(body_of_wall[order], body, side="right")
    low, high = walls.ends.low, walls.ends.high
    found = []
    for k, hole in enumerate(body):
        w = order[start[k] : stop[k]]
        begin, end = (ends.high[hole] - high[w], ends.high[hole] - low[w])
        if way[k] < 0:
            begin, end = (low[w] - ends.low[hole], high[w] - ends.low[hole])
        steps = zip((2.0 * walls.radius[w]).tolist(), begin.tolist(), end.tolist(), strict=True)
        found.append(tuple(HoleStep(*step) for step in sorted(steps, key=lambda step: step[1])))
    return found


def _forms(steps: list[tuple[HoleStep, ...]], is_sunk: BoolArray) -> list[HoleForm]:
    """Name the forms: more than one diameter, or a cone before the entry."""
    sizes = [len({round(step.diameter_mm / NAMING_MM) for step in hole}) for hole in steps]
    single = [HoleForm.COUNTERSINK if sunk else HoleForm.PLAIN for sunk in is_sunk]
    return [HoleForm.COUNTERBORE if size > 1 else form for size, form in zip(sizes, single, strict=True)]
