"""`wpcal cell`: make the cell file of one robot, and check and draw any cell."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import GroupedCommand, option_of
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, TOOL_HELP, TOOL_METAVAR

if TYPE_CHECKING:
    from wpcal.core.arrays import FloatArray
    from wpcal.core.transform import RigidTransform
    from wpcal.robot.kinematics.arm import Coupling
    from wpcal.robot.torch.shape import TorchShape

PLACE_METAVAR = "X,Y,Z[,RX,RY,RZ]"
PLACE_HELP = "mm and degrees (R = Rz Ry Rx)"


@click.group()
def cell() -> None:
    """Make the cell file that `wpcal plan` takes, and check and draw it."""


@cell.command(cls=GroupedCommand)
@click.option(
    "--torch-robot",
    metavar="ARM",
    required=True,
    help="Arm with the torch: the name of a shipped arm, an arm file or a URDF file; meshes beside it become bodies.",
)
@click.option("--positioner", metavar="ARM", help="Positioner with one or two axes: an arm file or a URDF file.")
@click.option(
    "--robot-at", metavar=PLACE_METAVAR, help=f"Base of the robot in world, {PLACE_HELP}.  [default: on the floor]"
)
@click.option("--positioner-at", metavar=PLACE_METAVAR, help=f"Base of the positioner in world, {PLACE_HELP}.")
@click.option(
    "--part-at",
    metavar=PLACE_METAVAR,
    help=f"Part on the positioner's flange, or in world, {PLACE_HELP}. A calibrated RESULT replaces it.",
)
@click.option("--tool", metavar=TOOL_METAVAR, help=TOOL_HELP)
@click.option("--tool-from", metavar="PROGRAM[#NAME]", help="Tool data of a program, as the controller states them.")
@click.option(
    "--tool-axis",
    type=click.Choice(["z", "x"]),
    default="z",
    show_default=True,
    help="Axis of the tool along the wire.",
)
@click.option(
    "--torch",
    metavar="NAME|FILE",
    default="straight",
    show_default=True,
    help="The torch: one of wpcal torches, or a file of that form. A neck bends towards the flange.",
)
@click.option("--wire-mm", type=float, help="From the tip of the wire to the nozzle.  [default: that of the torch]")
@click.option("--nozzle-radius-mm", type=float, help="Radius of the nozzle.  [default: that of the torch]")
@click.option(
    "--torch-mesh",
    metavar="FILE.stl",
    type=click.Path(path_type=Path),
    help="Bodies of the torch from a mesh in the frame of the flange, mm.  [default: from the sizes of the torch]",
)
@click.option(
    "--torch-capsule",
    "torch_capsules",
    metavar="X,Y,Z,X,Y,Z,R",
    multiple=True,
    help="Bodies of the torch from capsules: two ends in the frame of the flange, and the radius, mm. Repeatable.",
)
@click.option(
    "--box",
    "boxes",
    metavar="X,Y,Z,X,Y,Z",
    multiple=True,
    help="Table or fixture: two opposite corners in world, mm. Repeatable.",
)
@click.option(
    "--rail", metavar="X,Y,Z,MIN,MAX,SPEED", help="Rail under the robot: direction in world, limits mm, mm/s."
)
@click.option("--home", metavar="Q1,…,Q6", help="Joints at which programs start and end, deg.  [default: torch down]")
@click.option(
    "--coupled",
    metavar="JOINT:ADDS[:FACTOR]",
    multiple=True,
    help="Joint whose shown angle does not hold the motion of another: as joint_3:joint_2. Repeatable.",
)
@option_of("wpcal.planning.cell.new_cell:NewCell.safety_mm", "--safety-mm", help="Least distance between bodies.")
@click.option(
    "-o", "--out", "output", metavar="CELL.json", type=click.Path(path_type=Path), required=True, help="Output: a file."
)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the cell file and arm files beside it.")
def new(
    *,
    torch_robot: str,
    positioner: str | None,
    robot_at: str | None,
    positioner_at: str | None,
    part_at: str | None,
    tool: str | None,
    tool_from: str | None,
    tool_axis: str,
    torch: str,
    wire_mm: float | None,
    nozzle_radius_mm: float | None,
    torch_mesh: Path | None,
    torch_capsules: tuple[str, ...],
    boxes: tuple[str, ...],
    rail: str | None,
    home: str | None,
    coupled: tuple[str, ...],
    safety_mm: float,
    output: Path,
    force: bool,
) -> int:
    """Make the cell file of one robot, with a positioner or a fixed part.

    Arms come as URDF files; their collision meshes become convex hulls. The arm files are written beside the cell file.
    """
    from wpcal.core.errors import InputError
    from wpcal.core.records import to_json, write_file
    from wpcal.planning.cell.cell_check import check_cell
    from wpcal.planning.cell.cell_file import read_one_robot
    from wpcal.planning.cell.new_cell import NewCell, new_cell_files
    from wpcal.robot.kinematics.arm_file import find_arm

    arm = find_arm(torch_robot)
    cell = NewCell(
        robot=torch_robot,
        T_world_base=_place("--robot-at", robot_at, "world", "base", up=-arm.mount_mm),
        T_flange_tool=_tool(tool, tool_from, tool_axis),
        torch=_torch(torch, wire_mm, nozzle_radius_mm),
        torch_mesh=torch_mesh,
        torch_capsules=[_capsule(text) for text in torch_capsules],
        positioner=positioner,
        T_world_positioner=None if positioner is None else _positioner_place(positioner, positioner_at),
        T_carrier_part=None if part_at is None else _place("--part-at", part_at, "carrier", "part"),
        boxes=[_box(text) for text in boxes],
        rail=None if rail is None else _rail(rail),
        home_deg=None if home is None else _numbers("--home", home, (6,)),
        safety_mm=safety_mm,
        couplings=[_coupling(text) for text in coupled],
    )
    if torch_mesh is not None and torch_capsules:
        raise InputError("give either --torch-mesh or --torch-capsule")
    if positioner is None and positioner_at is not None:
        raise InputError("--positioner-at needs --positioner")
    files = new_cell_files(cell, output.name)
    output.parent.mkdir(parents=True, exist_ok=True)
    for name, record in files.items():
        write_file(output.with_name(name), to_json(record), overwrite=force)
    click.echo(f"wrote {', '.join(sorted(files))} to {output.parent}")
    if cell.T_flange_tool is None:
        click.echo(
            "wpcal: the cell has no tool data yet: give --tool or --tool-from, or fill in T_flange_tool", err=True
        )
        return 0
    for issue in check_cell(read_one_robot(output)):
        tried = "no free home was found: " if issue.code == "home" and home is None else ""
        click.echo(f"wpcal: odd cell: {tried}{issue.message}", err=True)
    return 0


@cell.command(cls=GroupedCommand)
@click.argument("cell_json", metavar="CELL.json", type=click.Path(path_type=Path))
@click.option("-o", "--out", "output", metavar="DIR", type=click.Path(path_type=Path), help="Output: a folder.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: cell.html.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: what is odd.")
def check(*, cell_json: Path, output: Path | None, force: bool, as_json: bool) -> int:
    """List what is odd in CELL.json, and draw the cell in cell.html (in the folder of -o, or here).

    Ends with code 2 if anything is odd.
    """
    from wpcal.cli.cell_check import run_cell_check

    return run_cell_check(cell_json, output, force=force, as_json=as_json)


def _numbers(option: str, text: str, counts: tuple[int, ...]) -> list[float]:
    from wpcal.core.errors import InputError
    from wpcal.core.numbers import parse_numbers

    try:
        values = parse_numbers(text)
    except InputError as error:
        raise InputError(f"{option}: {error}") from None
    if len(values) not in counts:
        raise InputError(f"{option}: expected {' or '.join(map(str, counts))} numbers, got {len(values)}")
    return values


def _place(
    option: str, text: str | None, target: str, source: str, *, up: FloatArray | tuple[float, ...] = (0.0, 0.0, 0.0)
) -> RigidTransform:
    """Return a place; without text the origin, raised so that the mounting face is on the floor."""
    import numpy as np

    from wpcal.core.rotations import rotation_from_zyx
    from wpcal.core.transform import RigidTransform

    if text is None:
        return RigidTransform(np.eye(3), np.asarray(up), target, source)
    values = _numbers(option, text, (3, 6))
    turn = np.radians(values[3:] or [0.0, 0.0, 0.0])
    return RigidTransform(rotation_from_zyx(*turn), np.array(values[:3]), target, source)


def _coupling(text: str) -> Coupling:
    from wpcal.core.errors import InputError
    from wpcal.robot.kinematics.arm import Coupling

    joint, _, rest = text.partition(":")
    adds, _, factor = rest.partition(":")
    try:
        number = float(factor or 1.0)
    except ValueError:
        number = math.nan
    if not (joint and adds and math.isfinite(number)):
        raise InputError(f"--coupled: expected JOINT:ADDS or JOINT:ADDS:FACTOR, as joint_3:joint_2, got {text!r}")
    return Coupling(joint, adds, number)


def _positioner_place(positioner: str, text: str | None) -> RigidTransform:
    from wpcal.core.errors import InputError

    if text is None:
        raise InputError("--positioner needs --positioner-at: where its base is in world")
    _ = positioner
    return _place("--positioner-at", text, "world", "base")


def _tool(tool: str | None, tool_from: str | None, axis: str) -> RigidTransform | None:
    """Return the tool with the wire along z."""
    import numpy as np

    from wpcal.controllers.tool_data import read_tool_data
    from wpcal.core.errors import InputError
    from wpcal.core.transform import RigidTransform
    from wpcal.robot.identify.poses_file import parse_tool

    if tool is not None and tool_from is not None:
        raise InputError("give either --tool or --tool-from")
    if tool is None and tool_from is None:
        return None
    if tool_from is not None:
        path, _, name = tool_from.partition("#")
        found = read_tool_data(Path(path), name or None)
    else:
        found = parse_tool(tool)[0]
    if axis == "z":
        return found
    # z of ours is x of theirs; x of ours is their -z, so that y stays
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    return RigidTransform(found.R @ turn, found.t_mm, "flange", "tool")


def _torch(name: str, wire_mm: float | None, nozzle_radius_mm: float | None) -> TorchShape:
    """Return the torch; the options change the sizes of a straight one."""
    from wpcal.core.errors import InputError
    from wpcal.robot.torch.file import find_torch
    from wpcal.robot.torch.shape import TorchShape

    shape = find_torch(name)
    wire, radius = wire_mm or shape.wire_mm, nozzle_radius_mm or shape.nozzle_radius_mm
    if (wire, radius) == (shape.wire_mm, shape.nozzle_radius_mm):
        return shape
    if shape.neck is not None or shape.mouth_radius_mm is not None:
        raise InputError(f"--wire-mm, --nozzle-radius-mm: {name} has its own sizes; change them in a torch file")
    return TorchShape(wire, radius, shape.length_mm)


def _capsule(text: str) -> tuple[FloatArray, FloatArray, float]:
    import numpy as np

    from wpcal.core.errors import InputError

    values = _numbers("--torch-capsule", text, (7,))
    if not values[6] > 0.0:
        raise InputError(f"--torch-capsule: expected two ends and a positive radius, got {text!r}")
    return np.array(values[:3]), np.array(values[3:6]), values[6]


def _box(text: str) -> tuple[FloatArray, FloatArray]:
    import numpy as np

    from wpcal.core.errors import InputError

    values = np.array(_numbers("--box", text, (6,))).reshape(2, 3)
    low, high = values.min(axis=0), values.max(axis=0)
    if not (high > low).all():
        raise InputError(f"--box: expected two opposite corners of a box, got {text!r}")
    return low, high


def _rail(text: str) -> dict[str, object]:
    x, y, z, low, high, speed = _numbers("--rail", text, (6,))
    return {"direction": [x, y, z], "min_mm": low, "max_mm": high, "speed_mm_s": speed}
