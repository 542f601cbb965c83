"""The process from which those of a batch are forked; not meant to be run by hand.

``python -P -m cad.work.server PARENT LOCK WORK MODULE…`` loads the modules once, and never works itself, so that it
cannot crash. Its standard input is a socket. The command sends a number and a socket for every group of jobs. A forked
process answers that socket (`cad.work.group`). When it ends, the server sends the number and how it ended.

When the command ends, in whatever way, the server ends all processes, removes the folder WORK with everything that was
not finished, and releases the lock of the output folder.
"""

from __future__ import annotations

import gc
import os
import select
import shutil
import signal
import socket
import struct
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

GROUP = struct.Struct("<q")  #: Number of a group.
ENDED = struct.Struct("<qq")  #: Number of a group, and the status of its process as the system tells it.


def main() -> None:
    """Answer the command until it ends."""
    parent, lock, work, modules = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], sys.argv[4:]
    command = socket.socket(fileno=os.dup(sys.stdin.fileno()))
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # the end of the command ends this process, not a signal to both
    with _given_up_with(parent, work):
        from cad.work.group import preload

        preload(modules)
    gc.collect()
    gc.freeze()  # objects that live until the end: looking at them would copy their memory in every fork
    groups = _serve(command, lock) if os.getppid() == parent else {}
    for process in groups:
        end_family(process)
    with suppress(ChildProcessError):  # there are none any more
        while True:
            os.waitpid(-1, 0)
    shutil.rmtree(work, ignore_errors=True)
    os._exit(0)


@contextmanager
def _given_up_with(parent: int, work: str) -> Iterator[None]:
    """End this process when the command ends while it still loads modules: nothing has begun then."""
    from cad.work.own_process import adopt_orphans, end_with_parent

    def give_up(*_: object) -> None:
        shutil.rmtree(work, ignore_errors=True)
        os._exit(0)

    adopt_orphans()  # a job whose group was killed may still write: its end is waited for
    signal.signal(signal.SIGUSR1, give_up)
    end_with_parent(parent, signal.SIGUSR1, too_late=give_up)
    yield
    signal.signal(signal.SIGUSR1, signal.SIG_IGN)  # from now on the end of the socket tells it


def end_family(process: int) -> None:
    """Kill the process of a group and its jobs: they are one process group."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process, signal.SIGKILL)
    with suppress(ProcessLookupError):
        os.kill(process, signal.SIGKILL)


def _serve(command: socket.socket, lock: int) -> dict[int, int]:
    """Fork a process for every group that the command sends; return those that run when the command ends."""
    wakes, wake = os.pipe()
    os.set_blocking(wake, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
    groups: dict[int, int] = {}
    heard: list[Any] = [command, wakes]
    while True:
        ready, _, _ = select.select(heard, [], [])
        if wakes in ready:
            os.read(wakes, 4096)
            if not _report(command, groups):
                return groups
        if command in ready:
            message, descriptors, _, _ = socket.recv_fds(command, GROUP.size, 1)
            if len(message) < GROUP.size or not descriptors:
                return groups
            server, process = os.getpid(), os.fork()
            if not process:
                signal.set_wakeup_fd(-1)
                for descriptor in (sys.stdin.fileno(), lock, wakes, wake, command.fileno()):
                    os.close(descriptor)
                os.open(os.devnull, os.O_RDONLY)  # as standard input: the lowest number that is free
                _become_group(descriptors[0], server)
            with suppress(OSError):  # the child does the same: whoever is first
                os.setpgid(process, process)
            os.close(descriptors[0])
            groups[process] = GROUP.unpack(message)[0]


def _report(command: socket.socket, groups: dict[int, int]) -> bool:
    """Tell the command which groups ended; False when nobody listens any more."""
    while True:
        try:
            process, status = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return True
        if not process:
            return True
        if process not in groups:  # a job of a group that ended
            continue
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process, signal.SIGKILL)  # its jobs
        try:
            command.sendall(ENDED.pack(groups.pop(process), status))
        except OSError:
            return False


def _become_group(descriptor: int, server: int) -> None:
    from cad.work.group import answer_jobs

    code = 1
    try:
        answer_jobs(socket.socket(fileno=descriptor), server)
        code = 0
    finally:
        os._exit(code)


if __name__ == "__main__":
    main()
