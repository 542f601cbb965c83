"""The command's side of the processes of a batch: starts the server, sends groups and jobs, and tells what happened."""

from __future__ import annotations

import contextlib
import errno
import os
import select
import signal
import socket
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto
from pathlib import Path
from typing import Any

from cad.work.child import CRASH_SIGNALS, last_line, start_python
from cad.work.frames import Channel, read_packet, write_packet
from cad.work.group import GroupRequest
from cad.work.plain_data import pack, unpack
from cad.work.plain_types import PlainDataError
from cad.work.server import ENDED, GROUP
from wpcal.core.errors import InputError, KernelError, fault_words
from wpcal.core.process import ONE_THREAD

END_S = 10.0  #: The server needs less than a second to end its processes and to remove what they began.
LATE, NO_MEMORY = "--job-seconds", "--job-gb"
"""The options that change the limits, for messages."""


class EventKind(Enum):
    """What happened."""

    OPENED = auto()  #: A group is ready for jobs.
    DONE = auto()  #: A job was done; the value is what it returned.
    FAILED = auto()  #: A job failed; the value is a `Failure`.
    LOST = auto()  #: A group cannot run jobs; the value is a `Failure`. Its running jobs are lost with it.


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a job or a group failed."""

    message: str  #: One line.
    errno: int = 0  #: Number of the system's error behind it; 0 if there is none.
    killed: bool = False  #: Whether somebody else killed the process: the same work may well succeed.
    of_group: bool = False  #: Whether no job of its group can be run.


@dataclass(frozen=True, slots=True)
class Event:
    """What happened to a group, or to one of its jobs (`number`)."""

    kind: EventKind
    group: int
    number: int = -1
    value: Any = None


class ServerEndedError(KernelError):
    """The server process was ended by somebody else."""


class Host:
    """The processes of one batch on this machine. Raises `InputError` when the folder cannot be made."""

    def __init__(self, work: Path, lock: int, modules: Sequence[str]) -> None:
        ours, theirs = socket.socketpair()
        self._command, self._noise = ours, tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the server runs
        self._channels: dict[int, Channel] = {}
        self._work = work
        self._requests: dict[int, GroupRequest] = {}
        self._all_ended, held = os.pipe()  # all processes hold the other end: it can be read when the last has ended
        with theirs:
            self._server = start_python(
                "cad.work.server",
                *(lock, work, *modules),
                environment=ONE_THREAD,
                stdin=theirs.fileno(),
                stdout=self._noise,
                stderr=self._noise,
                pass_fds=(lock, held),
            )
        os.close(held)
        try:
            work.mkdir()  # when there is a server, which removes it even if the command is killed
        except OSError as error:
            self.end()
            raise InputError(f"{work.parent}: cannot be written: {(error.strerror or str(error)).lower()}") from error

    def open_group(self, group: int, request: GroupRequest) -> None:
        """Start the process of a group; an event tells when it is ready for jobs.

        Raises `ServerEndedError` when the server does not run any more.
        """
        ours, theirs = socket.socketpair()
        self._channels[group], self._requests[group] = Channel(ours), request
        with theirs:
            try:
                socket.send_fds(self._command, [GROUP.pack(group)], [theirs.fileno()])
            except OSError:
                raise self._ended() from None
        with contextlib.suppress(OSError):  # it died at once: the server tells of that
            write_packet(self._channels[group], pack(request))

    def run(self, group: int, number: int, arguments: dict[str, Any]) -> None:
        """Start a job in a group that is ready. If it died meanwhile, an event will tell."""
        channel = self._channels.get(group)
        if channel is not None:
            with contextlib.suppress(OSError):  # it died: the server tells of that
                write_packet(channel, pack((number, arguments)))

    def close_group(self, group: int) -> None:
        """Let the process of a group end."""
        channel = self._channels.pop(group, None)
        if channel is not None:
            channel.close()

    def wait(self, wake: int | None = None) -> list[Event]:
        """Wait until something happens, and return it.

        Raises `ServerEndedError` when the server does not run any more.
        """
        channels = {channel.fileno(): group for group, channel in self._channels.items()}
        heard: list[Any] = [self._command, *channels, *([] if wake is None else [wake])]
        ready, _, _ = select.select(heard, [], [])
        events = []
        for each in ready:
            if each in channels and channels[each] in self._channels:
                events += self._heard(channels[each])
        if self._command in ready:
            events += self._group_ended()
        return events

    def end(self) -> None:
        """End all processes. What they began and did not finish is removed."""
        self._command.close()
        for group in list(self._channels):
            self.close_group(group)
        try:
            self._server.wait(END_S)
        except subprocess.TimeoutExpired:
            self._server.kill()
            self._server.wait()
        select.select([self._all_ended], [], [], END_S)  # those of a server that was killed may still write
        os.close(self._all_ended)
        self._noise.close()

    def _heard(self, group: int) -> list[Event]:
        packet = read_packet(self._channels[group])
        if packet is None:  # the server tells how it ended; until then nothing more comes from it
            self._channels.pop(group).close()
            return []
        kind, value = unpack(packet)
        if kind == "opened":
            return [Event(EventKind.OPENED, group)]
        if kind == "ended":
            number, sent, status = value
            return [self._job_ended(group, number, sent, status)]
        self.close_group(group)
        return [Event(EventKind.LOST, group, value=self._failure(group, kind, value))]

    def _job_ended(self, group: int, number: int, sent: bytes, status: int) -> Event:
        if sent:
            with contextlib.suppress(PlainDataError, ValueError):
                kind, value = unpack(sent)
                if kind == "done":
                    return Event(EventKind.DONE, group, number, value)
                return Event(EventKind.FAILED, group, number, self._failure(group, kind, value))
        return Event(EventKind.FAILED, group, number, self._death(group, status))

    def _group_ended(self) -> list[Event]:
        try:
            message = self._command.recv(ENDED.size, socket.MSG_WAITALL)
        except OSError:
            message = b""
        if len(message) < ENDED.size:
            raise self._ended()
        group, status = ENDED.unpack(message)
        if group not in self._requests:
            return []
        lost = self._death(group, status)
        del self._requests[group]
        self.close_group(group)
        return [Event(EventKind.LOST, group, value=lost)] if status else []

    def _failure(self, group: int, kind: str, value: Any) -> Failure:
        if kind == "no memory":
            most = self._requests[group].memory_gb
            return Failure(f"needs more than its limit of {most:g} GB of memory; {NO_MEMORY} allows more")
        if kind == "error":
            message, number = value
            if number not in (0, errno.ENOENT) and str(self._work) in message:  # files there are nobody's business
                message = f"{self._work.parent}: cannot be written: {os.strerror(number).lower()}"
            return Failure(message, number)
        return Failure(fault_words(value[0], debug=False))

    def _death(self, group: int, status: int) -> Failure:
        """Say how a process ended that did not say so itself."""
        code = os.waitstatus_to_exitcode(status)
        if code >= 0:
            return Failure(f"its process ended with code {code}: {last_line(self._noise)}")
        name = signal.Signals(-code).name
        if name == "SIGALRM":
            limit = self._requests[group].time_s
            return Failure(f"stopped after {limit:g} s, its time limit; {LATE} allows more")
        if name in CRASH_SIGNALS:
            return Failure(f"the CAD kernel cannot work with this file: it crashed ({name})")
        hint = "; the system may be out of memory" if name == "SIGKILL" else ""
        return Failure(f"its process was ended by {name}{hint}", killed=True)

    def _ended(self) -> ServerEndedError:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._server.wait(END_S)
        code = self._server.poll()
        how = f"with code {code}: {last_line(self._noise)}"
        if code is not None and code < 0:
            how = f"by {signal.Signals(-code).name}"
        return ServerEndedError(f"the process that starts the jobs was ended {how}")
