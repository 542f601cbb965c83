"""`wpcal export`: the seams of a finished calibration in the language of a controller."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.export_options import WeldProgramAsked
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import EXPORT_SCHEMA, print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wpcal.controllers.program.weld_program import WeldProgram


@command()
@path_argument("folder", metavar="DIR")
@click.option(
    "-f",
    "--format",
    "formats",
    required=True,
    multiple=True,
    help="Language or maker, as rapid or abb; repeatable. `list` shows all.",
)
@path_option("-o", "--out", help="Output: a folder; programs go to OUT/FORMAT.  [default: DIR/FORMAT]")
@path_option(
    "--write-templates",
    metavar="FOLDER",
    help="Only write the templates of the formats into a new folder, to be changed and used with --template.",
)
@path_option(
    "--setup",
    metavar="FILE",
    help="For a plan of touches: signal, speeds and names of the cell (TOML).  [default: as --write-setup writes it]",
)
@path_option(
    "--write-setup",
    metavar="FILE",
    help="Only write a touch setup with every key, its default and a sentence, to be changed and used with --setup.",
)
@takes("flags", WeldProgramAsked)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the files of this command in the folders.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: what was written.")
def export(
    *,
    folder: Path,
    formats: tuple[str, ...],
    out: Path | None,
    write_templates: Path | None,
    setup: Path | None,
    write_setup: Path | None,
    flags: WeldProgramAsked,
    force: bool,
    as_json: bool,
) -> int:
    """Write the calibrated seams in DIR (calibration.json, seams.json) as programs for a controller.

    If DIR holds a plan of `wpcal plan` with one robot (plan.json) instead, its programs are written again, without
    planning again: with other names, weld data or languages. If it holds a plan of touches (touches.json), its searches
    are written.

    Ends with code 1 unless the verdict of the calibration is PASS, if a seam is left out because the torch does not
    get along it, and if a template has lines that wpcal does not know; the files are written and say so.
    """
    from wpcal.cli.export_plan import export_plan, is_plan
    from wpcal.cli.export_touches import export_touches, touches_file, with_touches, write_touch_setup
    from wpcal.cli.outputs import write_programs
    from wpcal.cli.progress import shown_progress
    from wpcal.controllers.judge.written import write_judged
    from wpcal.controllers.registry import exporter_named
    from wpcal.core.errors import InputError
    from wpcal.core.records import check_writable

    if "list" in formats:
        return _list_formats(as_json=as_json)
    exporters = list({exporter.name: exporter for exporter in map(exporter_named, formats)}.values())
    if write_templates is not None:
        return _write_templates(write_templates, [exporter.name for exporter in exporters], force=force)
    if write_setup is not None:
        return write_touch_setup(write_setup, force=force)
    if is_plan(folder):
        return export_plan(folder, formats, flags, out=out, force=force, as_json=as_json)
    plan = touches_file(folder)
    if plan is not None:
        return export_touches(plan, exporters, flags, setup_file=setup, out=out, force=force, as_json=as_json)
    if setup is not None and not flags.touches:
        raise InputError("--setup is for a plan of touches, and this folder has none")
    targets = {exporter.name: (out or folder) / exporter.name for exporter in exporters}
    with shown_progress(f"reading {folder}") as progress:
        programs = flags.build(folder, progress=progress)
        forms = {each.name: programs.form(takes_arcs=getattr(each, "takes_arcs", False)) for each in exporters}
        for target in targets.values():
            check_writable(target, overwrite=force)
        made = {}
        for done, each in enumerate(exporters, 1):
            progress(f"writing {each.name} and executing it: {done} of {len(exporters)}")
            made[each.name] = write_judged(each.name, each.write, forms[each.name])
            if flags.touches:
                made[each.name] = with_touches(each, made[each.name], flags, setup_file=setup)
    contents = {name: each.files for name, each in made.items()}
    forms = {name: each.program for name, each in made.items()}
    write_programs(contents, targets, overwrite=force)
    unjudged = {what for each in made.values() for what in each.unjudged}
    foreign = [line for each in made.values() for line in each.not_checked]
    _show(forms, contents, targets, unjudged=[*sorted(unjudged), *foreign], as_json=as_json)
    program = forms[exporters[0].name]
    for why in program.left_out.values():
        click.echo(f"wpcal: not written: {why}", err=True)
    passed = program.calibration.get("verdict") == "PASS"
    if not passed:
        verdict = program.calibration.get("verdict")
        click.echo(f"wpcal: the verdict of the calibration is {verdict}; the files say so", err=True)
    return 0 if passed and not program.left_out and not foreign else 1


def _write_templates(folder: Path, names: list[str], *, force: bool) -> int:
    from wpcal.controllers.language.post import shipped_templates
    from wpcal.core.records import check_writable, new_directory

    templates = {name: shipped_templates(name) for name in names}
    for name in names:
        check_writable(folder / name, overwrite=force)
    for name, texts in templates.items():
        with new_directory(folder / name, overwrite=force) as temporary:
            for file, text in texts.items():
                (temporary / file).write_text(text, encoding="utf-8")
        click.echo(f"{name}: {', '.join(texts)} in {folder / name}")
    return 0


def _list_formats(*, as_json: bool) -> int:
    from wpcal.controllers.registry import exporter_named, exporter_names

    exporters = [exporter_named(name) for name in exporter_names()]
    if as_json:
        titles = {exporter.name: exporter.title for exporter in exporters}
        print_json({"schema": "wpcal/formats/1", "formats": titles})
        return 0
    for exporter in exporters:
        makers = ", ".join(getattr(exporter, "brands", ()))
        click.echo(f"{exporter.name:10} {exporter.title}{f' (also: {makers})' if makers else ''}")
    return 0


def _show(
    forms: Mapping[str, WeldProgram],
    contents: Mapping[str, Mapping[str, str | bytes]],
    targets: Mapping[str, Path],
    *,
    unjudged: list[str],
    as_json: bool,
) -> None:
    from wpcal.controllers.program.describe import NOT_CHECKED, describe_moves, describe_woven_data
    from wpcal.core.wording import counted

    program = next(iter(forms.values()))
    woven = describe_woven_data(path.run for path in program.paths)
    not_checked = "; ".join([NOT_CHECKED, *(f"NOT CHECKED: {what}" for what in unjudged), *woven])
    if as_json:
        written = {name: [str(targets[name] / file) for file in sorted(files)] for name, files in contents.items()}
        record = {
            "schema": EXPORT_SCHEMA,
            "verdict": program.calibration.get("verdict"),
            "seams": [path.seam.name for path in program.paths],
            "left_out": [{"seam": name, "why": why} for name, why in program.left_out.items()],
            "files": written,
            "moves": {name: _moves(form) for name, form in forms.items()},
            "checked": list(program.checked),
            "not_checked": not_checked,
        }
        print_json(record)
        return
    for name, files in contents.items():
        form = forms[name]
        poses = sum(len(path) for path in form.paths)
        away = "" if form.tolerance is None else f"; {describe_moves(form, form.tolerance)}"
        what = f"{counted(len(form.paths), 'seam')}, {poses} poses{away}"
        click.echo(f"{name}: {what}: {', '.join(sorted(files))} in {targets[name]}")
    click.echo(f"wpcal: {'; '.join((*program.checked, not_checked))}", err=True)


def _moves(form: WeldProgram) -> list[dict[str, object]]:
    """Return per seam the number of lines and arcs along it, and how far they are from it."""
    from wpcal.robot.moves import Arc

    rows = []
    for path in form.paths:
        arcs = sum(isinstance(move, Arc) for move in path.weld_moves)
        row: dict[str, object] = {"seam": path.seam.name, "lines": len(path.weld_moves) - arcs, "arcs": arcs}
        if path.moves is not None:
            row |= {"off_mm": path.moves.off_mm, "off_deg": math.degrees(path.moves.off_rad)}
        rows.append(row)
    return rows
