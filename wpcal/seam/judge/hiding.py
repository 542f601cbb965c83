"""What a torch would reach if a solid beside a seam were not there: a fixture, or what is mounted after the weld."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam.judge.leans import feel_seams
from wpcal.seam.options import Reach
from wpcal.seam.seam import Hiding, Seam

MOST_ASKED, MOST_SOLIDS = 10, 3
"""This many stretches are asked for, the longest ones, and this many solids at each: most parts have one or two."""
DIGITS = 6  #: Of a length, mm: seams of copies are equally long but for round-off, which would choose among them.
LOOSE_MM = 1.0  #: A solid with no other solid within this, by the boxes of faces, touches nothing.
LEAST_FREED_MM = 1.0  #: Less is not worth telling.


def with_hiding(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], reach: Reach) -> list[Seam]:
    """Return seams of which the longest blocked ones name the solids without which a torch would reach them.

    Only solids that the seam does not join are asked: a joint without its members is none.
    """
    found = list(seams)
    number = {name: solid for solid, name in enumerate(graph.solid_names)}
    others = {row: _others(seam) for row, seam in enumerate(seams) if seam.length_mm >= LEAST_FREED_MM}
    rows = sorted(
        (row for row, names in others.items() if names), key=lambda row: (-round(seams[row].length_mm, DIGITS), row)
    )
    asked: dict[int, list[int]] = {}
    for row in rows[:MOST_ASKED]:
        for name in others[row][:MOST_SOLIDS]:
            asked.setdefault(number[name], []).append(row)
    for solid, own in sorted(asked.items()):
        without = trimmed.without(solid)
        loose = is_loose(graph, trimmed, solid)
        for row, felt in zip(own, feel_seams(graph, without, [seams[row] for row in own], reach), strict=True):
            is_free = (felt.solid[:-1] < 0) & (felt.solid[1:] < 0) & (felt.solid_after < 0)  # between two free stations
            freed = float(np.diff(seams[row].frames.s_mm)[is_free].sum())
            if freed >= LEAST_FREED_MM:
                one = Hiding(graph.solid_names[solid], freed, loose)
                found[row] = replace(found[row], hiding=(*found[row].hiding, one))
    return found


def _others(seam: Seam) -> list[str]:
    """Return the solids in the way of the torch or of the wire that the seam does not join."""
    return [name for name in dict.fromkeys((*seam.inside, *seam.blocked_by)) if name not in seam.solids]


def is_loose(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> bool:
    """Tell whether no face of another solid has a box near a box of a face of this one."""
    own = np.flatnonzero(graph.face_solid == solid)
    low, high = (corner[own] for corner in trimmed.face_box)
    _, near = trimmed.box_tree.meeting(low - LOOSE_MM, high + LOOSE_MM)
    return bool((graph.face_solid[near] == solid).all())


def hiding_words(seam: Seam) -> str:
    """Say what a torch would reach without the solids in its way, for people; empty if nothing is known."""
    told = []
    for one in seam.hiding:
        loose = ", which touches nothing," if one.is_loose else ""
        part = ", all of it" if one.length_mm > seam.length_mm - LEAST_FREED_MM else " of it"
        told.append(f"without {one.solid}{loose} the torch would reach {one.length_mm:.1f} mm{part}")
    return "".join(f"; {words}" for words in told)


def gained_words(seams: Sequence[Seam]) -> list[str]:
    """Say for each solid in the way what would be gained without it in all seams of a part, the most first."""
    gained: dict[str, list[tuple[Seam, Hiding]]] = {}
    for seam in seams:
        for one in seam.hiding:
            gained.setdefault(one.solid, []).append((seam, one))
    told = []
    for solid, rows in sorted(gained.items(), key=lambda item: -sum(one.length_mm for _, one in item[1])):
        total = sum(one.length_mm for _, one in rows)
        loose = ", which touches nothing," if rows[0][1].is_loose else ""
        names = ", ".join(seam.name for seam, _ in rows)
        told.append(f"without {solid}{loose} the torch would reach {total:.1f} mm more ({names})")
    return told[:MOST_SOLIDS]
