"""`wpcal export` of a plan that was kept: its programs again, with other names, weld data or languages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.outputs import EXPORT_SCHEMA, print_json

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from wpcal.cli.export_options import WeldProgramAsked
    from wpcal.cli.weld_options import ArcAsked
    from wpcal.controllers.plan_programs import WrittenPlan
    from wpcal.controllers.program.planned_program import PlanOutput
    from wpcal.planning.sequence.kept_plan import KeptInput

TAKEN = frozenset(
    {
        *("folder", "formats", "out", "write_templates", "write_setup", "force", "as_json"),
        *("program_name", "tool_name", "tool_number", "set_tool", "zone_mm", "frame_number", "config", "template"),
        *("path_tol_mm", "every_point", "welds", "weld_rules", "arc", "arc_output"),
    }
)
"""Parameters of the command that a plan takes: all others are settled when it is made."""
PLANNED_TOOL = {"standoff_mm": "0", "tool_axis": "z"}  #: Of every cell: the tip of the wire, with z along it.


def is_plan(folder: Path) -> bool:
    """Tell whether a folder holds a plan of one robot, and no calibration."""
    from wpcal.core.input_file import holds_file
    from wpcal.core.result_files import CALIBRATION_FILE

    if holds_file(folder, CALIBRATION_FILE):
        return False
    from wpcal.planning.sequence.kept_plan import PLAN_FILE  # takes long

    return holds_file(folder, PLAN_FILE)


def refuse_other_tool(*given: Path) -> None:
    """Refuse a shop whose tool is not that of a cell: with it the programs of a plan would go elsewhere.

    `given`: Arguments of the command: beside them, or above, is the file of the shop.
    """
    from wpcal.cli.export import export
    from wpcal.cli.shop_file import find_shop, said_of
    from wpcal.core.errors import InputError

    said = said_of(export, "export", find_shop([str(path) for path in given]))
    for name, value in PLANNED_TOOL.items():
        if name in said and str(said[name].value).removesuffix(".0") != value:
            raise InputError(
                f"{said[name]} ({said[name].origin}): the tool of the programs of a plan has its centre at the tip "
                f"of the wire, and z along it. Use such a tool, and say so in the shop, or WPCAL_{name.upper()}={value}"
            )


def export_plan(
    folder: Path, formats: Sequence[str], flags: WeldProgramAsked, *, out: Path | None, force: bool, as_json: bool
) -> int:
    """Write the programs of a plan. The exit code: 1 if a language refuses, or something was not checked."""
    from wpcal.cli.outputs import refuse_options, write_programs
    from wpcal.cli.plan_sequence import calibration_of, plan_writers, refuse_languages, with_welds
    from wpcal.controllers.plan_programs import write_plan
    from wpcal.core.records import check_writable
    from wpcal.planning.sequence.kept_plan import kept_plan_of, read_kept_plan

    settled = "is settled in a plan; give it to wpcal plan, or to its cell (wpcal cell new)"
    refuse_options(TAKEN, lambda _: settled, PLANNED_TOOL)
    refuse_other_tool(folder)
    writers = plan_writers(tuple(formats))
    kept = read_kept_plan(folder)
    targets = {each.name: (out or folder) / each.name for each in writers}
    for target in targets.values():
        check_writable(target, overwrite=force)
    asked = replace(flags, arc=_arc(flags.arc, kept))
    calibration = calibration_of(kept.given, kept.folder)
    given, made = with_welds(kept.given, kept.cell, asked, calibration, kept.record["kept"]["speed_mm_s"])
    plan = kept_plan_of(kept.record, kept.cell, {each.name: each for each in given.seams})
    found = write_plan(plan, given.seams, made, writers, kept.given.part)
    refuse_languages(found.refused, writers)
    write_programs(found.files, targets, overwrite=force)
    _show(found, targets, made, kept.record, as_json=as_json)
    for note in found.notes(why=True):
        click.echo(f"wpcal: {note}", err=True)
    return 1 if found.refused or found.not_checked or plan.not_welded else 0


def _arc(arc: ArcAsked, kept: KeptInput) -> ArcAsked:
    """Return the weld data that are asked for, else those of the plan; its runs are always those of the plan."""
    from wpcal.weld.runs import RunChoice, Tacks, WeaveBy

    runs = kept.record["runs"]
    choice = RunChoice(Tacks(runs["tacks"]), WeaveBy(runs["weave"]), runs["overlap_mm"])
    if arc.welds is not None:
        return replace(arc, choice=choice)
    return replace(arc, choice=choice, welds=kept.welds, rules=replace(arc.rules, weld_rules=kept.rules))


def _show(
    found: WrittenPlan, targets: Mapping[str, Path], made: PlanOutput, record: Mapping[str, object], *, as_json: bool
) -> None:
    from wpcal.cli.plan_sequence import said_of_arc

    if as_json:
        written = {name: [str(targets[name] / file) for file in sorted(files)] for name, files in found.files.items()}
        answer = {
            "schema": EXPORT_SCHEMA,
            "seams": record["planned"],
            "files": written,
            "no_program": found.refused,
            "checked": [] if found.not_checked else [record["checked"]],
            "not_checked": "; ".join([*found.open, *found.not_checked]),
        }
        print_json(answer)
        return
    for name, files in found.files.items():
        click.echo(f"{name}: {', '.join(sorted(files))} in {targets[name]}")
    click.echo(said_of_arc(made))
