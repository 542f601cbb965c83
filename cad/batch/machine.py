"""The jobs of a batch on another machine: what a Dask worker does with them.

The process of a worker runs no job itself. It has its own `Host`, started by the first job: the same processes as on
the machine of the command, which a crash, a hang or too much memory cannot harm. They end with the worker.
"""

from __future__ import annotations

import os
import queue
import secrets
import shutil
import socket
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any

from cad.batch.job_record import original
from cad.batch.run import MOST_TRIES, WORK_MARK, Jobs, Task
from cad.batch.sent_files import Copies, SentFile
from cad.work.group import GroupRequest
from cad.work.host import Failure, Host, ServerEndedError
from wpcal.core.errors import WpcalError

KEPT_OPEN = 2  #: This many parts without jobs stay open in a worker: the next job may be about one of them.
END_S, STEP_S = 2.0, 0.02
"""Processes that are ended can write during a fraction of a second; their files are removed again for this long."""
GONE = "the process that starts the jobs of this worker was ended"


@dataclass(frozen=True, slots=True)
class SentJob:
    """A job on its way to another machine."""

    batch: str  #: Identifies the batch.
    group: int  #: Jobs of the same group share what is found in their part.
    request: GroupRequest  #: What opens the group. Its folders are those of the machine of the command.
    arguments: dict[str, Any]  #: Of the function that runs the job, without ``out``.
    files: tuple[SentFile, ...]  #: Those that the request and the arguments name; their contents are sent beside.
    modules: tuple[str, ...]  #: Loaded once by the worker's server.


def run_sent_job(job: SentJob, *contents: bytes) -> tuple[Any, dict[str, bytes]]:
    """Run a job here; return what it returned, or its `Failure`, and the files that it wrote."""
    value: Any = Failure("was given up")
    for _ in range(MOST_TRIES):
        if job.batch in _over:
            break
        try:
            return _machine(job.modules).run(job, contents)
        except (WpcalError, OSError) as error:  # somebody killed the server of this worker, or its disk is full
            value = Failure(" ".join(str(error).split()), getattr(error, "errno", None) or 0)
        finally:
            if job.batch in _over:  # it was given up meanwhile
                end_batch(job.batch, watch_s=END_S)
    return value, {}


def end_batch(batch: str, watch_s: float = 0.0) -> None:
    """End the processes of a batch on this worker, and remove its files. No further job of it is run.

    `watch_s`: For this long files are removed again that processes write which have not ended yet.
    """
    _over.add(batch)
    with _lock:
        now = _now
    if now is not None:
        now.end_batch(batch, watch_s)


_over: set[str] = set()
"""Batches that have ended. Jobs of a batch that was interrupted may still arrive."""
_lock = threading.Lock()
_now: _Machine | None = None


def _machine(modules: Sequence[str]) -> _Machine:
    global _now  # noqa: PLW0603 - one for all threads of the process
    with _lock:
        if _now is None or _now.has_ended:
            _now = _Machine(modules)
        return _now


class _Machine:
    """The processes for jobs on this machine, and the thread that speaks with them."""

    def __init__(self, modules: Sequence[str]) -> None:
        from distributed import get_worker

        worker = get_worker()
        self._folder = Path(worker.local_directory) / f"{WORK_MARK}{secrets.token_hex(4)}"
        self._threads: int = worker.state.nthreads
        self._modules = modules
        self._numbers = count()
        self._orders: queue.SimpleQueue[Callable[[Jobs], None]] = queue.SimpleQueue()
        self._waiting: dict[int, Future[Any]] = {}
        self._wakes, self._wake = socket.socketpair()
        self._wakes.setblocking(False)
        self.has_ended = False
        self._ready: Future[None] = Future()
        threading.Thread(target=self._work, name="wpcal", daemon=True).start()
        self._ready.result()

    def run(self, job: SentJob, contents: Sequence[bytes]) -> tuple[Any, dict[str, bytes]]:
        """Run a job; return what it returned, or its `Failure`, and the files that it wrote.

        Raises `ServerEndedError` when somebody killed the server.
        Raises `OSError` when files cannot be written.
        """
        of_batch = self._folder / job.batch
        copies = Copies(of_batch, job.files, contents)
        number = next(self._numbers)
        out = of_batch / f"result-{number}"
        request = replace(job.request, arguments=copies.placed(job.request.arguments), folder=of_batch, work=of_batch)
        arguments = {**copies.placed(job.arguments), "origins": copies.origins, "out": out}
        ended: Future[Any] = Future()
        self._waiting[number] = ended
        self._order(lambda jobs: jobs.add(Task(number, (job.batch, job.group), arguments), request))
        if self.has_ended:
            raise ServerEndedError(GONE)
        value = ended.result()
        if isinstance(value, Failure):
            return replace(value, message=original(value.message, copies.origins)), {}
        files = {path.name: path.read_bytes() for path in sorted(out.iterdir())}
        shutil.rmtree(out)
        return value, files

    def end_batch(self, batch: str, watch_s: float) -> None:
        """End the processes of a batch, and remove its files; see `end_batch`."""

        def is_of_batch(key: Any) -> bool:
            return bool(key[0] == batch)

        self._order(lambda jobs: jobs.end_groups(is_of_batch))
        begun = time.monotonic()
        while (now := time.monotonic() - begun) < watch_s or ((self._folder / batch).is_dir() and now < END_S):
            shutil.rmtree(self._folder / batch, ignore_errors=True)
            time.sleep(STEP_S)

    def _order(self, order: Callable[[Jobs], None]) -> None:
        self._orders.put(order)
        with suppress(OSError):  # the machine has ended: whoever waits is told
            self._wake.send(b"x")

    def _work(self) -> None:
        """Run jobs until the server ends. A thread of its own: the server ends with the thread that started it."""
        error: BaseException = ServerEndedError(GONE)
        lock = os.open(self._folder.parent, os.O_RDONLY)
        try:
            host = Host(self._folder, lock, self._modules)
        except Exception as raised:  # whoever waits must learn of it
            self.has_ended = True
            self._ready.set_exception(raised)
            return
        finally:
            os.close(lock)
        jobs = Jobs(host, at_once=self._threads, done=self._done, kept_open=KEPT_OPEN)
        self._ready.set_result(None)
        try:
            while True:
                while not self._orders.empty():
                    self._orders.get()(jobs)
                jobs.step(self._wakes.fileno())
                with suppress(BlockingIOError):
                    self._wakes.recv(4096)
        except Exception as raised:  # whoever waits must learn of it
            error = raised
        finally:
            self.has_ended = True
            host.end()
            self._wakes.close()
            self._wake.close()
            for waiting in list(self._waiting.values()):
                waiting.set_exception(error)

    def _done(self, task: Task, value: Any) -> None:
        self._waiting.pop(task.number).set_result(value)
