"""`wpcal plan` with two robots: what it takes, writes and prints."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from wpcal.cli.plan_sequence import PlanPrograms
    from wpcal.controllers.program.two_robots import HeldWeld
    from wpcal.planning.cell.cell import Cell
    from wpcal.planning.plan.coordinated import CoordinatedRun
    from wpcal.planning.plan.plan import Plan
    from wpcal.planning.plan.run import CellRun
    from wpcal.planning.search.diagnosis import NoFeasiblePlanError
    from wpcal.planning.search.nsga2 import Nsga2Options
    from wpcal.planning.search.objectives import WeldTargets
    from wpcal.planning.search.pareto import PlanningResult, Preference
    from wpcal.planning.search.problem import PlanningProblem


@dataclass(frozen=True, slots=True)
class TwoRobotRequest:
    """What is planned with two robots."""

    cell_json: Path
    cell: Cell
    result: Path  #: ``seams.json``, or the folder with it.
    output: Path  #: The folder.
    joints: bool  #: Whether programs are joint moves.
    weld: WeldTargets
    speed_mm_s: float
    prefer: str  #: Which plan is written as programs.
    genetic: Nsga2Options | None
    programs: PlanPrograms  #: Seams, languages, tolerance of the path, names in the controller, and the arc.

    @property
    def seams_json(self) -> Path:
        """The file with the seams."""
        from wpcal.core.result_files import SEAMS_FILE

        return self.result / SEAMS_FILE if self.result.is_dir() else self.result

    @property
    def preference(self) -> Preference:
        """Which plan is written as programs."""
        from wpcal.planning.search.pareto import Preference

        return Preference(self.prefer)

    def problem(self, seam: str) -> PlanningProblem:
        """Return what is searched for a seam.

        Raises `InputError` when there is no such seam, or a target is out of its range.
        """
        from wpcal.planning.plan.seam_file import read_seam_path
        from wpcal.planning.search.problem import PlanningProblem

        path = read_seam_path(self.seams_json, seam, self.cell)
        return PlanningProblem(self.cell, path, self.weld, self.speed_mm_s)

    def names(self) -> list[str]:
        """Return the seams of ``--only``, else the accepted ones, in the order of the file.

        Raises `InputError` when a name is unknown, or no seam is accepted.
        """
        from wpcal.core.errors import InputError
        from wpcal.planning.plan.seam_file import read_held_seams
        from wpcal.seam.names import seams_named, split_names

        seams = read_held_seams(self.seams_json, self.cell)
        only = self.programs.only
        chosen = None if only is None else set(seams_named(split_names(only), list(seams)))
        names = [name for name, seam in seams.items() if (seam.accepted if chosen is None else name in chosen)]
        if not names:
            raise InputError(f"{self.seams_json}: none of the {len(seams)} seams is accepted; name one with --only")
        return names


WAYS_BETWEEN = "the ways from one seam to the next are not planned: move both robots there by hand, or by your program"
"""Said where several seams are planned with two robots."""
LONGEST_FOLDER = 60  #: Characters of the name of a folder.


def run_seams_of_two_robots(asked: TwoRobotRequest, seam: str | None, *, force: bool, as_json: bool) -> int:
    """Plan one seam, or each of several in a folder of its own; 1 if one of them has no plan that is free.

    Raises `InputError` as `run_two_robots` does; also when several seams shall be one record on stdout.
    """
    from wpcal.controllers.language.naming import NameRules, safe_names
    from wpcal.core.errors import InputError

    names = asked.names() if seam is None else [seam]
    if seam is not None and asked.programs.only is not None:
        raise InputError("give either --seam or --only")
    if len(names) == 1:
        return run_two_robots(asked, names[0], force=force, as_json=as_json)
    if as_json:
        raise InputError(f"--json prints the record of one seam: name it with --seam; these are {', '.join(names)}")
    problems = [asked.problem(name) for name in names]  # refused before the first search
    folders, codes = safe_names(names, NameRules("folders", LONGEST_FOLDER)), {}
    for name, problem in zip(names, problems, strict=True):
        click.echo(f"{name}: {problem.path.s_mm[-1]:.0f} mm")
        own = replace(asked, output=asked.output / folders[name])
        codes[name] = run_two_robots(own, name, force=force, as_json=False)
    good = [name for name, code in codes.items() if code == 0]
    click.echo(f"{len(good)} of {len(names)} seams have programs: {', '.join(good) or '-'}; {WAYS_BETWEEN}")
    return max(codes.values())


def run_two_robots(asked: TwoRobotRequest, seam: str, *, force: bool, as_json: bool) -> int:
    """Plan, write the folder and print what was found; 1 if there is no feasible plan or its path is not free.

    Raises `InputError` when a file cannot be used, or arc instructions are asked for that cannot be written.
    """
    from wpcal.cli.progress import counted_progress
    from wpcal.controllers.program.coordinated_program import tacks_left_out
    from wpcal.planning.cell.cell_check import check_cell
    from wpcal.planning.plan.seam_file import part_beside
    from wpcal.planning.search.diagnosis import NoFeasiblePlanError
    from wpcal.planning.search.plan_seam import plan_seam

    problem, cell = asked.problem(seam), asked.cell
    _refuse_options(asked)
    held = _held_weld(asked, seam, None)  # bad weld data is refused before the search
    mesh, _ = part_beside(asked.seams_json)
    for issue in check_cell(cell):
        if issue.code != "bases-too-near":  # the search refuses such a cell with the same words
            click.echo(f"wpcal: odd cell: {issue.message}", err=True)
    if held.weld is not None and held.weld.tacks_mm and asked.programs.arc.choice.tacks.value != "off":
        click.echo(f"wpcal: {tacks_left_out(held.weld)}", err=True)
    try:
        with counted_progress("starting") as progress:
            result = plan_seam(problem, genetic=asked.genetic, progress=progress)
    except NoFeasiblePlanError as error:
        return _write_failure(problem, error, asked.output, force=force, as_json=as_json)
    return _write(asked, result, mesh, force=force, as_json=as_json)


def _refuse_options(asked: TwoRobotRequest) -> None:
    """Refuse options that programs of two robots do not have, before the search.

    Raises `InputError` if there is one.
    """
    from wpcal.controllers.program.two_robots import coordinated_languages, sync_languages
    from wpcal.controllers.registry import controller_named
    from wpcal.core.errors import InputError

    flags = asked.programs
    known, what = (sync_languages(), "joint") if asked.joints else (coordinated_languages(), "coordinated")
    for name in flags.formats:
        if controller_named(name).name not in known:
            raise InputError(f"{name} has no {what} programs of two robots; these have: {', '.join(known)}")
    choice = flags.arc.choice
    refused = {
        "programs of joint moves have no arc instructions: leave out --joints, or --arc on": (
            asked.joints and flags.arc.arc == "on"
        ),
        "two robots in coordinated motion have lines and arcs: use --joints for every point": flags.path.every_point,
        "programs of two robots have no templates: leave out --template": flags.controller.templates is not None,
        "programs of two robots have the joints of the plan, or configurations that follow from them: leave out "
        "--config": flags.controller.configurations,
        "a plan of two robots is one bead along the whole seam: leave out --tacks only": choice.tacks.value == "only",
        "a plan of two robots has no weave of points: leave out --weave points": choice.weave.value == "points",
        "a plan of two robots ends a closed seam where it starts: leave out --overlap-mm": choice.overlap_mm,
    }
    for why, is_asked in refused.items():
        if is_asked:
            raise InputError(why)


@dataclass(frozen=True, slots=True)
class Programs:
    """The programs of a run."""

    files: dict[str, str] = field(default_factory=dict)  #: Names and contents.
    refusals: tuple[str, ...] = ()  #: Why some languages have none.
    #: By language, the coordinated motion; none in programs of joint moves.
    motions: dict[str, CoordinatedRun] = field(default_factory=dict)

    def languages_of(self) -> list[tuple[str, CoordinatedRun]]:
        """Return each motion once, with the languages that have it."""
        found = list({id(one): one for one in self.motions.values()}.values())
        return [(", ".join(name for name, one in self.motions.items() if one is motion), motion) for motion in found]


def _held_weld(asked: TwoRobotRequest, name: str, plan: Plan | None) -> HeldWeld:
    """Return what is welded: the seam in `part`, and its weld data in the position that a plan gives it.

    Raises `InputError` when a file cannot be used, or arc instructions are asked for without weld data.
    """
    from wpcal.controllers.program.two_robots import HeldWeld
    from wpcal.core.transform import RigidTransform
    from wpcal.planning.plan.seam_file import part_beside, read_held_seams
    from wpcal.seam.path.position import weld_positions

    cell, (mesh, part) = asked.cell, part_beside(asked.seams_json)
    seams = read_held_seams(asked.seams_json, cell)
    seam, position = seams[name], "-"
    if plan is not None:
        R = cell.part_places(plan.q)[:, :3, :3] @ seam.frames.R
        position, _ = Counter(weld_positions(R, seam.weld).name).most_common(1)[0]
    welds, arc = asked.programs.arc.read(
        list(seams.values()),
        RigidTransform.identity(target="base", source="part"),
        part_glb=mesh,
        names={seam.name},
        positions={} if position == "-" else {seam.name: (position, "plan.json")},
    )
    weld = None if welds is None else welds[seam.name]
    return HeldWeld(seam=seam, tolerance=asked.programs.path.fitted, weld=weld, arc=arc, part=part)


def _programs(run: CellRun, held: HeldWeld, asked: TwoRobotRequest) -> Programs:
    """Return the programs of a run that is free; none if it is not."""
    from wpcal.controllers.judge.in_step import require_in_step
    from wpcal.controllers.program.two_robots import build_sync_program, possible_coordinated, possible_programs
    from wpcal.controllers.registry import controller_named
    from wpcal.planning.plan.plan import CollisionVerdict

    if run.verdict is not CollisionVerdict.FREE:
        return Programs()
    cell, settings = asked.cell, asked.programs.controller
    settings = replace(settings, program_name=f"{settings.program_name}_{run.plan.seam}")
    names = [controller_named(name).name for name in asked.programs.formats] or None
    if asked.joints:
        program = build_sync_program(run, cell, controller=settings)
        files, refusals = possible_programs(program, names)
        require_in_step(files, program, cell, held.part)
        return Programs(files, tuple(refusals))
    files, refusals, motions = possible_coordinated(run, cell, held, controller=settings, languages=names)
    return Programs(files, tuple(refusals), motions)


def _describe(languages: str, found: CoordinatedRun) -> str:
    """Say in one line how few moves a coordinated motion has, and how far it is from the seam and from the plan."""
    from wpcal.controllers.program.describe import counted_moves

    moves = found.moves
    return (
        f"{languages}: {counted_moves(moves.moves)} in the part for {len(found.run.plan)} points; "
        f"wire at most {moves.off_mm:.3f} mm and {math.degrees(moves.off_rad):.2f} deg off the seam, part at most "
        f"{math.degrees(found.part_turned_rad):.2f} deg off the plan; checked again: {found.check.verdict.value}, "
        f"{found.check.describe()}"
    )


def _write(asked: TwoRobotRequest, result: PlanningResult, mesh: bytes | None, *, force: bool, as_json: bool) -> int:
    from wpcal.cli.console import plain_console
    from wpcal.cli.plan_sequence import write_folder
    from wpcal.cli.plan_tables import show_plans
    from wpcal.core.records import to_json
    from wpcal.pages.plan import MethodFront, build_plan_page
    from wpcal.planning.plan.plan import CollisionVerdict, schedule_plan
    from wpcal.planning.plan.run import build_run
    from wpcal.planning.plan.run_record import run_csv, run_record
    from wpcal.planning.search.objectives import OBJECTIVES
    from wpcal.planning.search.pareto import pareto_record
    from wpcal.planning.sequence.kept_plan import INPUT, input_files, with_digest

    cell, preference = result.problem.cell, asked.preference
    plans, chosen = result.front.plans, result.front.chosen(preference)
    held = _held_weld(asked, result.problem.path.name, plans[chosen])
    speed = None if held.weld is None else held.weld.values.speed_mm_s
    speed = speed or result.problem.speed_mm_s
    runs = [build_run(one, cell, schedule_plan(one, cell, speed_mm_s=speed)) for one in plans]
    run = runs[chosen]
    programs = _programs(run, held, asked)
    arc = asked.programs.arc
    inputs = dict(input_files(asked.cell_json, asked.result, mesh, arc.welds, arc.rules.weld_rules))
    record = with_digest(run_record(run, cell, programs.motions, inputs=inputs))
    files = {"plan.json": to_json(record), "plan.csv": run_csv(run, cell)}
    groups = (("ladder", result.ladder), ("nsga2", result.genetic))
    fronts = [MethodFront(name, one.values, result.hypervolume_of(one)) for name, one in groups if one is not None]
    files["plan.html"] = build_plan_page(runs, cell, OBJECTIVES, chosen=chosen, fronts=fronts, part_glb=mesh)
    files |= programs.files
    front = files["pareto.json"] = to_json(pareto_record(result, preference, runs, no_program=programs.refusals))
    write_folder(asked.output, files, {INPUT: inputs}, force=force)
    if as_json:
        click.echo(front, nl=False)
    else:
        show_plans(result, preference, runs, plain_console())
        if not programs.motions:  # the programs are joint moves, or there are none
            plain_console().print(run.tip.describe(run.schedule.speed_mm_s))
        for languages, motion in programs.languages_of():
            plain_console().print(_describe(languages, motion))
    for refusal in programs.refusals:
        click.echo(f"wpcal: no program: {refusal}", err=True)
    return 0 if run.verdict is CollisionVerdict.FREE else 1


def _write_failure(
    problem: PlanningProblem, error: NoFeasiblePlanError, output: Path, *, force: bool, as_json: bool
) -> int:
    """Write the reason why there is no plan, and print it in one line."""
    from wpcal.core.records import new_directory, to_json, write_file
    from wpcal.planning.search.pareto import failed_record

    record = to_json(failed_record(problem, str(error), error.obstacle))
    with new_directory(output, overwrite=force) as folder:
        write_file(folder / "pareto.json", record, overwrite=True)
    if as_json:
        click.echo(record, nl=False)
    click.echo(f"wpcal: {error}", err=True)
    return 1
