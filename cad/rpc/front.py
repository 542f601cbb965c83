"""The front: answers a client, keeps its handles, and starts a worker again when one dies."""

from __future__ import annotations

import json
import os
import stat
import threading
import time
from collections import OrderedDict, deque
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from cad.rpc.client_lines import MOST_BYTES, LongLine, read_lines
from cad.rpc.kinds import ANSWER, BEGUN, CANCELLED, FINAL, KNOWN, PROGRESS
from cad.rpc.messages import PROTOCOL, Id, MessageFaultError, Request, error_line, read_request, result_line
from cad.rpc.protocol import HANDLE, check_request, method_names, takes_handle
from cad.rpc.worker_process import WorkerProcess
from cad.work.child import Limits, too_late
from wpcal.core.version import __version__
from wpcal.core.whole_folder import remove_left_by

MOST_WAITING = 1000
MOST_WAITING_BYTES = 64_000_000
AT_ONCE = ("hello", "cancel")  #: Methods that wait for no other request.
MOST_HANDLES = 100  #: A part more closes the handle that was not used for the longest time.
GRACE_S = 1.0  #: A cancelled request may clean up for as long as this. In the kernel it cannot.
LAST_S = 1.5  #: When the client is gone, a request that puts its files in place may go on for as long as this.
WATCHDOG_S = 1.7  #: This process ends this long after its client, also if nobody takes its answers.
PLACES = ("out", "table", "folder")  #: Params that say where a request writes.

Event = tuple[str, Any]


class ClientGoneError(Exception):
    """Nobody takes the answers."""


@dataclass(slots=True)
class Running:
    """The request that the worker does."""

    request: Request
    ends_at: float  #: Time limit, on the clock of `time.monotonic`.
    message: dict[str, Any]  #: What the worker gets.
    #: `is_cancelled`, `is_final`, `is_late`, `has_begun`, `is_again`: `is_final`: it puts its files in place, and a
    #: cancel comes too late. The last one: a worker died before it began; this is the second one.
    is_cancelled: bool = False
    is_final: bool = False
    is_late: bool = False
    has_begun: bool = False
    is_again: bool = False
    step: str = ""  #: The last line of progress.
    cancels: list[Id] = field(default_factory=list)  #: Requests to cancel it: answered when it has ended.


@dataclass(frozen=True, slots=True)
class Waiting:
    """A request that waits, and the size of its line."""

    request: Request
    size: int


class Front:
    """Answers a client on two file descriptors."""

    def __init__(self, requests: int, answers: int, limits: Limits | None = None) -> None:
        self._in, self._out = requests, answers
        self._limits = limits or Limits.from_environment()
        self._events: SimpleQueue[Event] = SimpleQueue()
        self._waiting: deque[Waiting] = deque()
        self._running: Running | None = None
        self._worker: WorkerProcess | None = None
        self._handles: OrderedDict[str, dict[str, Any]] = OrderedDict()
        self._opened = 0
        self._is_ending = False
        self._has_ended = threading.Event()
        self._room = threading.BoundedSemaphore(64)

    def run(self) -> int:
        """Answer until the client closes its end, or asks for the end. Return the exit code."""
        self._start_worker()
        threading.Thread(target=self._read, daemon=True).start()
        try:
            while not (self._is_ending and self._running is None and not self._waiting):
                self._handle(self._next_event())
        except ClientGoneError:
            pass
        finally:
            self._end()
            self._has_ended.set()
        return 0

    # What happens

    def _read(self) -> None:
        """Take lines of the client. A client that closes its end is gone, unless the requests are a file."""
        for line in read_lines(self._in):
            self._room.acquire()
            self._events.put(("line", line))
        if stat.S_ISREG(os.fstat(self._in).st_mode):
            self._events.put(("last", None))
            return
        self._events.put(("gone", None))
        if self._has_ended.wait(WATCHDOG_S):
            return
        if self._worker is not None:  # the main thread waits for somebody who takes an answer
            self._worker.kill()
        os._exit(0)

    def _next_event(self) -> Event:
        running = self._running
        if running is None:
            return self._events.get()
        try:
            return self._events.get(timeout=max(0.0, running.ends_at - time.monotonic()))
        except Empty:
            return "late", running

    def _handle(self, event: Event) -> None:
        kind, value = event
        if kind == "line":
            self._room.release()
            self._take_line(value)
        elif kind == "worker":
            self._hear(*value)
        elif kind == "late":
            value.is_late = not value.is_cancelled
            value.ends_at = time.monotonic() + self._limits.time_s
            if self._worker is not None:
                self._worker.kill()
        elif kind == "last":
            self._is_ending = True
        else:
            raise ClientGoneError
        self._start_next()

    # Lines of the client

    def _take_line(self, line: bytes | LongLine) -> None:
        if not isinstance(line, LongLine) and not line.strip():
            return
        try:
            request, size = self._read_line(line)
        except MessageFaultError as fault:
            self._write(error_line(fault.id, fault.kind, str(fault)))
            return
        if request.method == "hello":
            answer = {"wpcal": __version__, "protocol": PROTOCOL, "methods": list(method_names())}
            self._write(result_line(request.id, answer))
        elif request.method == "cancel":
            self._cancel(request.id, request.params["id"])
        else:
            self._waiting.append(Waiting(request, size))

    def _read_line(self, line: bytes | LongLine) -> tuple[Request, int]:
        """Return the request on a line, and the size of the line.

        Raises `MessageFaultError` if it is none, or cannot be taken now.
        """
        if isinstance(line, LongLine):
            what = f"the line has more than {MOST_BYTES // 10**6} MB; write large data to a file and send its path"
            raise MessageFaultError(what)
        request = read_request(line)
        if self._is_known(request.id):
            what = f"the id {request.id!r} belongs to a request that is not answered yet; that one goes on"
            raise MessageFaultError(what)
        check_request(request)
        is_full = len(self._waiting) >= MOST_WAITING or sum(each.size for each in self._waiting) > MOST_WAITING_BYTES
        if is_full and request.method not in AT_ONCE:
            raise MessageFaultError("too many requests wait; read the answers", id=request.id)
        return request, len(line)

    def _is_known(self, request_id: Id) -> bool:
        running = self._running
        is_running = running is not None and request_id in (running.request.id, *running.cancels)
        return is_running or any(each.request.id == request_id for each in self._waiting)

    def _cancel(self, asked_by: Id, request_id: Id) -> None:
        """Cancel a request. The answer of one that runs waits for its end: only then it is known."""
        running = self._running
        if running is not None and running.request.id == request_id:
            running.cancels.append(asked_by)
            if not (running.is_cancelled or running.is_final) and self._worker is not None:
                running.is_cancelled, running.ends_at = True, time.monotonic() + GRACE_S
                self._worker.send({"cancel": request_id})
            return
        found = next((each for each in self._waiting if each.request.id == request_id), None)
        if found is not None:
            self._waiting.remove(found)
            self._write(error_line(request_id, "Cancelled", "the request was cancelled before it began"))
        self._write(result_line(asked_by, {"cancelled": found is not None}))

    def _answer(self, line: bytes, *, is_cancelled: bool = False) -> None:
        """Answer the request that ran, and those that asked to cancel it."""
        running, self._running = self._running, None
        self._write(line)
        for asked_by in () if running is None else running.cancels:
            self._write(result_line(asked_by, {"cancelled": is_cancelled}))

    # Requests in their turn

    def _start_next(self) -> None:
        while self._running is None and self._waiting:
            request = self._waiting.popleft().request
            here = {"shutdown": self._shut_down, "close": self._close}.get(request.method)
            if here is not None:
                here(request)
            else:
                self._start(request)

    def _shut_down(self, request: Request) -> None:
        for each in self._waiting:
            self._write(error_line(each.request.id, "Cancelled", "the session was shut down"))
        self._waiting.clear()
        self._write(result_line(request.id, {}))
        self._is_ending = True

    def _close(self, request: Request) -> None:
        handle = request.params[HANDLE]
        if self._handles.pop(handle, None) is None:
            return self._refuse_handle(request)
        if self._worker is not None:
            self._worker.send({"drop": [handle]})
        return self._write(result_line(request.id, {}))

    def _refuse_handle(self, request: Request) -> None:
        handle = request.params[HANDLE]
        what = f"there is no open part {handle!r}: it was closed, or never opened; open the file again"
        self._write(error_line(request.id, "UnknownHandle", what))

    def _start(self, request: Request) -> None:
        """Give a request to the worker, with what it needs to know of its part."""
        message: dict[str, Any] = {"id": request.id, "method": request.method, "params": request.params}
        if request.method == "open":
            self._opened += 1
            path = os.path.abspath(request.params["path"])
            message["part"] = {HANDLE: f"p{self._opened}", "path": path, "sha256": None}
        elif takes_handle(request.method):
            handle = request.params[HANDLE]
            if handle not in self._handles:
                return self._refuse_handle(request)
            self._handles.move_to_end(handle)
            message["part"] = self._handles[handle]
        worker = self._worker or self._start_worker()
        self._running = Running(request, time.monotonic() + self._limits.time_s, message)
        return worker.send(message)

    # The worker

    def _start_worker(self) -> WorkerProcess:
        def heard(worker: WorkerProcess, line: bytes) -> None:
            self._events.put(("worker", (worker, line)))

        self._worker = WorkerProcess(self._limits, heard)
        return self._worker

    def _hear(self, worker: WorkerProcess, line: bytes) -> None:
        if worker is not self._worker:
            return
        kind, rest, running = line[:1], line[1:], self._running
        if not line:
            self._bury(worker)
        elif kind == KNOWN:
            self._keep(json.loads(rest))
        elif running is None:
            return
        elif kind == BEGUN:
            running.has_begun = True
        elif kind == PROGRESS:
            running.step = json.loads(rest)["progress"]["text"]
            self._write(rest)
        elif kind == FINAL:
            running.is_final = True
            if running.is_cancelled:  # it came too late
                running.is_cancelled, running.ends_at = False, time.monotonic() + self._limits.time_s
        elif kind in (ANSWER, CANCELLED):
            self._answer(rest, is_cancelled=kind == CANCELLED)

    def _keep(self, part: dict[str, Any]) -> None:
        self._handles[part[HANDLE]] = part
        self._handles.move_to_end(part[HANDLE])
        while len(self._handles) > MOST_HANDLES:
            self._handles.popitem(last=False)

    def _bury(self, worker: WorkerProcess) -> None:
        """Answer the request of a worker that ended, and start another worker; handles stay valid."""
        running, self._worker = self._running, None
        why = worker.end(step="" if running is None else running.step)
        if running is None:
            return
        self._clean_up(worker, running)
        fresh = self._start_worker()
        if not (running.has_begun or running.is_again or running.is_cancelled):
            running.is_again = True
            fresh.send(running.message)
            return
        request_id = running.request.id
        if running.is_cancelled:
            self._answer(error_line(request_id, "Cancelled", "the request was cancelled"), is_cancelled=True)
        elif running.is_late:
            self._answer(error_line(request_id, "KernelError", too_late(self._limits), code="kernel"))
        else:
            self._answer(error_line(request_id, "KernelCrash", why, code="kernel"))

    @staticmethod
    def _clean_up(worker: WorkerProcess, running: Running) -> None:
        """Remove what a worker that was killed began to write."""
        params = running.request.params
        remove_left_by(worker.number, *(Path(params[name]) for name in PLACES if params.get(name)))

    def _write(self, line: bytes) -> None:
        rest = memoryview(line)
        try:
            while rest:
                rest = rest[os.write(self._out, rest) :]
        except OSError:
            raise ClientGoneError from None

    def _end(self) -> None:
        """Answer what is not answered yet, if somebody takes it, and end the worker."""
        worker, running = self._worker, self._running
        with suppress(ClientGoneError):
            if worker is not None and running is not None:
                self._end_request(worker, running)
            for each in self._waiting:
                self._write(error_line(each.request.id, "Cancelled", "the session ended before the request began"))
        if worker is not None:
            worker.end()
            if running is not None:
                self._clean_up(worker, running)

    def _end_request(self, worker: WorkerProcess, running: Running) -> None:
        """Cancel the request that runs, and let it clean up; one that puts its files in place is finished."""
        begin = time.monotonic()
        if not (running.is_cancelled or running.is_final):
            running.is_cancelled = True
            worker.send({"cancel": running.request.id})
        while self._running is not None:
            left = begin + (LAST_S if running.is_final else GRACE_S) - time.monotonic()
            try:
                kind, value = self._events.get(timeout=max(0.0, left))
            except Empty:
                break
            if kind == "worker" and value[1]:
                self._hear(*value)
            elif kind == "worker":
                break
        if self._running is not None:
            worker.kill()
            self._answer(error_line(running.request.id, "Cancelled", "the session ended"))


def answer_client() -> int:
    """Run a front on standard input and output. What libraries print goes to standard error.

    Raises `InputError` if the environment states a limit that is not one.
    """
    requests, answers = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    os.close(nothing)
    try:
        return Front(requests, answers).run()
    finally:
        os.dup2(requests, 0)
        os.dup2(answers, 1)
