"""`wpcal plan` with one robot: what it takes, writes and prints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import option
from wpcal.cli.shared_help import ANGLE, ONLY_HELP

if TYPE_CHECKING:
    from wpcal.cli.plan import WeldFlags
    from wpcal.planning.cell.one_robot import OneRobotCell
    from wpcal.planning.sequence.plan_sequence import SequenceChoice
    from wpcal.planning.sequence.targets import SequenceTargets
    from wpcal.planning.sequence.timeline import Timeline


@dataclass(frozen=True, slots=True, kw_only=True)
class SequenceFlags:
    """What is asked for with one robot."""

    only: str | None = option("--only", metavar="W1,W5-W8", help=f"{ONLY_HELP}  [default: the accepted ones]")
    position: str = option(
        "--position",
        type=click.Choice(["flat", "PA", "PB", "any"]),
        default="flat",
        show_default=True,
        help="With one robot: the weld position that the positioner brings seams into; flat: PA, PB or between.",
    )
    position_tol_deg: float = option(
        "--position-tol-deg",
        type=ANGLE,
        default=10.0,
        show_default=True,
        help="How far from the weld position a seam is still in position.",
    )
    order: str = option(
        "--order",
        type=click.Choice(["time", "listed", "skip"]),
        default="time",
        show_default=True,
        help="Order of the seams: least time, as listed, or each far from the two before it (less distortion).",
    )

    def to_targets(self, weld: WeldFlags, *, seed: int) -> SequenceTargets:
        """Return what a sequence is asked for, angles in radians."""
        from wpcal.planning.sequence.targets import SequenceTargets, WeldOrder, WeldPosition

        return SequenceTargets(
            position=WeldPosition(self.position),
            position_tol_rad=math.radians(self.position_tol_deg),
            work_rad=math.radians(weld.work_angle_deg),
            travel_rad=math.radians(weld.travel_angle_deg),
            torch_range_rad=math.radians(weld.torch_range_deg),
            order=WeldOrder(self.order),
            speed_mm_s=weld.speed_mm_s,
            seed=seed,
        )


def run_sequence(
    cell: OneRobotCell,
    result: Path,
    output: Path,
    targets: SequenceTargets,
    flags: SequenceFlags,
    *,
    prefer: str,
    force: bool,
    as_json: bool,
) -> int:
    """Plan, write the folder and print what was found; 1 if a stretch is not welded or a move is not free."""
    from wpcal.cli.progress import shown_progress
    from wpcal.controllers.sequence_program import possible_sequences
    from wpcal.core.errors import InputError
    from wpcal.core.records import new_directory, to_json, write_file
    from wpcal.formats.trajectory import joint_trajectory
    from wpcal.pages.sequence import build_sequence_page
    from wpcal.planning.sequence.plan_sequence import SequencePreference, plan_sequence
    from wpcal.planning.sequence.sequence_input import read_sequence_input
    from wpcal.planning.sequence.sequence_record import sequence_csv, sequence_record
    from wpcal.planning.sequence.timeline import build_timeline
    from wpcal.seam.names import split_names

    names = None if flags.only is None else split_names(flags.only)
    given = read_sequence_input(result, cell, names)
    cell = given.placed(cell)
    if not cell.torch:
        raise InputError(
            "the torch has no bodies: no collision of the torch can be found; list them in torch_robot.torch"
        )
    with shown_progress("starting") as progress:
        choice = plan_sequence(
            cell, given.part, given.seams, targets, prefer=SequencePreference(prefer), progress=progress
        )
    line = build_timeline(choice.sequence)
    programs, refused = possible_sequences(choice.sequence)
    record = sequence_record(choice, line, no_program=refused)
    files: dict[str, str] = {"plan.json": to_json(record), "plan.csv": sequence_csv(choice.sequence, line), **programs}
    files["trajectory.yaml"] = joint_trajectory(choice.sequence, line)
    files["plan.html"] = build_sequence_page(choice, line, part_glb=given.part_glb)
    with new_directory(output, overwrite=force) as folder:
        for name, text in files.items():
            write_file(folder / name, text, overwrite=True)
    if as_json:
        click.echo(files["plan.json"], nl=False)
    else:
        _show(choice, line, has_part=given.part is not None)
        click.echo(f"wrote {', '.join(files)} to {output}")
    for name, why in refused.items():
        click.echo(f"wpcal: no {name} program: {why}", err=True)
    for gap in choice.sequence.unwelded:
        click.echo(f"wpcal: {gap.describe()}", err=True)
    return 0 if choice.sequence.is_free and not choice.sequence.unwelded else 1


def _show(choice: SequenceChoice, line: Timeline, *, has_part: bool) -> None:
    """Print the table of seams and the plans to choose from."""
    from rich.table import Table

    from wpcal.cli.console import plain_console
    from wpcal.planning.sequence.sequence_record import checked_text, position_name

    console, sequence = plain_console(), choice.sequence
    table = Table(title=f"Seams in the order of welding: {sequence.cell.name}")
    columns = ("", "seam", "mm", "external axes", "slope", "rotation", "off position", "mm/s", "least margin mm")
    for heading in columns:
        table.add_column(heading, justify="left" if heading in ("seam", "external axes") else "right")
    for row, piece in enumerate(sequence.pieces, start=1):
        candidate = piece.candidate
        slope, rotation = position_name(sequence.cell, piece)
        late = candidate.off_position_rad > sequence.targets.position_tol_rad
        off = math.degrees(candidate.off_position_rad)
        rail = sequence.cell.rail_axis
        external = [
            f"{value:.0f} mm" if axis == rail else f"{math.degrees(value):.0f}"
            for axis, value in enumerate(candidate.q[0].tolist())
            if axis >= 6  # the joints of the arm
        ]
        table.add_row(
            f"{row}",
            f"{piece.name}{' (reversed)' if candidate.is_reversed else ''}",
            f"{candidate.task.length_mm:.0f}",
            ", ".join(external),
            f"{slope:.0f}",
            "" if math.isnan(rotation) else f"{rotation:.0f}",
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
    console.print(f"{'free' if sequence.is_free else 'NOT FREE'}: {checked_text(sequence)}")
    if not has_part:
        console.print("NOT CHECKED for collisions with the part: there is no part.glb beside the seams")
