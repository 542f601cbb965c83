"""What a job of `wpcal batch` costs beside a run of `wpcal calibrate` on the same part, both with a cache of their own.

`WPCAL_BENCH_JOBS` sets the number of jobs.
"""

import os
import tempfile
from pathlib import Path

import numpy as np
from rich.table import Table

from cad.session.part import read_pick_part
from cad.step.new_file import new_step_text
from cad.workpiece.answer_cache import FOLDER_VARIABLE
from cad.workpiece.seams import SeamChoice
from tests.benchmarks.bench_pick import NOISE_MM, touched
from tests.benchmarks.timing import run_python
from tests.samples.steel_structure import steel_structure
from wpcal.core.pairs import PointPairs
from wpcal.seam import SeamOptions

JOBS = int(os.environ.get("WPCAL_BENCH_JOBS", "1000"))
SINGLE_RUNS = 8


def write_jobs(folder: Path, pairs: PointPairs, count: int) -> Path:
    """Write the taught points of every job, each with errors of its own, and their list."""
    rng = np.random.default_rng(1)
    rows = ["job,part,taught"]
    for job in range(count):
        p_base = np.round(pairs.p_target + rng.normal(0.0, NOISE_MM, pairs.p_target.shape), 2)
        lines = [f"{name},{x},{y},{z},{name}" for name, (x, y, z) in zip(pairs.names, p_base.tolist(), strict=True)]
        (folder / f"t{job}.csv").write_text("\n".join(["name,x_mm,y_mm,z_mm,feature", *lines]), encoding="utf-8")
        rows.append(f"j{job},part.step,t{job}.csv")
    (folder / "jobs.csv").write_text("\n".join(rows), encoding="utf-8")
    return folder / "jobs.csv"


def run(*arguments: object, environment: dict[str, str]) -> tuple[float, float]:
    """Run a command; return the time by the clock and the processor time, s. A job may end with UNSURE."""
    use = run_python("-m", "wpcal", *arguments, ends=(0, 1), environment=environment)
    return use.wall_s, use.processor_s


def main() -> Table:
    """Measure and return the table."""
    table = Table(title=f"wpcal batch -j 2, {JOBS} jobs, beside {SINGLE_RUNS} runs of wpcal calibrate")
    for heading in ("", "by the clock s", "processor s", "s per job", "processor s per job"):
        table.add_column(heading, justify="right")
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        cache = {FOLDER_VARIABLE: str(folder / "cache")}
        (folder / "part.step").write_bytes(new_step_text(steel_structure(1), "structure", pcurves=False))
        pairs, _ = touched(read_pick_part(folder / "part.step", options=SeamOptions(), choice=SeamChoice()))
        jobs = write_jobs(folder, pairs, JOBS)
        several = {}
        for pages, name in (("none", "batch, no page"), ("all", "batch, all pages")):
            out = folder / f"out-{pages}"
            several[name] = run("batch", jobs, "-o", out, "-j", "2", "--report", pages, environment=cache)
            done = sum(1 for _ in out.glob("*/calibration.json"))
            if done != JOBS:
                raise RuntimeError(f"{done} of {JOBS} jobs ended")
        files = [(folder / f"t{i}.csv", folder / f"o{i}") for i in range(SINGLE_RUNS)]
        singles = [run("calibrate", folder / "part.step", own, "-o", out, environment=cache) for own, out in files]
        several["calibrate"] = np.sum(singles, axis=0)
        for name, (clock_s, processor_s) in several.items():
            count = SINGLE_RUNS if name == "calibrate" else JOBS
            each = (clock_s, processor_s, clock_s / count, processor_s / count)
            table.add_row(name, *(f"{value:.3f}" for value in each))
    return table
