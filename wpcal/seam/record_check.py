"""Refuse a `seams.json` whose numbers are not poses: a robot would drive to whatever they happen to mean.

The file is edited by people and by other programs. Every number and every yes or no is therefore checked when the file
is read, and the message names the file, the seam, the point and the field.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.seam.options import MOST_LEAN_DEG

FARTHEST_MM = 1e5
"""100 m: no welding robot reaches a tenth of it, track included, and metres or micrometres taken for mm show up."""
ROTATION_ATOL = 1e-6
"""wpcal writes all digits (1e-15); numbers with seven digits still pass. 1e-6 moves a tip at 2 m by 0.002 mm."""
QUATERNION_ATOL = 1e-6  #: A quaternion that differs by more from its matrix shows that only one of the two was edited.
LONGEST_MM = 1e6  #: Largest length of a seam: a seam of 1 km is a mistake.
FLAGS = ("closed", "accepted", "reachable")


def check_seams(record: Mapping[str, Any], *, path: str) -> None:
    """Refuse a record of seams in which a value is not what its field says.

    Raises `FormatError` with the seam, the point (counted from 0, as in ``seams.csv``) and the field.
    """
    for place, problem in seam_faults(record):
        raise FormatError(f"{place}: {problem}", path=path)


def seam_faults(record: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the place (``seam W1: point 3: R``) of every value that is not what its field says, and what is wrong."""
    seams = record["seams"]
    if not isinstance(seams, Sequence) or isinstance(seams, str):
        yield "seams", "expected a list"
        return
    named: set[str] = set()
    for number, seam in enumerate(seams):
        if not isinstance(seam, Mapping) or not isinstance(seam.get("name"), str) or not seam["name"]:
            yield f"seam number {number}: name", "expected a text"
            continue
        for problem in _problems(seam):
            *place, what = problem.split(": ", 2 if problem.startswith("point ") else 1)
            yield ": ".join((f"seam {seam['name']}", *place)), what
        if seam["name"] in named:
            yield f"seam {seam['name']}: name", f"two seams are named {seam['name']}; expected a name per seam"
        named.add(seam["name"])


def _problems(seam: Mapping[str, Any]) -> Iterator[str]:
    """Yield what is wrong with a seam, the first problem first."""
    for flag in FLAGS:
        if not isinstance(seam[flag], bool):
            yield f"{flag}: expected true or false, got {seam[flag]!r}"
    yield from _number(seam["length_mm"], "length_mm", low=0.0, high=LONGEST_MM)
    if "confidence" in seam:
        yield from _number(seam["confidence"], "confidence", low=0.0, high=1.0)
    for field, value in seam["gap_mm"].items():
        yield from _number(value, f"gap_mm {field}", low=-FARTHEST_MM, high=FARTHEST_MM)
    frames, before = seam["frames"], -np.inf
    R = _numbers([frame["R"] for frame in frames], (len(frames), 3, 3))
    quaternions = [None] * len(frames) if R is None else quaternion_from_rotation(R)  # one by one they take long
    for number, (frame, quaternion) in enumerate(zip(frames, quaternions, strict=True)):
        for problem in _frame_problems(frame, before, quaternion):
            yield f"point {number}: {problem}"
        before = float(frame["s_mm"])


def _frame_problems(frame: Mapping[str, Any], before_mm: float, quaternion: FloatArray | None) -> Iterator[str]:
    yield from _number(frame["s_mm"], "s_mm", low=0.0, high=LONGEST_MM)
    if not frame["s_mm"] > before_mm:
        yield f"s_mm: expected more than {before_mm:g}, that of the point before, got {frame['s_mm']:g}"
    p = _numbers(frame["p_mm"], (3,))
    if p is None or not np.abs(p).max() < FARTHEST_MM:
        yield f"p_mm: expected three numbers between -{FARTHEST_MM:g} and {FARTHEST_MM:g} mm, got {frame['p_mm']}"
    R = _numbers(frame["R"], (3, 3))
    if R is None:
        yield f"R: expected three rows of three numbers, got {frame['R']}"
    else:
        yield from _rotation_problems(R)
    yield from _number(frame["angle_deg"], "angle_deg", low=0.0, high=360.0)
    if frame.get("u95_mm") is not None:
        yield from _number(frame["u95_mm"], "u95_mm", low=0.0, high=FARTHEST_MM)
    if frame.get("lean_deg") is not None:
        for field in ("work", "travel"):
            yield from _number(frame["lean_deg"][field], f"lean_deg {field}", low=-MOST_LEAN_DEG, high=MOST_LEAN_DEG)
        yield from _number(frame["lean_deg"].get("spin", 0.0), "lean_deg spin", low=-180.0, high=180.0)
    if R is not None and "q_xyzw" in frame:
        q = _numbers(frame["q_xyzw"], (4,))
        right = quaternion_from_rotation(R) if quaternion is None else quaternion
        if q is None or 1.0 - abs(float(q @ right)) > QUATERNION_ATOL:
            yield f"q_xyzw: expected the quaternion of R, got {frame['q_xyzw']}; edit both"


def _rotation_problems(R: FloatArray) -> Iterator[str]:
    off = np.abs(R.T @ R - np.eye(3)).max()
    if not off <= ROTATION_ATOL:
        yield (
            f"R: is not a rotation: its columns must be unit vectors at right angles to each other, within "
            f"{ROTATION_ATOL:g}; they are off by {off:.3g}"
        )
    elif np.linalg.det(R) < 0.0:
        yield "R: is a mirror image, not a rotation (determinant -1): one axis has the wrong sign"


def _number(value: object, field: str, *, low: float, high: float) -> Iterator[str]:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        yield f"{field}: expected a number from {low:g} to {high:g}, got {value!r}"


def _numbers(value: object, shape: tuple[int, ...]) -> FloatArray | None:
    """Return an array of finite numbers, or None for anything else."""
    try:
        array = np.array(value)
    except ValueError:
        return None
    if array.shape != shape or array.dtype.kind not in "fi" or not np.isfinite(array).all():
        return None
    return array.astype(np.float64)
