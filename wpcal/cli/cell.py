"""`wpcal cell`: make the cell file of one robot, and check and draw any cell."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import GroupedCommand, option_of, takes
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, TOOL_HELP, TOOL_METAVAR, path_argument, path_option
from wpcal.core.options import group, opt

if TYPE_CHECKING:
    from wpcal.core.arrays import FloatArray
    from wpcal.core.transform import RigidTransform
    from wpcal.planning.cell.new_cell import NewCell
    from wpcal.robot.kinematics.arm import Coupling
    from wpcal.robot.torch.shape import TorchShape

PLACE_METAVAR = "X,Y,Z[,RX,RY,RZ]"
PLACE_HELP = "mm and degrees (R = Rz Ry Rx)"


@click.group()
def cell() -> None:
    """Make the cell file that `wpcal plan` takes, and check and draw it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ToolAsked:
    """The tool data of the torch."""

    tool: str | None = opt(
        None, f"{TOOL_HELP} It is the tip of the wire: programs of a plan have no standoff.", metavar=TOOL_METAVAR
    )
    tool_from: str | None = opt(
        None,
        "Tool data of a program, as the controller states them; the tool centre point must be the tip of the wire.",
        metavar="PROGRAM[#NAME]",
    )
    tool_axis: str = opt("z", "Axis of the tool along the wire.", choices=("z", "x"))

    def to_tool(self) -> RigidTransform | None:
        """Return the tool with the wire along z; None if nothing states it."""
        from wpcal.controllers.tool_data import read_tool_data
        from wpcal.core.errors import InputError
        from wpcal.core.transform import RigidTransform
        from wpcal.robot.identify.poses_file import parse_tool

        if self.tool is not None and self.tool_from is not None:
            raise InputError("give either --tool or --tool-from")
        if self.tool_from is not None:
            path, _, name = self.tool_from.partition("#")
            found = read_tool_data(Path(path), name or None)
        elif self.tool is not None:
            found = parse_tool(self.tool)[0]
        else:
            return None
        if self.tool_axis == "z":
            return found
        # z of ours is x of theirs; x of ours is their -z, so that y stays
        return RigidTransform(
            found.R @ [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]], found.t_mm, "flange", "tool"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class TorchSizesAsked:
    """The torch, and sizes of a straight one."""

    torch: str = opt(
        "straight",
        "The torch: one of wpcal torches, or a file of that form. A neck bends towards the flange.",
        metavar="NAME|FILE",
    )
    wire_mm: float | None = opt(None, "From the tip of the wire to the nozzle.  [default: that of the torch]")
    nozzle_radius_mm: float | None = opt(None, "Radius of the nozzle.  [default: that of the torch]")

    def to_shape(self) -> TorchShape:
        """Return the torch. Raises `InputError` when it has its own sizes and others are stated."""
        from wpcal.core.errors import InputError
        from wpcal.robot.torch.file import find_torch
        from wpcal.robot.torch.shape import TorchShape

        shape = find_torch(self.torch)
        wire, radius = self.wire_mm or shape.wire_mm, self.nozzle_radius_mm or shape.nozzle_radius_mm
        if (wire, radius) == (shape.wire_mm, shape.nozzle_radius_mm):
            return shape
        if shape.neck is not None or shape.mouth_radius_mm is not None:
            what = f"{self.torch} has its own sizes; change them in a torch file"
            raise InputError(f"--wire-mm, --nozzle-radius-mm: {what}")
        return TorchShape(wire, radius, shape.length_mm)


@dataclass(frozen=True, slots=True, kw_only=True)
class CellAsked:
    """What a new cell is made from, as a person states it."""

    positioner: str | None = opt(None, "Positioner with one or two axes: an arm file or a URDF file.", metavar="ARM")
    robot_at: str | None = opt(
        None, f"Base of the robot in world, {PLACE_HELP}.  [default: on the floor]", metavar=PLACE_METAVAR
    )
    positioner_at: str | None = opt(None, f"Base of the positioner in world, {PLACE_HELP}.", metavar=PLACE_METAVAR)
    part_at: str | None = opt(
        None,
        f"Part on the positioner's flange, or in world, {PLACE_HELP}. A calibrated RESULT replaces it.",
        metavar=PLACE_METAVAR,
    )
    tool: ToolAsked = group(ToolAsked)
    torch: TorchSizesAsked = group(TorchSizesAsked)
    torch_mesh: Path | None = opt(
        None,
        "Bodies of the torch from a mesh in the frame of the flange, mm.  [default: from the sizes of the torch]",
        metavar="FILE.stl",
    )
    torch_capsules: tuple[str, ...] = opt(
        (),
        "Bodies of the torch from capsules: two ends in the frame of the flange, and the radius, mm. Repeatable.",
        "--torch-capsule",
        many=True,
        metavar="X,Y,Z,X,Y,Z,R",
    )
    boxes: tuple[str, ...] = opt(
        (),
        "Table or fixture: two opposite corners in world, mm. Repeatable.",
        "--box",
        many=True,
        metavar="X,Y,Z,X,Y,Z",
    )
    rail: str | None = opt(
        None, "Rail under the robot: direction in world, limits mm, mm/s.", metavar="X,Y,Z,MIN,MAX,SPEED"
    )
    home: str | None = opt(
        None, "Joints at which programs start and end, deg.  [default: torch down]", metavar="Q1,…,Q6"
    )
    coupled: tuple[str, ...] = opt(
        (),
        "Joint whose shown angle does not hold the motion of another: as joint_3:joint_2. Repeatable.",
        many=True,
        metavar="JOINT:ADDS[:FACTOR]",
    )

    def to_cell(self, robot: str, safety_mm: float) -> NewCell:
        """Return the cell of a robot. Raises `InputError` when an option cannot be read, or two contradict."""
        import numpy as np

        from wpcal.core.errors import InputError
        from wpcal.core.transform import RigidTransform
        from wpcal.planning.cell.new_cell import NewCell
        from wpcal.robot.kinematics.arm_file import find_arm

        if self.torch_mesh is not None and self.torch_capsules:
            raise InputError("give either --torch-mesh or --torch-capsule")
        if self.positioner is None and self.positioner_at is not None:
            raise InputError("--positioner-at needs --positioner")
        if self.positioner is not None and self.positioner_at is None:
            raise InputError("--positioner needs --positioner-at: where its base is in world")
        on_floor = RigidTransform(np.eye(3), -find_arm(robot).mount_mm, "world", "base")
        return NewCell(
            robot=robot,
            T_world_base=_place("--robot-at", self.robot_at, "world", "base") or on_floor,
            T_flange_tool=self.tool.to_tool(),
            torch=self.torch.to_shape(),
            torch_mesh=self.torch_mesh,
            torch_capsules=[_capsule(text) for text in self.torch_capsules],
            positioner=self.positioner,
            T_world_positioner=_place("--positioner-at", self.positioner_at, "world", "base"),
            T_carrier_part=_place("--part-at", self.part_at, "carrier", "part"),
            boxes=[_box(text) for text in self.boxes],
            rail=None if self.rail is None else _rail(self.rail),
            home_deg=None if self.home is None else _numbers("--home", self.home, (6,)),
            safety_mm=safety_mm,
            couplings=[_coupling(text) for text in self.coupled],
        )


@cell.command(cls=GroupedCommand)
@click.option(
    "--torch-robot",
    metavar="ARM",
    required=True,
    help="Arm with the torch: the name of a shipped arm, an arm file or a URDF file; meshes beside it become bodies.",
)
@takes("asked", CellAsked)
@option_of("wpcal.planning.cell.new_cell:NewCell.safety_mm", "--safety-mm", help="Least distance between bodies.")
@path_option("-o", "--out", "output", metavar="CELL.json", required=True, help="Output: a file.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the cell file and arm files beside it.")
def new(*, torch_robot: str, asked: CellAsked, safety_mm: float, output: Path, force: bool) -> int:
    """Make the cell file of one robot, with a positioner or a fixed part.

    Arms come as URDF files; their collision meshes become convex hulls. The arm files are written beside the cell file.
    """
    from wpcal.core.records import to_json, write_file
    from wpcal.planning.cell.cell_check import check_cell
    from wpcal.planning.cell.cell_file import read_one_robot
    from wpcal.planning.cell.new_cell import new_cell_files

    cell = asked.to_cell(torch_robot, safety_mm)
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
        tried = "no free home was found: " if issue.code == "home" and asked.home is None else ""
        click.echo(f"wpcal: odd cell: {tried}{issue.message}", err=True)
    return 0


@cell.command(cls=GroupedCommand)
@path_argument("cell_json", metavar="CELL.json")
@path_option("-o", "--out", "output", metavar="DIR", help="Output: a folder.")
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


def _place(option: str, text: str | None, target: str, source: str) -> RigidTransform | None:
    """Return a place, or None without text."""
    import numpy as np

    from wpcal.core.rotations import rotation_from_zyx
    from wpcal.core.transform import RigidTransform

    if text is None:
        return None
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
