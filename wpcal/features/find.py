"""Reference features of a part: corners, circular rims, holes, sphere centres and edge midpoints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from wpcal.brep.curves import edge_lengths, evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.features.reference import FeatureKind, ReferenceFeature

NAMING_MM = 1e-3
"""Positions are compared after rounding to this, so that round-off does not renumber a part."""
FULL_TURN_RAD = 2 * np.pi - 1e-3
"""Arcs and wall pieces that sum to this much of a turn make a circle or a hole."""
LEAST_EDGE_MM = 5.0
"""The middle of a shorter edge cannot be told from its ends with a wire tip."""
AXIS_ROUND = 1e-4
"""Directions of axes are compared after rounding to this (0.006 degrees)."""
LEAST_CORNER_EDGES = 3
"""Edges that meet in a corner; two meet where a circle closes or a curve is cut."""


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """A feature before it has its name."""

    kind: FeatureKind
    p: FloatArray
    direction: FloatArray | None
    diameter_mm: float | None
    solid: int


def find_features(graph: BrepGraph) -> tuple[ReferenceFeature, ...]:
    """Find what can be taught on a part.

    Parameters
    ----------
    graph : BrepGraph

    Returns
    -------
    tuple of ReferenceFeature
        Corners (``V``), circular rims (``C``), holes (``H``, the centre of the entry rim), sphere centres (``S``) and
        midpoints of straight edges (``M``). Numbered within their kind by position (rounded to 1e-3 mm, sorted by x, y,
        z, then solid and size): the same at every run, and a new kind never renumbers another.
    """
    circles = _circles(graph)
    found = [*_vertices(graph), *circles, *_holes(graph, circles), *_spheres(graph), *_midpoints(graph)]
    return tuple(_named(graph, found))


def _named(graph: BrepGraph, found: list[_Found]) -> Iterable[ReferenceFeature]:
    for kind in FeatureKind:
        ordered = sorted((item for item in found if item.kind is kind), key=_order)
        for number, item in enumerate(ordered, 1):
            solid = graph.solid_names[item.solid] if item.solid >= 0 else ""
            direction = None if item.direction is None else frozen(item.direction)
            yield ReferenceFeature(f"{kind.value}{number}", kind, frozen(item.p), direction, item.diameter_mm, solid)


def _order(item: _Found) -> tuple[float, ...]:
    place = (np.round(item.p / NAMING_MM) * NAMING_MM + 0.0).tolist()
    axis = [] if item.direction is None else (np.round(item.direction, 3) + 0.0).tolist()
    return (*place, item.solid, item.diameter_mm or 0.0, *axis)


def _vertices(graph: BrepGraph) -> list[_Found]:
    real = (graph.edge_kind != CurveKind.DEGENERATE) & ~graph.is_seam_edge
    ends = graph.edge_vertices[real].ravel()
    count = np.bincount(ends[ends >= 0], minlength=len(graph.vertex_p))
    corners = np.flatnonzero(count >= LEAST_CORNER_EDGES)
    return [_Found(FeatureKind.VERTEX, graph.vertex_p[v], None, None, int(graph.vertex_solid[v])) for v in corners]


def _midpoints(graph: BrepGraph) -> list[_Found]:
    lines = np.flatnonzero((graph.edge_kind == CurveKind.LINE) & ~graph.is_seam_edge & (graph.edge_solid >= 0))
    lines = lines[edge_lengths(graph)[lines] >= LEAST_EDGE_MM]
    p, slope = evaluate_edges(graph, lines, graph.edge_range[lines].mean(axis=1))
    return [
        _Found(FeatureKind.EDGE_MIDPOINT, p[i], positive_axis(slope[i]), None, int(graph.edge_solid[edge]))
        for i, edge in enumerate(lines)
    ]


def positive_axis(direction: FloatArray) -> FloatArray:
    """Return the unit vector along a line whose last component that is not zero (z, y, x) is positive."""
    unit = direction / np.linalg.norm(direction)
    for value in unit[::-1]:
        if abs(value) > AXIS_ROUND:
            return np.asarray(unit if value > 0 else -unit, dtype=np.float64)
    return np.asarray(unit, dtype=np.float64)


def _grouped(keys: FloatArray) -> list[IntArray]:
    """Return rows of equal keys together, in the order of their first rows."""
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    rows = np.argsort(inverse.ravel(), kind="stable")
    parts = np.split(rows, np.cumsum(np.bincount(inverse.ravel()))[:-1]) if len(keys) else []
    return [parts[i] for i in np.argsort(first)]


def _circles(graph: BrepGraph) -> list[_Found]:
    arcs = np.flatnonzero((graph.edge_kind == CurveKind.CIRCLE) & (graph.edge_solid >= 0))
    centre, radius = graph.edge_frame[arcs, 0], graph.edge_param[arcs, 0]
    axis = np.array([positive_axis(z) for z in graph.edge_frame[arcs, 3]]).reshape(-1, 3)
    keys = np.column_stack(
        [
            graph.edge_solid[arcs],
            np.round(centre / NAMING_MM),
            np.round(axis / AXIS_ROUND),
            np.round(radius / NAMING_MM),
        ]
    )
    turn = np.ptp(graph.edge_range[arcs], axis=1)
    return [
        _Found(
            FeatureKind.CIRCLE,
            centre[rows[0]],
            axis[rows[0]],
            2.0 * float(radius[rows[0]]),
            int(graph.edge_solid[arcs[rows[0]]]),
        )
        for rows in _grouped(keys)
        if turn[rows].sum() >= FULL_TURN_RAD
    ]


def _spheres(graph: BrepGraph) -> list[_Found]:
    faces = np.flatnonzero(graph.face_kind == SurfaceKind.SPHERE)
    centre, radius = graph.face_frame[faces, 0], graph.face_param[faces, 0]
    keys = np.column_stack([graph.face_solid[faces], np.round(centre / NAMING_MM), np.round(radius / NAMING_MM)])
    return [
        _Found(
            FeatureKind.SPHERE,
            centre[rows[0]],
            None,
            2.0 * float(radius[rows[0]]),
            int(graph.face_solid[faces[rows[0]]]),
        )
        for rows in _grouped(keys)
    ]


def _holes(graph: BrepGraph, circles: list[_Found]) -> list[_Found]:
    """Find walls of holes: cylinders whose outward normal points to the axis and that have a whole circle as rim."""
    walls = np.flatnonzero((graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward < 0))
    origin, radius = graph.face_frame[walls, 0], graph.face_param[walls, 0]
    axis = np.array([positive_axis(z) for z in graph.face_frame[walls, 3]]).reshape(-1, 3)
    foot = origin - np.einsum("ki,ki->k", origin, axis)[:, None] * axis
    keys = np.column_stack(
        [graph.face_solid[walls], np.round(foot / NAMING_MM), np.round(axis / AXIS_ROUND), np.round(radius / NAMING_MM)]
    )
    holes = []
    for rows in _grouped(keys):
        first = rows[0]
        rims = [
            c for c in circles if _is_rim(c, graph.face_solid[walls[first]], foot[first], axis[first], radius[first])
        ]
        if rims:
            holes.extend(_entries(graph, walls[rows], rims, axis[first]))
    return holes


def _is_rim(circle: _Found, solid: int, foot: FloatArray, axis: FloatArray, radius: float) -> bool:
    if circle.solid != solid or circle.direction is None or circle.diameter_mm is None:
        return False
    off = circle.p - foot
    aside = off - float(off @ axis) * axis
    same_size = abs(circle.diameter_mm - 2.0 * radius) <= NAMING_MM
    return bool(same_size and abs(circle.direction @ axis) > 1 - AXIS_ROUND and np.linalg.norm(aside) <= NAMING_MM)


def _entries(graph: BrepGraph, walls: IntArray, rims: list[_Found], axis: FloatArray) -> list[_Found]:
    """Return one hole for the rims on one axis: its entry is the rim that opens to free space, of two the upper one.

    A rim opens where the face around it looks along the axis away from the wall.
    """
    height = [float(rim.p @ axis) for rim in rims]
    best = max(range(len(rims)), key=lambda i: (_opens(graph, walls, rims[i], axis), height[i]))
    rim = rims[best]
    outward = axis if _opens(graph, walls, rim, axis) and _is_upper(graph, walls, rim, axis) else -axis
    return [_Found(FeatureKind.HOLE, rim.p, outward, rim.diameter_mm, rim.solid)]


def _is_upper(graph: BrepGraph, walls: IntArray, rim: _Found, axis: FloatArray) -> bool:
    """Tell whether the wall lies below a rim along the axis."""
    edges = np.unique(graph.coedge_edge[np.isin(graph.coedge_face, walls)])
    usable = edges[graph.edge_kind[edges] != CurveKind.DEGENERATE]
    middle = evaluate_edges(graph, usable, graph.edge_range[usable].mean(axis=1))[0] @ axis
    return bool(middle.mean() <= rim.p @ axis)


def _opens(graph: BrepGraph, walls: IntArray, rim: _Found, axis: FloatArray) -> bool:
    """Tell whether the face around a rim looks away from the wall."""
    assert rim.diameter_mm is not None
    rim_edges = np.flatnonzero(
        (graph.edge_kind == CurveKind.CIRCLE)
        & (np.linalg.norm(graph.edge_frame[:, 0] - rim.p, axis=1) <= NAMING_MM)
        & (np.abs(graph.edge_param[:, 0] - rim.diameter_mm / 2) <= NAMING_MM)
    )
    around = np.setdiff1d(graph.edge_faces[rim_edges].ravel(), [-1, *walls.tolist()])
    if len(around) == 0 or len(rim_edges) == 0:
        return False
    p = evaluate_edges(graph, rim_edges[:1], graph.edge_range[rim_edges[:1], 0])[0]
    normals = project_to_faces(graph, around, np.repeat(p, len(around), axis=0)).normal
    way = 1.0 if _is_upper(graph, walls, rim, axis) else -1.0
    return bool((way * normals @ axis > 0.1).any())
