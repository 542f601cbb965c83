"""`wpcal correct`: taught joint angles become corrected points, with an identified robot."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("taught_csv", metavar="TAUGHT_JOINTS.csv", type=click.Path(path_type=Path))
@click.option("--robot", required=True, help="Arm file, as written by `wpcal identify`, or the name of a shipped arm.")
@click.option("-o", "--output", metavar="POINTS.csv", type=click.Path(path_type=Path), help="File; stdout by default.")
@click.option(
    "--tool",
    metavar="X,Y,Z[,RX,RY,RZ]",
    help="Tool centre point in the flange frame as set in the controller, mm and degrees (R = Rz Ry Rx).",
)
@click.option("--force", is_flag=True, help="Overwrite the file.")
def correct(*, taught_csv: Path, robot: str, output: Path | None, tool: str | None, force: bool) -> int:
    """Turn taught joint angles into corrected points that `wpcal calibrate` reads.

    TAUGHT_JOINTS.csv has the columns name, q1_deg…q6_deg; all other columns (feature, use, …) are copied. The points
    are marked with the robot space of the arm. Export seams from such points with `wpcal export --robot`; otherwise the
    robot's error comes back.
    """
    from wpcal.cli.outputs import require_new
    from wpcal.core.records import write_file
    from wpcal.robot.compensation import correct_points
    from wpcal.robot.identify.poses_file import corrected_table, parse_tool, read_taught_joints
    from wpcal.robot.kinematics.arm_file import find_arm

    if output is not None:
        require_new(output, overwrite=force)
    arm = find_arm(robot)
    names, joints, others = read_taught_joints(taught_csv, arm)
    points = correct_points(arm, joints, T_flange_tool=parse_tool(tool))
    text = corrected_table(names, points, others, arm.space)
    if output is None:
        click.echo(text, nl=False)
        return 0
    write_file(output, text, overwrite=force)
    _show(names, points, correct_points(arm.as_nominal(), joints, T_flange_tool=parse_tool(tool)))
    return 0


def _show(names: tuple[str, ...], points: object, nominal: object) -> None:
    import numpy as np
    from rich.console import Console
    from rich.table import Table

    table = Table(title="Corrected points (true minus nominal)")
    table.add_column("point")
    for heading in ("dx mm", "dy mm", "dz mm", "distance mm"):
        table.add_column(heading, justify="right")
    shifts = np.asarray(points) - np.asarray(nominal)
    for name, shift in zip(names, shifts, strict=True):
        table.add_row(name, *(f"{value:+.3f}" for value in shift), f"{np.linalg.norm(shift):.3f}")
    Console().print(table)
