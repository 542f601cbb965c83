"""Compare the results of a calibration with results that were kept, in tests and with `wpcal diff`.

Positions are compared as distances in mm. Rotations are compared by how far they turn a point one metre away.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.errors import FormatError, InputError
from wpcal.core.result_files import CALIBRATION_FILE, SEAMS_FILE
from wpcal.results.differences import Difference
from wpcal.results.folder import RECORD_SCHEMAS, read_record

LEVER_MM = 1000.0  #: A rotation is measured by the arc at this distance: the size of a large welded part.
EQUAL_MM = 0.01  #: Distances up to this count as equal: a tenth of the repeatability of a robot.
COMPARED_NUMBERS = ("objective_mm", "lower_bound_mm", "rms_mm")
COMPARED_WORDS = ("verdict", "criterion", "certified", "robot_space")


def compare_folders(found: Path, golden: Path, *, atol_mm: float = EQUAL_MM) -> list[Difference]:
    """Compare the records that the golden folder holds; it may hold only one of the two.

    `atol_mm`: Largest distance that does not count as a difference, mm.
    Raises `InputError` when the golden folder holds neither record, a record cannot be read or lacks a field, or
    `atol_mm` is negative.
    """
    if not 0 <= atol_mm < np.inf:
        raise InputError(f"atol_mm is a length that is not negative, got {atol_mm}")
    names = [name for name in RECORD_SCHEMAS if (golden / name).is_file()]
    if not names:
        raise InputError(f"{golden}: holds neither {' nor '.join(RECORD_SCHEMAS)}")
    return [difference for name in names for difference in _compare_records(found, golden, name, atol_mm)]


def _compare_records(found: Path, golden: Path, name: str, atol_mm: float) -> list[Difference]:
    compare = {CALIBRATION_FILE: compare_calibrations, SEAMS_FILE: compare_seams}[name]
    mine, kept = read_record(found, name), read_record(golden, name)
    try:
        return list(compare(mine, kept, atol_mm=atol_mm))
    except (KeyError, TypeError, ValueError) as error:
        what = f"this file or {found / name} is not a complete record: {type(error).__name__} {error}"
        raise FormatError(what, path=str(golden / name)) from None


def compare_calibrations(
    found: Mapping[str, Any], golden: Mapping[str, Any], *, atol_mm: float
) -> Iterator[Difference]:
    """Yield what differs between two records of ``calibration.json``."""
    yield from _poses("T_base_part", found["T_base_part"], golden["T_base_part"], atol_mm)
    for name in COMPARED_NUMBERS:
        off = abs(found[name] - golden[name])
        if not off <= atol_mm:  # NaN differs from everything
            yield Difference(name, f"{found[name]:.6f}", f"{golden[name]:.6f}", f"{off:.6f} mm")
    for name in COMPARED_WORDS:
        if found.get(name) != golden.get(name):
            yield Difference(name, str(found.get(name)), str(golden.get(name)))
    points = {point["name"]: point for point in found["points"]}
    for point in golden["points"]:
        mine = points.pop(point["name"], None)
        if mine is None:
            yield Difference(f"point {point['name']}", "missing", "there")
            continue
        for field in ("p_part_mm", "p_base_mm", "residual_mm"):
            yield from _points(f"point {point['name']} {field}", mine[field], point[field], atol_mm)
    for name in points:
        yield Difference(f"point {name}", "there", "missing")


def compare_seams(found: Mapping[str, Any], golden: Mapping[str, Any], *, atol_mm: float) -> Iterator[Difference]:
    """Yield what differs between two records of ``seams.json``."""
    for name in ("frame", "z_sense", "robot_space"):
        if found[name] != golden[name]:
            yield Difference(name, str(found[name]), str(golden[name]))
    mine = {seam["name"]: seam for seam in found["seams"]}
    for seam in golden["seams"]:
        other = mine.pop(seam["name"], None)
        if other is None:
            yield Difference(f"seam {seam['name']}", "missing", "there")
        else:
            yield from _one_seam(other, seam, atol_mm)
    for name in mine:
        yield Difference(f"seam {name}", "there", "missing")


def _one_seam(found: Mapping[str, Any], golden: Mapping[str, Any], atol_mm: float) -> Iterator[Difference]:
    where = f"seam {golden['name']}"
    for name in ("joint", "weld", "solids", "closed", "accepted", "reachable"):
        if found[name] != golden[name]:
            yield Difference(f"{where} {name}", str(found[name]), str(golden[name]))
    off = abs(found["length_mm"] - golden["length_mm"])
    if not off <= atol_mm:
        yield Difference(
            f"{where} length_mm", f"{found['length_mm']:.6f}", f"{golden['length_mm']:.6f}", f"{off:.6f} mm"
        )
    if len(found["frames"]) != len(golden["frames"]):
        yield Difference(f"{where} frames", str(len(found["frames"])), str(len(golden["frames"])))
        return
    for number, (mine, frame) in enumerate(zip(found["frames"], golden["frames"], strict=True)):
        yield from _points(f"{where} frame {number} p_mm", mine["p_mm"], frame["p_mm"], atol_mm)
        turn = float(np.abs(np.subtract(mine["R"], frame["R"])).max())
        if not turn * LEVER_MM <= atol_mm:
            yield Difference(f"{where} frame {number} R", "turned", "", f"{turn:.2e} rad")


def _poses(where: str, found: Any, golden: Any, atol_mm: float) -> Iterator[Difference]:
    a, b = np.asarray(found, dtype=np.float64), np.asarray(golden, dtype=np.float64)
    yield from _points(f"{where} origin", a[:3, 3], b[:3, 3], atol_mm)
    turn = float(np.abs(a[:3, :3] - b[:3, :3]).max())
    if not turn * LEVER_MM <= atol_mm:
        yield Difference(f"{where} rotation", "turned", "", f"{turn:.2e} rad")


def _points(where: str, found: Any, golden: Any, atol_mm: float) -> Iterator[Difference]:
    a, b = np.asarray(found, dtype=np.float64), np.asarray(golden, dtype=np.float64)
    off = float(np.linalg.norm(a - b))
    if not off <= atol_mm:
        yield Difference(where, _shown(a), _shown(b), f"{off:.6f} mm")


def _shown(point: Any) -> str:
    return ", ".join(f"{v:.4f}" for v in point)


def assert_calibration_close(found: Mapping[str, Any], golden: Mapping[str, Any], *, atol_mm: float) -> None:
    """Fail with a list of differences when two records of ``calibration.json`` differ by more than `atol_mm`."""
    _assert_none(compare_calibrations(found, golden, atol_mm=atol_mm))


def assert_seams_close(found: Mapping[str, Any], golden: Mapping[str, Any], *, atol_mm: float) -> None:
    """Fail with a list of differences when two records of ``seams.json`` differ by more than `atol_mm`."""
    _assert_none(compare_seams(found, golden, atol_mm=atol_mm))


def _assert_none(differences: Iterator[Difference]) -> None:
    lines = [f"{d.where}: found {d.found}, expected {d.expected} {d.off_by}" for d in differences]
    if lines:
        raise AssertionError("\n".join(lines))
