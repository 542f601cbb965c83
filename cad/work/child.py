"""Run one function of the CAD side in a child process with a limit of time and memory.

The kernel can crash, hang or run out of memory on a file. In a child process such a fault is one line (`KernelError`),
and the parent starts without loading the kernel. The child sends its results as frames over a pipe of its own, as plain
data (`cad.work.plain_data`). Whatever the kernel prints on standard output goes to the child's standard error, which
the parent does not show. `cad.work.child_main` is the child's side.

The child is started as ``python -P -m cad.work.child_main``. Without ``-P``, Python would look for modules in the
current folder first, and run a ``numpy.py`` that lies beside a customer's STEP file. ``-I`` would also do that, but the
child would then not find a wpcal in the user's own site-packages or on PYTHONPATH.
"""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from cad.work.frames import LAST_FRAMES, read_frames, write_packet
from cad.work.plain_data import pack
from cad.work.plain_types import PlainDataError
from wpcal.core.errors import InputError, KernelError
from wpcal.core.options import opt
from wpcal.core.progress import Progress, no_progress
from wpcal.core.whole_folder import remove_left_by

DEFAULT_TIMEOUT_S = 600.0  #: Twenty times what the kernel needed for the largest real part tried (170 MB, 30 s).
DEFAULT_MEMORY_GB = 8.0  #: The largest real part tried took 1.4 GB; before any part is read it is 0.5 GB.
TIME_VARIABLE, MEMORY_VARIABLE = "WPCAL_KERNEL_TIME_S", "WPCAL_KERNEL_MEMORY_GB"
"""Environment variables that change the two limits."""
READING = "reading "  #: Progress messages begin with it while a file is read.
GRACE_S = 1.0
"""After an interrupt the child may remove its temporary folder for as long as this. In the kernel it cannot."""

LAST_BYTES = 10_000  #: Of what processes print: enough to find the last line.
CRASH_SIGNALS = frozenset({"SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL"})
"""Signals that end a process after a fault in compiled code."""


class ChildFaultError(RuntimeError):
    """A defect of wpcal in the child: an unexpected exception. Its traceback is in the notes."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What the child may use.

    `time_s`: Time from its start, s.
    `memory_gb`: Memory of its own, 10⁹ bytes. Only Linux holds a process to this limit.
    """

    time_s: float = opt(
        DEFAULT_TIMEOUT_S, "Time limit of one job, and of reading one part.", "--job-seconds", metavar="S", above=0
    )
    memory_gb: float = opt(
        DEFAULT_MEMORY_GB, "Memory limit of the process of one job (Linux).", "--job-gb", metavar="GB", above=0
    )

    @staticmethod
    def from_environment() -> Limits:
        """Return the limits that the environment states, otherwise the usual ones.

        Raises `InputError` if a variable is not a positive number.
        """
        return Limits(_number_of(TIME_VARIABLE, DEFAULT_TIMEOUT_S), _number_of(MEMORY_VARIABLE, DEFAULT_MEMORY_GB))


def _number_of(variable: str, usual: float) -> float:
    text = os.environ.get(variable)
    if text is None:
        return usual
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not (math.isfinite(number) and number > 0):
        raise InputError(f"{variable}: expected a positive number, got {text!r}")
    return number


def run_in_child(
    target: str,
    arguments: Mapping[str, Any] | None = None,
    *,
    what: str,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> Any:
    """Call a function in a new process and return what it returns. The function's result.

    Raises `WpcalError` when the function raised one; it is raised again here.
    Raises `KernelError` when the child crashed, was killed or exceeded its limits.
    Raises `InputError` when the environment states a limit that is not one.
    Raises `ChildFaultError` when the function raised anything else.
    """
    limits = limits or Limits.from_environment()
    request = pack((target, dict(arguments or {}), progress is not None, limits.time_s, limits.memory_gb))
    with tempfile.TemporaryFile() as noise:
        process = start_python("cad.work.child_main", stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=noise)
        child = _Child(process, noise, what, limits)
        clock = threading.Timer(limits.time_s, child.end_late)
        clock.daemon = True
        clock.start()
        try:
            return child.converse(request, progress or no_progress)
        except KeyboardInterrupt:
            child.ask_to_end()
            raise
        finally:
            clock.cancel()
            child.close()
            remove_left_by(process.pid, *(each for each in (arguments or {}).values() if isinstance(each, Path)))


def start_python(
    module: str, *words: object, environment: Mapping[str, str] | None = None, **streams: Any
) -> subprocess.Popen[bytes]:
    """Start a module as a process of its own, with the number of this process and words as its arguments.

    Ctrl-C reaches this process only, which ends the other one.
    """
    return subprocess.Popen(
        [sys.executable, "-P", "-m", module, str(os.getpid()), *map(str, words)],
        env={**child_environment(), **(environment or {})},
        start_new_session=True,
        **streams,
    )


def child_environment() -> dict[str, str]:
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
    limits: Limits
    is_late: bool = False
    step: str = ""  #: The last progress message.

    def end_late(self) -> None:
        """End the child because it exceeded its time limit."""
        self.is_late = True
        self.process.kill()

    def ask_to_end(self) -> None:
        """Let the child remove what it began to write."""
        self.process.terminate()
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(GRACE_S)

    def close(self) -> None:
        """End the child if it still runs, and close its pipes."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            with suppress(BrokenPipeError):  # it died before it read its request; `converse` reports that
                if pipe is not None:
                    pipe.close()

    def converse(self, request: bytes, progress: Progress) -> Any:
        """Send the request and handle frames until the result. A stream that ends earlier means that the child died."""
        if self.process.stdin is not None:
            with suppress(BrokenPipeError):  # a dead child also has no frames to read
                write_packet(self.process.stdin, request)
        try:
            for kind, value in read_frames(self.process.stdout):
                if kind == "progress":
                    self.step = str(value)
                    progress(self.step)
                elif kind in LAST_FRAMES:
                    return self._ended(kind, value)
        except PlainDataError as error:
            raise KernelError(f"{self.what}: the CAD kernel's process sent what cannot be read: {error}") from None
        raise KernelError(f"{self.what}: {self._cause_of_death()}")

    def _ended(self, kind: str, value: Any) -> Any:
        """Return the result, or raise what the function raised."""
        if kind == "result":
            return value
        if kind == "no memory":
            raise KernelError(f"{self.what}: the CAD kernel needs more than {self._memory()}")
        if kind == "error":
            raise value
        fault = ChildFaultError(f"{self.what}: {value[0]}")
        fault.add_note(value[1])
        raise fault

    def _memory(self) -> str:
        return f"its limit of {self.limits.memory_gb:g} GB of memory; set {MEMORY_VARIABLE} to allow more"

    def _cause_of_death(self) -> str:
        """Say how the child ended."""
        code = self.process.wait()
        if self.is_late:
            return too_late(self.limits)
        return cause_of_death(code, step=self.step, noise=self.noise)


def too_late(limits: Limits) -> str:
    """Say that a child exceeded its time."""
    return f"stopped after {limits.time_s:g} s, its time limit; set {TIME_VARIABLE} to allow more"


def cause_of_death(code: int, *, step: str, noise: IO[bytes]) -> str:
    """Say how a child ended that sent no result.

    `code`: Its exit code; negative for a signal.
    `step`: The last progress message; empty if there was none.
    `noise`: Its standard error.
    """
    if code >= 0:
        return f"the process of the CAD kernel ended with code {code}: {last_line(noise)}"
    name = signal.Signals(-code).name
    if name in CRASH_SIGNALS:
        if not step or step.startswith(READING):
            return f"the CAD kernel cannot read this file: it crashed ({name})"
        return f"the CAD kernel cannot work with this file: it crashed ({name}) at the step: {step}"
    hint = "; the system may be out of memory" if name == "SIGKILL" else ""
    return f"the process of the CAD kernel was ended by {name}{hint}"


def last_line(noise: IO[bytes]) -> str:
    """Return the last line that a process printed; processes may share the place where the next byte goes."""
    size = os.fstat(noise.fileno()).st_size
    if hasattr(os, "pread"):
        last = os.pread(noise.fileno(), LAST_BYTES, max(0, size - LAST_BYTES))
    else:
        noise.seek(max(0, size - LAST_BYTES))
        last = noise.read()
    lines = last.decode("utf-8", errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "no message")
