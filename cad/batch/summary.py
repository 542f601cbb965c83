"""``summary.jsonl`` and ``summary.csv``: one line for every job.

While a batch runs, lines are added in the order in which jobs end. At the end the file is written anew in the order of
the list. Lines are kept on the disk and not in memory.
"""

from __future__ import annotations

import json
import math
import os
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from io import FileIO
from pathlib import Path
from typing import Any

from cad.batch.job_list import Job
from wpcal.core.csv_text import csv_text
from wpcal.core.errors import InputError
from wpcal.core.result_files import SUMMARY_FILE, SUMMARY_SCHEMA, SUMMARY_TABLE
from wpcal.core.whole_folder import flush

FAILED = "ERROR"  #: In place of a verdict: the job did not end with one.
NUMBERS = (
    "worst_residual_mm", "worst_point", "objective_mm", "bound_mm", "worst_seam_error_mm", "worst_seam",
)  # fmt: skip
PLACE = {
    "x_mm": ("xyz_mm", 0), "y_mm": ("xyz_mm", 1), "z_mm": ("xyz_mm", 2),
    "a_deg": ("rpy_deg", 0), "b_deg": ("rpy_deg", 1), "c_deg": ("rpy_deg", 2),
}  # fmt: skip
"""By the name of a column: where the pose of a line has it. R = Rz(c) Ry(b) Rx(a), as for ``--nominal``."""
CSV_COLUMNS = ("job", "verdict", *NUMBERS, *PLACE, "seconds", "error", "part", "taught", "when")


def summary_line(job: Job, result: Mapping[str, Any] | None, *, seconds: float | None, error: str = "") -> str:
    """Return the line of a job."""
    result = result or {}
    line = {
        "schema": SUMMARY_SCHEMA,
        "job": job.name,
        "line": job.line,
        "part": job.part,
        "taught": job.taught,
        "when": job.when or None,
        "verdict": result.get("verdict", FAILED),
        **{name: result.get(name) for name in NUMBERS},
        "pose": result.get("pose"),
        "seconds": None if seconds is None else round(seconds, 3),
        "error": " ".join(error.split()) or None,
    }
    return json.dumps(line, ensure_ascii=False, allow_nan=False)


def csv_row(line: Mapping[str, Any]) -> list[object]:
    """Return a line as a row of ``summary.csv``."""
    pose = line["pose"] or {"xyz_mm": (None,) * 3, "rpy_deg": (None,) * 3}
    return [pose[PLACE[name][0]][PLACE[name][1]] if name in PLACE else line[name] for name in CSV_COLUMNS]


class Summary:
    """The summary of a batch that runs."""

    def __init__(self, out: Path, work: Path) -> None:
        self._out, self._work = out, work
        self._numbers, self._places = array("q"), array("q")  # of a million jobs: 16 MB
        self._size = 0
        self._file: FileIO | None = None
        self.verdicts: Counter[str] = Counter()

    def add(self, number: int, verdict: str, line: str) -> None:
        """Add the line of a job. Raises `InputError` when it cannot be written."""
        data = line.encode() + b"\n"
        with self._written(SUMMARY_FILE):
            if self._file is None:
                self._file = (self._out / SUMMARY_FILE).open("w+b", buffering=0)
            self._append(self._file, data)
        self._numbers.append(number)
        self._places.append(self._size)
        self._size += len(data)
        self.verdicts[verdict] += 1

    def _append(self, file: FileIO, data: bytes) -> None:
        """Write a line, or nothing of it."""
        try:
            rest = memoryview(data)
            while rest:  # a disk that is nearly full takes a part
                rest = rest[file.write(rest) :]
        except OSError:
            with suppress(OSError):
                file.truncate(self._size)
            raise

    def lines(self) -> Iterator[bytes]:
        """Yield the lines in the order of the list."""
        ends = [*self._places[1:], self._size]
        for row in sorted(range(len(self._numbers)), key=self._numbers.__getitem__):
            if self._file is not None:
                self._file.seek(self._places[row])
                yield self._file.read(ends[row] - self._places[row])

    def finish(self) -> None:
        """Write both files in the order of the list. Raises `InputError` when they cannot be written."""
        if self._file is None:
            return
        text = b"".join(self.lines())
        self._file.close()
        self._file = None
        rows = (csv_row(json.loads(line)) for line in text.splitlines())
        self._replace(SUMMARY_TABLE, csv_text([CSV_COLUMNS, *rows]).encode())
        self._replace(SUMMARY_FILE, text)

    def _replace(self, name: str, data: bytes) -> None:
        """Write a file among the unfinished work, which is removed even if this process is killed, and rename it."""
        with self._written(name):
            self._work.mkdir(exist_ok=True)
            new = self._work / name
            new.write_bytes(data)
            flush(new)
            os.replace(new, self._out / name)

    @contextmanager
    def _written(self, name: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            what = (error.strerror or str(error)).lower()
            raise InputError(f"{self._out / name}: cannot be written: {what}") from error


def seconds_of(out: Path) -> dict[str, float]:
    """Return how long jobs took, by name, from the summary of an earlier run; what cannot be read is left out."""
    found = {}
    try:
        lines = (out / SUMMARY_FILE).read_bytes().splitlines()
    except OSError:
        return {}
    for text in lines:
        try:
            line = json.loads(text)
            name, seconds = str(line["job"]), float(line["seconds"])
        except (ValueError, KeyError, TypeError, OverflowError, RecursionError):
            continue
        if 0 <= seconds < math.inf:
            found[name] = seconds
    return found
