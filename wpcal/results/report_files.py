"""The files of a finished calibration that the page is made of, checked for agreement."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.mesh_glb import read_part_glb
from wpcal.calibrate.result import SCHEMA as CALIBRATION_SCHEMA
from wpcal.core.errors import FormatError, FrameError, InputError
from wpcal.core.records import read_bytes, read_json
from wpcal.seam.record import SEAMS_SCHEMA

NEEDED = (
    "verdict",
    "tolerance_mm",
    "points",
    "criterion",
    "objective_mm",
    "lower_bound_mm",
    "certified",
    "T_base_part",
    "correction",
    "criteria",
    "issues",
    "solver",
    "seed",
    "teaching_error",
    "robot_space",
    "versions",
)
"""What the page shows of ``calibration.json``."""


@dataclass(frozen=True, slots=True, eq=False)
class ReportFiles:
    """What `wpcal report` starts from.

    Parameters
    ----------
    calibration : dict
        The record of ``calibration.json``.
    seams : dict
        The record of ``seams.json``.
    part_glb : bytes or None
        ``part.glb``, where there is one.
    """

    calibration: dict[str, Any]
    seams: dict[str, Any]
    part_glb: bytes | None


def read_report_files(folder: Path) -> ReportFiles:
    """Read ``calibration.json``, ``seams.json`` and ``part.glb`` of one folder.

    Parameters
    ----------
    folder : Path
        As `wpcal calibrate` wrote it.

    Raises
    ------
    InputError
        When the folder or one of the records is not there.
    FrameError
        When the seams are not in `base`.
    FormatError
        When a file breaks its format, or they do not come from one calibration.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; expected the folder of a finished calibration")
    calibration = read_json(folder / "calibration.json", schema=CALIBRATION_SCHEMA)
    missing = [key for key in NEEDED if key not in calibration]
    if missing:
        raise FormatError(f"lacks {', '.join(missing)}", path=str(folder / "calibration.json"))
    path = folder / "seams.json"
    seams = read_json(path, schema=SEAMS_SCHEMA)
    if seams.get("frame") != "base":
        raise FrameError(f"{path}: expected seams in the frame 'base', got {seams.get('frame')!r}")
    if not np.array_equal(seams.get("T_base_part") or (), calibration["T_base_part"]):
        raise FormatError("T_base_part differs from the one in calibration.json: two calibrations", path=str(path))
    return ReportFiles(calibration, seams, _read_part(folder / "part.glb", calibration))


def _read_part(path: Path, calibration: dict[str, Any]) -> bytes | None:
    """Return the bytes of the mesh when they belong to the calibrated part."""
    if not path.exists():
        return None
    data = read_bytes(path)
    expected = calibration.get("inputs", {}).get("part", {}).get("sha256")
    if read_part_glb(data, path=str(path)).sha256 != expected:
        raise FormatError("was made from another STEP file than calibration.json", path=str(path))
    return data
