"""Lists of jobs for tests of batches, and what a batch wrote."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np

from tests.record_checks import check_record

FIXTURES = Path(__file__).parents[1] / "fixtures"
JOBS = 6
EVER_DIFFERENT = "seconds"
"""The only field of the summary that is not the same in the next run."""


def write_parts(folder: Path) -> None:
    """Write a part and points that were touched on it, each time with other errors."""
    shutil.copy(FIXTURES / "tee" / "tee.step", folder)
    rows = (FIXTURES / "tee" / "taught.csv").read_text().splitlines()
    at = rows[0].split(",").index("x_mm")
    for number in range(JOBS):
        rng, moved = np.random.default_rng(number), [rows[0]]
        for row in rows[1:]:
            cells = row.split(",")
            cells[at] = f"{float(cells[at]) + rng.normal(0, 0.1):.4f}"
            moved.append(",".join(cells))
        (folder / f"day{number}.csv").write_text("\n".join(moved) + "\n")
    lines = [f"j{k},tee.step,day{k}.csv,{'robust' if k == 1 else ''},{'x' if k == 2 else ''}" for k in range(JOBS)]
    (folder / "jobs.csv").write_text("\n".join(["job,part,taught,criterion,wrap", *lines]) + "\n")


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files of a folder, of the summary without what is ever different."""
    found = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    lines = [json.loads(line) for line in found.pop("summary.jsonl").splitlines()]
    for line in lines:
        check_record(line)
        line[EVER_DIFFERENT] = None
    found["summary"] = json.dumps(lines).encode()
    rows = [row.split(",") for row in found.pop("summary.csv").decode().splitlines()]
    at = rows[0].index(EVER_DIFFERENT)
    return {**found, "table": json.dumps([[*row[:at], *row[at + 1 :]] for row in rows]).encode()}
