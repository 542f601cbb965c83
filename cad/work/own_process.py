"""What a process of this room does for itself: it ends with its parent, keeps its limits, and tells what a call did.

This module imports only the standard library: a process watches its parent before anything large is imported.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import IO, Any

_PR_SET_PDEATHSIG = 1  #: Linux: the system sends a signal when the parent ends.
_PR_SET_CHILD_SUBREAPER = 36  #: Linux: the children of a child that ended become children of this process.
_OPEN_SO_EARLY = 64  #: More files than this process has open when it starts to watch its parent.


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


def limit_memory(memory_gb: float) -> None:
    """Let the system refuse more memory than this, 10⁹ bytes, where it can."""
    if sys.platform == "linux":
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        asked = int(memory_gb * 1e9)
        resource.setrlimit(resource.RLIMIT_DATA, (asked if most < 0 else min(asked, most), most))


@contextmanager
def limited(time_s: float, memory_gb: float) -> Iterator[None]:
    """Hold this process to limits: of memory for good, of time until the end of the block. Exceeding it ends it."""
    limit_memory(memory_gb)
    signal.setitimer(signal.ITIMER_REAL, time_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


def private_output() -> IO[bytes]:
    """Return what was standard output; whatever else is printed goes to standard error.

    The kernel and libraries print with C++ streams: only the descriptor counts.
    """
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return channel


def function_named(target: str) -> Callable[..., Any]:
    """Import and return ``"package.module:function"``."""
    module, _, name = target.partition(":")
    found: Callable[..., Any] = getattr(import_module(module), name)
    return found


def outcome_of(work: Callable[[], Any]) -> tuple[str, Any]:
    """Call a function; return ``result`` with its value, ``no memory``, or ``error`` or ``fault`` with the exception.

    An error is one that the user is told; a fault is a defect of wpcal, or an error of the system.
    """
    from wpcal.core.errors import KernelError, OutOfMemoryError, WpcalError

    try:
        return "result", work()
    except (MemoryError, OutOfMemoryError):
        return "no memory", None
    except WpcalError as error:
        return "error", error
    except Exception as error:  # the outermost handler of a process: the other side must learn of every exception
        if type(error).__module__.startswith("OCP."):
            what = f"the CAD kernel failed ({type(error).__name__}: {error}); the file may be damaged"
            return "error", KernelError(what)
        return "fault", error


def told_fault(error: BaseException) -> tuple[str, str]:
    """Return a fault as it is sent: one line, and the traceback."""
    return f"{type(error).__name__}: {error}", "".join(traceback.format_exception(error))
