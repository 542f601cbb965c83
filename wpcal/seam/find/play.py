"""The play of an assembly: the clearance that its joints have by design, estimated from all of them together.

Whoever draws tabs in slots, tubes in holes or one tube in another leaves the same clearance everywhere: it is one fact
per assembly, not a constant of wpcal. A gap that several joints have is not a doubt about a weld.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import linked_groups
from wpcal.seam.find.facing import FacingFaces, find_facing
from wpcal.seam.options import Play, SeamOptions

MOST_PLAY_MM = 1.0  #: A wider clearance is not play: fillets bridge gaps of up to 1 mm without a larger leg.
LEAST_JOINTS = 3  #: This many joints have the gap: two equal gaps may be chance, or the two sides of one member.
SAME_PLAY_MM, SAME_PLAY_SHARE = 0.02, 0.05
"""Gaps are the same within this: round-off of drawn dimensions, and fits of different diameters."""


def measure_play(graph: BrepGraph, trimmed: TrimmedFaces) -> tuple[Play, ...]:
    """Estimate which gaps the joints of an assembly have by design.

    Returns: Gaps between `FLUSH_MM` and `MOST_PLAY_MM` that at least `LEAST_JOINTS` joints have, the most frequent
    first. A joint is a place: a slot with four sides is one.
    """
    facing = find_facing(graph, trimmed, most_mm=MOST_PLAY_MM)
    if len(facing.first) < LEAST_JOINTS:
        return ()
    joint = _joints(graph, facing)
    gaps = np.array([np.median(facing.gap_mm[joint == number]) for number in range(joint.max() + 1)])
    found, left = [], np.sort(gaps)
    while len(left) >= LEAST_JOINTS:
        width = np.maximum(SAME_PLAY_MM, SAME_PLAY_SHARE * left)
        count = np.searchsorted(left, left + width, side="right") - np.arange(len(left))
        first = int(np.argmax(count))
        if count[first] < LEAST_JOINTS:
            break
        own = left[first : first + count[first]]
        found.append(Play(float(own[0]), float(np.median(own)), float(own[-1]), len(own)))
        left = np.delete(left, np.arange(first, first + count[first]))
    return tuple(found)


def with_play(graph: BrepGraph, trimmed: TrimmedFaces, options: SeamOptions) -> SeamOptions:
    """Return options with the play of the part. If a person said how wide gaps are, that counts alone."""
    if options.play is not None:
        return options
    return replace(options, play=measure_play(graph, trimmed) if options.gap_mm is None else ())


def _joints(graph: BrepGraph, facing: FacingFaces) -> IntArray:
    """Return the number of the joint of each pair: pairs of the same two solids with neighbouring faces are one."""
    solids = np.sort(np.stack([graph.face_solid[facing.first], graph.face_solid[facing.second]], axis=1), axis=1)
    neighbours: dict[int, set[int]] = defaultdict(set)
    for a, b in graph.edge_faces[(graph.edge_faces >= 0).all(axis=1)].tolist():
        neighbours[a].add(b)
        neighbours[b].add(a)
    rows_of: dict[tuple[int, ...], list[int]] = defaultdict(list)
    for row, pair in enumerate(solids.tolist()):
        rows_of[tuple(pair)].append(row)
    links: list[tuple[int, int]] = []
    faces = np.stack([facing.first, facing.second], axis=1)
    faces = np.where((graph.face_solid[facing.first] != solids[:, 0])[:, None], faces[:, ::-1], faces).tolist()
    for rows in rows_of.values():
        for row in rows:
            near, opposite = (neighbours[face] for face in faces[row])
            links += [(row, other) for other in rows if faces[other][0] in near and faces[other][1] in opposite]
    count = len(facing.first)
    i, j = np.array(links, dtype=np.int64).reshape(-1, 2).T
    return linked_groups(count, i, j)


def is_play(play: tuple[Play, ...], gap_mm: FloatArray) -> BoolArray:
    """Tell which gaps, shape (n,), are the play of the assembly."""
    same = [(gap_mm >= one.least_mm - SAME_PLAY_MM) & (gap_mm <= one.most_mm + SAME_PLAY_MM) for one in play]
    return np.asarray(np.any(same, axis=0) if same else np.zeros(len(gap_mm), dtype=bool), dtype=bool)
