"""`wpcal correct`: taught joint angles become corrected points, with an identified robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, ROBOT_HELP, TOOL_HELP, TOOL_METAVAR, path_argument, path_option

if TYPE_CHECKING:
    from wpcal.core.arrays import FloatArray
    from wpcal.core.issue import Issue


@click.command()
@path_argument("taught_csv", metavar="TAUGHT_JOINTS.csv")
@click.option("--robot", metavar="ARM", required=True, help=f"{ROBOT_HELP} As written by `wpcal identify`.")
@path_option("-o", "--out", "output", metavar="POINTS.csv", help="Output: a table.  [default: stdout]")
@click.option("--tool", metavar=TOOL_METAVAR, help=TOOL_HELP)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the file.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the points.")
def correct(*, taught_csv: Path, robot: str, output: Path | None, tool: str | None, force: bool, as_json: bool) -> int:
    """Turn taught joint angles into corrected points that `wpcal calibrate` reads.

    TAUGHT_JOINTS.csv has the columns name, q1_deg…q6_deg; all other columns (feature, use, …) are copied. The points
    are marked with the robot space of the arm. Export seams from such points with `wpcal export --robot`; otherwise the
    robot's error comes back.
    """
    from wpcal.cli.outputs import require_new
    from wpcal.core.issue import Issue
    from wpcal.core.records import write_file
    from wpcal.core.rotations import rx_ry_rz_deg
    from wpcal.robot.compensation import correct_points
    from wpcal.robot.identify.poses_file import corrected_table, parse_tool, read_taught_joints
    from wpcal.robot.kinematics.arm_file import find_arm

    if output is not None:
        require_new(output, overwrite=force)
    arm = find_arm(robot)
    names, joints, others = read_taught_joints(taught_csv, arm)
    T_flange_tool, tool_error_mm = parse_tool(tool)
    points = correct_points(arm, joints, T_flange_tool=T_flange_tool)
    bias_mm, issues = tool_error_mm, list[Issue]()
    if bias_mm is None:
        bias_mm = arm.unseen_tool_mm
        issues = _doubts(arm.name, bias_mm)
    for issue in issues:
        click.echo(f"note: {issue.message}", err=True)
    postures = arm.forward(joints)[:, :3, :3] @ T_flange_tool.R
    text = corrected_table(names, points, others, arm.space, tcp_bias_mm=bias_mm, postures=postures)
    if output is not None:
        write_file(output, text, overwrite=force)
    shifts = points - correct_points(arm.as_nominal(), joints, T_flange_tool=T_flange_tool)
    if as_json:
        turns = rx_ry_rz_deg(postures)
        rows = zip(names, points.tolist(), turns.tolist(), shifts.tolist(), strict=True)
        record = {
            "schema": "wpcal/corrected/1",
            "robot": arm.name,
            "robot_space": arm.space.value,
            "tcp_bias_mm": bias_mm,
            "points": [
                {"name": name, "p_base_mm": point, "rx_ry_rz_deg": turn, "shift_mm": shift}
                for name, point, turn, shift in rows
            ],
            "issues": [issue.to_record() for issue in issues],
        }
        print_json(record)
    elif output is None:
        click.echo(text, nl=False)
    else:
        _show(names, shifts)
    return 0


def _doubts(arm: str, bias_mm: float) -> list[Issue]:
    from wpcal.core.issue import Issue

    if not bias_mm:
        return []
    message = (
        f"{arm} was identified with an unknown tool, so this tool centre point may be off by {bias_mm:.1f} mm (95 %); "
        "find it in the identified arm with `wpcal tcp` and give its file as --tool"
    )
    return [Issue("tool-unknown", message)]


def _show(names: tuple[str, ...], shifts: FloatArray) -> None:
    import numpy as np

    from wpcal.cli.console import new_table, plain_console

    table = new_table("Corrected points (true minus nominal)", "<point|dx mm|dy mm|dz mm|distance mm")
    for name, shift in zip(names, shifts, strict=True):
        table.add_row(name, *(f"{value:+.3f}" for value in shift), f"{np.linalg.norm(shift):.3f}")
    plain_console().print(table)
