"""The process of a group of jobs that share a part: it prepares what they share, and forks processes that run the jobs.

Requests and answers are frames of plain data (`cad.work.frames`) on a socket. The first request says which function
opens the group and which runs a job. A process runs one job after another, at most `JOBS_OF_A_PROCESS`. If it dies,
only the job that it ran is lost. What a job began to write and did not finish is removed. If this process ends, the
system ends those of its jobs.
"""

from __future__ import annotations

import gc
import os
import select
import shutil
import signal
import socket
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from cad.work.frames import Channel, Writes, read_packet, write_frame, write_packet
from cad.work.own_process import end_with_parent, function_named, limited, outcome_of, told_fault
from cad.work.plain_data import unpack

JOBS_OF_A_PROCESS = 16
"""A new process costs as much as a quarter of a small job, most of it for memory that it begins to use."""


@dataclass(frozen=True, slots=True)
class GroupRequest:
    """What the process of a group does."""

    #: `open_target`, `run_target`: ``package.module:function``. The first takes `arguments` and returns what the jobs
    #: share; the second takes that and the arguments of a job, and returns plain data.
    open_target: str
    run_target: str
    arguments: dict[str, Any]  #: Keyword arguments, plain data.
    folder: Path  #: In which both work: relative names are looked up there.
    work: Path  #: Of unfinished work. A job finds the folder ``work/NUMBER`` for itself.
    #: `time_s`, `memory_gb`: Limits of opening, and of each job. Only Linux holds a process to the limit of memory.
    time_s: float
    memory_gb: float


def preload(modules: Sequence[str]) -> None:
    """Import what groups and jobs need, so that forked processes have it."""
    from wpcal.core.process import collect_rarely

    collect_rarely()
    for module in modules:
        import_module(module)


def answer_jobs(channel: socket.socket, server: int) -> None:
    """Open the group that the first request describes, then run jobs until the other side closes the channel."""
    os.setpgid(0, 0)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD):
        signal.signal(number, signal.SIG_DFL)
    end_with_parent(server)
    stream = Channel(channel)
    packet = read_packet(stream)
    if packet is None:
        return
    request: GroupRequest = unpack(packet)
    os.chdir(request.folder)
    tempfile.tempdir = str(request.work)  # removed also if this process is killed
    with limited(request.time_s, request.memory_gb):
        opened = _told(stream, lambda: function_named(request.open_target)(**request.arguments))
        if opened is None:
            return
    gc.collect()
    gc.freeze()
    write_frame(stream, "opened", None)
    _Jobs(stream, request, opened).run()


@dataclass(slots=True)
class _Worker:
    """A process that runs one job after another."""

    process: int
    channel: Channel
    number: int | None = None
    """Of the job that it runs."""
    begun: int = 0


class _Jobs:
    """Gives jobs to processes, forks these when needed, and sends the answers."""

    def __init__(self, channel: Channel, request: GroupRequest, opened: Any) -> None:
        self._channel, self._request, self._opened = channel, request, opened
        self._workers: dict[int, _Worker] = {}

    def run(self) -> None:
        """Work until the other side closes the channel."""
        while True:
            heard: list[Any] = [self._channel, *self._workers]
            ready, _, _ = select.select(heard, [], [])
            for each in ready:
                if isinstance(each, int):
                    self._receive(self._workers[each])
                elif (packet := read_packet(self._channel)) is None:
                    return
                else:
                    number, _ = unpack(packet)
                    self._give(number, packet)

    def _give(self, number: int, packet: bytes) -> None:
        """Give a job to a process that is free, or to a new one."""
        worker = next((each for each in self._workers.values() if each.number is None), None) or self._fork()
        shutil.rmtree(self._request.work / str(number), ignore_errors=True)  # of a process that was killed
        worker.number, worker.begun = number, worker.begun + 1
        with suppress(OSError):  # it was killed: the end of its channel tells that
            write_packet(worker.channel, packet)

    def _fork(self) -> _Worker:
        ours, theirs = socket.socketpair()
        group, process = os.getpid(), os.fork()
        if not process:
            end_with_parent(group)
            for channel in (self._channel, *(each.channel for each in self._workers.values())):
                channel.close()
            ours.close()
            self._work(Channel(theirs))
        theirs.close()
        worker = _Worker(process, Channel(ours))
        self._workers[worker.channel.fileno()] = worker
        return worker

    def _work(self, channel: Channel) -> None:
        """Run jobs in the process that was forked for them, until there are no more."""
        code = 1
        try:
            request = self._request
            run = function_named(request.run_target)
            while (packet := read_packet(channel)) is not None:
                number, arguments = unpack(packet)
                with limited(request.time_s, request.memory_gb):
                    answer = _told(channel, partial(run, self._opened, folder=request.work / str(number), **arguments))
                if answer is not None:
                    write_frame(channel, "done", answer)
            code = 0
        finally:
            os._exit(code)  # the kernel's own shutdown can crash after all work is done

    def _receive(self, worker: _Worker) -> None:
        """Take the answer of a process, or the news that it ended, and pass it on."""
        answer, status = read_packet(worker.channel), 0
        is_over = answer is None or worker.begun >= JOBS_OF_A_PROCESS
        if is_over:
            del self._workers[worker.channel.fileno()]
            worker.channel.close()
            _, status = os.waitpid(worker.process, 0)
        number, worker.number = worker.number, None
        if number is not None:
            shutil.rmtree(self._request.work / str(number), ignore_errors=True)
            write_frame(self._channel, "ended", (number, answer or b"", status))


def _told(stream: Writes, work: Callable[[], Any]) -> Any:
    """Return what a function returns; send what it raises as a frame, and return None."""
    kind, value = outcome_of(work)
    if kind == "result":
        return value
    if kind == "error":
        value = (str(value), _errno_behind(value))
    elif isinstance(value, OSError):
        where = value.filename or tempfile.gettempdir()  # a write that fails names no file: jobs write only there
        kind, value = "error", (f"{where}: {(value.strerror or str(value)).lower()}", value.errno or 0)
    elif kind == "fault":
        value = told_fault(value)
    write_frame(stream, kind, value)
    return None


def _errno_behind(error: BaseException) -> int:
    """Return the number of the system's error from which an error was made; 0 if there is none."""
    cause = error.__cause__ or error.__context__
    return (cause.errno or 0) if isinstance(cause, OSError) else 0
