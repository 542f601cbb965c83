"""Repair what has one answer: rotations and quaternions of ``seams.json`` that lost digits.

Nothing else is repaired: which of two points with one name is meant, or where a point really is, only a person knows.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.controllers.audit.fault import Fault
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.records import parse_json, to_json, write_file
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.seam.record_check import QUATERNION_ATOL, ROTATION_ATOL

LOST_DIGITS = 2e-3
"""A rotation whose columns are off by less was rounded to three digits or more; the nearest rotation is meant."""


def repairs_of_seams(record: Mapping[str, Any]) -> dict[str, str]:
    """Return what is written instead of wrong values, by their places."""
    return {place: words for place, words, _, _ in _repairs(record)}


def repaired_seams(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of ``seams.json`` with the rotations and quaternions that are meant."""
    fixed = copy.deepcopy(dict(record))
    for _, _, frame, R in _repairs(fixed):
        frame["R"] = R.tolist()
        if "q_xyzw" in frame:
            frame["q_xyzw"] = quaternion_from_rotation(R).tolist()
    return fixed


def _repairs(record: Mapping[str, Any]) -> Iterator[tuple[str, str, dict[str, Any], FloatArray]]:
    """Yield place, words, frame and rotation of each frame that can be repaired."""
    for seam in record["seams"]:
        for number, frame in enumerate(seam["frames"]):
            R = np.array(frame["R"], dtype=np.float64)
            q = np.array(frame["q_xyzw"], dtype=np.float64) if "q_xyzw" in frame else None
            off = float(np.abs(R.T @ R - np.eye(3)).max())
            if not off <= LOST_DIGITS or np.linalg.det(R) < 0.0:
                continue
            u, _, vt = np.linalg.svd(R)
            nearest = np.asarray(u @ vt, dtype=np.float64)
            place = f"seam {seam['name']}: point {number}"
            apart = 0.0 if q is None else 1.0 - abs(float(q @ quaternion_from_rotation(nearest)))
            if not abs(apart) <= LOST_DIGITS:
                continue
            if off > ROTATION_ATOL:
                yield f"{place}: R", "the nearest rotation", frame, nearest
            elif abs(apart) > QUATERNION_ATOL:
                yield f"{place}: q_xyzw", "the quaternion of R", frame, R


def repair_file(path: Path, output: Path, faults: Sequence[Fault], *, overwrite: bool) -> list[str]:
    """Write a repaired copy of a file. Place and words of each repair.

    Raises `InputError` when nothing can be repaired, or the file to write exists.
    """
    if path.is_dir() or (output.exists() and output.resolve() == path.resolve()):
        raise InputError(f"{path}: expected one file, and another one to write")
    done = [f"{fault.place}: {fault.repair}" for fault in faults if fault.repair is not None]
    if not done:
        raise InputError(f"{path}: nothing here has one answer; a person must decide ({len(faults)} faults)")
    record = parse_json(read_bytes(path), path=str(path))
    write_file(output, to_json(repaired_seams(record)), overwrite=overwrite)
    return done
