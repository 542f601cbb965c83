"""What a job of `wpcal batch --dask` costs beside `wpcal batch -j 2`: a scheduler and two workers on this machine.

`WPCAL_BENCH_JOBS` sets the number of jobs. Both ways run in turn, `WPCAL_BENCH_ROUNDS` times, and the quickest run of
each counts. The first run with Dask also starts the processes for jobs in both workers and is shown apart.
"""

import os
import tempfile
from pathlib import Path

import psutil
from rich.table import Table

from cad.session.part import read_pick_part
from cad.step.new_file import new_step_text
from cad.workpiece.answer_cache import FOLDER_VARIABLE
from cad.workpiece.seams import SeamChoice
from tests.benchmarks.bench_batch import JOBS, run, write_jobs
from tests.benchmarks.bench_pick import touched
from tests.cad.dask_processes import DaskProcesses, dask_processes
from tests.samples.steel_structure import steel_structure
from wpcal.seam import SeamOptions

ROUNDS = int(os.environ.get("WPCAL_BENCH_ROUNDS", "3"))


def processor_s(processes: DaskProcesses, home: Path) -> float:
    """Return the processor time of the scheduler, the workers, their servers and all that these ran, s."""
    ours = [psutil.Process(each.pid) for each in (processes.scheduler, *processes.workers)]
    for each in psutil.process_iter(["cmdline"]):
        line = " ".join(each.info["cmdline"] or ())
        if str(home) in line and "cad.work.server" in line:
            ours.append(each)
    return float(sum(sum(each.cpu_times()[:4]) for each in ours))


def main() -> Table:
    """Measure and return the table."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        cache = {FOLDER_VARIABLE: str(folder / "cache")}
        os.environ.update(cache)  # of the workers
        (folder / "part.step").write_bytes(new_step_text(steel_structure(1), "structure", pcurves=False))
        pairs, _ = touched(read_pick_part(folder / "part.step", options=SeamOptions(), choice=SeamChoice()))
        jobs = write_jobs(folder, pairs, JOBS)
        here, there = [], []
        with dask_processes(folder / "dask") as processes:
            for _ in range(2):
                processes.add_worker()
            for number in range(ROUNDS + 1):
                here.append(run("batch", jobs, "-o", folder / f"here{number}", "-j", "2", environment=cache))
                before = processor_s(processes, folder)
                out, to = folder / f"there{number}", processes.address
                clock_s, used_s = run("batch", jobs, "-o", out, "--dask", to, environment=cache)
                there.append((clock_s, used_s + processor_s(processes, folder) - before))
                done = sum(1 for _ in folder.glob(f"*here{number}/*/calibration.json"))
                if done != 2 * JOBS:
                    raise RuntimeError(f"{done} of {2 * JOBS} jobs ended")
    return _table(JOBS, here, there)


def _table(count: int, here: list[tuple[float, float]], there: list[tuple[float, float]]) -> Table:
    table = Table(title=f"wpcal batch, {count} jobs: -j 2, and --dask with two workers of one thread")
    for heading in ("", "clock s", "processor s", "ms/job", "processor ms/job", "ratio", "of processor"):
        table.add_column(heading, justify="right")
    least = tuple(min(values) for values in zip(*here, strict=True))
    rows = {
        "-j 2": least,
        "--dask, first run": there[0],
        "--dask": tuple(min(values) for values in zip(*there[1:], strict=True)),
    }
    for name, (clock_s, used_s) in rows.items():
        each = (clock_s, used_s, 1e3 * clock_s / count, 1e3 * used_s / count)
        ratios = (clock_s / least[0], used_s / least[1])
        table.add_row(name, *(f"{value:.1f}" for value in each), *(f"{value:.2f}" for value in ratios))
    return table
