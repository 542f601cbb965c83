"""`wpcal export` of a plan of touches: a program for each controller, and a file to read back from it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.outputs import EXPORT_SCHEMA, print_json

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from wpcal.cli.export_options import WeldProgramAsked
    from wpcal.controllers.judge.written import Written
    from wpcal.controllers.program import WeldProgram
    from wpcal.controllers.program.touch_program import TouchProgram
    from wpcal.controllers.registry import Controller, Exporter
    from wpcal.robot.kinematics.arm import Arm
    from wpcal.touch.searches import TouchPlan

TAKEN = frozenset(
    {
        *("folder", "formats", "out", "write_templates", "setup", "write_setup", "force", "as_json", "robot"),
        *("program_name", "tool_name", "tool_number", "config", "template"),
    }
)
"""Parameters of the command that a plan of touches takes."""
MOST_STAGES = 2  #: Of a program that touches and welds.


def touches_file(folder: Path) -> Path | None:
    """Return the plan of touches that the user means, by its file or its folder; None if there is none.

    Raises `InputError` when the folder holds a calibration, too.
    """
    from wpcal.core.errors import InputError
    from wpcal.core.result_files import CALIBRATION_FILE, SEAMS_FILE
    from wpcal.touch.searches.record import TOUCHES_FILE

    if folder.is_file() and folder.suffix.lower() == ".json" and folder.name not in (CALIBRATION_FILE, SEAMS_FILE):
        return folder
    file = folder / TOUCHES_FILE
    if not file.is_file():
        return None
    if (folder / CALIBRATION_FILE).is_file():
        raise InputError(
            f"{folder}: holds {CALIBRATION_FILE} and {TOUCHES_FILE}: name the plan, {file}, for its touch programs, or "
            "move it out of the folder for weld programs"
        )
    return file


def _why_not(name: str) -> str:
    """Say why a plan of touches does not take an option of weld programs."""
    elsewhere = {
        "frame_number": "its number is frame_number in the touch setup (--setup)",
        "standoff_mm": "its tool centre point is in the plan (wpcal touches --standoff-mm)",
    }
    where = elsewhere.get(name, "speeds and names of a touch program are in the touch setup (--setup)")
    return f"is for weld programs, and this is a plan of touches; {where}"


def write_touch_setup(path: Path, *, force: bool) -> int:
    """Write a touch setup with every key; return the exit code."""
    from wpcal.core.records import write_file
    from wpcal.touch.searches import setup_template

    write_file(path, setup_template(), overwrite=force)
    click.echo(f"touch setup: {path}")
    return 0


def export_touches(
    file: Path,
    exporters: Sequence[Exporter | Controller],
    flags: WeldProgramAsked,
    *,
    setup_file: Path | None,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> int:
    """Write the touch programs of a plan. The exit code. `setup_file`: The touch setup; None for its defaults."""
    from wpcal.cli.outputs import refuse_options, require_as_planned, write_programs
    from wpcal.controllers.judge.written import write_judged
    from wpcal.controllers.program.touch_program import TouchProgram
    from wpcal.core.records import check_writable
    from wpcal.touch.searches import TouchSetup, read_touch_plan, read_touch_setup

    plan = read_touch_plan(file)
    tool: dict[str, float | str] = {"standoff_mm": plan.standoff_mm, "tool_axis": "z"}
    refuse_options(TAKEN, _why_not, tool)
    require_as_planned(tool)
    setup = TouchSetup() if setup_file is None else read_touch_setup(setup_file)
    program = TouchProgram(plan, setup, flags.controller, _arm(plan, flags.arm.robot))
    controllers = [_with_touches(each) for each in exporters]
    targets = {each.name: (out or file.parent) / each.name for each in controllers}
    for target in targets.values():
        check_writable(target, overwrite=force)
    made = {each.name: write_judged(each.name, each.write_touches, program) for each in controllers}
    contents = {name: each.files for name, each in made.items()}
    write_programs(contents, targets, overwrite=force)
    _show(program, contents, targets, setup_file=setup_file, as_json=as_json)
    foreign = [line for each in made.values() for line in (*each.unjudged, *each.not_checked)]
    for line in foreign:
        click.echo(f"wpcal: NOT CHECKED: {line}", err=True)
    return 1 if foreign else 0


def with_touches(
    exporter: Exporter | Controller, welds: Written[WeldProgram], flags: WeldProgramAsked, *, setup_file: Path | None
) -> Written[WeldProgram]:
    """Return the files of a weld program with those of searches that correct its frame and call it.

    Raises `InputError` when the plan, or the language, cannot be used for it.
    """
    from wpcal.controllers.judge.written import Written, write_judged
    from wpcal.controllers.program.frame_correction import in_stages, welds_after
    from wpcal.controllers.program.touch_program import TouchProgram
    from wpcal.core.errors import InputError
    from wpcal.touch.searches import TouchSetup, read_touch_plan, read_touch_setup

    controller, *plans = _with_touches(exporter), *map(read_touch_plan, flags.touches)
    if len(plans) > MOST_STAGES:
        raise InputError(f"--touches {len(plans)} times: touches have one or two stages")
    plan, first = plans[-1], plans[0] if plans[1:] else None
    setup = TouchSetup() if setup_file is None else read_touch_setup(setup_file)
    program = replace(welds.program, is_corrected=True)
    whole = plan if first is None else in_stages(first, plan, flags.air.up)
    stage = len(whole.searches) - len(plan.searches)
    after = welds_after(whole, setup, program, flags.air.up, stage=stage)
    touches = TouchProgram(whole, setup, flags.controller, _arm(plan, flags.arm.robot), after)
    files = controller.write(program)
    found = write_judged(controller.name, lambda each: {**files, **controller.write_touches(each)}, touches)
    told = (*welds.not_checked, *found.not_checked), (*welds.unjudged, *found.unjudged)
    return Written(found.files, program, *told)


def _with_touches(exporter: Exporter | Controller) -> Controller:
    from wpcal.controllers.registry import Controller, controllers
    from wpcal.core.errors import InputError

    if not isinstance(exporter, Controller) or exporter.touch_writer is None:
        known = ", ".join(each.name for each in controllers() if each.touch_writer is not None)
        raise InputError(f"{exporter.name} has no touch programs; controllers that have: {known}")
    return exporter


def _arm(plan: TouchPlan, robot: str | None) -> Arm | None:
    """Return the arm that the joints of the plan belong to: it computes the configuration."""
    from wpcal.core.errors import InputError
    from wpcal.robot.kinematics.arm_file import find_arm

    if all(search.joints is None for search in plan.searches):
        if robot is not None:
            raise InputError("--robot: the plan of touches was made without an arm and has no joints")
        return None
    if robot is None and plan.arm is not None:
        return plan.arm
    if robot is None:
        try:
            return find_arm(plan.robot)
        except InputError:
            return None
    arm = find_arm(robot)
    if plan.robot and arm.name != plan.robot:
        raise InputError(f"--robot {robot}: the plan of touches was made for the arm {plan.robot}")
    return arm


def _show(
    program: TouchProgram,
    contents: Mapping[str, Mapping[str, str | bytes]],
    targets: Mapping[str, Path],
    *,
    setup_file: Path | None,
    as_json: bool,
) -> None:
    from wpcal.controllers.program.describe import NOT_CHECKED

    searches = [search.name for search in program.plan.searches]
    setup = "the defaults of the touch setup" if setup_file is None else str(setup_file)
    if as_json:
        record = {
            "schema": EXPORT_SCHEMA,
            "seams": [],
            "searches": searches,
            "fingerprint": program.plan.fingerprint,
            "setup": setup,
            "files": {name: [str(targets[name] / file) for file in sorted(files)] for name, files in contents.items()},
            "not_checked": NOT_CHECKED,
        }
        print_json(record)
        return
    for name, files in contents.items():
        what = f"{len(searches)} searches, fingerprint {program.plan.fingerprint}"
        click.echo(f"{name}: {what}: {', '.join(sorted(files))} in {targets[name]}")
    click.echo(f"wpcal: signal, speeds and names from {setup}; {NOT_CHECKED}", err=True)
