"""A new cell file of one robot: bodies from URDF files and meshes, places as given, a torch from a few numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Carrier, Cell
from wpcal.planning.cell.cell_file import CELL_SCHEMA, rail_from_record, shapes_from_records
from wpcal.planning.cell.home import choose_home
from wpcal.planning.cell.shape import JOINTS
from wpcal.robot.kinematics.arm import Arm, Coupling
from wpcal.robot.kinematics.arm_file import arm_record, find_arm
from wpcal.robot.kinematics.urdf_bodies import read_link_hulls
from wpcal.robot.torch.bodies import (
    NOZZLE_TO_PART_MM,
    bodies_of_capsules,
    bodies_of_mesh,
    bodies_of_shape,
    hulled,
)
from wpcal.robot.torch.file import without_none
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape

SAFETY_MM = 10.0  #: Above the errors of bases and meshes, and below what is between the links of most arms and a part.
NO_FLOOR_MM = -1e5  #: The floor of a cell of which nothing is known: no arm reaches it.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NewCell:
    """What a new cell is made from."""

    robot: str  #: Shipped arm, arm file or URDF file.
    T_world_base: RigidTransform
    T_flange_tool: RigidTransform | None = None  #: None: not known yet; the cell file says so, and a plan asks for it.
    #: Its sizes are written into the cell, and compared with the torch with which seams were felt.
    torch: TorchShape = USUAL_TORCH
    #: STL file in the frame `flange`, mm. None: bodies from `torch_capsules`, or from `torch`.
    torch_mesh: Path | None = None
    torch_capsules: Sequence[tuple[FloatArray, FloatArray, float]] = ()  #: In the frame `flange`, mm.
    positioner: str | None = None  #: Arm file or URDF file with one or two axes.
    T_world_positioner: RigidTransform | None = None
    T_carrier_part: RigidTransform | None = None  #: The part on the positioner, or in `world`.
    boxes: Sequence[tuple[FloatArray, FloatArray]] = ()  #: Corners of boxes in `world`, mm: table, fixtures.
    rail: Mapping[str, Any] | None = None  #: As in the cell file.
    home_deg: Sequence[float] | None = None
    safety_mm: float = SAFETY_MM
    couplings: Sequence[Coupling] = ()  #: Of the robot's joints, which a URDF file cannot name.


def bare_cell(arm: str, T_flange_tool: RigidTransform, torch: TorchShape) -> Cell:
    """Return the cell of one arm with a straight torch and nothing around it: its base is `world`, without a floor.

    Raises `InputError` when the arm is not known, or its file cannot be read.
    """
    place = RigidTransform.identity(target="world", source="base")
    new = NewCell(robot=arm, T_world_base=place, T_flange_tool=T_flange_tool, torch=torch, safety_mm=NOZZLE_TO_PART_MM)
    found = _arm(new)
    robot, _ = _robot(new, found, {})
    cell = _cell(new, found, {"name": arm, "torch_robot": robot, "bench": []}, None)
    cell = replace(cell, floor_z_mm=NO_FLOOR_MM)
    return replace(cell, home=choose_home(cell))


def new_cell_files(new: NewCell, name: str) -> dict[str, dict[str, Any]]:
    """Return the records of a new cell by file name: ``cell.json`` is under `name`, arm files are beside it.

    Raises `InputError` or `FormatError` when an arm or a mesh cannot be read.
    """
    files: dict[str, dict[str, Any]] = {}
    arm = _arm(new)
    robot, source = _robot(new, arm, files)
    record: dict[str, Any] = {
        "schema": CELL_SCHEMA,
        "name": name.removesuffix(".json"),
        "source": source,
        "safety_distance_mm": new.safety_mm,
        "torch_robot": robot,
        "bench": [_box(f"box {row + 1}", *corners) for row, corners in enumerate(new.boxes)],
    }
    place = None if new.T_carrier_part is None else new.T_carrier_part.to_record()
    if new.positioner is None:
        record["T_world_part"] = place
    else:
        carrier = find_arm(new.positioner)
        at = new.T_world_positioner or RigidTransform.identity(target="world", source="base")
        record["positioner"] = {
            "arm": _arm_file(carrier, new.positioner, files),
            "T_world_base": at.to_record(),
            "links": _links(carrier, new.positioner),
            "T_flange_part": place,
        }
    if new.T_flange_tool is not None:
        cell = _cell(new, arm, record, None if new.positioner is None else carrier)
        home = np.asarray(new.home_deg) if new.home_deg is not None else np.round(np.degrees(choose_home(cell)), 1)
        robot["home_deg"] = (home + 0.0).tolist()
    files[name] = record
    return files


def _cell(new: NewCell, arm: Arm, record: Mapping[str, Any], carrier: Arm | None) -> Cell:
    """Return the cell of a record whose arm files are not written yet; the part is not in it."""
    robot = record["torch_robot"]
    rail = None if new.rail is None else rail_from_record(new.rail)
    positioner = None
    if carrier is not None:
        at = RigidTransform.from_record(record["positioner"]["T_world_base"], target="world", source="base")
        positioner = Carrier(carrier, at, shapes_from_records(record["positioner"]["links"]))
    count = (rail is not None) + (0 if carrier is None else len(carrier.joints))
    return Cell(
        name=str(record["name"]),
        arm=arm,
        T_world_base=new.T_world_base,
        T_flange_tool=new.T_flange_tool or RigidTransform.identity(target="flange", source="tool"),
        T_carrier_part=None,
        d1_mm=new.safety_mm,
        home=np.zeros(JOINTS + count),
        rail=rail,
        carrier=positioner,
        touched_at=np.zeros(count),
        links=shapes_from_records(robot["links"]),
        torch=shapes_from_records(robot["torch"]),
        bench=shapes_from_records(record["bench"]),
    )


def _arm(new: NewCell) -> Arm:
    arm = find_arm(new.robot)
    if not new.couplings:
        return arm
    if not Path(new.robot).suffix:
        raise InputError(f"{new.robot} is a shipped arm: its couplings are in it; they are stated for a file only")
    return replace(arm, couplings=tuple(new.couplings))


def _robot(new: NewCell, arm: Arm, files: dict[str, dict[str, Any]]) -> tuple[dict[str, Any], str]:
    links = _links(arm, new.robot)
    tool = new.T_flange_tool
    robot: dict[str, Any] = {
        "arm": _arm_file(arm, new.robot, files),
        "T_world_base": new.T_world_base.to_record(),
        "T_flange_tool": None if tool is None else tool.to_record(),
        "links": links,
        "torch_shape": without_none(asdict(new.torch)),
        "torch": [] if tool is None else _torch(new, tool),
    }
    if new.rail is not None:
        robot["rail"] = dict(new.rail)
    mount = (new.T_world_base.R @ arm.mount_mm + new.T_world_base.t_mm)[2]
    robot["mounting_face_z_mm"] = float(round(mount, 3)) + 0.0
    bodies = "hulls of the collision meshes of the URDF file" if links else "no bodies: the arm file has none"
    torch = "the mesh given" if new.torch_mesh else "the capsules given" if new.torch_capsules else str(new.torch)
    return robot, f"robot: {bodies}; torch: {torch}"


def _arm_file(arm: Arm, given: str, files: dict[str, dict[str, Any]]) -> str:
    """Return the name under which the cell names its arm, and add the arm's file if it is not a shipped arm."""
    path = Path(given)
    if not path.suffix:
        return given
    name = f"{path.stem}.arm.json"
    files[name] = arm_record(arm)
    return name


def _links(arm: Arm, given: str) -> list[dict[str, Any]]:
    path = Path(given)
    if path.suffix.lower() != ".urdf":
        return []
    return [hulled(body.name, body.hull, link=body.link) for body in read_link_hulls(path, arm)]


def _torch(new: NewCell, tool: RigidTransform) -> list[dict[str, Any]]:
    if new.torch_mesh is not None:
        return bodies_of_mesh(new.torch_mesh, tool, new.torch.wire_mm)
    if new.torch_capsules:
        return bodies_of_capsules(new.torch_capsules, tool)
    return bodies_of_shape(new.torch, tool)


def _box(name: str, low: FloatArray, high: FloatArray) -> dict[str, Any]:
    return hulled(name, np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T)
