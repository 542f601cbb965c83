"""Calls of functions on the workers of a Dask scheduler, and what becomes of them if a worker is lost.

The command decides which worker gets which call, so that no worker waits while another has much to do. If a worker is
lost, the scheduler gives its calls to others.
"""

from __future__ import annotations

import logging
import queue
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

from wpcal.core.dask.same_code import OtherVersionError, checked_call, require_same, versions_here
from wpcal.core.errors import InputError
from wpcal.core.wording import shown

CONNECT_S = 8.0  #: A scheduler answers within a fraction of a second.
LOOK_S = 1.0  #: So often the command looks which workers there are.
NO_WORKERS_S = 20.0
"""The command waits this long while there is no worker: Dask starts one that ended again within a few seconds."""
END_S = 5.0  #: Within this time the connection is closed, or it is given up.
_ADDRESS = re.compile(r"(tcp|tls)://[^\s/]+:\d{1,5}")
_LOGGERS = ("distributed", "tornado", "asyncio")
"""Their messages are about connections; wpcal says in one line what the user can do."""


@dataclass(frozen=True, slots=True)
class Call:
    """A function that a worker is to call."""

    tag: Any  #: What the call is for; it comes back with its value.
    function: Callable[..., Any]  #: At the top level of a module.
    arguments: tuple[Any, ...]  #: Values, or what `Cluster.shared` returned.


@dataclass(frozen=True, slots=True)
class CallFailed:
    """In place of a value: why there is none, in one line."""

    message: str


@dataclass(slots=True)
class _Worker:
    threads: int
    running: int = 0

    @property
    def is_free(self) -> bool:
        """Whether it may get a call: some more than it has threads, so that none waits for the next one."""
        return self.running < self.threads + max(1, self.threads // 4)


@dataclass(frozen=True, slots=True)
class _Running:
    call: Call
    worker: str
    future: Any


class Cluster:
    """The workers of a scheduler, while a block runs.

    `address`: Of the scheduler: ``tcp://host:port``, or ``tls://host:port`` with the certificates of Dask's
    configuration.
    Raises `InputError` in all methods: when Dask is not installed, no scheduler answers or it is gone, there is no
    worker, or a worker would compute other bytes.
    """

    def __init__(self, address: str) -> None:
        if not _ADDRESS.fullmatch(address):
            raise InputError(f"{shown(address)} is not the address of a Dask scheduler; expected tcp://host:port")
        self._address = address
        self._client: Any = None
        self._versions = versions_here()
        self._workers: dict[str, _Worker] = {}
        self._running: dict[str, _Running] = {}
        self._ended: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._at_end: list[tuple[Callable[..., Any], tuple[Any, ...]]] = []
        self._looked_at = self._seen_at = 0.0

    def __enter__(self) -> Self:
        try:
            self.start()
        except BaseException:
            self.end()
            raise
        return self

    def start(self) -> None:
        """Connect, and wait for a worker. `end` must follow, also if this raises."""
        try:
            import dask
            import distributed
        except ImportError as error:
            raise InputError(f"--dask needs the package distributed ({error}): pip install 'wpcal[dask]'") from None
        for name in [*logging.root.manager.loggerDict]:
            if name.partition(".")[0] in _LOGGERS:
                logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        dask.config.set({"distributed.comm.timeouts.connect": CONNECT_S})
        try:
            _require_scheduler_at(self._address)
            self._client = distributed.Client(
                self._address, timeout=CONNECT_S, set_as_default=False, direct_to_workers=True
            )
        except Exception as error:  # whatever answers at this address: each library of Dask has its own exceptions
            raise InputError(
                f"no Dask scheduler answers at {self._address} ({_first_line(error)}); start one with: dask scheduler"
            ) from None
        self._seen_at = time.monotonic()
        while not self._workers:
            self._look()
            if not self._workers:
                time.sleep(LOOK_S / 5)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.end()

    def shared(self, content: bytes) -> Any:
        """Send content once, for many calls: workers take it from one another. It is kept while the answer is kept."""
        with self._one_line():
            return self._client.submit(bytes, content, pure=False)

    def results(self, next_call: Callable[[str], Call | None]) -> Iterator[tuple[Any, Any]]:
        """Yield the tag and the value of every call, in the order in which they end.

        The value is a `CallFailed` if the call raised, or too many workers were lost with it.
        """
        while True:
            self._place(next_call)
            if not self._running:
                return
            yield from self._wait()

    def at_end(self, function: Callable[..., Any], *arguments: Any) -> None:
        """Let all workers that can then be reached call a function at the end, however that comes."""
        self._at_end.append((function, arguments))

    def end(self) -> None:
        """Give up what runs, and close the connection."""
        self._running.clear()  # what no worker has begun is not begun any more
        if self._client is None:
            return
        with suppress(Exception):  # workers may be gone, and so may the scheduler
            for function, arguments in self._at_end if self._client.status == "running" else ():
                self._client.run(function, *arguments, on_error="ignore")
        with suppress(Exception):
            self._client.close(timeout=END_S)

    def _place(self, next_call: Callable[[str], Call | None]) -> None:
        """Give calls to the workers that are free, one to each in turn."""
        is_over = False
        while not is_over:
            free = sorted(
                (worker.running / worker.threads, name) for name, worker in self._workers.items() if worker.is_free
            )
            is_over = True
            for _, name in free:
                call = next_call(name)
                if call is not None:
                    self._submit(call, name)
                    is_over = False

    def _submit(self, call: Call, worker: str) -> None:
        with self._one_line():
            future = self._client.submit(
                checked_call, self._versions, call.function, *call.arguments,
                workers=[worker], allow_other_workers=True, pure=False,
            )  # fmt: skip
        self._running[future.key] = _Running(call, worker, future)
        self._workers[worker].running += 1
        future.add_done_callback(lambda done: self._ended.put(done.key))

    def _wait(self) -> Iterator[tuple[Any, Any]]:
        """Wait until calls end, or it is time to look after the workers."""
        keys = []
        with suppress(queue.Empty):
            keys.append(self._ended.get(timeout=max(0.0, self._looked_at + LOOK_S - time.monotonic())))
            while True:
                keys.append(self._ended.get_nowait())
        for key in keys:
            ended = self._running.pop(key)
            if ended.worker in self._workers:
                self._workers[ended.worker].running -= 1
            yield ended.call.tag, self._value(ended)
        if time.monotonic() >= self._looked_at + LOOK_S:
            self._look()

    def _value(self, ended: _Running) -> Any:
        self._require_scheduler()
        if ended.future.status == "error":
            error = ended.future.exception()
            if isinstance(error, OtherVersionError):
                raise InputError(f"{error}; install the same versions on all machines")
            return CallFailed(f"on worker {ended.worker}: {_first_line(error)}")
        with self._one_line():
            return ended.future.result()

    def _look(self) -> None:
        """Find out which workers there are; new ones must have the same versions."""
        self._require_scheduler()
        with self._one_line():
            threads: dict[str, int] = self._client.nthreads()
            new = [name for name in threads if name not in self._workers]
            found = self._client.run(versions_here, workers=new, on_error="return") if new else {}
        for name, versions in found.items():
            if isinstance(versions, OSError):  # it is gone again
                threads.pop(name, None)
            else:
                require_same(self._versions, versions, name)
        self._workers = {name: self._workers.get(name, _Worker(count)) for name, count in threads.items()}
        self._looked_at = time.monotonic()
        if self._workers:
            self._seen_at = self._looked_at
        elif self._looked_at - self._seen_at > NO_WORKERS_S:
            raise InputError(
                f"the Dask scheduler {self._address} has no workers; start one on every machine with: "
                f"dask worker {self._address}"
            )

    def _require_scheduler(self) -> None:
        if self._client.status != "running":
            raise InputError(f"the Dask scheduler {self._address} is gone; start it and its workers again")

    @contextmanager
    def _one_line(self) -> Iterator[None]:
        """Turn what the connection raises into one line."""
        from concurrent.futures import CancelledError

        try:
            yield
        except (OSError, RuntimeError, TimeoutError, CancelledError) as error:
            self._require_scheduler()
            raise InputError(f"the Dask scheduler {self._address} does not answer ({_first_line(error)})") from None


def _require_scheduler_at(address: str) -> None:
    """Refuse an address where something else listens: the client of Dask would wait for it without end."""
    import asyncio
    from concurrent.futures import ThreadPoolExecutor

    from distributed.core import rpc
    from distributed.security import Security

    async def ask() -> Any:
        settings = Security().get_connection_args("client")
        async with rpc(address, timeout=CONNECT_S, connection_args=settings) as there:
            return await there.identity()

    with ThreadPoolExecutor(1) as thread:  # in this one a loop may run: a notebook, for example
        kind = thread.submit(lambda: asyncio.run(asyncio.wait_for(ask(), CONNECT_S))).result()["type"]
    if kind != "Scheduler":
        raise ValueError(f"a {str(kind).lower()} of Dask is there")


def _first_line(error: BaseException) -> str:
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
