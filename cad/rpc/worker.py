"""The worker: holds the opened parts and does what the methods say; not meant to be run by hand.

``python -P -m cad.rpc.worker PARENT LIFELINE`` takes requests as lines from standard input, one after another, and
sends lines over what was standard output. The first byte of a line says what it is (`cad.rpc.kinds`). Whatever
libraries print goes to standard error. It ends when its parent ends, which is arranged before anything large is
imported.
"""

from __future__ import annotations

import _thread
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from queue import SimpleQueue
from types import FrameType
from typing import IO, Any

from cad.rpc.kinds import ANSWER, BEGUN, CANCELLED, FINAL, KNOWN, PROGRESS
from cad.work.own_process import end_at_end_of, end_with_parent, has_death_signal, limit_memory, private_output

WARM = (
    "cad.rpc.part_methods",
    "cad.step.read",
    "cad.kernel.to_brep",
    "cad.kernel.section",
    "wpcal.touch.design",
    "wpcal.brep.extend",
    "scipy.optimize",
    "scipy.spatial",
)
"""Imported before the first request comes."""
AGAIN_S = 0.05  #: A request is not interrupted in the middle of an import; this is the time until the next try.
LEAST_BETWEEN_S = 0.05  #: Between two lines of progress about the same step.


class RequestCancelledError(BaseException):
    """The client cancelled the request that runs."""


class Worker:
    """Answers requests one after another."""

    def __init__(self, requests: int, channel: IO[bytes]) -> None:
        self._requests, self._channel = requests, channel
        self._queue: SimpleQueue[dict[str, Any]] = SimpleQueue()
        self._running: Any = None
        self._cancelled: Any = None
        self._is_sending = False

    def run(self) -> None:
        """Answer until the parent closes its end."""
        signal.signal(signal.SIGINT, self._interrupted)
        threading.Thread(target=self._read, daemon=True).start()
        for module in WARM:
            import_module(module)
        from cad.rpc.open_parts import OpenParts
        from wpcal.core.whole_folder import call_before_replacing

        call_before_replacing(self._be_final)
        parts = OpenParts()
        while True:
            message = self._queue.get()
            if "drop" in message:
                parts.drop(message["drop"])
                continue
            self._send(BEGUN, b"\n")
            self._send(*self._answer(message, parts))

    def _read(self) -> None:
        """Take lines from the parent; a cancelled request is interrupted in the main thread."""
        with os.fdopen(self._requests, "rb") as pipe:
            for line in pipe:
                message = json.loads(line)
                if "cancel" in message:
                    self._cancelled = message["cancel"]
                    _thread.interrupt_main()
                else:
                    self._queue.put(message)
        os._exit(0)

    def _interrupted(self, _: int, frame: FrameType | None) -> None:
        """Raise in the request that was cancelled, but not while it sends a line or imports a module.

        Half a line would spoil the next one, and a module that is half imported could not be imported again.
        """
        if self._running is None or self._cancelled != self._running:
            return
        if not (self._is_sending or _is_importing(frame)):
            raise RequestCancelledError
        again = threading.Timer(AGAIN_S, _thread.interrupt_main)
        again.daemon = True
        again.start()

    def _be_final(self) -> None:
        """Tell the front that files are put in place now: from here on the request is not interrupted any more."""
        running, self._running = self._running, None
        if running is not None:
            self._send(FINAL, b"\n")

    def _send(self, kind: bytes, line: bytes) -> None:
        self._is_sending = True
        self._channel.write(kind + line)
        self._channel.flush()
        self._is_sending = False

    def _answer(self, message: dict[str, Any], parts: Any) -> tuple[bytes, bytes]:
        """Return the kind of line that answers a request, and the line."""
        from cad.rpc.faults import fault_line_of
        from cad.rpc.messages import error_line, result_line

        request_id = message["id"]
        try:
            try:
                self._running = request_id
                result = self._do(message, parts)
                line = result_line(request_id, result)
                self._running = None
            finally:
                self._running = None
        except RequestCancelledError:
            return CANCELLED, error_line(request_id, "Cancelled", "the request was cancelled")
        except Exception as error:  # the outermost handler of this process: the client must learn of every exception
            return ANSWER, fault_line_of(request_id, error, message)
        return ANSWER, line

    def _do(self, message: dict[str, Any], parts: Any) -> dict[str, Any]:
        from cad.rpc import command_methods, part_methods
        from cad.rpc.warm_answers import WarmAnswers
        from cad.work.system_libraries import libgl_explained
        from cad.workpiece.answer_cache import kernel_in_this_process, user_cache
        from wpcal.cli.progress import progress_told_to

        method, params, progress = message["method"], message["params"], self._progress(message["id"])
        known = message.get("part")
        with libgl_explained(), progress_told_to(progress):
            if known is None:
                with kernel_in_this_process(WarmAnswers.before(user_cache())):
                    return command_methods.METHODS[method](params)
            part = parts.get(known["handle"], Path(known["path"]), progress)
            reread = known["sha256"] not in (None, part.sha256)
            told = json.dumps({"handle": known["handle"], "path": known["path"], "sha256": part.sha256})
            self._send(KNOWN, told.encode("ascii") + b"\n")
            with kernel_in_this_process(part.answers):
                if method in part_methods.METHODS:
                    found = part_methods.METHODS[method](part, params, progress)
                else:
                    found = command_methods.METHODS[method]({**params, "path": known["path"]})
        return {"handle": known["handle"], "sha256": part.sha256, "reread": reread, **found}

    def _progress(self, request_id: Any) -> Callable[[str], None]:
        """Return what sends lines of progress. A step that counts is told now and then."""
        from cad.rpc.messages import progress_line

        last_step, last_at = "", 0.0

        def tell(text: str) -> None:
            nonlocal last_step, last_at
            step, now = text.rstrip("0123456789 of"), time.monotonic()
            if step != last_step or now - last_at >= LEAST_BETWEEN_S:
                last_step, last_at = step, now
                self._send(PROGRESS, progress_line(request_id, text))

        return tell


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def main() -> None:
    """Take requests until the parent ends."""
    parent, lifeline = int(sys.argv[1]), int(sys.argv[2])
    end_with_parent(parent)
    if not has_death_signal() and lifeline >= 0:
        end_at_end_of(lifeline)
    requests = os.dup(0)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    channel = private_output()
    from cad.work.child import Limits
    from wpcal.core.process import collect_rarely

    limit_memory(Limits.from_environment().memory_gb)
    collect_rarely()
    with suppress(BrokenPipeError):
        Worker(requests, channel).run()
    os._exit(0)  # the kernel's own shutdown can crash


if __name__ == "__main__":
    main()
