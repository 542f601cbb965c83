"""Cells as JSON files (schema ``wpcal/cell/1``)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import read_json
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.robot_cell import JOINTS, RobotCell, Shape
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.arm_file import find_arm, shipped_arms

CELL_SCHEMA = "wpcal/cell/1"
Built = TypeVar("Built")


def read_cell(path: Path) -> RobotCell:
    """Read a cell file. An arm is the name of a shipped arm, or of a file beside the cell file.

    Raises
    ------
    InputError : When the file or one of its arms cannot be opened, or the part's place in the gripper is missing.
    FormatError : When a field is missing or wrong; the message names the file.
    """
    record = read_json(path, schema=CELL_SCHEMA)
    return cell_from_record(record, path=path)


def cell_from_record(record: Mapping[str, Any], *, path: Path) -> RobotCell:
    """Return the cell of a record. `path` is its file: arm files are looked up beside it, and messages name it.

    Raises
    ------
    InputError, FormatError : As `read_cell` does.
    """
    return built_from(_cell, record, path)


def built_from(build: Callable[[Mapping[str, Any], Path], Built], record: Mapping[str, Any], path: Path) -> Built:
    """Build a cell from the record of a file; messages name the file, and fields that are missing or of a wrong type.

    Raises
    ------
    InputError, FormatError : As `build` does, or when it finds no field or a wrong one.
    """
    try:
        return build(record, path)
    except FormatError:
        raise
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except KeyError as error:
        raise FormatError(f"the field {error.args[0]!r} is missing", path=str(path)) from None
    except (TypeError, ValueError, AttributeError) as error:
        raise FormatError(f"a field has a wrong type: {error}", path=str(path)) from None


def _cell(record: Mapping[str, Any], path: Path) -> RobotCell:
    one, two = record["torch_robot"], record["holder_robot"]
    if two.get("T_flange_part") is None:
        raise InputError("holder_robot: T_flange_part is missing: where the part sits in the gripper of robot 2")
    arm1, arm2 = (arm_beside(str(robot["arm"]), path) for robot in (one, two))
    return RobotCell(
        name=str(record["name"]),
        arm1=arm1,
        arm2=arm2,
        T_world_base1=RigidTransform.from_record(one["T_world_base"], target="world", source="base1"),
        T_world_base2=RigidTransform.from_record(two["T_world_base"], target="world", source="base2"),
        T_flange1_tool=RigidTransform.from_record(one["T_flange_tool"], target="flange1", source="tool"),
        T_flange2_part=RigidTransform.from_record(two["T_flange_part"], target="flange2", source="part"),
        d1_mm=float(record["safety_distance_mm"]),
        weights1=_weights(one, arm1),
        weights2=_weights(two, arm2),
        links1=shapes_from_records(one["links"]),
        links2=shapes_from_records(two["links"]),
        torch=shapes_from_records(one["torch"]),
        part=shapes_from_records(two["part"]),
        bench=shapes_from_records(record.get("bench", [])),
        source=str(record.get("source", "")),
        floor_z_mm=float(record.get("floor_z_mm", 0.0)),
        mount_z_mm=(_mount_z(one), _mount_z(two)),
    )


def arm_beside(name: str, path: Path) -> Arm:
    """Return the arm that the cell file `path` names: a shipped arm, or a file beside the cell file.

    Raises
    ------
    InputError, FormatError : When there is no such arm, or its file breaks its format.
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
