"""The least of several runs: what the code takes when nothing else disturbs it."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ProcessUse:
    """What a process and those that it started took."""

    wall_s: float
    processor_s: float  #: Of user and system.
    peak_mb: float  #: Of the largest process.

    def least(self, other: ProcessUse) -> ProcessUse:
        """Return the least times and the largest memory of two runs."""
        return ProcessUse(
            min(self.wall_s, other.wall_s), min(self.processor_s, other.processor_s), max(self.peak_mb, other.peak_mb)
        )


def run_python(
    *arguments: object, ends: Sequence[int] = (0,), environment: Mapping[str, str] | None = None, folder: str = "."
) -> ProcessUse:
    """Run Python with these arguments, as a user does, and measure it; another exit code than `ends` is an error."""
    command = [sys.executable, *map(str, arguments)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    start = time.perf_counter()
    process = subprocess.Popen(command, cwd=folder, env={**os.environ, **(environment or {})}, **quiet)
    _, status, usage = os.wait4(process.pid, 0)  # its children that ended count, too
    wall_s = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in ends:
        raise RuntimeError(f"{' '.join(command[1:])} ended with {process.returncode}")
    return ProcessUse(wall_s, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def least_seconds(work: Callable[[], object], repeats: int) -> float:
    """Run `work` once to warm up, then `repeats` times, and return the shortest time."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)
