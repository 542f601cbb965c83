"""The jobs of folders of ``wpcal batch``, part by part, as arrays."""

from __future__ import annotations

import json
import math
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes, require_folder
from wpcal.core.record_check import check_record
from wpcal.core.records import parse_json
from wpcal.core.result_files import CALIBRATION_FILE, CALIBRATION_SCHEMA, SUMMARY_FILE, SUMMARY_SCHEMA

USED = ("schema", "inputs", "T_base_part", "points", "suspect", "touches")  #: Fields of a calibration that are read.
NEEDED = USED[:-2]
UNKNOWN = [math.nan] * 3
MOST_CALIBRATION_MB = 16.0
MOST = 0.8  #: Points in this share of the jobs are the usual ones: a few jobs on others must not hide how these change.
_DECODER = json.JSONDecoder()
SUMMARY_FIELDS = ("job", "when", "verdict", "worst_seam_error_mm")
READ_OF_SUMMARY = frozenset({"schema", *SUMMARY_FIELDS, "error"})
READ_OF_POINT = ("name", "p_part_mm", "residual_mm", "rx_ry_rz_deg")


@dataclass(frozen=True, slots=True)
class PartJobs:
    """The n jobs of one part in the order of their times, and the p points that are in all of them."""

    #: `file`, `sha256`: Name of the STEP file, and its contents.
    file: str
    sha256: str
    #: `names`, `when`: Of the jobs; `when` is empty without a time.
    names: tuple[str, ...]
    when: tuple[str, ...]
    by_time: bool  #: Whether every job has a time. Otherwise the order is that of the folders and their lists.
    T_base_part: FloatArray
    points: tuple[str, ...]
    residuals: FloatArray  #: Touched point minus moved model point in `base`, mm.
    places: FloatArray  #: Model points in `part`, mm: the median over the jobs.
    seam_error_mm: FloatArray  #: Largest 95 % error of a seam; NaN without one.
    suspected: FloatArray  #: In how many jobs the calibration names the point as wrong.
    left_out: tuple[str, ...] = ()  #: Points that are not in all jobs.
    on_others: tuple[str, ...] = ()  #: Jobs that are left out, because they lack points that most jobs have.
    #: shape (n, p, 3). Angles (z, y, x) of the tool at each point in `base`, rad; NaN where they are not known, and in
    #: jobs with touches on faces.
    angles: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class FailedJob:
    """A job without a calibration, and why."""

    job: str
    out: str
    error: str


@dataclass(frozen=True, slots=True)
class _Job:
    name: str
    when: str
    seam_error_mm: float
    part: tuple[str, str]
    T_base_part: Any
    points: dict[str, list[Any]]
    suspected: tuple[str, ...]


def read_drift_jobs(
    folders: Sequence[Path], *, advance: Callable[[int], None] = lambda _: None
) -> tuple[list[PartJobs], list[FailedJob]]:
    """Read folders of ``wpcal batch``. The parts by their names.

    Raises `InputError` when a folder is not one of ``wpcal batch``, or a record in it is damaged.
    """
    found: dict[tuple[str, str], list[_Job]] = {}
    failed: list[FailedJob] = []
    _require_folders(folders)
    count = 0
    for folder in folders:
        for line in _summary(folder):
            if line["verdict"] == "ERROR":
                failed.append(FailedJob(line["job"], str(folder), line.get("error") or "no reason is recorded"))
                continue
            try:
                job = _read_job(folder, line)
            except InputError:
                if (folder / line["job"] / CALIBRATION_FILE).exists():
                    raise
                failed.append(FailedJob(line["job"], str(folder), f"its {CALIBRATION_FILE} is not there any more"))
                continue
            found.setdefault(job.part, []).append(job)
            count += 1
            advance(count)
    return [_arrays(part, jobs) for part, jobs in sorted(found.items())], failed


def _require_folders(folders: Sequence[Path]) -> None:
    seen: set[Path] = set()
    for folder in folders:
        require_folder(folder, "the results of wpcal batch")
        if not (folder / SUMMARY_FILE).is_file():
            raise InputError(f"{folder}: is not a folder of wpcal batch: it has no {SUMMARY_FILE}")
        if folder.resolve() in seen:
            raise InputError(f"{folder}: is given twice")
        seen.add(folder.resolve())


def _summary(folder: Path) -> list[dict[str, Any]]:
    path, lines = folder / SUMMARY_FILE, list[dict[str, Any]]()
    for number, text in enumerate(read_bytes(path).splitlines(), start=1):
        where = f"{path}: line {number}"
        line = parse_json(text, path=where)
        if not isinstance(line, dict) or line.get("schema") != SUMMARY_SCHEMA:
            raise FormatError(f"{where}: is not a line of wpcal batch: expected the schema {SUMMARY_SCHEMA}")
        line = {name: value for name, value in line.items() if name in READ_OF_SUMMARY}
        check_record(line, SUMMARY_SCHEMA, path=where)
        missing = [name for name in SUMMARY_FIELDS if name not in line]
        if missing:
            raise FormatError(f"{where}: has no {missing[0]}")
        is_folder = line["job"] not in ("", "..") and Path(line["job"]).name == line["job"]
        if line["verdict"] != "ERROR" and not is_folder:
            raise FormatError(f"{where}: job: expected the name of a folder, got {json.dumps(line['job'])}")
        lines.append(line)
    return lines


def _read_job(folder: Path, line: dict[str, Any]) -> _Job:
    path = folder / line["job"] / CALIBRATION_FILE
    record = _used_fields(read_bytes(path, most_mb=MOST_CALIBRATION_MB), str(path))
    if record.get("schema") != CALIBRATION_SCHEMA:
        raise FormatError(f"{path}: is not a calibration: expected the schema {CALIBRATION_SCHEMA}")
    with suppress(KeyError, TypeError):  # the whole is checked then: it says what is wrong
        record["points"] = [{name: each[name] for name in READ_OF_POINT if name in each} for each in record["points"]]
    check_record(record, CALIBRATION_SCHEMA, path=str(path))
    try:
        part = record["inputs"]["part"]
        return _Job(
            name=line["job"],
            when=line["when"] or "",
            seam_error_mm=np.nan if line["worst_seam_error_mm"] is None else line["worst_seam_error_mm"],
            part=(part["file"], part["sha256"] or ""),
            T_base_part=record["T_base_part"],
            points={each["name"]: _numbers(each, "touches" in record) for each in record["points"]},
            suspected=tuple(map(sys.intern, (record.get("suspect") or {"names": ()})["names"])),
        )
    except KeyError as missing:
        raise FormatError(f"{path}: has no {missing.args[0]}") from None


def _numbers(point: dict[str, Any], has_faces: bool) -> list[list[float]]:
    angles = UNKNOWN if has_faces else point.get("rx_ry_rz_deg", UNKNOWN)
    return [point["p_part_mm"], point["residual_mm"], angles]


def _used_fields(raw: bytes, path: str) -> dict[str, Any]:
    """Return the fields of a calibration that are needed: a third of the time for the whole.

    wpcal writes each field of a record on a line of its own, after one blank, and no text in JSON holds the end of a
    line. A file that looks otherwise is read as a whole.
    """
    found = {}
    try:
        text = raw.decode()
        for name in USED:
            head = f'\n "{name}": '
            at = text.find(head)
            if at >= 0:
                found[name], _ = _DECODER.raw_decode(text, at + len(head))
    except (ValueError, RecursionError):  # the whole file tells where
        found = {}
    if raw.endswith(b"}\n") and all(name in found for name in NEEDED):
        return found
    whole = parse_json(raw, path=path)
    return {name: whole[name] for name in USED if name in whole} if isinstance(whole, dict) else {}


def _arrays(part: tuple[str, str], jobs: list[_Job]) -> PartJobs:
    times = [_time(job.when) for job in jobs]
    by_time = all(time is not None for time in times) and len({time.tzinfo is None for time in times if time}) == 1
    if by_time:
        order = sorted(range(len(jobs)), key=lambda row: times[row])  # type: ignore[arg-type,return-value]
        jobs = [jobs[row] for row in order]
    jobs, on_others = _on_usual_points(jobs)
    common = set(jobs[0].points).intersection(*(job.points for job in jobs))
    points = tuple(name for name in jobs[0].points if name in common)
    others = dict.fromkeys(name for job in jobs for name in job.points if name not in common)
    both = np.array([[job.points[name] for name in points] for job in jobs], dtype=float)
    both = both.reshape(len(jobs), len(points), 3, 3)
    suspects = [name for job in jobs for name in job.suspected]
    return PartJobs(
        file=part[0],
        sha256=part[1],
        names=tuple(job.name for job in jobs),
        when=tuple(job.when for job in jobs),
        by_time=by_time,
        T_base_part=np.array([job.T_base_part for job in jobs], dtype=float),
        points=points,
        residuals=both[:, :, 1],
        places=np.median(both[:, :, 0], axis=0),
        seam_error_mm=np.array([job.seam_error_mm for job in jobs], dtype=float),
        suspected=np.array([suspects.count(name) for name in points], dtype=float),
        left_out=tuple(others),
        on_others=on_others,
        angles=np.deg2rad(both[:, :, 2, ::-1]),
    )


def _on_usual_points(jobs: list[_Job]) -> tuple[list[_Job], tuple[str, ...]]:
    """Return the jobs on the points of most jobs, and the names of the others; all jobs if there is no majority."""
    counts = Counter(name for job in jobs for name in job.points)
    usual = {name for name, count in counts.items() if count >= MOST * len(jobs)}
    kept = [job for job in jobs if usual <= job.points.keys()]
    if not usual or len(kept) < MOST * len(jobs):
        return jobs, ()
    return kept, tuple(job.name for job in jobs if not usual <= job.points.keys())


def _time(text: str) -> datetime | None:
    try:
        return datetime.fromisoformat(text.strip())
    except ValueError:
        return None
