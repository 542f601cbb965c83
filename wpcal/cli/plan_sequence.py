"""`wpcal plan` with one robot: what it takes, writes and prints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.export_options import PathAsked
from wpcal.cli.part_option import read_part_option
from wpcal.cli.shared_help import ONLY_HELP
from wpcal.cli.weld_options import ArcAsked
from wpcal.core.options import group, opt

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

    from wpcal.cli.export_options import WeldProgramAsked
    from wpcal.controllers.plan_programs import WrittenPlan
    from wpcal.controllers.program.planned_program import PlanOutput
    from wpcal.controllers.program.weld_program import ControllerSettings
    from wpcal.controllers.registry import Controller
    from wpcal.core.arrays import FloatArray
    from wpcal.planning.cell.cell import Cell
    from wpcal.planning.sequence.plan_sequence import SequenceChoice
    from wpcal.planning.sequence.sequence_input import SequenceInput
    from wpcal.planning.sequence.targets import SequenceTargets
    from wpcal.planning.sequence.timeline import Timeline


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanPrograms:
    """Which seams are planned, and how plans become programs."""

    only: str | None = opt(None, f"{ONLY_HELP}  [default: the accepted ones]", metavar="W1,W5-W8")
    formats: tuple[str, ...] = opt(
        (),
        "Language or maker, as rapid or abb; repeatable.  [default: all that can hold a plan]",
        "-f",
        "--format",
        many=True,
    )
    path: PathAsked = group(PathAsked)
    controller: ControllerSettings = group("wpcal.controllers.program.weld_program:ControllerSettings")
    arc: ArcAsked = group(ArcAsked)


@dataclass(frozen=True, slots=True)
class SequenceRequest:
    """What is planned with one robot."""

    cell_json: Path
    cell: Cell  #: Of that file.
    result: Path  #: A folder with ``seams.json``, or the file.
    output: Path  #: The folder.
    targets: SequenceTargets
    flags: PlanPrograms  #: Seams, languages, tolerance of the path, names in the controller, and the arc.
    prefer: str  #: Which plan is written as programs.
    part: Path | None  #: The part, if not ``part.glb`` beside the seams.


def run_sequence(asked: SequenceRequest, *, force: bool, as_json: bool) -> int:
    """Plan, write the folder and print what was found; 1 if a stretch is not welded or a move is not free."""
    from wpcal.cli.progress import shown_progress
    from wpcal.controllers.plan_programs import refusals, write_plan
    from wpcal.core.records import to_json
    from wpcal.pages.sequence import build_sequence_page
    from wpcal.planning.sequence.cuts import out_of_reach
    from wpcal.planning.sequence.kept_plan import INPUT, input_files, kept_plan_of, with_digest
    from wpcal.planning.sequence.plan_sequence import SequencePreference, plan_sequence
    from wpcal.planning.sequence.timeline import build_timeline, sequence_csv, sequence_record
    from wpcal.planning.sequence.trajectory import joint_trajectory, tesseract_states

    flags, targets, output = asked.flags, asked.targets, asked.output
    writers = plan_writers(flags.formats)
    given, cell = _read(asked)
    planned = [each.name for each in given.seams]
    given, made = with_welds(given, cell, flags, calibration_of(given, asked.result), targets.speed_mm_s)
    refused = refusals(cell, given.seams, made, writers)
    if flags.formats:
        refuse_languages(refused, writers)
    for odd in filter(None, (given.other_torch(cell), *out_of_reach(cell, given.seams, targets))):
        click.echo(f"wpcal: {odd}", err=True)
    with shown_progress("starting") as progress:
        choice = plan_sequence(
            cell, given.part, given.seams, targets, prefer=SequencePreference(asked.prefer), progress=progress
        )
    line = build_timeline(choice.sequence)
    inputs = dict(
        input_files(asked.cell_json, asked.result, given.part_glb, flags.arc.welds, flags.arc.rules.weld_rules)
    )
    record = sequence_record(choice, line, inputs=inputs, planned=planned, runs=flags.arc.choice)
    kept = kept_plan_of(record, cell, {each.name: each for each in given.seams})
    found = write_plan(kept, given.seams, made, [each for each in writers if each.name not in refused], given.part)
    found.refused |= refused
    record = with_digest({**record, "no_program": found.refused})
    files: dict[str, str] = {
        "plan.json": to_json(record),
        "plan.csv": sequence_csv(choice.sequence, line),
        "trajectory.yaml": joint_trajectory(choice.sequence, line),
        "trajectory_tesseract.py": tesseract_states(choice.sequence, line),
        "plan.html": build_sequence_page(choice, line, part_glb=given.part_glb),
    }
    folders = {INPUT: inputs, **found.files}
    write_folder(output, files, folders, force=force)
    if as_json:
        click.echo(files["plan.json"], nl=False)
    else:
        _show(choice, line, has_part=given.part is not None)
        if found.files and found.refused and not flags.formats:
            click.echo(f"no program in {', '.join(found.refused)}: plan.json says why (no_program)")
        listed = [*files, *(f"{name}/ ({len(texts)})" for name, texts in folders.items())]
        click.echo(f"wrote {', '.join(listed)} to {output}\n{said_of_arc(made)}")
    _say_notes(choice, given, found, flags)
    is_whole = choice.sequence.is_free and not choice.sequence.unwelded and not found.not_checked
    return 0 if is_whole and not (flags.formats and found.refused) else 1


def _read(asked: SequenceRequest) -> tuple[SequenceInput, Cell]:
    """Return the seams and the cell with the part in its place. Raises `InputError` when the torch has no bodies."""
    from wpcal.core.errors import InputError
    from wpcal.planning.sequence.sequence_input import read_sequence_input
    from wpcal.seam.names import split_names

    names = None if asked.flags.only is None else split_names(asked.flags.only)
    given = read_sequence_input(asked.result, asked.cell, names, part_glb=read_part_option(asked.part))
    cell = given.placed(asked.cell)
    if not cell.torch:
        raise InputError(
            "the torch has no bodies: no collision of the torch can be found; list them in torch_robot.torch"
        )
    return given, cell


def _say_notes(choice: SequenceChoice, given: SequenceInput, found: WrittenPlan, flags: PlanPrograms) -> None:
    """Say what is open, which ways are short, what weaves are, why there is no program, and what is not welded."""
    from wpcal.controllers.program.describe import describe_woven_data

    notes = (
        *choice.sequence.open_points(has_part=given.part is not None or bool(found.open)),
        *choice.sequence.short_ways,
        *describe_woven_data(each.run for each in given.seams),
        *found.notes(why=bool(flags.formats)),
    )
    for note in (*notes, *(gap.describe() for gap in choice.sequence.unwelded)):
        click.echo(f"wpcal: {note}", err=True)


def write_folder(
    output: Path, files: Mapping[str, str], folders: Mapping[str, Mapping[str, str | bytes]], *, force: bool
) -> None:
    """Write the files of a plan, and the folders beside them."""
    from wpcal.core.records import new_directory, write_file

    for target, texts in {output: files, **{output / name: texts for name, texts in folders.items()}}.items():
        with new_directory(target, overwrite=force) as folder:
            for name, data in texts.items():
                write_file(folder / name, data, overwrite=True)


def said_of_arc(made: PlanOutput) -> str:
    """Say whether programs switch the arc."""
    return "the programs are a dry run: the arc stays off" if made.arc is None else "the programs switch the arc"


def refuse_languages(refused: Mapping[str, str], writers: Sequence[Controller]) -> None:
    """Refuse to go on when no language that is asked for can hold the programs.

    Raises `InputError` with the first reason.
    """
    from wpcal.core.errors import InputError

    if len(refused) == len(writers):
        raise InputError("; ".join(f"no {name} program: {why}" for name, why in refused.items()))


def plan_writers(formats: tuple[str, ...]) -> tuple[Controller, ...]:
    """Return the controllers whose programs are asked for; by default all that can hold a plan.

    Raises `InputError` when a name is unknown, or its controller has no programs of plans.
    """
    from wpcal.controllers.registry import controller_named, controllers
    from wpcal.core.errors import InputError

    able = tuple(each for each in controllers() if each.takes_plans)
    chosen = tuple({each.name: each for each in map(controller_named, formats)}.values())
    for each in chosen:
        if not each.takes_plans:
            known = ", ".join(one.name for one in able)
            raise InputError(f"{each.name}: no programs of plans are written in it; formats of plans: {known}")
    return chosen or able


def with_welds(
    given: SequenceInput,
    cell: Cell,
    flags: PlanPrograms | WeldProgramAsked,
    calibration: Mapping[str, Any],
    speed_mm_s: float,
) -> tuple[SequenceInput, PlanOutput]:
    """Return the seams with their weld data, and how the plan becomes programs."""
    from wpcal.controllers.program.planned_program import PlanOutput

    T_base_part, seams = given.in_base(cell)
    names = {each.name for each in given.seams}
    welds, arc = flags.arc.read(seams, T_base_part, part_glb=given.part_glb, names=names)
    output = PlanOutput(flags.path.tolerance, flags.controller, arc, calibration, given.part_glb is not None)
    return given.with_welds(welds, flags.arc.choice, speed_mm_s), output


def calibration_of(given: SequenceInput, result: Path) -> Mapping[str, Any]:
    """Return the record of the calibration that found the part; empty without one."""
    from wpcal.core.result_files import CALIBRATION_FILE
    from wpcal.results.folder import read_record

    folder = result if result.is_dir() else result.parent
    is_calibrated = given.T_base_part is not None and (folder / CALIBRATION_FILE).exists()
    return read_record(folder, CALIBRATION_FILE) if is_calibrated else {}


def _show(choice: SequenceChoice, line: Timeline, *, has_part: bool) -> None:
    """Print the table of seams and the plans to choose from."""
    from wpcal.cli.console import new_table, plain_console
    from wpcal.planning.sequence.timeline import position_name

    console, sequence = plain_console(), choice.sequence
    headings = "|<seam|mm|<external axes|slope|rotation|off position|mm/s|least margin mm"
    table = new_table(f"Seams in the order of welding: {sequence.cell.name}", headings)
    for row, piece in enumerate(sequence.pieces, start=1):
        candidate = piece.candidate
        slope, rotation = position_name(sequence.cell, piece)
        late = candidate.off_position_rad > sequence.targets.position_tol_rad
        off = math.degrees(candidate.off_position_rad)
        external = [_along(sequence.cell, axis, column) for axis, column in enumerate(candidate.q.T) if axis >= 6]
        table.add_row(
            f"{row}",
            f"{piece.name}{' (reversed)' if candidate.is_reversed else ''}",
            f"{candidate.task.length_mm:.0f}",
            ", ".join(external),
            f"{slope:z.0f}",
            "" if math.isnan(rotation) else f"{rotation:z.0f}",
            f"{off:.0f}{' !' if late else ''}",
            f"{piece.speed_mm_s:.1f}{f' ({piece.slowed_by})' if piece.slowed_by else ''}",
            f"{piece.check.margin_mm.min():.1f}",
        )
    console.print(table)
    for preference, values in choice.values.items():
        mark = "*" if preference is choice.chosen else " "
        console.print(
            f"{mark} {preference.value}: {values.position_deg:.1f} deg off position, "
            f"torch {values.torch_deg:.1f} deg off, {values.motion_deg_per_mm:.3f} deg/mm, {values.time_s:.0f} s"
        )
    unwelded = sum(gap.to_mm - gap.from_mm for gap in sequence.unwelded)
    console.print(
        f"welded: {sequence.welded_mm:.0f} mm in {len(sequence.pieces)} pieces, {line.t_s[-1]:.0f} s; "
        f"not welded: {unwelded:.0f} mm"
    )
    if sequence.out_of_position:
        listed = ", ".join(piece.name for piece in sequence.out_of_position)
        console.print(f"out of position (!), more than the tolerance: {listed}")
    console.print(f"{'free' if sequence.is_free else 'NOT FREE'}: {sequence.checked}")
    if not has_part:
        console.print("NOT CHECKED for collisions with the part: there is no part.glb beside the seams; give --part")


def _along(cell: Cell, axis: int, column: FloatArray) -> str:
    """Return an external axis as the table shows it: at rest, or from where to where it moves."""
    unit, factor = (" mm", 1.0) if axis == cell.rail_axis else ("", 180.0 / math.pi)
    start, end = factor * float(column[0]), factor * float(column[-1])
    return f"{start:z.0f}{unit}" if start == end else f"{start:z.0f} to {end:z.0f}{unit}"
