"""The child's side of `cad.kernel.child`; not meant to be run by hand.

``python -P -m cad.kernel.child_main PARENT`` takes one request from standard input, calls the function, and sends
frames over what was standard output. It ends when the process PARENT ends. That is arranged before anything large is
imported, so this module imports only the standard library.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Mapping
from contextlib import suppress
from importlib import import_module
from types import FrameType
from typing import IO, Any

_ALARM_GRACE_S = 30  #: The child ends itself this long after its time limit, in case its parent cannot.
_PR_SET_PDEATHSIG = 1  #: Linux: the system sends a signal when the parent ends.
_PR_SET_CHILD_SUBREAPER = 36  #: Linux: the children of a child that ended become children of this process.
_OPEN_SO_EARLY = 64  #: More files than this process has open when it starts to watch its parent.


class _AskedToEndError(BaseException):
    """The parent was interrupted: what was begun is removed."""


def main() -> None:
    """Take one request from standard input, run it, and send frames over what was standard output."""
    end_with_parent(int(sys.argv[1]))
    signal.signal(signal.SIGTERM, _raise_asked_to_end)
    from cad.kernel.frames import read_packet
    from cad.kernel.plain_data import unpack

    request = read_packet(sys.stdin.buffer)
    if request is None:
        os._exit(0)  # the parent ended
    if not has_death_signal():
        end_at_end_of(sys.stdin.fileno())
    channel = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # the kernel prints with C++ streams: only the descriptor counts
    target, arguments, wants_progress, time_s, memory_gb = unpack(request)
    _limit_time(time_s)
    limit_memory(memory_gb)
    try:
        _answer(channel, target, arguments, wants_progress=wants_progress)
    except _AskedToEndError:
        os._exit(128 + signal.SIGTERM)
    os._exit(0)  # the kernel's own shutdown can crash after all work is done


def _raise_asked_to_end(_number: int, _frame: FrameType | None) -> None:
    raise _AskedToEndError


def has_death_signal() -> bool:
    """Whether the system can send a signal when the parent ends."""
    return sys.platform == "linux"


def end_with_parent(
    parent: int, number: int = signal.SIGKILL, *, too_late: Callable[[], object] = lambda: os._exit(0)
) -> None:
    """Let the system send this process a signal when its parent ends, also while the CAD kernel computes.

    `number`: The signal.
    `too_late`: Called if the parent has ended already.
    """
    if has_death_signal():
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, number, 0, 0, 0)
        if os.getppid() != parent:  # it ended before the line above
            too_late()


def adopt_orphans() -> None:
    """Let this process wait for the children of its children, too, where the system can do that."""
    if has_death_signal():
        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def end_at_end_of(pipe: int) -> None:
    """End this process when the parent's end of the pipe is closed, on systems that send no signal.

    A process of its own waits for that: a thread would wait for the CAD kernel, which holds Python's lock.
    """
    if not hasattr(os, "fork"):
        threading.Thread(target=lambda: (os.read(pipe, 1), os._exit(0)), daemon=True).start()
        return
    worker = os.getpid()
    if os.fork():
        return
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    for descriptor in set(range(_OPEN_SO_EARLY)) - {pipe}:  # or the parent would not see the end of what is sent
        with suppress(OSError):
            os.close(descriptor)
    os.read(pipe, 1)
    if os.getppid() == worker:
        os.kill(worker, signal.SIGKILL)
    os._exit(0)


def _limit_time(time_s: float) -> None:
    if hasattr(signal, "alarm"):
        signal.alarm(int(time_s) + _ALARM_GRACE_S)


def limit_memory(memory_gb: float) -> None:
    """Let the system refuse more memory than this, 10⁹ bytes, where it can."""
    if sys.platform == "linux":
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        asked = int(memory_gb * 1e9)
        resource.setrlimit(resource.RLIMIT_DATA, (asked if most < 0 else min(asked, most), most))


def _answer(channel: IO[bytes], target: str, arguments: Mapping[str, Any], *, wants_progress: bool) -> None:
    """Call the function and send its result, its error, or a defect as one frame."""
    from cad.kernel.frames import write_frame
    from cad.kernel.system_libraries import libgl_explained
    from wpcal.core.collector import collect_rarely
    from wpcal.core.errors import KernelError, OutOfMemoryError, WpcalError

    collect_rarely()
    progress = {"progress": lambda text: write_frame(channel, "progress", text)} if wants_progress else {}
    try:
        module, _, function = target.partition(":")
        with libgl_explained():
            write_frame(channel, "result", getattr(import_module(module), function)(**arguments, **progress))
    except (MemoryError, OutOfMemoryError):
        write_frame(channel, "no memory", None)
    except WpcalError as error:
        write_frame(channel, "error", error)
    except Exception as error:  # the outermost handler of this process: the parent must learn of every exception
        if type(error).__module__.startswith("OCP."):
            what = f"the CAD kernel failed ({type(error).__name__}: {error}); the file may be damaged"
            write_frame(channel, "error", KernelError(what))
            return
        write_frame(channel, "fault", (f"{type(error).__name__}: {error}", traceback.format_exc()))


if __name__ == "__main__":
    main()
