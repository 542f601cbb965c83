"""`wpcal plan`: one robot on all seams, or two robots on one: plans to choose from, the chosen one as programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.export_plan import refuse_other_tool
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import require_result
from wpcal.cli.part_option import part_option
from wpcal.cli.plan_sequence import PlanPrograms
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option
from wpcal.core.options import group, opt

if TYPE_CHECKING:
    from wpcal.planning.cell.cell import Cell
    from wpcal.planning.search.nsga2 import Nsga2Options
    from wpcal.planning.search.objectives import WeldTargets
    from wpcal.planning.sequence.targets import SequenceTargets


@dataclass(frozen=True, slots=True, kw_only=True)
class GeneticAsked:
    """Whether and how NSGA-II searches after the deterministic search."""

    generations: int = opt(0, "Generations of NSGA-II; 0: do not run it.", least=0)
    options: Nsga2Options = group("wpcal.planning.search.nsga2:Nsga2Options")

    def asked(self) -> Nsga2Options | None:
        """Return the options of NSGA-II; None without a generation."""
        return replace(self.options, generations=self.generations) if self.generations else None


@command()
@path_argument("cell_json", metavar="CELL.json")
@path_argument("seams_json", metavar="[RESULT]", required=False)
@click.option("--seam", metavar="NAME", help="With two robots: only this seam.  [default: those of --only]")
@part_option
@path_option("-o", "--out", "output", metavar="DIR", help="Output: a folder.")
@click.option(
    "--check",
    "check_only",
    is_flag=True,
    help="Plan nothing: list what is odd in CELL.json, and draw the cell in cell.html (in the folder of -o, or here).",
)
@click.option(
    "--prefer",
    type=click.Choice(["position", "smooth", "balanced"]),
    default="balanced",
    show_default=True,
    help="Which plan is written as programs.",
)
@takes("programs", PlanPrograms)
@takes("targets", "wpcal.planning.sequence.targets:SequenceTargets", without=["seed"], later=True)
@takes("weld", "wpcal.planning.search.objectives:WeldTargets", later=True)
@takes("genetic", GeneticAsked)
@click.option(
    "--joints",
    is_flag=True,
    help="Programs of two robots as joint moves with a mark at every point of the seam, not as coordinated motion.",
)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the files of this command in the folder.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the record of pareto.json.")
def plan(
    *,
    cell_json: Path,
    seams_json: Path | None,
    seam: str | None,
    part: Path | None,
    output: Path | None,
    check_only: bool,
    prefer: str,
    programs: PlanPrograms,
    targets: Callable[[], SequenceTargets],
    weld: Callable[[], WeldTargets],
    genetic: GeneticAsked,
    joints: bool,
    force: bool,
    as_json: bool,
) -> int:
    """Plan how one robot welds all seams of a part, or how two robots weld its seams one by one.

    CELL.json describes the cell: robots, positioner, tools and their places (`wpcal cell new`). RESULT is the folder of
    `wpcal calibrate` or `wpcal seams`, or its seams.json.

    With one robot all accepted seams are planned together: directions, order, positioner, torch angles, branches of the
    arm, and the moves between seams. Writes plan.json, plan.csv, plan.html, and programs. Seams that cannot be welded
    are told with the reason; the command then ends with code 1.

    With two robots (a cell with holder_robot) each seam is planned by itself, in a folder of its name if there are
    several: robot 1 with the torch, robot 2 holding and turning the part. The ways between seams are not planned.
    Writes pareto.json (the trade-off plans), plan.html (a page that shows them), and for the chosen plan plan.json,
    plan.csv and the programs of both robots: coordinated motion in the frame of the held part, or with --joints joint
    moves. Ctrl-C keeps the best plans so far. Ends with code 1 if there is no feasible plan.

    With --check only the cell is read, listed and drawn, as by `wpcal cell check`. It ends with code 2 if anything in
    the cell is odd.
    """
    if check_only:
        from wpcal.cli.cell_check import run_cell_check

        return run_cell_check(cell_json, output, force=force, as_json=as_json)
    if seams_json is None or output is None:
        raise _incomplete({"RESULT": seams_json, "-o": output})
    require_result(seams_json, cell_json)
    refuse_other_tool(cell_json, seams_json)
    cell = _cell(cell_json, output, needs_pymoo=bool(genetic.generations), force=force)
    if cell.has_two_robots:
        from wpcal.cli.two_robots import TwoRobotRequest, run_seams_of_two_robots

        if part is not None:
            raise click.UsageError("--part is for one robot: the bodies of a held part are in its cell file")
        request = TwoRobotRequest(
            cell_json, cell, seams_json, output, joints, weld(), targets().speed_mm_s, prefer, genetic.asked(), programs
        )
        return run_seams_of_two_robots(request, seam, force=force, as_json=as_json)
    from wpcal.cli.plan_sequence import SequenceRequest, run_sequence

    if seam is not None:
        raise click.UsageError("--seam is for two robots; name the seams of one robot with --only")
    seeded = replace(targets(), seed=genetic.options.seed)
    asked = SequenceRequest(cell_json, cell, seams_json, output, seeded, programs, prefer, part)
    return run_sequence(asked, force=force, as_json=as_json)


def _cell(cell_json: Path, output: Path, *, needs_pymoo: bool, force: bool) -> Cell:
    """Refuse at the start what would fail at the end, and read the cell."""
    from wpcal.core.records import check_writable
    from wpcal.planning.cell.cell_file import read_cell

    check_writable(output, overwrite=force)
    _require_extra("fcl", *(("pymoo",) if needs_pymoo else ()))
    return read_cell(cell_json)


def _incomplete(given: Mapping[str, object]) -> click.UsageError:
    names = ", ".join(name for name, value in given.items() if value is None)
    return click.UsageError(f"a plan needs {names}; to check the cell alone, add --check")


def _require_extra(*modules: str) -> None:
    from importlib.util import find_spec

    from wpcal.core.errors import InputError

    missing = [module for module in modules if find_spec(module) is None]
    if missing:
        raise InputError(f"planning needs {', '.join(missing)}: install wpcal[planning]")
