"""Whether the files of one result folder come from one calibration, and are as it wrote them."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wpcal.brep.mesh_glb import read_part_glb
from wpcal.core.errors import FormatError, FrameError
from wpcal.core.input_file import MOST_STEP_MB, holds_file, read_bytes, sha256_of
from wpcal.core.records import read_json, to_json, write_file
from wpcal.core.result_files import (
    CALIBRATION_FILE,
    CALIBRATION_SCHEMA,
    JOB_FILE,
    JOB_SCHEMA,
    PAGE_FILE,
    PART_FILE,
    SEAMS_FILE,
    TABLE_FILE,
)
from wpcal.core.transform import RigidTransform
from wpcal.results.differences import walk_records
from wpcal.seam.record import seams_csv

SAME_POSE_MM = 1e-9
"""All files are written with all digits from one result: a larger difference of positions means two calibrations."""
SAME_POSE_RAD = 1e-9
"""The same for rotations: 1e-9 rad moves a point at one metre by 1e-6 mm, and round-off is a thousand times smaller."""


def agreed_pose(calibration: Mapping[str, Any], seams: Mapping[str, Any], *, path: Path) -> RigidTransform:
    """Return the ``T_base_part`` that both records state.

    Raises `FrameError` when the seams are not in `base`.
    Raises `InputError` when a pose is not a rigid motion.
    Raises `FormatError` when the poses differ by more than `SAME_POSE_MM` or `SAME_POSE_RAD`.
    """
    if seams["frame"] != "base" or seams["T_base_part"] is None:
        raise FrameError(f"{path}: expected seams in the frame 'base', got {seams['frame']!r}")
    of_seams, fitted = (
        RigidTransform.from_matrix(record["T_base_part"], target="base", source="part")
        for record in (seams, calibration)
    )
    if not of_seams.is_close(fitted, atol_mm=SAME_POSE_MM, atol_rad=SAME_POSE_RAD):
        raise FormatError("T_base_part differs from the one in calibration.json: two calibrations", path=str(path))
    return of_seams


def check_same_part(part_glb: bytes, calibration: Mapping[str, Any], *, path: Path) -> None:
    """Refuse a mesh of another part than the calibrated one.

    Raises `FormatError` when the file is not such a mesh, or was made from another STEP file.
    """
    expected = calibration.get("inputs", {}).get("part", {}).get("sha256")
    if read_part_glb(part_glb, path=str(path)).sha256 != expected:
        raise FormatError("was made from another STEP file than calibration.json", path=str(path))


@dataclass(frozen=True, slots=True)
class Changed:
    """A file of a result folder that is not as it was written."""

    name: str
    listed_in: str  #: The file with its SHA-256; of ``job.json``, which has none, the one that states the same.
    field: str  #: The first value that was changed; empty if no other file of the folder states it.

    def __str__(self) -> str:
        """Say it after the name of the file."""
        where = f", at {self.field}" if self.field else ""
        edited = ", with --seams for edited seams" * (self.name == SEAMS_FILE)
        by = "values" if self.name == JOB_FILE else "SHA-256"
        what = f"was changed after wpcal calibrate wrote it{where} ({by} in {self.listed_in})"
        return f"{what}; calibrate again{edited}"


def changed_files(folder: Path, names: Iterable[str] | None = None) -> Iterator[Changed]:
    """Yield the files that are not as the calibration of the folder wrote them; missing ones are not named.

    `names`: Those that are looked at; all if None.
    Raises `InputError` or `FormatError` when ``job.json``, or ``calibration.json`` without it, cannot be read.
    """
    source, hashes = _written(folder)
    for name in hashes if names is None else names:
        if name in hashes and holds_file(folder, name) and _sha256(folder / name) != hashes[name]:
            yield Changed(name, source, _changed_value(folder, name, hashes))
    if names is None and source == JOB_FILE and (value := _changed_value(folder, JOB_FILE, hashes)):
        yield Changed(JOB_FILE, CALIBRATION_FILE, value)


def require_as_written(path: Path, *, also: Iterable[str] = ()) -> str | None:
    """Refuse the records of a result folder, or one file of it, if they are not as the calibration wrote them.

    Returns what is to be said if nothing could be compared; None if all was, or this is no result folder.

    `also`: Further files of the folder that are read.
    Raises `FormatError` with file and field of the first change, or as `changed_files` does.
    """
    folder, names = (
        (path, (CALIBRATION_FILE, SEAMS_FILE, PART_FILE, *also)) if path.is_dir() else (path.parent, (path.name, *also))
    )
    for each in changed_files(folder, names):
        raise FormatError(str(each), path=str(folder / each.name))
    if holds_file(folder, JOB_FILE) or not holds_file(folder, CALIBRATION_FILE):
        return None
    return f"{folder} has no {JOB_FILE}: nothing says whether its records are as they were written"


def note_written(folder: Path, name: str) -> None:
    """Write the SHA-256 of a file that was made again from the others into ``job.json``, where there is one."""
    if holds_file(folder, JOB_FILE):
        record = read_json(folder / JOB_FILE, schema=JOB_SCHEMA)
        files = {**record["files"], name: _sha256(folder / name)}
        text = to_json({**record, "files": dict(sorted(files.items()))})
        write_file(folder / JOB_FILE, text, overwrite=True)


def _sha256(path: Path) -> str:
    return sha256_of(read_bytes(path, most_mb=MOST_STEP_MB))


def _written(folder: Path) -> tuple[str, Mapping[str, str]]:
    """Return the file of a folder that lists hashes, and them; scripts write no ``job.json``."""
    for name, schema in ((JOB_FILE, JOB_SCHEMA), (CALIBRATION_FILE, CALIBRATION_SCHEMA)):
        if holds_file(folder, name):
            return name, read_json(folder / name, schema=schema).get("files", {})
    return JOB_FILE, {}


def _changed_value(folder: Path, name: str, hashes: Mapping[str, str]) -> str:
    """Return the first value of a changed file that a file that is not changed states otherwise; empty without one."""
    try:
        mine = _stated(name, read_bytes(folder / name))
        for other in (TABLE_FILE, SEAMS_FILE, PAGE_FILE, CALIBRATION_FILE):
            data = read_bytes(folder / other) if other != name and holds_file(folder, other) else b""
            if data and sha256_of(data) == hashes.get(other):
                for each in walk_records(*_of_both(mine, _stated(other, data)), ""):
                    return f"{each.where.partition(' ')[2]} ({each.found}, was {each.expected})"
    except _UNREADABLE:
        pass  # it is not what it was: its own reader says why
    return ""


def twice_stated(folder: Path, name: str) -> tuple[Any, Any]:
    """Return what a table or page says, and what the records of its folder say of the same; empty for other files."""
    try:
        mine = _stated(name, read_bytes(folder / name))
        records: dict[str, Any] = {}
        for each in (CALIBRATION_FILE, SEAMS_FILE):
            records |= _stated(each, read_bytes(folder / each))
        return _of_both(mine, records)
    except _UNREADABLE:
        return "unreadable", "a table or a page"


_UNREADABLE = (ValueError, KeyError, TypeError, AttributeError, RecursionError)


def _of_both(mine: dict[str, Any], others: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    both = [key for key in others if key in mine]
    return {key: mine[key] for key in both}, {key: others[key] for key in both}


def _stated(name: str, data: bytes) -> dict[str, Any]:
    """Return what a file says that another one says, too."""
    if name == TABLE_FILE:
        return {"frames": _rows(data.decode())}
    if name == PAGE_FILE:
        page = json.loads(data.decode().partition('id="data">')[2].partition("</script>")[0])
        return {"calibration": page["calibration"], "seams": page["seams"]}
    if name not in (CALIBRATION_FILE, SEAMS_FILE, JOB_FILE):
        return {}
    record: dict[str, Any] = json.loads(data)
    if name == JOB_FILE:
        return {**record["result"], "pose": record["result"]["pose"]["xyz_mm"]}
    pose = {"T_base_part": record.get("T_base_part")}
    if name == CALIBRATION_FILE:
        worst = max(record["points"], key=lambda point: point["distance_mm"])
        own = {
            "worst_residual_mm": worst["distance_mm"],
            "worst_point": worst["name"],
            "bound_mm": record["lower_bound_mm"],
        }
        own |= {"verdict": record["verdict"], "objective_mm": record["objective_mm"]}
        return {"calibration": record, "placed": pose, **own, "pose": [row[3] for row in record["T_base_part"][:3]]}
    heads = [{key: value for key, value in seam.items() if key != "frames"} for seam in record["seams"]]
    return {"frames": _rows(seams_csv(record)), "seams": heads, "placed": pose}


def _rows(table: str) -> dict[str, dict[str, str]]:
    rows = csv.DictReader(io.StringIO(table))
    return {f"seam {row['seam']}: point {row['point']}:": row for row in rows}
