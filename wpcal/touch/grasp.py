"""The grasp: the place of the part in the gripper of robot 2, measured with robot 1, written into a cell file.

Also here: the place of base 2 relative to base 1, from points that both robots touched, written into a cell file.

The fit is that of a part: the points in the base of robot 2 take the place of the model.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.calibrate import CalibrationResult, Criterion, Solver, calibrate
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_numbers
from wpcal.core.pairs import PointPairs
from wpcal.core.records import read_json
from wpcal.core.tables import read_table
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_file import cell_from_record
from wpcal.planning.cell.shape import JOINTS
from wpcal.robot.kinematics.arm_file import ARM_SCHEMA, shipped_arms
from wpcal.robot.torch.file import CELL_SCHEMA

NO_GRASP = {"xyz_mm": [0.0, 0.0, 0.0], "rpy_deg": [0.0, 0.0, 0.0]}
"""Placeholder while the grasp is not known, so that the rest of the cell file can be checked."""


@dataclass(frozen=True, slots=True, eq=False)
class Holding:
    """A cell file and the joints of robot 2 while robot 1 touched the part."""

    path: Path  #: The cell file.
    record: Mapping[str, Any]  #: Content of the file; the grasp may be missing.
    cell: Cell  #: The same cell; a missing grasp is replaced by the identity.
    joints2: FloatArray  #: shape (6,). Shown angles of robot 2, rad.


def read_holding(path: Path, joints_deg: str) -> Holding:
    """Read a cell file, whose grasp may be missing, and the joints of robot 2.

    `joints_deg`: Six shown angles in degrees, separated by commas.
    Raises `InputError` when there are not six numbers or a joint is beyond its limits.
    Raises `FormatError` when the file breaks its format.
    """
    record = read_json(path, schema=CELL_SCHEMA)
    if not isinstance(record.get("holder_robot"), dict):
        raise FormatError("the field 'holder_robot' is missing", path=str(path))
    cell = _read_without_grasp(record, path)
    return Holding(path, record, cell, _joints(joints_deg, cell))


def _joints(text: str, cell: Cell) -> FloatArray:
    try:
        q = np.radians(parse_numbers(text))
    except ValueError:
        q = np.zeros(0)
    if q.shape != (JOINTS,):
        raise InputError(
            f"joints of the holder: expected {JOINTS} angles in degrees, separated by commas, got {text!r}"
        )
    low, high = np.degrees(cell.arm2.limits)
    for joint, value, least, most in zip(cell.arm2.joints, np.degrees(q), low, high, strict=True):
        if not least <= value <= most:
            raise InputError(
                f"joints of the holder: {joint.name} is {value:g} deg, its limits are {least:g} and {most:g}"
            )
    return frozen(q)


def solve_grasp(holding: Holding, T_base1_part: RigidTransform) -> RigidTransform:
    r"""Return ``T_flange2_part`` from the place where robot 1 found the part.

    .. math:: T_{flange2,part} = (T_{base1,base2} \, T_{base2,flange2}(q_2))^{-1} \, T_{base1,part}

    Errors of the bases and of the arms enter the grasp. They cancel where robot 2 holds the part as it did during the
    touching, and grow with the rotation away from that pose.
    """
    cell = holding.cell
    flange = cell.arm2.forward(holding.joints2[None])[0]
    T_base2_flange2 = RigidTransform.from_matrix(flange, target="base2", source="flange2")
    touched = T_base1_part.relabelled(target="base1", source="part")
    return (cell.T_base1_base2 @ T_base2_flange2).inverse() @ touched


def cell_files(holding: Holding, T_flange2_part: RigidTransform) -> dict[str, Any]:
    """Return the files of the cell with a grasp, by name: ``cell.json``, and the arm files beside the cell file."""
    record = copy.deepcopy(dict(holding.record))
    record["holder_robot"]["T_flange_part"] = T_flange2_part.to_record()
    return with_arms(record, holding.path)


def with_arms(record: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """Return the record of a cell as ``cell.json``, and the records of the arm files beside its file.

    Returns dict of str to dict. Records by file name. The cell names its arms without a folder, so that all files can
    be in one folder.
    """
    cell = copy.deepcopy(dict(record))
    files = {"cell.json": cell}
    for robot in ("torch_robot", "holder_robot"):
        name = str(cell[robot]["arm"])
        if name not in shipped_arms():
            beside = path.parent / name
            cell[robot]["arm"] = beside.name
            files[beside.name] = read_json(beside, schema=ARM_SCHEMA)
    return files


BASE1_COLUMNS = ("base1_x_mm", "base1_y_mm", "base1_z_mm")
BASE2_COLUMNS = ("base2_x_mm", "base2_y_mm", "base2_z_mm")
FEWEST = 3  #: Fewest points that determine a pose in space.


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredBases:
    """A cell with the measured place of robot 2."""

    result: CalibrationResult  #: Of the points; its `T_base_part` is ``T_base1_base2``.
    #: ``cell.json`` with the new ``T_world_base`` of robot 2, and the arm files that it names.
    files: Mapping[str, Any]
    moved_mm: float  #: Distance between the measured base of robot 2 and the base in the cell file.


def read_base_points(path: Path) -> PointPairs:
    """Read ``name,base1_x_mm,base1_y_mm,base1_z_mm,base2_x_mm,base2_y_mm,base2_z_mm``, one row per point.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when a column is missing, a cell is not a number, a name appears twice, or there are fewer than
    three points.
    """
    table = read_table(path)
    table.require(("name", *BASE1_COLUMNS, *BASE2_COLUMNS))
    names = table.unique_names("name")
    if len(names) < FEWEST:
        raise FormatError(
            f"two bases need at least {FEWEST} points that both robots touched, got {len(names)}", path=str(path)
        )
    return PointPairs(tuple(names), table.numbers(BASE2_COLUMNS), table.numbers(BASE1_COLUMNS))


def measure_bases(cell_json: Path, touched: PointPairs, *, tolerance_mm: float) -> MeasuredBases:
    r"""Fit the place of robot 2 and put it into a cell.

    .. math:: T_{world,base2} = T_{world,base1} \, T_{base1,base2}

    `touched`: Of n points: source in base 2, target in base 1, mm.
    Raises `GeometryError` when the points are on one line.
    Raises `FormatError` when the file breaks its format.
    """
    record = copy.deepcopy(read_json(cell_json, schema=CELL_SCHEMA))
    cell = _read_without_grasp(record, cell_json)
    result = calibrate(touched, criterion=Criterion.MINIMAX, solver=Solver.EXACT, tolerance_mm=tolerance_mm)
    fitted = result.T_base_part.relabelled(target="base1", source="base2")
    T_world_base2 = cell.T_world_base @ fitted
    record["holder_robot"]["T_world_base"] = T_world_base2.to_record()
    moved = float(np.linalg.norm(T_world_base2.t_mm - cell.T_world_base2.t_mm))
    return MeasuredBases(result, with_arms(record, cell_json), moved)


def _read_without_grasp(record: Mapping[str, Any], path: Path) -> Cell:
    """Read a cell and check everything except its grasp, which may be measured later."""
    filled = copy.deepcopy(dict(record))
    holder = filled.get("holder_robot")
    if isinstance(holder, dict) and holder.get("T_flange_part") is None:
        holder["T_flange_part"] = NO_GRASP
    return cell_from_record(filled, path=path)
