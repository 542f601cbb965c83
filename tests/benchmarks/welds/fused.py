"""Fused variants of parts with lists: bodies that welds join become one body, as other programs and suppliers draw it.

The list stays the same: what was a weld between two bodies is one inside a body. Faces that continue each other are
united, so that no edge is left where two bodies were flush.
"""

from pathlib import Path
from typing import Any

from build123d import Solid
from OCP.TopLoc import TopLoc_Location

from cad.step.new_file import plain_step_text
from cad.step.read import read_step
from tests.benchmarks.welds.lists import OPTIONAL, Weld


def fused_groups(names: tuple[str, ...], welds: tuple[Weld, ...]) -> list[list[int]]:
    """Return the numbers of bodies that sure and probable welds join, directly or through others."""
    group = {name: {name} for name in names}
    for weld in welds:
        if weld.cls != OPTIONAL:
            whole = set().union(*(group[name] for name in weld.members if name in group))
            group |= dict.fromkeys(whole, whole)
    whole = {id(own): own for own in group.values()}.values()
    return [[row for row, name in enumerate(names) if name in own] for own in whole]


def write_fused(step: Path, welds: tuple[Weld, ...], path: Path) -> int:
    """Write a part with its welded bodies fused; return how many bodies were fused into others."""
    solids = read_step(step).solids
    names = tuple(solid.name for solid in solids)
    groups = fused_groups(names, welds)
    members: list[tuple[str, Any, Any]] = []
    for rows in groups:
        first, *others = (Solid(solids[row].shape) for row in rows)
        whole = first.fuse(*others).clean().solids() if others else [first]
        members += [
            (f"{names[rows[0]]}-{number}", solid.wrapped, TopLoc_Location()) for number, solid in enumerate(whole)
        ]
    path.write_bytes(plain_step_text(members, path.stem, pcurves=False))
    return len(names) - len(members)
