"""From a run of both robots to their programs, in every language that can hold them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from wpcal import __version__
from wpcal.controllers.abb.sync import write_dual_rapid
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.sync_program import DualProgram
from wpcal.controllers.yaskawa.sync import write_dual_inform
from wpcal.core.errors import InputError
from wpcal.planning.cell.robot_cell import RobotCell
from wpcal.planning.plan.plan import CollisionVerdict
from wpcal.planning.plan.run import CellRun

DUAL_WRITERS: Mapping[str, Callable[[DualProgram], dict[str, str]]] = {
    "inform": write_dual_inform,
    "rapid": write_dual_rapid,
}
"""Languages of programs for two robots, by name."""


def dual_program(run: CellRun, cell: RobotCell, *, controller: ControllerSettings | None = None) -> DualProgram:
    """Return the program of both robots for a run.

    Parameters
    ----------
    run : CellRun
    cell : RobotCell
    controller : ControllerSettings, optional
        Without it the program is called after the seam, so that those of several seams can be loaded together.

    Raises
    ------
    InputError
        When the run was checked and is not free: a program that is known to collide is not written.
    """
    freedom = run.verdict
    if freedom is CollisionVerdict.NOT_FREE and run.check is not None:
        raise InputError(
            f"seam {run.plan.seam}: no program is written for a path that is not free: {run.check.describe()}"
        )
    checked = "NOT CHECKED for collisions" if run.check is None else f"checked: {freedom.value}; {run.check.describe()}"
    return DualProgram(
        seam=run.plan.seam,
        arms=(cell.arm1, cell.arm2),
        joints=(run.state.joints1, run.state.joints2),
        seconds=np.diff(run.t_s),
        arc_on=run.first,
        arc_off=run.last,
        notes=(f"written by wpcal {__version__} from plan.json", run.schedule.describe(), checked),
        controller=controller or ControllerSettings(program_name=f"WPCAL_{run.plan.seam}"),
    )


def write_programs(program: DualProgram, languages: tuple[str, ...] = tuple(sorted(DUAL_WRITERS))) -> dict[str, str]:
    """Return the files of a program in some languages, by name.

    Raises
    ------
    InputError
        When a language is not known, or the program is beyond what a language can hold.
    """
    unknown = [name for name in languages if name not in DUAL_WRITERS]
    if unknown:
        raise InputError(f"programs of two robots: unknown language {unknown[0]!r}; known: {', '.join(DUAL_WRITERS)}")
    return {file: text for name in languages for file, text in DUAL_WRITERS[name](program).items()}


def possible_programs(program: DualProgram) -> tuple[dict[str, str], list[str]]:
    """Return the files of all languages that can hold a program, and why the others cannot."""
    files: dict[str, str] = {}
    refusals: list[str] = []
    for name in sorted(DUAL_WRITERS):
        try:
            files |= write_programs(program, (name,))
        except InputError as error:
            refusals.append(str(error))
    return files, refusals
