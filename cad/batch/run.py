"""Run a batch: which process does which job, and what becomes of a process that dies."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections import deque
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import Any

from cad.work.group import GroupRequest
from cad.work.host import Event, EventKind, Failure, Host
from wpcal.core.errors import InputError
from wpcal.core.records import check_writable
from wpcal.core.whole_folder import FolderLock, lock_taken

WORK_MARK = ".wpcal-batch-"  #: Start of the name of the folder for unfinished work, in the output folder.
NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG})
"""After one of these errors every other job would fail for the same reason."""
MOST_TRIES = 2  #: A job or a group whose process somebody else killed is tried once more.
WAIT_FOR_LOCK_S, STEP_S = 3.0, 0.05
"""The processes of a batch that was killed end within this time, and hold its lock until then."""


@dataclass(frozen=True, slots=True)
class Task:
    """A job as its process gets it."""

    number: int
    group: Hashable  #: Jobs of the same group share what is found in their part.
    arguments: dict[str, Any]  #: Keyword arguments of the function that runs it, plain data.


@dataclass(slots=True, eq=False)
class _Group:
    """The jobs of a group that are to be run."""

    key: Hashable
    number: int
    request: GroupRequest
    waiting: deque[Task] = field(default_factory=deque)
    running: dict[int, Task] = field(default_factory=dict)
    is_open: bool = False
    is_opening: bool = False
    tries: int = 0

    @property
    def is_idle(self) -> bool:
        """Whether it could run a job and has none."""
        return self.is_open and not self.waiting and not self.running


@contextmanager
def locked_output(out: Path, *, overwrite: bool) -> Iterator[tuple[int, Path]]:
    """Make the output folder, and hold its lock; yield its descriptor and a folder for unfinished work.

    The folder for unfinished work does not exist yet.

    Raises `InputError` when the folder cannot be made or written, or holds files, or another batch writes into it.
    """
    check_writable(out, overwrite=True)
    is_new = not out.exists()
    try:
        out.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(out, os.O_RDONLY)
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {(error.strerror or str(error)).lower()}") from None
    work = out / f"{WORK_MARK}{secrets.token_hex(4)}"
    try:
        if lock_taken(descriptor, WAIT_FOR_LOCK_S, STEP_S) is FolderLock.ANOTHERS:
            raise InputError(f"{out}: another run is writing into it now; wait for its end")
        for left in out.glob(f"{WORK_MARK}*"):
            shutil.rmtree(left, ignore_errors=True)
        if not overwrite and any(out.iterdir()):
            raise InputError(
                f"{out}: exists and is not empty; continue its batch with --resume, or choose another folder"
            )
        yield descriptor, work.resolve()
    finally:
        shutil.rmtree(work, ignore_errors=True)
        os.close(descriptor)
        if is_new:
            with_nothing(out)


def with_nothing(out: Path) -> None:
    """Remove a folder that holds nothing."""
    try:
        out.rmdir()
    except OSError:
        return


def run_tasks(
    tasks: Sequence[Task],
    requests: dict[Hashable, GroupRequest],
    host: Host,
    *,
    at_once: int,
    done: Callable[[Task, Any], None],
) -> None:
    """Run jobs, this many at once, in the order of the list within each group.

    Raises `InputError` when the disk is full or read-only: no other job could write its results.
    Raises `ServerEndedError` when somebody killed the process from which jobs are forked.
    """

    def ended(task: Task, value: Any) -> None:
        require_room(value)
        done(task, value)

    jobs = Jobs(host, at_once=at_once, done=ended)
    for task in tasks:
        jobs.add(task, requests[task.group])
    while jobs.has_groups:
        jobs.step()


def require_room(value: Any) -> None:
    """Refuse what became of a job if no other job could write its results either.

    Raises `InputError` when the disk is full or read-only.
    """
    if isinstance(value, Failure) and value.errno in NO_ROOM:
        raise InputError(value.message)


class Jobs:
    """Jobs that are run, this many at once, and what becomes of a process that dies."""

    def __init__(self, host: Host, *, at_once: int, done: Callable[[Task, Any], None], kept_open: int = 0) -> None:
        self._host, self._at_once, self._done, self._kept_open = host, at_once, done, kept_open
        self._of_key: dict[Hashable, _Group] = {}
        self._groups: dict[int, _Group] = {}
        self._numbers = count()
        self._pending: deque[_Group] = deque()
        self._open: list[_Group] = []
        self._killed: set[int] = set()

    @property
    def has_groups(self) -> bool:
        """Whether a group is open, or is still to be opened."""
        return bool(self._pending or self._open)

    def add(self, task: Task, request: GroupRequest) -> None:
        """Run a job as soon as there is a process for it; `request` opens its group if it is not open."""
        group = self._of_key.get(task.group)
        if group is None:
            group = _Group(task.group, next(self._numbers), request)
            self._of_key[task.group] = self._groups[group.number] = group
            self._pending.append(group)
        group.waiting.append(task)

    def step(self, wake: int | None = None) -> None:
        """Start what can be started, then wait until something happens, or something can be read from `wake`."""
        self._start()
        for event in self._host.wait(wake):
            if event.group in self._groups:
                self._heard(self._groups[event.group], event)

    def end_groups(self, is_over: Callable[[Hashable], bool]) -> None:
        """End the groups whose key fulfils a condition. Their jobs end as killed."""
        for group in [each for key, each in self._of_key.items() if is_over(key)]:
            if group in self._open:
                self._host.close_group(group.number)
            self._fail(group, Failure("was given up", killed=True))

    @property
    def _busy(self) -> int:
        return sum(len(group.running) + group.is_opening for group in self._open)

    def _start(self) -> None:
        """Give work to as many processes as may work."""
        for _ in range(self._at_once - self._busy):
            ready = next((group for group in self._open if group.is_open and group.waiting), None)
            if ready is not None:
                task = ready.waiting.popleft()
                ready.running[task.number] = task
                self._host.run(ready.number, task.number, task.arguments)
            elif self._pending:
                self._open_group(self._pending.popleft())

    def _open_group(self, group: _Group) -> None:
        group.is_opening, group.is_open, group.tries = True, False, group.tries + 1
        self._open.append(group)
        self._host.open_group(group.number, group.request)

    def _heard(self, group: _Group, event: Event) -> None:
        if group not in self._open:
            return
        if event.kind is EventKind.OPENED:
            group.is_open, group.is_opening = True, False
            return
        if event.kind is EventKind.LOST:
            self._lost(group, event.value)
            return
        task = group.running.pop(event.number)
        failure: Failure | None = event.value if event.kind is EventKind.FAILED else None
        if failure is not None and failure.killed and task.number not in self._killed:
            self._killed.add(task.number)
            group.waiting.appendleft(task)
            return
        self._done(task, event.value)
        if group.is_idle:
            self._rest(group)

    def _rest(self, group: _Group) -> None:
        """Close the group that has had nothing to do for the longest time, if too many have nothing to do."""
        self._open.remove(group)
        self._open.append(group)
        idle = [each for each in self._open if each.is_idle]
        if len(idle) > self._kept_open:
            self._host.close_group(idle[0].number)
            self._forget(idle[0])

    def _forget(self, group: _Group) -> None:
        if group in self._open:
            self._open.remove(group)
        if group in self._pending:
            self._pending.remove(group)
        del self._of_key[group.key], self._groups[group.number]

    def _lost(self, group: _Group, failure: Failure) -> None:
        """Open a group again whose process was killed; otherwise its jobs fail as it did."""
        group.waiting.extendleft(reversed(group.running.values()))
        group.running.clear()
        if failure.killed and group.tries < MOST_TRIES:
            self._open.remove(group)
            self._pending.appendleft(group)
            return
        self._fail(group, replace(failure, of_group=True))

    def _fail(self, group: _Group, failure: Failure) -> None:
        self._forget(group)
        for task in (*group.running.values(), *group.waiting):
            self._done(task, failure)
