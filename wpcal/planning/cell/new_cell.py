"""A new cell file of one robot: bodies from URDF files and meshes, places as given, a torch from a few numbers.

Also here: a home for a new cell: the torch points down in front of the arm, and nothing is in collision.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.same_bits import length, product
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Carrier, Cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.cell_file import default_home, rail_from_record, shapes_from_records
from wpcal.planning.cell.shape import BY_LENGTH, JOINTS
from wpcal.planning.cell.workplace import is_usable, reach_mm
from wpcal.robot.kinematics.arm import Arm, Coupling, arm_frames
from wpcal.robot.kinematics.arm_file import arm_record, find_arm
from wpcal.robot.kinematics.forward import start_frames, walk
from wpcal.robot.kinematics.inverse import solve_inverse
from wpcal.robot.kinematics.urdf_bodies import read_link_hulls
from wpcal.robot.torch.bodies import (
    NOZZLE_TO_PART_MM,
    bodies_of_capsules,
    bodies_of_mesh,
    bodies_of_shape,
    hulled,
    mounted,
)
from wpcal.robot.torch.file import CELL_SCHEMA, without_none
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape

HOME_DISTANCES, HOME_HEIGHTS = (0.7, 0.6, 0.8, 0.5), (0.8, 0.6, 1.0)
"""Where the tip of the wire is at home, in front of the base and above the mounting face, in parts of the reach."""
ELBOW = 4.0  #: What an elbow that is higher by the reach counts against a turn of the wrist, rad.
TURNS_DEG = tuple(float(sign * turn) for turn in range(0, 181, 15) for sign in (1, -1) if 0 < turn < 180 or sign > 0)
"""Turns of joint 1 away from the front, the smallest first."""
AT_ONCE = 128  #: States that are compared with the cell together: most cells have a free one among the first.


def choose_home(cell: Cell) -> FloatArray:
    """Return joints of a home, shape (6,), rad.

    The elbow is up and the wrist is turned little. Of these poses the first is taken that keeps all safety distances
    from the bodies of the cell: first in front of the base, then with joint 1 turned. If none does, the first pose is
    returned; `wpcal.planning.cell.cell_check` then tells what it touches.
    """
    poses = _torch_down(cell)
    if not len(poses):
        poses = default_home(cell.arm)[None]
    turned = np.concatenate([poses + np.radians([turn, 0, 0, 0, 0, 0]) for turn in TURNS_DEG])
    low, high = cell.arm.limits
    turned = np.round(np.degrees(turned), 1)  # as it is written
    turned = np.radians(turned[((np.radians(turned) >= low) & (np.radians(turned) <= high)).all(axis=1)])
    clearance = CellClearance(cell, None)
    for start in range(0, len(turned), AT_ONCE):
        some = turned[start : start + AT_ONCE]
        q = np.concatenate([some, np.repeat(cell.home[None, JOINTS:], len(some), axis=0)], axis=1)
        clear = clearance.margins(q).is_clear
        if clear.any():
            return np.asarray(some[int(np.argmax(clear))])
    return np.asarray(turned[0] if len(turned) else poses[0])


def _torch_down(cell: Cell) -> FloatArray:
    """Return joints with the torch pointing down in front of the arm, shape (n, 6), rad, the best first."""
    arm = cell.arm
    reach = reach_mm(arm)
    places = [(x * reach, z * reach + arm.mount_mm[2]) for z in HOME_HEIGHTS for x in HOME_DISTANCES]
    R = np.array([[[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]] for c, s in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0))])
    T = np.repeat(np.eye(4)[None], len(places) * len(R), axis=0)
    T[:, :3, :3] = np.tile(R, (len(places), 1, 1))
    T[:, [0, 2], 3] = np.repeat(places, len(R), axis=0)
    joints = solve_inverse(arm, product(T, cell.T_flange_tool.inverse().matrix)).joints
    good = is_usable(arm, joints).reshape(-1)
    flat = joints.reshape(-1, joints.shape[-1])[good]
    if not len(flat):
        return flat
    elbow = list(arm_frames(arm, RigidTransform.identity(target="world", source="base"), flat))[2].p[2] / reach
    worth = np.abs(flat)[:, [0, 3, 5]].max(axis=1) - ELBOW * elbow
    return np.asarray(flat[np.argsort(worth, kind="stable")])


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
        "bench": [
            hulled(f"box {row + 1}", np.array(np.meshgrid(*zip(*corners, strict=True))).reshape(3, -1).T)
            for row, corners in enumerate(new.boxes)
        ],
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
        "torch_shape": without_none(asdict(new.torch if tool is None else mounted(new.torch, tool))),
        "torch": [] if tool is None else _torch(new, tool),
    }
    if new.rail is not None:
        robot["rail"] = dict(new.rail)
    mount = (new.T_world_base.R @ arm.mount_mm + new.T_world_base.t_mm)[2]
    robot["mounting_face_z_mm"] = float(round(mount, 3)) + 0.0
    is_urdf = Path(new.robot).suffix.lower() == ".urdf"
    bodies = "hulls of the collision meshes of the URDF file" if is_urdf else "capsules estimated from its lengths"
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
        return _estimated(arm)
    return [hulled(body.name, body.hull, link=body.link) for body in read_link_hulls(path, arm)]


RADII = (0.105, 0.095, 0.067, 0.06, 0.053, 0.035, 0.035)
"""Of the bodies of base and links in parts of the reach: as the MH6, whose drawings show 75 to 150 mm for 1422 mm."""


def _estimated(arm: Arm) -> list[dict[str, Any]]:
    """Return capsules along the lengths of the links of an arm without meshes: along z, then along x of each link."""
    reach = reach_mm(arm)
    motions = list(walk(start_frames(arm.chain.T_base_dh0, 1), arm.chain.table, np.zeros((len(arm.joints), 1))))
    first = motions[0].p_before[:, 0]
    ways = [[arm.mount_mm, first]]
    for motion in motions:
        start, end, z = motion.p_before[:, 0], motion.frame.p[:, 0], motion.z[:, 0]
        corner = start + float(product(end - start, z)) * z
        R = motion.frame.rotations()[0]
        ways.append([np.asarray(product(point - end, R), dtype=np.float64) for point in (start, corner, end)])
    T_flange_last = arm.chain.T_dhn_flange.inverse()
    ways[-1] = [T_flange_last.apply(point) for point in ways[-1]]
    return [
        {"name": f"link {link} {BY_LENGTH}", "link": link, "capsules": capsules}
        for link, (way, share) in enumerate(zip(ways, RADII, strict=True))
        if (
            capsules := [
                {"p_mm": one.tolist(), "q_mm": other.tolist(), "radius_mm": round(share * reach)}
                for one, other in pairwise(way)
                if length(other - one) > 1.0
            ]
        )
    ]


def _torch(new: NewCell, tool: RigidTransform) -> list[dict[str, Any]]:
    if new.torch_mesh is not None:
        return bodies_of_mesh(new.torch_mesh, tool, new.torch.wire_mm)
    if new.torch_capsules:
        return bodies_of_capsules(new.torch_capsules, tool)
    return bodies_of_shape(new.torch, tool)
