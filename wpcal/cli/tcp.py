"""`wpcal tcp`: the tool centre point from touches of one point in several postures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, ROBOT_HELP, path_argument, path_option

if TYPE_CHECKING:
    from wpcal.robot.tool_point import ToolPoint


@click.command()
@path_argument("touches_csv", metavar="TOUCHES.csv")
@click.option("--robot", metavar="ARM", required=True, help=f"{ROBOT_HELP} As written by `wpcal identify`.")
@path_option("-o", "--out", "output", metavar="TOOL.json", help="Output: the file for `correct --tool`.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the file.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the record.")
def tcp(*, touches_csv: Path, robot: str, output: Path | None, force: bool, as_json: bool) -> int:
    """Find the tool centre point from touches of one fixed point.

    Touch the same sharp point (a tip clamped in the cell) at least four times, with the tool tilted in different
    directions. TOUCHES.csv has the columns name, q1_deg…q6_deg. Use the arm that corrects your points: with an
    identified arm, a tool centre point taught in the controller does not fit.

    Ends with code 1 if the touches are not of one point.
    """
    from wpcal.cli.outputs import require_new
    from wpcal.core.records import to_json, write_file
    from wpcal.robot.identify.poses_file import read_taught_joints
    from wpcal.robot.kinematics.arm_file import find_arm
    from wpcal.robot.tool_point import find_tool_point

    if output is not None:
        require_new(output, overwrite=force)
    arm = find_arm(robot)
    names, joints, _ = read_taught_joints(touches_csv, arm)
    found = find_tool_point(arm, joints)
    record = to_json(found.to_record(arm, names))
    if output is not None:
        write_file(output, record, overwrite=force)
    if as_json:
        click.echo(record, nl=False)
    else:
        _show(names, found)
    if found.refusal:
        click.echo(f"wpcal: {found.refusal}", err=True)
    return 1 if found.refusal else 0


def _show(names: tuple[str, ...], found: ToolPoint) -> None:
    import numpy as np

    from wpcal.cli.console import new_table, plain_console

    table = new_table("Touches of the point", "<touch|off mm")
    for name, off in zip(names, np.linalg.norm(found.residuals, axis=1), strict=True):
        table.add_row(name, f"{off:.3f}")
    console = plain_console()
    console.print(table)
    x, y, z = found.t_flange
    console.print(f"tool centre point {x:.3f},{y:.3f},{z:.3f} mm in the flange frame")
    console.print(f"95 % error {found.error_95_mm:.3f} mm, RMS of the touches {found.rms_mm:.3f} mm")
