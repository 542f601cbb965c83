"""Solids that fill room which another solid fills already: the same body twice, or one wholly inside another.

A drawing may hold a body under two names, before and after its last chamfer, by itself and in its assembly, or a union
beside what was united. Two bodies that fill the same room cannot both be members: each contact would give several equal
seams. One of them counts.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.boxes import BoxTree
from wpcal.brep.graph import BrepGraph
from wpcal.brep.hits import find_hits
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.surfaces import unit
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.given_names import is_given_name
from wpcal.core.issue import Issue
from wpcal.seam.find.bead_bodies import bead_bodies

LOOKS = ((8, 0.75), (200, 0.98))
"""Points inside a solid that are looked at, and the share of them that is at least inside the other one. A plug that
stands out by a tenth is told from a covered one with 200 points; a few points may be judged wrong."""
LINES = 4  #: Random lines per point: most lines through the box of a thin solid miss it.
BOX_MM = 0.1  #: A solid that stands out of another one by more is not inside it; boxes of round faces are not exact.
NAMED = 3  #: This many solids are named in an issue.


def covered_by(graph: BrepGraph, trimmed: TrimmedFaces) -> IntArray:
    """Return for each solid the solid that fills its room and counts instead of it, or -1.

    Returns shape (S,). Of equal bodies, the first one counts. Looked for once: the answer is kept in `trimmed.known`.
    """
    found = trimmed.known.get(("covered", -1))
    if found is None:
        found = trimmed.known[("covered", -1)] = _find(graph, trimmed)
    return np.asarray(found, dtype=np.int64)


def covered_issues(graph: BrepGraph, trimmed: TrimmedFaces) -> tuple[Issue, ...]:
    """Say which solids do not count because others fill their room."""
    by = covered_by(graph, trimmed)
    own = np.flatnonzero(by >= 0)
    if len(own) == 0:
        return ()
    names = graph.solid_names
    told = [f"{names[solid]} in {names[by[solid]]}" for solid in own[:NAMED].tolist()]
    told += [f"and {len(own) - NAMED} more"] if len(own) > NAMED else []
    count = "1 solid fills" if len(own) == 1 else f"{len(own)} solids fill"
    words = f"{count} room that another solid fills, so one of the two gives no seams: {', '.join(told)}"
    return (Issue("same-room", words, tuple(names[solid] for solid in own.tolist())),)


def _find(graph: BrepGraph, trimmed: TrimmedFaces) -> IntArray:
    inner, outer = _boxes_inside(graph, trimmed)
    rng = np.random.default_rng(0)
    for count, least in LOOKS:
        solids = np.unique(inner)
        owner, points = _points_inside(graph, trimmed, solids, count, rng)
        row, around = find_solids_around(ExactMaterial(graph, trimmed), points)
        size = len(graph.solid_names)
        of = np.bincount(owner, minlength=size)
        pairs, hits = np.unique(owner[row] * size + around, return_counts=True)
        inside = np.zeros(len(inner), dtype=np.int64)
        at = np.searchsorted(pairs, inner * size + outer)
        known = at < len(pairs)
        known[known] = pairs[at[known]] == (inner * size + outer)[known]
        inside[known] = hits[at[known]]
        kept = (inside >= least * of[inner]) & (of[inner] > 0)
        inner, outer = inner[kept], outer[kept]
    pairs = set(zip(inner.tolist(), outer.tolist(), strict=True))
    for first, copy in find_same_rooms(graph, trimmed):
        pairs |= {(first, copy), (copy, first)}
    return _chosen(graph, pairs)


def _boxes_inside(graph: BrepGraph, trimmed: TrimmedFaces) -> tuple[IntArray, IntArray]:
    """Return the pairs of solids of which the box of the first is inside that of the second."""
    low, high = trimmed.solid_boxes
    one, other = BoxTree.of(low, high).meeting(low, high)
    within = (low[one] >= low[other] - BOX_MM).all(axis=1) & (high[one] <= high[other] + BOX_MM).all(axis=1)
    kept = (one != other) & within
    return one[kept], other[kept]


def _points_inside(
    graph: BrepGraph, trimmed: TrimmedFaces, solids: IntArray, count: int, rng: np.random.Generator
) -> tuple[IntArray, FloatArray]:
    """Return places inside solids, half way along random lines through them: their solids, and points (n, 3)."""
    low, high = trimmed.solid_boxes
    solid = np.repeat(solids, LINES * count)
    way = unit(rng.normal(size=(len(solid), 3)))
    through = low[solid] + (high - low)[solid] * rng.uniform(size=(len(solid), 3))
    reach = np.linalg.norm(high - low, axis=1)[solid] + 1.0
    start = through - reach[:, None] * way
    hits = find_hits(trimmed, start, way, length_mm=2.0 * reach, solid=solid)
    first = np.flatnonzero((hits.way[:-1] < 0) & (hits.way[1:] > 0) & (hits.ray[:-1] == hits.ray[1:]))
    ray, at = hits.ray[first], (hits.at_mm[first] + hits.at_mm[first + 1]) / 2
    return solid[ray], start[ray] + at[:, None] * way[ray]


def _chosen(graph: BrepGraph, pairs: set[tuple[int, int]]) -> IntArray:
    """Return for each solid the one that counts instead of it: the outer one, and of two that are equal the first.

    Of two equal ones, a name that a person gave goes before the name of a modelling step.
    """
    rank = [(not is_given_name(name), solid) for solid, name in enumerate(graph.solid_names)]
    by = np.full(len(graph.solid_names), -1)
    for one, other in sorted(pairs, key=lambda pair: rank[pair[1]], reverse=True):
        if (other, one) not in pairs or rank[other] < rank[one]:
            by[one] = other
    for solid in range(len(by)):  # what counts instead is not covered itself
        way = [solid]
        while by[way[-1]] >= 0 and by[way[-1]] not in way:
            way.append(int(by[way[-1]]))
        by[way[:-1]] = way[-1]
        by[way[-1]] = -1
    return by


def count_solids(graph: BrepGraph, trimmed: TrimmedFaces, solids: IntArray) -> BoolArray:
    """Tell which of some solids count; numbers below zero do, beads that were drawn do not.

    Returns ndarray of bool, same shape.
    """
    counts = covered_by(graph, trimmed) < 0
    counts[bead_bodies(graph, trimmed)] = False
    return np.asarray((solids < 0) | counts[np.maximum(solids, 0)], dtype=bool)


SAME_BOX = 0.02
"""The boxes of two such solids agree within this share of their diagonal: a chamfer, a hole or a thread may differ."""
SAME_ROOM = 0.8  #: Share of the room that both fill of the room that one of them fills.
ROOM_LOOKS, FEWEST = ((150, 0.18), (2000, 0.0)), 20
"""Points in the box at which is looked what solids are there, and how far from `SAME_ROOM` so few are sure; how many of
them must be in a solid."""
ON_FACES = 0.05
"""Share of the points on the boundary of one solid that may lie off the surface of the other one, if too few points of
the box are inside: thin plates that lie askew."""
NEAR_MM = 0.01  #: A point is on a face if it is this near.


def find_same_rooms(graph: BrepGraph, trimmed: TrimmedFaces) -> list[tuple[int, int]]:
    """Find the pairs of solids that fill the same room. The first solid in a room, and another one."""
    count = len(graph.solid_names)
    low, high = trimmed.solid_boxes
    has_faces = np.flatnonzero(np.bincount(graph.face_solid, minlength=count) > 0)
    low, high = low[has_faces], high[has_faces]
    slack = SAME_BOX * np.linalg.norm(high - low, axis=1)[:, None]
    middle = (low + high) / 2
    row, column = BoxTree.of(middle, middle).meeting(middle - slack, middle + slack)
    alike = (row < column) & (np.abs(low[row] - low[column]) <= slack[row]).all(axis=1)
    alike &= (np.abs(high[row] - high[column]) <= slack[row]).all(axis=1)
    found: dict[int, int] = {}
    looked: dict[tuple[bytes, int], tuple[IntArray, IntArray]] = {}
    for a, b in sorted(zip(has_faces[row[alike]].tolist(), has_faces[column[alike]].tolist(), strict=True)):
        first = found.get(a, a)
        if b not in found and _fill_the_same(graph, trimmed, first, b, looked):
            found[b] = first
    return sorted((first, copy) for copy, first in found.items())


def _fill_the_same(
    graph: BrepGraph, trimmed: TrimmedFaces, a: int, b: int, looked: dict[tuple[bytes, int], tuple[IntArray, IntArray]]
) -> bool:
    """Tell whether two solids with equal boxes fill the same room.

    `looked`: What solids are where in a box, by its corners and the number of points.
    """
    low, high = (corner[a] for corner in trimmed.solid_boxes)
    points = low + np.random.default_rng(0).uniform(size=(ROOM_LOOKS[-1][0], 3)) * (high - low)
    for count, clearly in ROOM_LOOKS:
        box = low.tobytes() + high.tobytes()
        if (box, count) not in looked:
            looked[box, count] = find_solids_around(ExactMaterial(graph, trimmed), points[:count])
        point, solid = looked[box, count]
        in_a, in_b = set(point[solid == a].tolist()), set(point[solid == b].tolist())
        most = max(len(in_a), len(in_b))
        if most >= FEWEST and abs(len(in_a & in_b) - SAME_ROOM * most) > clearly * most:
            break
    if min(len(in_a), len(in_b)) < FEWEST:
        return most < FEWEST and _have_the_same_edges(trimmed, a, b)
    return len(in_a & in_b) >= SAME_ROOM * most


def _have_the_same_edges(trimmed: TrimmedFaces, a: int, b: int) -> bool:
    """Tell whether nearly all points of the boundaries of the faces of two solids coincide."""
    one, other = _boundary(trimmed, a), _boundary(trimmed, b)
    near = BoxTree.of(other - NEAR_MM, other + NEAR_MM).meeting(one, one)[0]
    return bool(len(np.unique(near)) >= (1.0 - ON_FACES) * len(one))


def _boundary(trimmed: TrimmedFaces, solid: int) -> FloatArray:
    faces = np.flatnonzero(trimmed.graph.face_solid == solid).tolist()
    return np.concatenate([trimmed.p0[trimmed.start[face] : trimmed.start[face + 1]] for face in faces])
