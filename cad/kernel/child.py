"""Run one function of the CAD side in a child process with a time limit.

The kernel can crash, hang or run out of memory on a file. In a child process such a fault is one line (`KernelError`),
and the parent starts without loading the kernel. The child sends its results as frames over a pipe of its own. Whatever
the kernel prints on standard output goes to the child's standard error, which the parent does not show.

``python -P -m cad.kernel.child`` starts the child's side. It is not meant to be run by hand. Without ``-P``, Python
would look for modules in the current folder first, and run a ``numpy.py`` that lies beside a customer's STEP file.
``-I`` would also do that, but the child would then not find a wpcal in the user's own site-packages or on PYTHONPATH.
"""

from __future__ import annotations

import os
import pickle
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import traceback
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from typing import IO, Any

from cad.kernel.system_libraries import libgl_explained
from wpcal.core.errors import KernelError, WpcalError
from wpcal.core.progress import Progress

DEFAULT_TIMEOUT_S = 600.0
"""Twenty times what the kernel needed for the largest real part tried (170 MB, 30 s)."""

_LENGTH = struct.Struct("<Q")
_ALARM_GRACE_S = 30
"""The child ends itself this long after its time limit, in case its parent is gone."""

CRASH_SIGNALS = frozenset({"SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL"})
"""Signals that end a process after a fault in compiled code."""


class ChildFaultError(RuntimeError):
    """A defect of wpcal in the child: an unexpected exception. Its traceback is in the notes."""


def run_in_child(
    target: str,
    arguments: Mapping[str, Any] | None = None,
    *,
    what: str,
    timeout_s: float = DEFAULT_TIMEOUT_S,
    progress: Progress | None = None,
) -> Any:
    """Call a function in a new process and return what it returns.

    Parameters
    ----------
    target : str
        ``package.module:function``.
    arguments : mapping, optional
        Keyword arguments. They and the result must be values that can be pickled.
    what : str
        For messages: what is being done to which file (``reading part.step``).
    timeout_s : float
        The child is ended after this time, s.
    progress : callable, optional
        When given, the function also gets a keyword argument `progress`. Each text it passes arrives here.

    Returns
    -------
    object
        The function's result.

    Raises
    ------
    WpcalError
        When the function raised one; it is raised again here.
    KernelError
        When the child crashed, was killed or exceeded its time.
    ChildFaultError
        When the function raised anything else.
    """
    request = pickle.dumps((target, dict(arguments or {}), progress is not None, timeout_s))
    with tempfile.TemporaryFile() as noise:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "cad.kernel.child"],
            env=_environment(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=noise,
            start_new_session=True,  # Ctrl-C reaches the parent only, which ends the child
        )
        child = _Child(process, noise, what, timeout_s)
        clock = threading.Timer(timeout_s, child.end_late)
        clock.daemon = True
        clock.start()
        try:
            return child.converse(request, progress)
        finally:
            clock.cancel()
            child.close()


def _environment() -> dict[str, str]:
    """Return the environment without the empty entries of PYTHONPATH: to Python they mean the current folder."""
    environment = dict(os.environ)
    entries = [entry for entry in environment.pop("PYTHONPATH", "").split(os.pathsep) if entry]
    if entries:
        environment["PYTHONPATH"] = os.pathsep.join(entries)
    return environment


@dataclass(slots=True)
class _Child:
    """The parent's view of the running child."""

    process: subprocess.Popen[bytes]
    noise: IO[bytes]
    what: str
    timeout_s: float
    is_late: bool = False

    def end_late(self) -> None:
        """End the child because it exceeded its time limit."""
        self.is_late = True
        self.process.kill()

    def close(self) -> None:
        """End the child if it still runs, and close its pipes."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            with suppress(BrokenPipeError):  # it died before it read its request; `converse` reports that
                if pipe is not None:
                    pipe.close()

    def converse(self, request: bytes, progress: Progress | None) -> Any:
        """Send the request and handle frames until the result. A stream that ends earlier means that the child died."""
        if self.process.stdin is not None:
            with suppress(BrokenPipeError):  # a dead child also has no frames to read
                _send(self.process.stdin, request)
        for kind, value in _frames(self.process.stdout):
            if kind == "progress" and progress is not None:
                progress(value)
            elif kind == "result":
                return value
            elif kind == "error":
                raise value
            elif kind == "fault":
                fault = ChildFaultError(f"{self.what}: {value[0]}")
                fault.add_note(value[1])
                raise fault
        raise KernelError(f"{self.what}: {self._cause_of_death()}")

    def _cause_of_death(self) -> str:
        """Say how the child ended."""
        code = self.process.wait()
        if self.is_late:
            return f"stopped after {self.timeout_s:g} s, its time limit"
        if code >= 0:
            return f"the process of the CAD kernel ended with code {code}: {self._last_line()}"
        name = signal.Signals(-code).name
        if name in CRASH_SIGNALS:
            return f"the CAD kernel crashed ({name})"
        hint = "; the system may be out of memory" if name == "SIGKILL" else ""
        return f"the process of the CAD kernel was ended by {name}{hint}"

    def _last_line(self) -> str:
        self.noise.seek(0)
        lines = self.noise.read().decode("utf-8", errors="replace").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "no message")


def _send(pipe: IO[bytes], payload: bytes) -> None:
    pipe.write(_LENGTH.pack(len(payload)) + payload)
    pipe.flush()


def _frames(pipe: IO[bytes] | None) -> Iterator[tuple[str, Any]]:
    """Yield frames until the stream ends. An incomplete frame is ignored."""
    while pipe is not None and len(head := pipe.read(_LENGTH.size)) == _LENGTH.size:
        payload = pipe.read(_LENGTH.unpack(head)[0])
        if len(payload) < _LENGTH.unpack(head)[0]:
            return
        yield pickle.loads(payload)


# The child's side ----------------------------------------------------------------------------------------------------


def main() -> None:
    """Take one request from standard input, run it, and send frames over what was standard output."""
    channel = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # the kernel prints with C++ streams: only the descriptor counts
    head = sys.stdin.buffer.read(_LENGTH.size)
    target, arguments, wants_progress, timeout_s = pickle.loads(sys.stdin.buffer.read(_LENGTH.unpack(head)[0]))
    if hasattr(signal, "alarm"):
        signal.alarm(int(timeout_s) + _ALARM_GRACE_S)
    if wants_progress:
        arguments["progress"] = lambda text: _send(channel, pickle.dumps(("progress", text)))
    _send(channel, _outcome(target, arguments))
    channel.flush()
    os._exit(0)  # the kernel's own shutdown can crash after all work is done


def _outcome(target: str, arguments: dict[str, Any]) -> bytes:
    """Call the function and return its result, its error, or a defect as one frame."""
    try:
        module, _, function = target.partition(":")
        with libgl_explained():
            return pickle.dumps(("result", getattr(import_module(module), function)(**arguments)))
    except WpcalError as error:
        return pickle.dumps(("error", error))
    except MemoryError:
        return pickle.dumps(("error", KernelError("the CAD kernel ran out of memory")))
    except Exception as error:  # the outermost handler of this process: the parent must learn of every exception
        return pickle.dumps(("fault", (f"{type(error).__name__}: {error}", traceback.format_exc())))


if __name__ == "__main__":
    main()
