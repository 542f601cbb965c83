"""Cell files with one robot: the schema ``wpcal/cell/1`` without ``holder_robot``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.records import read_json
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell_file import CELL_SCHEMA, arm_beside, built_from, cell_from_record, shapes_from_records
from wpcal.planning.cell.one_robot import OneRobotCell, Positioner, Rail
from wpcal.planning.cell.robot_cell import JOINTS, RobotCell
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.torch.file import torch_from_fields


def read_any_cell(path: Path) -> RobotCell | OneRobotCell:
    """Read a cell file: one robot, or two robots if it has ``holder_robot``.

    Raises
    ------
    InputError : When the file or one of its arms cannot be opened, or the tool of the robot is missing.
    FormatError : When a field is missing or wrong; the message names the file.
    """
    record = read_json(path, schema=CELL_SCHEMA)
    return cell_from_record(record, path=path) if "holder_robot" in record else one_robot_from_record(record, path=path)


def read_one_robot(path: Path) -> OneRobotCell:
    """Read the cell file of one robot.

    Raises
    ------
    InputError, FormatError : As `read_any_cell`; also when the file is of two robots.
    """
    found = read_any_cell(path)
    if isinstance(found, RobotCell):
        raise InputError(f"{path}: this cell has a holder_robot; expected a cell with one robot")
    return found


def one_robot_from_record(record: Mapping[str, Any], *, path: Path) -> OneRobotCell:
    """Return the cell of a record. `path` is its file: arm files are looked up beside it, and messages name it.

    Raises
    ------
    InputError, FormatError : As `read_any_cell`.
    """
    return built_from(_cell, record, path)


def _cell(record: Mapping[str, Any], path: Path) -> OneRobotCell:
    robot = record["torch_robot"]
    if robot.get("T_flange_tool") is None:
        raise InputError(
            "torch_robot: T_flange_tool is missing: the tool centre point of the torch (wpcal cell new --tool, or "
            "--tool-from with a program of the controller)"
        )
    arm = arm_beside(str(robot["arm"]), path)
    rail = None if robot.get("rail") is None else rail_from_record(robot["rail"])
    positioner = _positioner(record.get("positioner"), path)
    place = record.get("T_world_part") if positioner is None else record["positioner"].get("T_flange_part")
    external = _external(robot, record, "home_mm", "home_deg", rail, positioner)
    return OneRobotCell(
        name=str(record["name"]),
        arm=arm,
        T_world_base=RigidTransform.from_record(robot["T_world_base"], target="world", source="base"),
        T_flange_tool=RigidTransform.from_record(robot["T_flange_tool"], target="flange", source="tool"),
        T_carrier_part=None if place is None else RigidTransform.from_record(place, target="carrier", source="part"),
        d1_mm=float(record["safety_distance_mm"]),
        home=np.concatenate([_home(robot, arm), external]),
        rail=rail,
        positioner=positioner,
        touched_at=_external(robot, record, "touched_at_mm", "touched_at_deg", rail, positioner),
        links=shapes_from_records(robot.get("links", ())),
        torch=shapes_from_records(robot.get("torch", ())),
        bench=shapes_from_records(record.get("bench", ())),
        floor_z_mm=float(record.get("floor_z_mm", 0.0)),
        mount_z_mm=None if robot.get("mounting_face_z_mm") is None else float(robot["mounting_face_z_mm"]),
        source=str(record.get("source", "")),
        torch_shape=None if robot.get("torch_shape") is None else torch_from_fields(robot["torch_shape"]),
    )


def _home(robot: Mapping[str, Any], arm: Arm) -> FloatArray:
    if "home_deg" in robot:
        return _numbers(robot["home_deg"], JOINTS, "torch_robot.home_deg")
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


def _positioner(record: Mapping[str, Any] | None, path: Path) -> Positioner | None:
    if record is None:
        return None
    place = RigidTransform.from_record(record["T_world_base"], target="world", source="base")
    return Positioner(arm_beside(str(record["arm"]), path), place, shapes_from_records(record.get("links", ())))


def _external(
    robot: Mapping[str, Any],
    record: Mapping[str, Any],
    rail_key: str,
    turning_key: str,
    rail: Rail | None,
    positioner: Positioner | None,
) -> FloatArray:
    """Return the external axes as a field states them; what is missing is zero, or the limit nearest to zero."""
    values: list[FloatArray] = []
    if rail is not None:
        usual = min(max(0.0, rail.min_mm), rail.max_mm)
        values.append(np.array([float(robot["rail"].get(rail_key, usual))]))
    if positioner is not None:
        count = len(positioner.arm.joints)
        stated = record["positioner"].get(turning_key)
        usual_rad = np.clip(np.zeros(count), *positioner.arm.limits)
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
