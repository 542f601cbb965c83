"""Files of measured poses and of taught joint angles: one row per pose, joints in degrees as on the pendant."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.csv_text import csv_text
from wpcal.core.errors import FormatError, InputError, UnitError
from wpcal.core.numbers import parse_numbers, parse_whole_number
from wpcal.core.orientation_columns import ANGLE_COLUMNS, QUATERNION_COLUMNS, orientations_of_table
from wpcal.core.records import read_json
from wpcal.core.robot_space import RobotSpace
from wpcal.core.rotations import rotation_from_zyx, rx_ry_rz_deg
from wpcal.core.tables import Table, read_table
from wpcal.core.transform import RigidTransform
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.tool_point import TOOL_SCHEMA

POSITION_COLUMNS = ("x_mm", "y_mm", "z_mm")
SETS = ("train", "test")
RADIANS_BELOW = 2.0 * np.pi
"""Angles that all stay below this number look like radians: no joint of a set of poses moves by six degrees only."""
LEAST_TURN_DEG = 1e-3  #: Rows with all joints closer than this are one pose: joint sensors resolve about as much.
LIMIT_SLACK_DEG = 1.0
"""A joint shown this far beyond its limit is the data sheet's rounding; further off, sign or zero are wrong."""


def read_poses(path: Path, arm: Arm) -> tuple[PoseObservations, BoolArray | None]:
    """Read ``q1_deg…qn_deg,x_mm,y_mm,z_mm[,qx,qy,qz,qw | rx_deg,ry_deg,rz_deg][,reflector][,set]``.

    Returns `test`: ndarray of bool, shape (N,), or None. Rows of the set ``test``; None where the file does not say.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when columns are missing, a cell is not a finite number, a quaternion does not have length one,
    a joint is beyond its limits, two rows are one pose, or both forms of an orientation are there.
    Raises `UnitError` when the joint angles look like radians.
    """
    table = read_table(path)
    joints = read_joints(table, arm)
    positions = table.numbers(POSITION_COLUMNS)
    reflectors, reflector = _reflectors(table)
    _refuse_twice(table, joints, reflector)
    test = np.array(table.choices("set", SETS, default=SETS[0])) == SETS[1] if table.has("set") else None
    if test is not None and (test.all() or not test.any()):
        raise FormatError(
            "the column has one word only; expected some rows train and some test", path=table.path, column="set"
        )
    try:
        poses = PoseObservations(joints, positions, orientations_of_table(table), reflectors, reflector, table.lines)
    except InputError as error:
        raise FormatError(str(error), path=table.path) from None
    return poses, test


def read_joints(table: Table, arm: Arm) -> FloatArray:
    """Return the joint angles of a table, shape (N, n), rad, after the checks named in `read_poses`."""
    columns = [f"q{i + 1}_deg" for i in range(len(arm.joints))]
    extra = f"q{len(arm.joints) + 1}_deg"
    if table.has(extra):
        raise FormatError(
            f"{arm.name} has {len(arm.joints)} joints, the table has a column {extra}", path=table.path, line=1
        )
    degrees = table.numbers(columns)
    if len(degrees) > 1 and np.abs(degrees).max() < RADIANS_BELOW:
        raise UnitError(f"{table.path}: no joint angle is above {np.abs(degrees).max():.3g}: radians? Expected degrees")
    low, high = np.rad2deg(arm.limits)
    beyond = (degrees < low - LIMIT_SLACK_DEG) | (degrees > high + LIMIT_SLACK_DEG)
    if beyond.any():
        row, joint = np.argwhere(beyond)[0]
        what = (
            f"joint {arm.joints[joint].name} at {degrees[row, joint]:g} deg is beyond its limits "
            f"{low[joint]:g} to {high[joint]:g}; check sign, zero and limits in the arm file"
        )
        raise FormatError(what, path=table.path, line=table.lines[row], column=columns[joint])
    return np.deg2rad(degrees)


def _reflectors(table: Table) -> tuple[tuple[str, ...], np.ndarray[tuple[int, ...], np.dtype[np.int64]]]:
    if not table.has("reflector"):
        return ("",), np.zeros(len(table), dtype=np.int64)
    cells = table.columns["reflector"]
    names = tuple(sorted(set(cells)))
    if "" in names:
        line = table.lines[cells.index("")]
        raise FormatError("the name is empty", path=table.path, line=line, column="reflector")
    rows = {name: row for row, name in enumerate(names)}
    return names, np.array([rows[cell] for cell in cells], dtype=np.int64)


def _refuse_twice(table: Table, joints: FloatArray, reflector: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> None:
    """Refuse two rows with the same joint angles and reflector: a repeat adds no pose, a slip of the pen misleads."""
    keys = np.column_stack([np.rint(np.rad2deg(joints) / LEAST_TURN_DEG), reflector])
    seen: dict[tuple[float, ...], int] = {}
    for line, key in zip(table.lines, map(tuple, keys.tolist()), strict=True):
        if key in seen:
            what = f"the same joint angles as in line {seen[key]}; measure each pose once, or give the mean"
            raise FormatError(what, path=table.path, line=line)
        seen[key] = line


def read_taught_joints(path: Path, arm: Arm) -> tuple[tuple[str, ...], FloatArray, list[dict[str, str]]]:
    """Read ``name,q1_deg…qn_deg[, other columns]``: joint angles taught with the robot.

    Returns `joints`: ndarray, shape (N, n). Shown angles, rad.
    Returns `others`: list of dict. The other cells of each row (``feature``, ``use``), to be passed on.

    Raises `InputError, FormatError, UnitError` as in `read_poses`; also when a name is missing or appears twice.
    """
    table = read_table(path)
    names = table.unique_names("name")
    joints = read_joints(table, arm)
    taken = {"name", *(f"q{i + 1}_deg" for i in range(len(arm.joints)))}
    clash = sorted({*POSITION_COLUMNS, "robot_space", "tcp_bias_mm"} & set(table.columns))
    if clash:
        raise FormatError(
            f"column {', '.join(clash)} is what `correct` writes; give joint angles only", path=table.path, line=1
        )
    rest = [column for column in table.columns if column not in taken]
    others = [{column: table.columns[column][i] for column in rest} for i in range(len(table))]
    return names, joints, others


def corrected_table(
    names: Sequence[str],
    points: FloatArray,
    others: Sequence[dict[str, str]],
    space: RobotSpace,
    *,
    tcp_bias_mm: float = 0.0,
    postures: FloatArray | None = None,
) -> str:
    """Return the CSV of corrected points: ``name,x_mm,y_mm,z_mm,robot_space,tcp_bias_mm`` and the columns passed on.

    ``rx_deg,ry_deg,rz_deg`` follow if the postures are given and no column that is passed on says them.

    `points`: shape (N, 3). In the base, mm; written to 1e-6 mm.
    `tcp_bias_mm`: Error of the tool centre point that all points share (95 %), mm; the column is left out at zero.
    `postures`: shape (N, 3, 3). The axes of the tool in the base, as columns.
    """
    rest = list(others[0]) if others else []
    columns: tuple[str, ...] = ()
    angles: FloatArray = np.empty((len(names), 0))
    if postures is not None and not {*ANGLE_COLUMNS, *QUATERNION_COLUMNS} & set(rest):
        columns, angles = ANGLE_COLUMNS, rx_ry_rz_deg(postures)
    bias = {"tcp_bias_mm": f"{tcp_bias_mm:.6f}"} if tcp_bias_mm else {}
    rows = [["name", *POSITION_COLUMNS, "robot_space", *bias, *columns, *rest]]
    for name, point, turn, cells in zip(names, points, angles, others, strict=True):
        place, posture = (f"{value:.6f}" for value in point), (f"{value:.4f}" for value in turn)
        rows.append([name, *place, space.value, *bias.values(), *posture, *(cells[key] for key in rest)])
    return csv_text(rows)


def plan_table(arm: Arm, joints: FloatArray) -> str:
    """Return the CSV of planned poses: joint angles, and the nominal flange position, to place the instrument.

    `joints`: shape (N, n). Shown joint angles, rad.
    """
    rows = [[*(f"q{i + 1}_deg" for i in range(joints.shape[1])), "nominal_x_mm", "nominal_y_mm", "nominal_z_mm"]]
    for q, p in zip(np.rad2deg(joints), arm.forward(joints)[:, :3, 3], strict=True):
        rows.append([*(f"{angle:.4f}" for angle in q), *(f"{value:.1f}" for value in p)])
    return csv_text(rows)


def parse_tool(text: str | None) -> tuple[RigidTransform, float | None]:
    """Read a tool centre point: ``x,y,z``, ``x,y,z,rx,ry,rz`` (mm, degrees), or a file of `wpcal tcp`.

    No text is the flange itself.

    Raises `InputError` when the text is not three or six finite numbers, or the file is not one of `wpcal tcp`.
    """
    if text is None:
        return RigidTransform.identity(target="flange", source="tool"), None
    if text.endswith(".json"):
        record = read_json(Path(text), schema=TOOL_SCHEMA)
        try:
            values, error = np.array(record["xyz_mm"], dtype=np.float64), float(record["error_95_mm"])
        except (KeyError, TypeError, ValueError):
            raise FormatError("expected xyz_mm and error_95_mm as numbers", path=text) from None
        if values.shape != (3,) or not np.isfinite([*values, error]).all():
            raise FormatError("expected xyz_mm as three finite numbers", path=text)
        return RigidTransform(np.eye(3), values, "flange", "tool"), error
    try:
        values = np.array(parse_numbers(text))
    except InputError:
        values = np.zeros(0)
    if values.shape not in ((3,), (6,)):
        raise InputError(f"a tool is three or six numbers x,y,z[,rx,ry,rz] in mm and degrees, got {text!r}")
    turn = np.deg2rad(values[3:]) if len(values) == 6 else np.zeros(3)
    return RigidTransform(rotation_from_zyx(*turn), values[:3], "flange", "tool"), None


def parse_rows(text: str) -> tuple[int, ...]:
    """Return line numbers from a text like ``57,58``. Raises `InputError` when one of them is not a whole number."""
    try:
        return tuple(parse_whole_number(cell) for cell in text.split(","))
    except ValueError:
        raise InputError(f"rows to leave out: expected line numbers as 57,58, got {text!r}") from None
