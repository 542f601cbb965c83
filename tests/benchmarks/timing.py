"""The least of several runs: what the code takes when nothing else disturbs it."""

from __future__ import annotations

import os
import subprocess
import sys
import timeit
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

LAUNCHER = """
import os, subprocess, sys, time
start = time.perf_counter()
process = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, use = os.wait4(process.pid, 0)
print(os.waitstatus_to_exitcode(status), time.perf_counter() - start, use.ru_utime + use.ru_stime, use.ru_maxrss / 1024)
"""
"""A small process starts the one that is measured: the memory of its starter counts as its own until it is replaced."""


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
    command = [sys.executable, "-S", "-c", LAUNCHER, sys.executable, *map(str, arguments)]
    used = subprocess.check_output(command, cwd=folder, env=os.environ | dict(environment or {}))
    code, *use = map(float, used.split())
    if code not in ends:
        raise RuntimeError(f"{' '.join(map(str, arguments))} ended with {code:.0f}")
    return ProcessUse(*use)


def least_seconds(work: Callable[[], object], repeats: int) -> float:
    """Run `work` once to warm up, then `repeats` times, and return the shortest time."""
    work()
    return min(timeit.repeat(work, number=1, repeat=repeats))
