"""A new cell file of one robot: bodies from URDF files and meshes, places as given, a torch from a few numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from wpcal.brep.surface_points import surface_points
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import to_json
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.bodies import arm_frames
from wpcal.planning.cell.cell_file import CELL_SCHEMA
from wpcal.planning.cell.hulls import capsule_around
from wpcal.planning.cell.one_robot import OneRobotCell
from wpcal.planning.cell.one_robot_file import default_home, read_one_robot
from wpcal.planning.cell.singularity import is_regular, is_within_turns
from wpcal.planning.cell.workplace import reach_mm
from wpcal.robot.kinematics.arm import Arm, Coupling
from wpcal.robot.kinematics.arm_file import arm_record, find_arm
from wpcal.robot.kinematics.inverse import solve_inverse
from wpcal.robot.kinematics.urdf_bodies import hull_corners, read_link_hulls, read_stl
from wpcal.seam.torch import TorchShape

SAFETY_MM = 10.0
"""Above the errors of bases and meshes, and below what is between the links of most arms and a part."""
NOZZLE_TO_PART_MM = 3.0
"""The nozzle works near the part: this is above the errors of a calibration and of a path."""
NO_FLOOR_MM = -1e5
"""The floor of a cell of which nothing is known: no arm reaches it."""
NOZZLE_MM = 110.0
"""From the tip of the wire to where a usual swan neck bends."""
NECK_RADIUS_MM = 30.0
"""Half of the width of a usual torch body with its cables."""
HOME_DISTANCES, HOME_HEIGHTS = (0.7, 0.6, 0.8, 0.5), (0.8, 0.6, 1.0)
"""Where the tip of the wire is at home, in front of the base and above the mounting face, in parts of the reach."""
ELBOW = 4.0
"""What an elbow that is higher by the reach counts against a turn of the wrist, rad."""
SLICE_MM = 30.0
"""A torch mesh is cut across the wire into pieces of this length, each with its own hull: a bent neck stays bent."""
SAMPLE_MM = 3.0
"""Points on a torch mesh are at most this far apart."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NewCell:
    """What a new cell is made from.

    Parameters
    ----------
    robot : str
        Shipped arm, arm file or URDF file.
    T_world_base : RigidTransform
    T_flange_tool : RigidTransform or None
        None: not known yet; the cell file says so, and a plan asks for it.
    torch : TorchShape
    torch_mesh : Path or None
        STL file in the frame `flange`, mm. None: capsules from `torch`.
    positioner : str or None
        Arm file or URDF file with one or two axes.
    T_world_positioner : RigidTransform
    T_carrier_part : RigidTransform or None
        The part on the positioner, or in `world`.
    boxes : sequence of (low, high)
        Corners of boxes in `world`, mm: table, fixtures.
    rail : mapping or None
        As in the cell file.
    home_deg : sequence of float or None
    safety_mm : float
    couplings : sequence of Coupling
        Of the robot's joints, which a URDF file cannot name.
    """

    robot: str
    T_world_base: RigidTransform
    T_flange_tool: RigidTransform | None = None
    torch: TorchShape = field(default_factory=TorchShape)
    torch_mesh: Path | None = None
    positioner: str | None = None
    T_world_positioner: RigidTransform | None = None
    T_carrier_part: RigidTransform | None = None
    boxes: Sequence[tuple[FloatArray, FloatArray]] = ()
    rail: Mapping[str, Any] | None = None
    home_deg: Sequence[float] | None = None
    safety_mm: float = SAFETY_MM
    couplings: Sequence[Coupling] = ()


def bare_cell(arm: str, T_flange_tool: RigidTransform, torch: TorchShape) -> OneRobotCell:
    """Return the cell of one arm with a straight torch and nothing around it: its base is `world`, without a floor.

    Parameters
    ----------
    arm : str
        Shipped arm, arm file or URDF file.
    T_flange_tool : RigidTransform
    torch : TorchShape

    Raises
    ------
    InputError
        When the arm is not known, or its file cannot be read.
    """
    place = RigidTransform.identity(target="world", source="base")
    new = NewCell(robot=arm, T_world_base=place, T_flange_tool=T_flange_tool, torch=torch, safety_mm=NOZZLE_TO_PART_MM)
    with TemporaryDirectory() as folder:
        for name, record in new_cell_files(new, "cell.json").items():
            Path(folder, name).write_text(to_json(record), encoding="utf-8")
        return replace(read_one_robot(Path(folder, "cell.json")), name=arm, floor_z_mm=NO_FLOOR_MM)


def new_cell_files(new: NewCell, name: str) -> dict[str, dict[str, Any]]:
    """Return the records of a new cell by file name: ``cell.json`` is under `name`, arm files are beside it.

    Raises
    ------
    InputError, FormatError
        When an arm or a mesh cannot be read.
    """
    files: dict[str, dict[str, Any]] = {}
    robot, source = _robot(new, files)
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
        arm = find_arm(new.positioner)
        at = new.T_world_positioner or RigidTransform.identity(target="world", source="base")
        record["positioner"] = {
            "arm": _arm_file(arm, new.positioner, files),
            "T_world_base": at.to_record(),
            "links": _links(arm, new.positioner),
            "T_flange_part": place,
        }
    files[name] = record
    return files


def _robot(new: NewCell, files: dict[str, dict[str, Any]]) -> tuple[dict[str, Any], str]:
    arm = find_arm(new.robot)
    if new.couplings:
        if not Path(new.robot).suffix:
            raise InputError(f"{new.robot} is a shipped arm: its couplings are in it; they are stated for a file only")
        arm = replace(arm, couplings=tuple(new.couplings))
    links = _links(arm, new.robot)
    tool = new.T_flange_tool
    robot: dict[str, Any] = {
        "arm": _arm_file(arm, new.robot, files),
        "T_world_base": new.T_world_base.to_record(),
        "T_flange_tool": None if tool is None else tool.to_record(),
        "links": links,
        "torch": [] if tool is None else _torch(new, tool),
    }
    if tool is not None:
        robot["home_deg"] = list(new.home_deg) if new.home_deg is not None else _home(arm, tool)
    if new.rail is not None:
        robot["rail"] = dict(new.rail)
    mount = (new.T_world_base.R @ arm.mount_mm + new.T_world_base.t_mm)[2]
    robot["mounting_face_z_mm"] = float(round(mount, 3)) + 0.0
    bodies = "hulls of the collision meshes of the URDF file" if links else "no bodies: the arm file has none"
    torch = "the mesh given" if new.torch_mesh else "capsules from the lengths given"
    return robot, f"robot: {bodies}; torch: {torch}"


def _home(arm: Arm, T_flange_tool: RigidTransform) -> list[float]:
    """Return joints with the torch pointing down in front of the arm: the elbow up, the wrist turned little; deg."""
    reach = reach_mm(arm)
    places = [(x * reach, z * reach + arm.mount_mm[2]) for z in HOME_HEIGHTS for x in HOME_DISTANCES]
    R = np.array([[[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]] for c, s in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0))])
    T = np.repeat(np.eye(4)[None], len(places) * len(R), axis=0)
    T[:, :3, :3] = np.tile(R, (len(places), 1, 1))
    T[:, [0, 2], 3] = np.repeat(places, len(R), axis=0)
    joints = solve_inverse(arm, T @ T_flange_tool.inverse().matrix).joints
    good = (is_within_turns(arm, joints) & is_regular(arm, joints)).reshape(-1)
    if not good.any():
        return [float(value) for value in np.round(np.degrees(default_home(arm)), 1)]
    flat = joints.reshape(-1, joints.shape[-1])[good]
    elbow = list(arm_frames(arm, RigidTransform.identity(target="world", source="base"), flat))[2].p[2] / reach
    best = flat[int(np.argmin(np.abs(flat)[:, [0, 3, 5]].max(axis=1) - ELBOW * elbow))]
    return [float(value) for value in np.round(np.degrees(best), 1) + 0.0]


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
    return [_hulled(body.name, body.hull, link=body.link) for body in read_link_hulls(path, arm)]


def _hulled(name: str, hull: FloatArray, **more: Any) -> dict[str, Any]:
    p, q, radius = capsule_around(hull)
    capsule = {"p_mm": _rounded(p), "q_mm": _rounded(q), "radius_mm": float(np.ceil(radius * 100 + 2) / 100)}
    return {"name": name, **more, "capsules": [capsule], "hull_mm": hull.tolist()}


def _rounded(values: FloatArray) -> list[float]:
    return [float(value) for value in np.round(values, 2) + 0.0]


def _box(name: str, low: FloatArray, high: FloatArray) -> dict[str, Any]:
    return _hulled(name, np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T)


def _torch(new: NewCell, T_flange_tool: RigidTransform) -> list[dict[str, Any]]:
    if new.torch_mesh is not None:
        return _sliced(new.torch_mesh, T_flange_tool, new.torch.wire_mm)
    radius = new.torch.nozzle_radius_mm
    flange = T_flange_tool.inverse().t_mm
    bend = np.array([0.0, 0.0, -max(NOZZLE_MM, new.torch.wire_mm + 2.0 * radius)])
    way = flange - bend
    length = float(np.linalg.norm(way))
    bodies = [_capsule("nozzle", np.array([0.0, 0.0, -new.torch.wire_mm - radius]), bend, radius)]
    bodies[0]["to_part_mm"] = NOZZLE_TO_PART_MM
    if length > NECK_RADIUS_MM:
        start = bend + way / length * min(NECK_RADIUS_MM, length / 2)
        bodies.append(_capsule("torch body", start, flange, NECK_RADIUS_MM))
    return bodies


def _capsule(name: str, p: FloatArray, q: FloatArray, radius: float) -> dict[str, Any]:
    return {"name": name, "capsules": [{"p_mm": _rounded(p), "q_mm": _rounded(q), "radius_mm": radius}]}


def _sliced(path: Path, T_flange_tool: RigidTransform, wire_mm: float) -> list[dict[str, Any]]:
    """Return hulls of the slices of a torch mesh across the wire; what is in front of the nozzle is the wire."""
    corners = T_flange_tool.inverse().apply(read_stl(path)).reshape(-1, 3, 3)
    points = np.concatenate(surface_points(corners, SAMPLE_MM))
    points = points[points[:, 2] <= SAMPLE_MM - wire_mm]
    if not len(points):
        raise InputError(f"{path}: no part of this mesh is behind the nozzle; expected it in mm in the frame flange")
    bodies = []
    number = np.floor(points[:, 2] / SLICE_MM).astype(int)
    for row, which in enumerate(np.unique(number)[::-1], start=1):
        edge = which * SLICE_MM
        own = points[(points[:, 2] >= edge - SAMPLE_MM) & (points[:, 2] <= edge + SLICE_MM + SAMPLE_MM)]
        try:
            body = _hulled(f"torch {row}", hull_corners(own))
        except FormatError:  # the last points of a mesh: they are in the slice beside it, too
            continue
        if -edge - SLICE_MM < NOZZLE_MM:
            body["to_part_mm"] = NOZZLE_TO_PART_MM
        bodies.append(body)
    return bodies
