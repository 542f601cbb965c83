"""The worker as the front sees it: a process that takes requests and sends lines, and may die."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from cad.work.child import MEMORY_VARIABLE, Limits, cause_of_death, start_python

Heard = Callable[["WorkerProcess", bytes], None]
"""Gets every line of a worker, and an empty one at its end."""


class WorkerProcess:
    """A running worker. It ends when this process ends."""

    def __init__(self, limits: Limits, heard: Heard) -> None:
        self._noise = tempfile.TemporaryFile()  # noqa: SIM115  # closed by `end`
        lifeline, self._life = os.pipe()
        passed = (lifeline,) if os.name == "posix" else ()
        self._process = start_python(
            "cad.rpc.worker",
            lifeline if passed else -1,
            environment={MEMORY_VARIABLE: repr(limits.memory_gb)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=None if os.environ.get("WPCAL_DEBUG") else self._noise,
            pass_fds=passed,
        )
        os.close(lifeline)
        threading.Thread(target=self._listen, args=(heard,), daemon=True).start()

    def _listen(self, heard: Heard) -> None:
        if self._process.stdout is not None:
            for line in self._process.stdout:
                if line.endswith(b"\n"):
                    heard(self, line)
        heard(self, b"")

    @property
    def number(self) -> int:
        """Number of the process."""
        return self._process.pid

    def send(self, message: dict[str, Any]) -> None:
        """Give a message to the worker; a dead one takes nothing, and its end is heard."""
        with suppress(OSError):
            if self._process.stdin is not None:
                self._process.stdin.write(json.dumps(message).encode("ascii") + b"\n")
                self._process.stdin.flush()

    def kill(self) -> None:
        """End the process now; its end is heard."""
        self._process.kill()

    def end(self, *, step: str = "") -> str:
        """Wait for the end of a process that was killed or died, and say how it ended."""
        self._process.kill()
        code = self._process.wait()
        why = cause_of_death(code, step=step, noise=self._noise)
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                if pipe is not None:
                    pipe.close()
        os.close(self._life)
        self._noise.close()
        return why
