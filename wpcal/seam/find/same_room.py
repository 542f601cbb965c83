"""Solids that are in the file twice: two bodies that fill the same room cannot both be members.

A file often holds a body before and after its last chamfer, or a part both by itself and in its assembly. Each contact
then gives several equal seams. Which one of them counts, says `covered.covered_by`.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.boxes import BoxTree, boxes_of_solids
from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray

SAME_BOX = 0.02
"""The boxes of two such solids agree within this share of their diagonal: a chamfer, a hole or a thread may differ."""
SAME_ROOM = 0.8  #: Share of the room that both fill of the room that one of them fills.
LOOKS, FEWEST = ((150, 0.18), (2000, 0.0)), 20
"""Points in the box at which is looked what solids are there, and how far from `SAME_ROOM` so few are sure; how many of
them must be in a solid."""
ON_FACES = 0.05
"""Share of the points on the boundary of one solid that may lie off the surface of the other one, if too few points of
the box are inside: thin plates that lie askew."""
NEAR_MM = 0.01  #: A point is on a face if it is this near.


def find_same_rooms(graph: BrepGraph, trimmed: TrimmedFaces) -> list[tuple[int, int]]:
    """Find the pairs of solids that fill the same room. The first solid in a room, and another one."""
    count = len(graph.solid_names)
    low, high = boxes_of_solids(graph.face_solid, trimmed.face_box, count)
    has_faces = np.flatnonzero(np.bincount(graph.face_solid, minlength=count) > 0)
    low, high = low[has_faces], high[has_faces]
    slack = SAME_BOX * np.linalg.norm(high - low, axis=1)[:, None]
    middle = (low + high) / 2
    row, column = BoxTree.of(middle, middle).meeting(middle - slack, middle + slack)
    alike = (row < column) & (np.abs(low[row] - low[column]) <= slack[row]).all(axis=1)
    alike &= (np.abs(high[row] - high[column]) <= slack[row]).all(axis=1)
    found: dict[int, int] = {}
    looked: dict[tuple[int, int], tuple[IntArray, IntArray]] = {}
    for a, b in sorted(zip(has_faces[row[alike]].tolist(), has_faces[column[alike]].tolist(), strict=True)):
        first = found.get(a, a)
        if b not in found and _fill_the_same(graph, trimmed, first, b, looked):
            found[b] = first
    return sorted((first, copy) for copy, first in found.items())


def _fill_the_same(
    graph: BrepGraph, trimmed: TrimmedFaces, a: int, b: int, looked: dict[tuple[int, int], tuple[IntArray, IntArray]]
) -> bool:
    """Tell whether two solids with equal boxes fill the same room.

    `looked`: What solids are where in the box of a solid, by its number and that of the points.
    """
    own = graph.face_solid == a
    low, high = trimmed.face_box[0][own].min(axis=0), trimmed.face_box[1][own].max(axis=0)
    points = low + np.random.default_rng(0).uniform(size=(LOOKS[-1][0], 3)) * (high - low)
    for count, clearly in LOOKS:
        if (a, count) not in looked:
            looked[a, count] = find_solids_around(ExactMaterial(graph, trimmed), points[:count])
        point, solid = looked[a, count]
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
