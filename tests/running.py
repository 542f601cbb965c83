"""Two ways to run `wpcal` in a test: in this process, which is quick, and in one of its own, as a user does."""

import io
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

import psutil
import pytest

from cad.work.plain_data import pack, unpack
from tests.record_checks import check_output
from wpcal.cli.main import run

FINISHED = (0, 1)  #: Exit codes of a command that wrote its results: within the tolerance, or not.
TIMEOUT_S = 300  #: Of a command in a process: far above the slowest test.

needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
"""Mark of a test that looks at processes: a container may have no /proc."""

AnyEnded = TypeVar("AnyEnded", "Ended", "subprocess.CompletedProcess[str]")


def children_of(process: int) -> list[int]:
    """Return the processes that a process started; none if it has ended."""
    try:
        return [child.pid for child in psutil.Process(process).children()]
    except psutil.NoSuchProcess:
        return []


def are_gone(*processes: int, within_s: float) -> bool:
    """Whether processes end within a time; a zombie has ended."""
    until = time.monotonic() + within_s
    while (found := any(map(_lives, processes))) and time.monotonic() < until:
        time.sleep(0.005)
    return not found


def _lives(process: int) -> bool:
    try:
        return bool(psutil.Process(process).status() != psutil.STATUS_ZOMBIE)
    except psutil.NoSuchProcess:
        return False


@dataclass(frozen=True, slots=True)
class Ended:
    """How a command ended; the fields are those of `subprocess.CompletedProcess`."""

    returncode: int | str | None
    stdout: str
    stderr: str


def run_here(*arguments: Path | str, cwd: Path | None = None) -> Ended:
    """Run a command in this process. Work with the CAD kernel still runs in a child process of its own."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err), chdir(cwd or Path()):
        try:
            run([str(argument) for argument in arguments])
        except SystemExit as ended:
            return _checked(Ended(ended.code, out.getvalue(), err.getvalue()), arguments)
    raise AssertionError("wpcal did not end by sys.exit")


def run_command(
    *command: Path | str, cwd: Path | None = None, timeout_s: float = TIMEOUT_S, **more: str
) -> subprocess.CompletedProcess[str]:
    """Run any command in a new process, whose environment has more variables."""
    environment = {**os.environ, **more}
    return subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=cwd, env=environment, timeout=timeout_s
    )


def run_process(*arguments: Path | str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command in a new process: its exit code and its streams are those that a shell sees."""
    return _checked(run_command(sys.executable, "-m", "wpcal", *map(str, arguments), cwd=cwd), arguments, cwd=cwd)


def _checked(done: AnyEnded, arguments: Sequence[Path | str], *, cwd: Path | None = None) -> AnyEnded:
    """Return how a command ended; the records that it wrote must follow their schemas."""
    if done.returncode in FINISHED:
        check_output(arguments, done.stdout, cwd=cwd or Path())
    return done


def kernel_work_here(target: str, arguments: Mapping[str, Any], *, progress: Any = None, **_: Any) -> Any:
    """Do the work of `cad.work.child.run_in_child` in this process, where the kernel is loaded once for all tests.

    What goes to the kernel's process and comes back is copied as on the way there.
    """
    module, _, function = target.partition(":")
    given = unpack(pack(dict(arguments)))
    if progress is not None:
        given["progress"] = progress
    return unpack(pack(getattr(import_module(module), function)(**given)))
