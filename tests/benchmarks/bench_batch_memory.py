"""Whether `wpcal batch` needs more memory the more jobs it has done, and how it behaves with many folders.

`WPCAL_BENCH_JOBS` sets the number of jobs (10 000). The part is the small sample tee.
"""

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil
from rich.table import Table

from tests.benchmarks.bench_batch import write_jobs
from tests.running import children_of
from wpcal.core.pairs import PointPairs
from wpcal.taught.table import read_taught

JOBS = int(os.environ.get("WPCAL_BENCH_JOBS", "10000"))
TEE = Path(__file__).parents[2] / "fixtures" / "tee"
EVERY_S = 2.0
WARM_UP = 0.1  #: The first tenth of the jobs is left out: caches fill.


@dataclass(slots=True)
class Watched:
    """What was seen of a batch."""

    done: list[int] = field(default_factory=list)  #: Jobs, at each look.
    #: Memory of the processes that live as long as the batch: the command, the server and the process of the group.
    lasting_mb: list[float] = field(default_factory=list)
    worker_mb: float = 0.0  #: The most memory of one process that runs jobs.

    def look(self, process: int, out: Path) -> None:
        """Look at the processes of a batch; the command is the first, and each of the others is a child of another."""
        server = children_of(process)[:1]
        groups = [group for each in server for group in children_of(each)]
        workers = [worker for group in groups for worker in children_of(group)]
        summary = out / "summary.jsonl"
        self.done.append(summary.read_bytes().count(b"\n") if summary.exists() else 0)
        self.lasting_mb.append(sum(map(_memory_mb, [process, *server, *groups])))
        self.worker_mb = max([self.worker_mb, *map(_memory_mb, workers)])

    def slope(self) -> tuple[float, float]:
        """Return the growth of the memory in MB per 1000 jobs, and its standard error."""
        done, mb = np.array(self.done) / 1000.0, np.array(self.lasting_mb)
        used = (done > WARM_UP * done.max()) & (done < done.max())
        x, y = done[used] - done[used].mean(), mb[used] - mb[used].mean()
        slope = float(x @ y / (x @ x))
        return slope, float(np.sqrt(np.sum((y - slope * x) ** 2) / (len(x) - 2) / (x @ x)))


def _memory_mb(process: int) -> float:
    try:
        return float(psutil.Process(process).memory_info().rss) / 2**20
    except psutil.NoSuchProcess:
        return 0.0


def run(folder: Path, *options: str) -> tuple[float, Watched]:
    """Run the batch in a folder; return the time by the clock, s, and what was seen."""
    watched, start = Watched(), time.perf_counter()
    command = [sys.executable, "-m", "wpcal", "batch", "jobs.csv", "-o", "out", "-j", "2", "--report", "none"]
    quiet = subprocess.DEVNULL
    with subprocess.Popen([*command, *options], cwd=folder, stdout=quiet, stderr=quiet) as process:
        while process.poll() is None:
            watched.look(process.pid, folder / "out")
            time.sleep(EVERY_S)
    return time.perf_counter() - start, watched


def main() -> Table:
    """Measure and return the table."""
    table = Table(title=f"memory of wpcal batch -j 2 over {JOBS} jobs")
    for heading in ("", "by the clock s", "slope MB per 1000 jobs", "± 1 sigma", "lasting MB", "one worker MB"):
        table.add_column(heading, justify="right")
    with tempfile.TemporaryDirectory(dir=os.environ.get("WPCAL_BENCH_FOLDER")) as made:
        folder = Path(made)
        (folder / "part.step").write_bytes((TEE / "tee.step").read_bytes())
        taught = read_taught(TEE / "taught.csv")
        write_jobs(folder, PointPairs(taught.names, taught.p_base, taught.p_base), JOBS)
        seconds, seen = run(folder)
        done = sum(1 for _ in (folder / "out").glob("*/calibration.json"))
        slope, error = seen.slope()
        lasting = f"{min(seen.lasting_mb):.0f} to {max(seen.lasting_mb):.0f}"
        table.add_row(
            f"{done} done", f"{seconds:.0f}", f"{slope:.3f}", f"{error:.3f}", lasting, f"{seen.worker_mb:.0f}"
        )
        seconds, _ = run(folder, "--resume")
        table.add_row("--resume", f"{seconds:.0f}", "", "", "", "")
    return table
