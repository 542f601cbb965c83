"""A Dask scheduler and workers on this machine, as a user starts them: processes of their own."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

START_S = 60.0  #: On a loaded machine Dask takes some seconds to start.


class DaskProcesses:
    """A scheduler, and workers with one thread each."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir()
        self._folder, self._file = folder, folder / "scheduler.json"
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0")
        until = time.monotonic() + START_S
        while not self._file.exists() and time.monotonic() < until:
            time.sleep(0.02)
        self.address: str = json.loads(self._file.read_text())["address"]
        self.workers: list[subprocess.Popen[bytes]] = []
        self.homes: list[Path] = []  #: The folder of each worker.

    def add_worker(self) -> None:
        """Start a worker in a folder of its own."""
        home = self._folder / f"worker{len(self.workers)}"
        options = ("--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--local-directory", str(home))
        self.workers.append(self._start("worker", *options))
        self.homes.append(home)

    def _start(self, kind: str, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", "--scheduler-file", str(self._file)]
        environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
        with (self._folder / f"{kind}.log").open("ab") as log:
            return subprocess.Popen(
                [*command, *options, "--no-dashboard"], stdout=log, stderr=log, env=environment, cwd=self._folder
            )

    def end(self) -> None:
        """End all processes."""
        for process in (*self.workers, self.scheduler):
            process.kill()
        for process in (*self.workers, self.scheduler):
            process.wait()


@contextmanager
def dask_processes(folder: Path) -> Iterator[DaskProcesses]:
    """Yield a scheduler without workers; it and its workers end with the block."""
    processes = DaskProcesses(folder)
    try:
        yield processes
    finally:
        processes.end()
