# SPDX-License-Identifier: MIT
"""The client of `wpcal rpc`: a child process that answers requests while the window stays alive.

One JSON object per line in both directions. Nothing here waits except `Request.wait`, for scripts without a window.
"""

from __future__ import annotations

import json
import os
from typing import Any, Callable, Optional

import FreeCAD

from ..qt import QtCore, application, wait_until
from ..words import translate
from .environment import clean_environment
from .executable import Executable, find_executable, how_to_install
from .failure import Failure

PROTOCOL = 1  #: The version of the protocol that this workbench speaks.
STOP_MS = 2000  #: A process that was asked to end and still runs after this time is killed.
LAST_WORDS = 2000  #: Characters of the child's error output that are kept for the message when it ends.

Result = Callable[[Any], None]
Failed = Callable[[Failure], None]
Progress = Callable[[str, Optional[float]], None]


class Request:
    """One question to wpcal. It ends with exactly one result or one failure."""

    def __init__(
        self,
        client: Client,
        number: int,
        message: dict[str, Any],
        on_result: Result | None,
        on_failure: Failed | None,
        on_progress: Progress | None,
    ) -> None:
        self._client = client
        self.number = number
        self.message = message
        self._on_result = on_result
        self._on_failure = on_failure
        self._on_progress = on_progress
        self.is_done = False
        self.result: Any = None
        self.failure: Failure | None = None

    def cancel(self) -> None:
        """Ask wpcal to stop. The request then fails with the kind `Cancelled`, unless it was just answered."""
        self._client.cancel(self)

    def wait(self, seconds: float = 600.0) -> Any:
        """Wait for the answer and return the result. For scripts and tests; a window would freeze.

        Raises `RuntimeError` when the request failed, or was not answered in time.
        """
        wait_until(lambda: self.is_done, seconds)
        if not self.is_done:
            raise RuntimeError(f"wpcal did not answer {self.message['method']} in {seconds:g} s")
        if self.failure is not None:
            raise RuntimeError(f"{self.failure.kind}: {self.failure.text}")
        return self.result

    def progress(self, text: str, fraction: float | None) -> None:
        """Tell how far the work is; `fraction` is None if that is not known."""
        if self._on_progress is not None and not self.is_done:
            self._on_progress(text, fraction)

    def succeed(self, result: Any) -> None:
        """Take the result; later answers to this request are ignored."""
        if self._end():
            self.result = result
            if self._on_result is not None:
                self._on_result(result)

    def fail(self, failure: Failure) -> None:
        """Take the reason why there is no result."""
        if self._end():
            self.failure = failure
            if self._on_failure is not None:
                self._on_failure(failure)

    def _end(self) -> bool:
        if self.is_done:
            return False
        self.is_done = True
        return True


class Client:
    """A child process `wpcal rpc`. It is started by the first request, and again by the first one after a crash."""

    def __init__(self, find: Callable[[], Executable | None] = find_executable) -> None:
        self._find = find
        self._process: Any = None
        self._requests: dict[int, Request] = {}
        self._count = 0
        self._rest = b""
        self._last_words = ""
        self._refused: Failure | None = None
        #: How often a process was started. Parts that an earlier one had opened are not known to the present one.
        self.starts = 0
        self.version = ""  #: The version of wpcal, once it has answered.

    def call(
        self,
        method: str,
        params: dict[str, Any] | None = None,
        *,
        on_result: Result | None = None,
        on_failure: Failed | None = None,
        on_progress: Progress | None = None,
    ) -> Request:
        """Send a request. The callbacks are called later, by Qt's event loop."""
        self._count += 1
        message = {"id": self._count, "method": method, "params": params or {}}
        request = Request(self, self._count, message, on_result, on_failure, on_progress)
        refused = self._start()
        if refused is not None:
            application()
            QtCore.QTimer.singleShot(0, lambda: request.fail(refused))
            return request
        self._requests[request.number] = request
        self._send(message)
        return request

    def cancel(self, request: Request) -> None:
        """Ask the process to stop one request."""
        if request.number in self._requests and self._process is not None:
            self._count += 1
            self._send({"id": self._count, "method": "cancel", "params": {"id": request.number}})

    def stop(self) -> None:
        """End the process. Requests that are under way fail."""
        process, self._process = self._process, None
        if process is None:
            return
        process.blockSignals(True)
        process.closeWriteChannel()  # at the end of its input the process ends by itself
        if not process.waitForFinished(STOP_MS):
            process.kill()
            process.waitForFinished(STOP_MS)
        self._fail_all(Failure("stopped", translate("wpcal was stopped.")))

    @property
    def is_running(self) -> bool:
        """Whether there is a process."""
        return self._process is not None

    @property
    def process_id(self) -> int:
        """The number of the process; 0 if there is none."""
        return int(self._process.processId()) if self._process is not None else 0

    def _start(self) -> Failure | None:
        """Start a process if there is none; return why there cannot be one."""
        if self._process is not None:
            return None
        executable = self._find()
        if executable is None:
            return Failure("missing", how_to_install())
        application()
        process = QtCore.QProcess()
        environment = QtCore.QProcessEnvironment()
        for name, value in clean_environment(os.environ).items():
            environment.insert(name, value)
        process.setProcessEnvironment(environment)
        process.readyReadStandardOutput.connect(self._read)
        process.readyReadStandardError.connect(self._read_errors)
        process.finished.connect(lambda code, *_: self._ended(process, code))
        process.errorOccurred.connect(lambda error: self._not_started(process, executable, error))
        self._process, self._rest, self._last_words = process, b"", ""
        self.starts += 1
        self._refused = None
        process.start(executable.command[0], [*executable.command[1:], "rpc"])
        if self._process is None:  # on Windows the error comes at once
            return self._refused
        self._greet()
        return None

    def _greet(self) -> None:
        """Ask for the protocol first; another version than ours ends the process with a clear message."""
        self._count += 1
        message: dict[str, Any] = {"id": self._count, "method": "hello", "params": {}}
        self._requests[self._count] = Request(self, self._count, message, self._greeted, self._not_greeted, None)
        self._send(message)

    def _greeted(self, answer: Any) -> None:
        self.version = str(answer.get("wpcal", ""))
        if answer.get("protocol") != PROTOCOL:
            self._wrong_version(str(answer.get("protocol")))

    def _not_greeted(self, failure: Failure) -> None:
        if failure.kind not in ("missing", "stopped"):
            self._wrong_version(failure.message)

    def _wrong_version(self, theirs: str) -> None:
        text = translate("wpcal {version} does not speak protocol {ours} of this workbench ({theirs}). Update both.")
        failure = Failure("version", text.format(version=self.version, ours=PROTOCOL, theirs=theirs))
        self._fail_all(failure)
        self.stop()

    def _send(self, message: dict[str, Any]) -> None:
        self._process.write((json.dumps(message, allow_nan=False) + "\n").encode("utf-8"))

    def _read(self) -> None:
        if self._process is None:
            return
        *lines, self._rest = (self._rest + bytes(self._process.readAllStandardOutput())).split(b"\n")
        for line in lines:
            if line.strip():
                self._take(line)

    def _take(self, line: bytes) -> None:
        try:
            answer = json.loads(line.decode("utf-8"))
            request = self._requests.get(answer.get("id"))
        except (ValueError, AttributeError, TypeError):
            FreeCAD.Console.PrintWarning(f"wpcal: not an answer: {line[:200]!r}\n")
            return
        if request is None:  # the answer to a cancellation
            return
        if "progress" in answer:
            request.progress(*_progress(answer["progress"]))
            return
        del self._requests[request.number]
        if "error" in answer:
            error = dict(answer["error"])
            request.fail(Failure(error.pop("kind", "InternalError"), error.pop("message", ""), error))
        else:
            request.succeed(answer.get("result"))

    def _read_errors(self) -> None:
        if self._process is not None:
            text = bytes(self._process.readAllStandardError()).decode("utf-8", "replace")
            self._last_words = (self._last_words + text)[-LAST_WORDS:]

    def _ended(self, process: Any, code: int) -> None:
        if process is not self._process:
            return
        self._read()
        self._read_errors()
        self._process = None
        words = self._last_words.strip().splitlines()
        text = translate("wpcal stopped unexpectedly (exit code {code}{words}). The next action starts it again.")
        self._fail_all(Failure("stopped", text.format(code=code, words=f": {words[-1]}" if words else "")))

    def _not_started(self, process: Any, executable: Executable, error: Any) -> None:
        if process is not self._process or error != QtCore.QProcess.FailedToStart:
            return
        self._process = None
        text = translate("{command} ({origin}) cannot be started.")
        message = text.format(command=" ".join(executable.command), origin=executable.origin)
        self._refused = Failure("missing", f"{message}\n{how_to_install()}")
        self._fail_all(self._refused)

    def _fail_all(self, failure: Failure) -> None:
        requests, self._requests = list(self._requests.values()), {}
        for request in requests:
            request.fail(failure)


def _progress(record: dict[str, Any]) -> Any:
    """Return text and fraction of a progress line."""
    done, whole = record.get("done"), record.get("of")
    is_known = isinstance(done, (int, float)) and isinstance(whole, (int, float)) and whole > 0
    return str(record.get("text", "")), (done / whole if is_known else None)  # type: ignore[operator]
