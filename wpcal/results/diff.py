"""Compare the results of a calibration with results that were kept, in tests and with `wpcal diff`.

Positions are compared as distances in mm. Rotations are compared by how far they turn a point one metre away.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
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
    a, b = (np.asarray(record["T_base_part"], dtype=np.float64) for record in (found, golden))
    yield from _points("T_base_part origin", a[:3, 3], b[:3, 3], atol_mm)
    yield from _turned("T_base_part rotation", a[:3, :3], b[:3, :3], atol_mm)
    for name in COMPARED_NUMBERS:
        yield from _numbers(name, found[name], golden[name], atol_mm)
    yield from _words("", found, golden, COMPARED_WORDS)
    for where, mine, point in _pairs("point", found["points"], golden["points"]):
        if mine is None or point is None:
            yield _only_one(where, mine)
            continue
        for field in ("p_part_mm", "p_base_mm", "residual_mm"):
            yield from _points(f"{where} {field}", mine[field], point[field], atol_mm)


def compare_seams(found: Mapping[str, Any], golden: Mapping[str, Any], *, atol_mm: float) -> Iterator[Difference]:
    """Yield what differs between two records of ``seams.json``."""
    yield from _words("", found, golden, ("frame", "z_sense", "robot_space"))
    for where, mine, seam in _pairs("seam", found["seams"], golden["seams"]):
        if mine is None or seam is None:
            yield _only_one(where, mine)
        else:
            yield from _one_seam(where, mine, seam, atol_mm)


def _one_seam(where: str, found: Mapping[str, Any], golden: Mapping[str, Any], atol_mm: float) -> Iterator[Difference]:
    yield from _words(f"{where} ", found, golden, ("joint", "weld", "solids", "closed", "accepted", "reachable"))
    yield from _numbers(f"{where} length_mm", found["length_mm"], golden["length_mm"], atol_mm)
    if len(found["frames"]) != len(golden["frames"]):
        yield Difference(f"{where} frames", str(len(found["frames"])), str(len(golden["frames"])))
        return
    for number, (mine, frame) in enumerate(zip(found["frames"], golden["frames"], strict=True)):
        yield from _points(f"{where} frame {number} p_mm", mine["p_mm"], frame["p_mm"], atol_mm)
        yield from _turned(f"{where} frame {number} R", mine["R"], frame["R"], atol_mm)


Row = Mapping[str, Any]


def _pairs(kind: str, found: Iterable[Row], golden: Iterable[Row]) -> Iterator[tuple[str, Row | None, Row | None]]:
    """Yield rows of one name, or one without the other."""
    mine = {row["name"]: row for row in found}
    yield from ((f"{kind} {row['name']}", mine.pop(row["name"], None), row) for row in golden)
    yield from ((f"{kind} {name}", row, None) for name, row in mine.items())


def _only_one(where: str, found: Row | None) -> Difference:
    return Difference(where, *(("missing", "there") if found is None else ("there", "missing")))


def _words(where: str, found: Row, golden: Row, names: Iterable[str]) -> Iterator[Difference]:
    for name in names:
        if found.get(name) != golden.get(name):
            yield Difference(f"{where}{name}", str(found.get(name)), str(golden.get(name)))


def _numbers(where: str, found: float, golden: float, atol_mm: float) -> Iterator[Difference]:
    off = abs(found - golden)
    if not off <= atol_mm:  # NaN differs from everything
        yield Difference(where, f"{found:.6f}", f"{golden:.6f}", f"{off:.6f} mm")


def _turned(where: str, found: Any, golden: Any, atol_mm: float) -> Iterator[Difference]:
    turn = float(np.abs(np.subtract(found, golden)).max())
    if not turn * LEVER_MM <= atol_mm:
        yield Difference(where, "turned", "", f"{turn:.2e} rad")


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
