"""Plain text for any other program: the tool's poses as JSON (with its JSON Schema) and as CSV.

Both state the frame, the units and the sense of the tool's axis in the file and keep all digits. They give each
rotation as a matrix and as a quaternion x, y, z, w.
"""

import math
from typing import Any

import numpy as np

from wpcal.controllers.language.naming import NameRules, safe_name
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, errors_mm
from wpcal.controllers.registry import Exporter
from wpcal.core.csv_text import csv_text
from wpcal.core.records import to_json
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.core.schemas import schema_file, schema_text

NAMES = NameRules("plain text", 60)  #: For the name of the file.
PROGRAM_SCHEMA = "wpcal/program/1"
PROGRAM_CSV_COLUMNS = (
    *("seam", "point", "role", "x_mm", "y_mm", "z_mm", "qx", "qy", "qz", "qw"),
    *(f"r{row}{column}" for row in range(1, 4) for column in range(1, 4)),
    *("u95_mm", "frame", "z_sense"),
)
ALL_DIGITS = "%.17g"  #: Reads back as the same number.


def write_program_json(program: WeldProgram) -> dict[str, str]:
    """Write one JSON file with all seams. ``NAME.program.json`` and its schema."""
    torch, motion = program.torch, program.motion
    record = {
        "schema": PROGRAM_SCHEMA,
        "about": describe(program, has_arc=False),
        "frame": "base",
        "units": {"length": "mm", "angle": "deg", "speed": "mm/s"},
        "wire_axis": f"+{torch.tool_axis.value}",
        "z_sense": "inward",
        "T_base_part": program.T_base_part.matrix.tolist(),
        "torch": {
            "work_angle_deg": math.degrees(torch.work_rad),
            "travel_angle_deg": math.degrees(torch.travel_rad),
            "standoff_mm": torch.standoff_mm,
        },
        "motion": {"speed_mm_s": motion.speed_mm_s, "air_speed_mm_s": motion.air_speed_mm_s},
        "safe_point": None if program.safe_point is None else _poses(program.safe_point)[0],
        "seams": [_seam(path, program.weld_speed_mm_s(path)) for path in program.paths],
    }
    name = safe_name(program.controller.program_name, NAMES)
    return {f"{name}.program.json": to_json(record), schema_file(PROGRAM_SCHEMA): schema_text(PROGRAM_SCHEMA)}


def _seam(path: WeldPath, mm_s: float) -> dict[str, Any]:
    rows = zip(path.roles, _poses(path), errors_mm(path), strict=True)
    poses = [{"role": role, **pose, "u95_mm": error} for role, pose, error in rows]
    seam = path.seam
    return {
        "name": seam.name,
        "joint": seam.joint.value,
        "weld": seam.weld.value,
        "closed": seam.closed,
        "length_mm": seam.length_mm,
        "speed_mm_s": mm_s,
        **({} if path.run is None else {"weld_data": path.values.to_record()}),
        "poses": poses,
    }


def _poses(path: WeldPath | SafePoint) -> list[dict[str, Any]]:
    q = quaternion_from_rotation(path.R_base).tolist()
    rows = zip(path.p_base.tolist(), path.R_base.tolist(), q, strict=True)
    return [{"p_mm": p, "R": R, "q_xyzw": q_xyzw} for p, R, q_xyzw in rows]


def write_program_csv(program: WeldProgram) -> dict[str, str]:
    """Write one row per pose.

    Returns: ``NAME.program.csv``. The safe point, if there is one, is the first row, without a seam. ``rij`` is row i,
    column j of the rotation; its columns are the tool's axes in `frame`.
    """
    table: list[list[object]] = [[*PROGRAM_CSV_COLUMNS]]
    if program.safe_point is not None:
        table.append(["", 0, "safe", *_cells(program.safe_point)[0], "", "base", "inward"])
    for path in program.paths:
        rows = zip(path.roles, _cells(path), errors_mm(path), strict=True)
        for point, (role, cells, error) in enumerate(rows):
            last = ("" if error is None else ALL_DIGITS % error, "base", "inward")
            table.append([path.seam.name, point, role, *cells, *last])
    return {f"{safe_name(program.controller.program_name, NAMES)}.program.csv": csv_text(table)}


def _cells(path: WeldPath | SafePoint) -> list[list[str]]:
    q = quaternion_from_rotation(path.R_base)
    table = np.concatenate([path.p_base, q, path.R_base.reshape(-1, 9)], axis=1)
    return [[ALL_DIGITS % value for value in row] for row in table.tolist()]


JSON = Exporter("json", "Plain JSON: NAME.program.json and its JSON Schema", write_program_json)
CSV = Exporter("csv", "Plain CSV: NAME.program.csv, one row per pose", write_program_csv)
