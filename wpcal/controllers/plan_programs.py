"""Write the programs of a plan in several languages; each is checked, and one that refuses stops no other.

What a language needs is asked for before anything is planned (`refusals`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.controllers.judge.in_cell import CellSweep
from wpcal.controllers.judge.written import WrittenBlockedError, write_judged
from wpcal.controllers.program import WeldProgram
from wpcal.controllers.program.planned_program import PlanOutput, build_planned_program
from wpcal.controllers.registry import Controller
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.planning.cell.cell import Cell
from wpcal.planning.sequence.kept_plan import KeptPiece, KeptPlan
from wpcal.planning.sequence.seam_task import seam_task
from wpcal.planning.sequence.sequence_input import PlannedSeam


@dataclass(slots=True)
class WrittenPlan:
    """The programs of a plan, by language."""

    files: dict[str, Mapping[str, str | bytes]] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)  #: Why there is no program.
    not_checked: list[str] = field(default_factory=list)
    open: list[str] = field(default_factory=list)  #: What the headers of all programs say that nobody checked.

    def tell(self, name: str, unjudged: Sequence[str]) -> None:
        """Keep what was not checked of the programs of a language."""
        self.not_checked += (f"NOT CHECKED: {name}: {what}" for what in unjudged)

    def notes(self, *, why: bool) -> list[str]:
        """Say what was not checked, and why there is no program: where it was asked for, or in no language."""
        reasons = self.refused.items() if why or not self.files else ()
        return [*self.open, *self.not_checked, *(f"no {name} program: {reason}" for name, reason in reasons)]


def write_plan(
    plan: KeptPlan,
    seams: Sequence[PlannedSeam],
    output: PlanOutput,
    writers: Sequence[Controller],
    part: TriangleMaterial | None,
) -> WrittenPlan:
    """Return the programs of a plan, executed and swept in its cell.

    `part`: In `part`.

    Between two points of a plan a line or an arc may turn the torch otherwise than the plan does. If that is not free,
    such a seam keeps nearer to the plan.

    Raises `FormatError` when a template of the user has a fault.
    """
    in_cell = _sweep(plan, seams, part)
    try:
        return _written(plan, seams, output, writers, in_cell)
    except WrittenBlockedError:
        return _written(plan, seams, replace(output, is_free=in_cell.is_free_along), writers, in_cell)


def _written(
    plan: KeptPlan, seams: Sequence[PlannedSeam], output: PlanOutput, writers: Sequence[Controller], in_cell: CellSweep
) -> WrittenPlan:
    named, found = {each.name: each for each in seams}, WrittenPlan()
    with _telling(found.refused, [each.name for each in writers]):
        output = replace(output, zones=_zones(in_cell, output))
        carried = build_planned_program(plan, named, output)
    if found.refused:
        return found
    found.open = [line for line in carried.checked if line.startswith("NOT CHECKED")]
    for each in writers:
        with _telling(found.refused, [each.name]):
            is_carried = each.coordinates_arcs or carried.planned is None or not carried.planned.follows
            program = carried if is_carried else build_planned_program(plan, named, replace(output, is_carried=False))
            program = _with_corners(program, output, each)
            sweep = in_cell if is_carried else replace(in_cell, is_carried=False)
            written = write_judged(each.name, each.write, program, in_cell=sweep)
            found.files[each.name] = written.files
            found.tell(each.name, (*written.unjudged, *written.not_checked))
    return found


def _zones(in_cell: CellSweep, output: PlanOutput) -> Callable[[FloatArray], tuple[FloatArray, FloatArray]] | None:
    """Return what finds the zones of joint moves; None where corners are exact."""
    most_mm = output.controller.zone_mm
    return partial(in_cell.zones, most_mm=most_mm) if most_mm and not in_cell.has_moving_axes else None


@contextmanager
def _telling(refused: dict[str, str], names: Iterable[str]) -> Iterator[None]:
    """Keep why languages refuse a program; a fault in a file of the user stops all of them."""
    try:
        yield
    except FormatError:
        raise
    except InputError as error:
        refused |= dict.fromkeys(names, str(error))


def _sweep(plan: KeptPlan, seams: Sequence[PlannedSeam], part: TriangleMaterial | None) -> CellSweep:
    """Return what sweeps the programs of a plan."""
    ways = [q for way in plan.ways for q in (way.from_home, way.to_home)]
    more_mm = max((each.seam.more_wire_mm for each in seams), default=0.0)
    return CellSweep.of(plan.cell, part, [*plan.air, *ways], [piece.q for piece in plan.pieces], more_mm)


def _with_corners(program: WeldProgram, output: PlanOutput, controller: Controller) -> WeldProgram:
    """Return a program that says what happens at corners of joint moves: exact where a language cannot round them."""
    planned, asked = program.planned, output.controller.zone_mm
    if planned is None or not asked:
        return program
    rounds = controller.takes_zones and output.zones is not None
    legs = planned.legs if controller.welds_alone else planned.air
    sizes = [mm for moves in legs if moves.zone_mm is not None for mm in moves.zone_mm if mm]
    if rounds:
        count, least = len(sizes), min(sizes, default=0.0)
        told = f"{count} corners of joint moves are rounded, within {least:g} to {max(sizes, default=0.0):g} mm"
    else:
        why = "external axes move" if controller.takes_zones else "this language bounds no zone"
        told = f"the robot stops at every corner of joint moves: {why}"
    return replace(program, planned=replace(planned, about=(*planned.about, told)))


def refusals(
    cell: Cell, seams: Sequence[PlannedSeam], output: PlanOutput, writers: Sequence[Controller]
) -> dict[str, str]:
    """Return which languages refuse every plan of these seams, and why: names, numbers, weld data, templates.

    A plan in which the arm stands at home is written for this, with two points of each seam.

    Raises `FormatError` when a template of the user has a fault.
    """
    home = cell.home[None]
    ends = [seam_task(each.seam, each.speed_mm_s, each.rank) for each in seams]
    ends = [replace(task.part_of(0, 1), s_mm=task.s_mm[[0, -1]], p=task.p[[0, -1]]) for task in ends]
    pieces = tuple(KeptPiece(task.name, task, 0, np.repeat(home, 4, axis=0), 1, 1) for task in ends)
    still = KeptPlan(cell, pieces, (home,) * (len(pieces) + 1), (), (), True, "", 1.0, 1.0, 1.0)
    program = build_planned_program(still, {each.name: each for each in seams}, replace(output, tolerance=None))
    found = dict[str, str]()
    for each in writers:
        with _telling(found, [each.name]):
            each.write(program)
    return found
