"""Cells as JSON files (schema ``wpcal/cell/1``): one robot, or two robots if the file has ``holder_robot``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError, fields_of
from wpcal.core.records import read_json
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Carrier, Cell, Rail
from wpcal.planning.cell.shape import JOINTS, Shape
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.arm_file import find_arm, shipped_arms
from wpcal.robot.torch.file import CELL_SCHEMA, torch_from_fields


def read_cell(path: Path) -> Cell:
    """Read a cell file. An arm is the name of a shipped arm, or of a file beside the cell file.

    Raises `InputError` when a file cannot be opened, or the tool or the part's place in a gripper is missing.
    Raises `FormatError` when a field is missing or wrong; the message names the file.
    """
    return cell_from_record(read_json(path, schema=CELL_SCHEMA), path=path)


def read_one_robot(path: Path) -> Cell:
    """Read the cell file of one robot.

    Raises `InputError` or `FormatError` as `read_cell`; also when the file is of two robots.
    """
    found = read_cell(path)
    if found.has_two_robots:
        raise InputError(f"{path}: this cell has a holder_robot; expected a cell with one robot")
    return found


def cell_from_record(record: Mapping[str, Any], *, path: Path) -> Cell:
    """Return the cell of a record. `path` is its file: arm files are looked up beside it, and messages name it.

    Raises `InputError` or `FormatError` as `read_cell` does.
    """
    with fields_of(str(path)):
        return (_two_robots if "holder_robot" in record else _one_robot)(record, path)


def _two_robots(record: Mapping[str, Any], path: Path) -> Cell:
    one, two = record["torch_robot"], record["holder_robot"]
    if two.get("T_flange_part") is None:
        raise InputError("holder_robot: T_flange_part is missing: where the part sits in the gripper of robot 2")
    arm1, arm2 = (arm_beside(str(robot["arm"]), path) for robot in (one, two))
    has_home = "home_deg" in one and "home_deg" in two  # the way from the home of one alone says nothing of both
    homes = [_home(each, arm) if has_home else np.zeros(JOINTS) for each, arm in ((one, arm1), (two, arm2))]
    T_world_base2 = RigidTransform.from_record(two["T_world_base"], target="world", source="base2")
    return Cell(
        arm=arm1,
        T_world_base=RigidTransform.from_record(one["T_world_base"], target="world", source="base1"),
        T_flange_tool=RigidTransform.from_record(one["T_flange_tool"], target="flange1", source="tool"),
        T_carrier_part=RigidTransform.from_record(two["T_flange_part"], target="flange2", source="part"),
        carrier=Carrier(arm2, T_world_base2, shapes_from_records(two["links"]), _mount_z(two)),
        part=shapes_from_records(two["part"]),
        home=np.concatenate(homes),
        joint_weights=np.concatenate([_weights(one, arm1), _weights(two, arm2)]),
        **_common(record),
    )


def _one_robot(record: Mapping[str, Any], path: Path) -> Cell:
    robot = record["torch_robot"]
    if robot.get("T_flange_tool") is None:
        raise InputError(
            "torch_robot: T_flange_tool is missing: the tool, whose origin is the tip of the wire (wpcal cell new "
            "--tool, or --tool-from with a program of the controller)"
        )
    arm = arm_beside(str(robot["arm"]), path)
    rail = None if robot.get("rail") is None else rail_from_record(robot["rail"])
    carrier = _positioner(record.get("positioner"), path)
    place = record.get("T_world_part") if carrier is None else record["positioner"].get("T_flange_part")
    external = _external(robot, record, "home_mm", "home_deg", rail, carrier)
    return Cell(
        arm=arm,
        T_world_base=RigidTransform.from_record(robot["T_world_base"], target="world", source="base"),
        T_flange_tool=RigidTransform.from_record(robot["T_flange_tool"], target="flange", source="tool"),
        T_carrier_part=None if place is None else RigidTransform.from_record(place, target="carrier", source="part"),
        home=np.concatenate([_home(robot, arm), external]),
        rail=rail,
        carrier=carrier,
        touched_at=_external(robot, record, "touched_at_mm", "touched_at_deg", rail, carrier),
        torch_shape=None if robot.get("torch_shape") is None else torch_from_fields(robot["torch_shape"]),
        **_common(record),
    )


def _common(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields that a cell of one robot and one of two robots have alike."""
    robot = record["torch_robot"]
    return {
        "name": str(record["name"]),
        "d1_mm": float(record["safety_distance_mm"]),
        "links": shapes_from_records(robot.get("links", ())),
        "torch": shapes_from_records(robot.get("torch", ())),
        "bench": shapes_from_records(record.get("bench", ())),
        "floor_z_mm": float(record.get("floor_z_mm", 0.0)),
        "mount_z_mm": _mount_z(robot),
        "source": str(record.get("source", "")),
    }


def arm_beside(name: str, path: Path) -> Arm:
    """Return the arm that the cell file `path` names: a shipped arm, or a file beside the cell file.

    Raises `InputError` or `FormatError` when there is no such arm, or its file breaks its format.
    """
    return find_arm(name if name in shipped_arms() else str(path.parent / name))


def _mount_z(robot: Mapping[str, Any]) -> float | None:
    value = robot.get("mounting_face_z_mm")
    return None if value is None else float(value)


def _weights(robot: Mapping[str, Any], arm: Arm) -> FloatArray:
    """Return K_j of the file; otherwise 1 for the slowest joint and 1/2 for a joint that is twice as fast.

    The paper derives K_j from the inertia that a joint moves. Makers set the largest joint speeds by that inertia.
    """
    if "joint_weights" in robot:
        return np.asarray(robot["joint_weights"], dtype=np.float64)
    speeds = [joint.speed_rad_s for joint in arm.joints]
    if any(speed is None for speed in speeds):
        return np.ones(JOINTS)
    values = np.array(speeds, dtype=np.float64)
    return np.asarray(values.min() / values, dtype=np.float64)


def shapes_from_records(records: Sequence[Mapping[str, Any]]) -> tuple[Shape, ...]:
    """Return the bodies that a list of a cell file describes."""
    return tuple(_shape(record) for record in records)


def _shape(record: Mapping[str, Any]) -> Shape:
    capsules = record["capsules"]
    to_part = record.get("to_part_mm")
    return Shape(
        name=str(record["name"]),
        p=np.array([capsule["p_mm"] for capsule in capsules], dtype=np.float64),
        q=np.array([capsule["q_mm"] for capsule in capsules], dtype=np.float64),
        radius_mm=np.array([capsule["radius_mm"] for capsule in capsules], dtype=np.float64),
        link=int(record.get("link", 0)),
        hull=np.array(record.get("hull_mm", []), dtype=np.float64),
        to_part_mm=None if to_part is None else float(to_part),
    )


def _home(robot: Mapping[str, Any], arm: Arm) -> FloatArray:
    if "home_deg" in robot:
        return _numbers(robot["home_deg"], JOINTS, "home_deg")
    return default_home(arm)


def default_home(arm: Arm) -> FloatArray:
    """Return joints of rest, shape (6,), rad: zero or the limit nearest to it, with joint 5 bent by 90 degrees."""
    low, high = arm.limits
    home = np.zeros(JOINTS)
    home[4] = np.pi / 2 if low[4] + high[4] >= 0.0 else -np.pi / 2
    return np.clip(home, low, high)


def rail_from_record(record: Mapping[str, Any]) -> Rail:
    """Return the rail of a cell file."""
    limits = (float(record[name]) for name in ("min_mm", "max_mm", "speed_mm_s"))
    return Rail(_array(record["direction"], "rail.direction"), *limits)


def _positioner(record: Mapping[str, Any] | None, path: Path) -> Carrier | None:
    if record is None:
        return None
    place = RigidTransform.from_record(record["T_world_base"], target="world", source="base")
    carrier = Carrier(arm_beside(str(record["arm"]), path), place, shapes_from_records(record.get("links", ())))
    if carrier.is_robot:
        raise InputError(f"{carrier.arm.name}: a positioner has one or two axes, this one has {JOINTS}")
    return carrier


def _external(
    robot: Mapping[str, Any],
    record: Mapping[str, Any],
    rail_key: str,
    turning_key: str,
    rail: Rail | None,
    carrier: Carrier | None,
) -> FloatArray:
    """Return the external axes as a field states them; what is missing is zero, or the limit nearest to zero."""
    values: list[FloatArray] = []
    if rail is not None:
        usual = min(max(0.0, rail.min_mm), rail.max_mm)
        values.append(np.array([float(robot["rail"].get(rail_key, usual))]))
    if carrier is not None:
        count = len(carrier.arm.joints)
        stated = record["positioner"].get(turning_key)
        usual_rad = np.clip(np.zeros(count), *carrier.arm.limits)
        values.append(usual_rad if stated is None else _numbers(stated, count, f"positioner.{turning_key}"))
    return np.concatenate([np.zeros(0), *values])


def _array(values: Sequence[float], name: str) -> FloatArray:
    found = np.array(values, dtype=np.float64)
    if found.ndim != 1 or not np.isfinite(found).all():
        raise InputError(f"{name}: expected finite numbers")
    return found


def _numbers(values: Sequence[float], count: int, name: str) -> FloatArray:
    """Return angles of a file in rad."""
    found = _array(values, name)
    if found.shape != (count,):
        raise InputError(f"{name}: expected {count} angles in degrees, got {found.size}")
    return np.asarray(np.radians(found), dtype=np.float64)
