"""From a run of two robots to their programs, for every controller that can hold them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.controllers.judge.in_step import require_in_step
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.program.arc import ArcSettings
from wpcal.controllers.program.coordinated_program import SyncProgram, build_coordinated_program, swept_notes
from wpcal.controllers.registry import controller_named, controllers
from wpcal.core.errors import InputError
from wpcal.core.version import __version__
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.closed_chain import SeamPath
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.plan.coordinated import CoordinatedRun, HolderMove, coordinate_run
from wpcal.planning.plan.plan import CollisionVerdict
from wpcal.planning.plan.run import CellRun
from wpcal.robot.moves import PathTolerance
from wpcal.robot.moves.fit import USUAL_TOLERANCE
from wpcal.seam.seam import Seam
from wpcal.weld.seam_weld import SeamWeld


def build_sync_program(run: CellRun, cell: Cell, *, controller: ControllerSettings | None = None) -> SyncProgram:
    """Return the program of both robots for a run.

    Raises `InputError` when the run was checked and is not free: wpcal never writes a program that is known to collide.

    `controller`: By default the program is named after the seam, so that programs of several seams can be loaded
    together.
    """
    verdict = run.verdict
    if verdict is CollisionVerdict.NOT_FREE and run.check is not None:
        raise InputError(
            f"seam {run.plan.seam}: no program is written for a path that is not free: {run.check.describe()}"
        )
    checked = "NOT CHECKED for collisions" if run.check is None else f"checked: {verdict.value}; {run.check.describe()}"
    return SyncProgram(
        seam=run.plan.seam,
        arms=(cell.arm, cell.arm2),
        joints=(run.q[:, :JOINTS], run.q[:, JOINTS:]),
        seconds=np.diff(run.t_s),
        arc_on=run.first,
        arc_off=run.last,
        notes=(f"written by wpcal {__version__} from plan.json", run.schedule.describe(), checked),
        controller=controller or ControllerSettings(program_name=f"WPCAL_{run.plan.seam}"),
    )


def sync_languages() -> tuple[str, ...]:
    """Return the names of the controllers that can hold programs of two robots."""
    return tuple(controller.name for controller in controllers() if controller.sync_writer is not None)


def coordinated_languages() -> tuple[str, ...]:
    """Return the names of the controllers that can hold coordinated motion."""
    return tuple(controller.name for controller in controllers() if controller.coordinated_writer is not None)


def write_programs(program: SyncProgram, languages: Sequence[str] | None = None) -> dict[str, str]:
    """Return the files of a program: names and contents.

    Raises `InputError` when a language is not known, or cannot hold the program.
    """
    known = sync_languages()
    chosen = known if languages is None else languages
    unknown = [name for name in chosen if name not in known]
    if unknown:
        raise InputError(f"programs of two robots: unknown language {unknown[0]!r}; known: {', '.join(known)}")
    return {file: text for name in chosen for file, text in controller_named(name).write_sync(program).items()}


def possible_programs(program: SyncProgram, languages: Sequence[str] | None = None) -> tuple[dict[str, str], list[str]]:
    """Return the files in all languages that can hold a program, and why the other languages cannot."""
    files: dict[str, str] = {}
    refusals: list[str] = []
    for name in languages or sync_languages():
        try:
            files |= write_programs(program, (name,))
        except InputError as error:
            refusals.append(str(error))
    return files, refusals


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldWeld:
    """What is welded on the part that robot 2 holds, and how its program is written."""

    seam: Seam  #: In `part`.
    tolerance: PathTolerance = USUAL_TOLERANCE  #: Of the lines and arcs.
    weld: SeamWeld | None = None  #: Its weld data.
    arc: ArcSettings | None = None  #: None for a dry run.
    part: TriangleMaterial | None = None  #: In `part`; None: only the bodies of the cell are in the hand of robot 2.


def possible_coordinated(
    run: CellRun,
    cell: Cell,
    held: HeldWeld,
    *,
    controller: ControllerSettings | None = None,
    languages: Sequence[str] | None = None,
) -> tuple[dict[str, str], list[str], dict[str, CoordinatedRun]]:
    """Return a run in coordinated motion in all languages that can hold it.

    Returns `files`: dict of str to str. Names and contents.
    Returns `refusals`: list of str. Why the other languages cannot hold it.
    Returns `motions`: By language, the motion in its files: languages differ in how they move robot 2.
    """
    path = SeamPath.of_frames(held.seam.name, held.seam.frames)
    runs: dict[tuple[HolderMove, bool], CoordinatedRun | InputError] = {}
    files: dict[str, str] = {}
    refusals: list[str] = []
    motions: dict[str, CoordinatedRun] = {}
    for each in map(controller_named, languages or coordinated_languages()):
        kind = (HolderMove.LINE if each.holder_on_line else HolderMove.JOINTS, each.coordinates_arcs)
        try:
            if kind not in runs:
                runs[kind] = _coordinated(run, cell, path, kind, held.tolerance)
            found = runs[kind]
            if isinstance(found, InputError):
                raise found
            program = build_coordinated_program(found, held.seam, controller=controller, weld=held.weld, arc=held.arc)
            program = program if each.run is None else replace(program, notes=swept_notes(program.notes))
            own = each.write_coordinated(program)
            require_in_step(own, program, cell, held.part)
            files |= own
            motions[each.name] = found
        except InputError as error:
            why = str(error)
            refusals.append(why if why.lower().startswith(each.name) else f"{each.name}: {why}")
    return files, refusals, motions


def _coordinated(
    run: CellRun, cell: Cell, path: SeamPath, kind: tuple[HolderMove, bool], tolerance: PathTolerance
) -> CoordinatedRun | InputError:
    """Return the motion, or why there is none: the next language of the same kind is then refused at once."""
    try:
        return coordinate_run(run, cell, path, holder=kind[0], arcs=kind[1], tolerance=tolerance)
    except InputError as error:
        return error
