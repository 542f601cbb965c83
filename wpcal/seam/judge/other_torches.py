"""Which shipped torch reaches what the stated torch does not reach, the most usual one first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.robot.torch.file import shipped_torches
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam.judge.leans import FeltAt, at_stations, feel_seams
from wpcal.seam.options import Reach
from wpcal.seam.seam import OtherTorch, Seam

FEW = (1, 4, 12)
"""A torch is felt at this many stations first: what is behind something is out of reach for most torches. On its way to
the ends, which takes the longest, it is felt only with the whole stretch."""
MOST_ASKED = 20
"""This many stretches are asked for, the longest ones: feeling bent necks takes 30 ms each, and one torch is advised
for a part, not one for each of 500 stretches inside a box. `--explain` asks for any one."""


def with_other_torches(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Sequence[Seam]], reach: Reach, *, least_mm: float
) -> list[list[Seam]]:
    """Return seams of which the longest that the torch does not reach name a shipped torch that reaches all of them."""
    found = [list(pieces) for pieces in seams]
    todo = [
        (row, at)
        for row, pieces in enumerate(found)
        for at, piece in enumerate(pieces)
        if piece.blocked_by and piece.length_mm >= least_mm
    ]

    def free_at(places: list[tuple[int, int]], own: Reach, wire_mm: float, few: int) -> list[tuple[int, int]]:
        tried = [replace(found[row][at], more_wire_mm=wire_mm - own.torch.wire_mm) for row, at in places]
        if few == 0:
            felt = feel_seams(graph, trimmed, tried, own)
            return [place for place, one in zip(places, felt, strict=True) if one.is_free]
        tried = [at_stations(seam, np.arange(len(seam.frames)), few) for seam in tried]
        felt = feel_seams(graph, trimmed, tried, own, FeltAt.SOME)
        return [place for place, one in zip(places, felt, strict=True) if not (one.solid >= 0).any()]

    todo = sorted(todo, key=lambda place: (-found[place[0]][place[1]].length_mm, place))[:MOST_ASKED]
    core = core_of_all()
    todo = sorted(free_at(todo, replace(reach, torch=core), core.wire_mm, 1))
    for shipped in shipped_torches():
        torch, own = shipped.shape, replace(reach, torch=shipped.shape)
        if torch == reach.torch:
            continue
        for wire_mm in dict.fromkeys((torch.wires_mm[0], torch.wires_mm[-1])):
            reached = todo
            for few in (*FEW, 0):
                reached = free_at(reached, own, wire_mm, few)
            for row, at in reached:
                found[row][at] = replace(found[row][at], other_torch=OtherTorch(torch.name, wire_mm))
            todo = [place for place in todo if place not in reached]
    return found


@cache
def core_of_all() -> TorchShape:
    """Return a torch that is inside every shipped one: what it does not reach, none of them does."""
    shapes = [torch.shape for torch in shipped_torches()]
    wire_mm = max(shape.wires_mm[-1] for shape in shapes)
    return TorchShape(
        wire_mm,
        min(shape.nozzle_radius_mm for shape in shapes),
        wire_mm + min(shape.front_mm for shape in shapes),
        mouth_radius_mm=min(shape.mouth_mm for shape in shapes),
        taper_mm=max(shape.taper_mm for shape in shapes),
    )
