"""`wpcal export`: the seams of a finished calibration in the language of a controller."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wpcal.controllers.program import WeldProgram


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("-f", "--format", "formats", required=True, multiple=True, help="Format; repeatable. `list` shows all.")
@click.option("-o", "--out", type=click.Path(path_type=Path), help="Write to OUT/FORMAT.  [default: DIR/FORMAT]")
@click.option("--seams", metavar="W1,W2", help="Only these seams.  [default: the accepted ones]")
@click.option("--all", "everything", is_flag=True, help="Candidates, too.")
@click.option("--work-angle-deg", type=float, default=0.0, show_default=True, help="From the bisector, + towards y.")
@click.option(
    "--travel-angle-deg", type=float, default=0.0, show_default=True, help="+ push (0 to 15 is usual), - drag."
)
@click.option(
    "--stick-out-mm", type=float, default=0.0, show_default=True, help="Tool centre point back from the seam."
)
@click.option("--tool-axis", type=click.Choice(["z", "x"]), default="z", show_default=True, help="Along the wire.")
@click.option("--approach-mm", type=float, default=50.0, show_default=True, help="Back along the wire.")
@click.option("--retract-mm", type=float, default=50.0, show_default=True, help="Back along the wire.")
@click.option("--speed-mm-s", type=float, default=8.0, show_default=True, help="Along the seam.")
@click.option("--air-speed-mm-s", type=float, default=100.0, show_default=True, help="Of approach and retract.")
@click.option("--program-name", default="WPCAL", show_default=True)
@click.option("--tool-name", default="tTorch", show_default=True, help="Where the controller's tools have names.")
@click.option("--tool-number", type=int, default=1, show_default=True, help="Where they have numbers.")
@click.option("--frame-number", type=int, default=1, show_default=True, help="User frame that the part becomes.")
@click.option("--config", "configuration", help="Configuration of the arm as the pendant shows it (FANUC, INFORM).")
@click.option(
    "--robot", metavar="ARM.json", help="Identified arm: write the targets that make it go to the true poses."
)
@click.option(
    "--near", metavar="Q1,…,Q6", help="With --robot: shown angles near the seam, deg; they say how it stands."
)
@click.option("--tool", metavar="X,Y,Z[,RX,RY,RZ]", help="With --robot: tool as set in the controller, mm and deg.")
@click.option("--force", is_flag=True, help="Write into folders that exist and hold files.")
@click.option("--json", "as_json", is_flag=True, help="Print what was written as JSON on stdout.")
def export(
    *, folder: Path, formats: tuple[str, ...], out: Path | None, force: bool, as_json: bool, **values: Any
) -> int:
    """Write the calibrated seams in DIR (calibration.json, seams.json) as programs for a controller.

    Ends with code 1 when the calibration missed its tolerance; the files are written and say so.
    """
    from wpcal.core.records import check_writable, new_directory
    from wpcal.formats.registry import exporter_named

    if "list" in formats:
        return _list_formats(as_json=as_json)
    exporters = [exporter_named(name) for name in dict.fromkeys(formats)]
    program = _program(folder, values)
    targets = {exporter.name: (out or folder) / exporter.name for exporter in exporters}
    for target in targets.values():
        check_writable(target, overwrite=force)
    contents = {exporter.name: exporter.write(program) for exporter in exporters}
    for name, files in contents.items():
        with new_directory(targets[name], overwrite=force) as temporary:
            for file, data in files.items():
                (temporary / file).write_bytes(data.encode("utf-8") if isinstance(data, str) else data)
    _show(program, contents, targets, as_json=as_json)
    if program.calibration.get("verdict") == "PASS":
        return 0
    click.echo("wpcal: the calibration missed its tolerance; the files say so", err=True)
    return 1


def _list_formats(*, as_json: bool) -> int:
    from wpcal.formats.registry import exporter_named, exporter_names

    titles = {name: exporter_named(name).title for name in exporter_names()}
    if as_json:
        from wpcal.core.records import to_json

        click.echo(to_json({"schema": "wpcal/formats/1", "formats": titles}), nl=False)
        return 0
    for name, title in titles.items():
        click.echo(f"{name:10} {title}")
    return 0


def _program(folder: Path, values: dict[str, Any]) -> WeldProgram:
    """Read the calibration and put the torch on its seams as the options say."""
    import math

    from wpcal.controllers.program import ControllerSettings, MotionSettings, build_program
    from wpcal.controllers.torch import ToolAxis, TorchSettings
    from wpcal.core.errors import InputError
    from wpcal.core.robot_space import RobotSpace
    from wpcal.results.folder import read_finished

    if values["seams"] is not None and values["everything"]:
        raise InputError("give either --seams or --all")
    names = None if values["seams"] is None else [name.strip() for name in values["seams"].split(",")]
    torch = TorchSettings(
        math.radians(values["work_angle_deg"]),
        math.radians(values["travel_angle_deg"]),
        values["stick_out_mm"],
        ToolAxis(values["tool_axis"]),
    )
    motion = MotionSettings(*(values[key] for key in ("approach_mm", "retract_mm", "speed_mm_s", "air_speed_mm_s")))
    keys = ("program_name", "tool_name", "tool_number", "frame_number", "configuration")
    controller = ControllerSettings(*(values[key] for key in keys))
    space = RobotSpace.NOMINAL if values["robot"] is None else RobotSpace.IDENTIFIED
    finished = read_finished(folder, space=space).select(names, everything=values["everything"])
    program = build_program(finished, torch=torch, motion=motion, controller=controller)
    return program if values["robot"] is None else _compensated(program, values)


def _compensated(program: WeldProgram, values: dict[str, Any]) -> WeldProgram:
    """Replace the poses by what an identified robot has to be sent."""
    import numpy as np

    from wpcal.controllers.compensation import compensate_program
    from wpcal.core.errors import InputError
    from wpcal.robot.identify.poses_file import parse_tool
    from wpcal.robot.kinematics.arm_file import find_arm

    arm = find_arm(values["robot"])
    try:
        near = np.radians([float(cell) for cell in (values["near"] or "").split(",")])
    except ValueError:
        near = np.zeros(0)
    if near.shape != (6,) or not np.isfinite(near).all():
        raise InputError(f"--robot needs --near: six joint angles in degrees near the seam, got {values['near']!r}")
    if values["tool"] is None:
        raise InputError("--robot needs --tool: the tool as set in the controller; 0,0,0 where it is the flange itself")
    return compensate_program(program, arm, near=near, T_flange_tool=parse_tool(values["tool"]))


def _show(
    program: WeldProgram,
    contents: Mapping[str, Mapping[str, str | bytes]],
    targets: Mapping[str, Path],
    *,
    as_json: bool,
) -> None:
    if as_json:
        from wpcal.core.records import to_json

        written = {name: [str(targets[name] / file) for file in sorted(files)] for name, files in contents.items()}
        seams = [path.seam.name for path in program.paths]
        click.echo(to_json({"schema": "wpcal/export/1", "seams": seams, "files": written}), nl=False)
        return
    poses = sum(len(path) for path in program.paths)
    for name, files in contents.items():
        click.echo(f"{name}: {len(program.paths)} seams, {poses} poses: {', '.join(sorted(files))} in {targets[name]}")
