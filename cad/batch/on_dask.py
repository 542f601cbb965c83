"""Run a batch on the workers of a Dask scheduler.

The command reads the inputs and sends their bytes. A worker sends back the files that a job wrote, and the command puts
them in place. Workers therefore need no folder in common with the command.
"""

from __future__ import annotations

import secrets
import shutil
from collections import Counter, deque
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cad.batch.job_record import put_job_in_place
from cad.batch.machine import SentJob, end_batch, run_sent_job
from cad.batch.run import Task, require_room
from cad.batch.sent_files import FilesOfOptions, Reader, SentFile
from cad.work.group import GroupRequest
from cad.work.host import Failure
from wpcal.core.dask.cluster import Call, CallFailed, Cluster
from wpcal.core.errors import InputError
from wpcal.core.whole_folder import flushed_later

SMALL = 65_536  #: Bytes. A larger file that several jobs name is sent once, and workers take it from one another.


def run_on_dask(
    tasks: Sequence[Task],
    requests: Mapping[Hashable, GroupRequest],
    cluster: Cluster,
    modules: Sequence[str],
    *,
    files_of_options: FilesOfOptions,
    done: Callable[[Task, Any], None],
) -> None:
    """Run the jobs of a batch on the workers of a scheduler.

    Raises `InputError` when the scheduler is gone or has no workers, or a disk is full.
    """
    reader = Reader(next(iter(requests.values())).folder, files_of_options)
    run = _Run(tasks, requests, cluster, tuple(modules), reader, done)
    cluster.at_end(end_batch, run.batch)
    with flushed_later():
        run.run()


@dataclass(slots=True, eq=False)
class _Group:
    """The jobs of a group that no worker has yet."""

    number: int
    request: GroupRequest
    waiting: deque[Task] = field(default_factory=deque)


class _Files:
    """What the jobs of a batch need; large files that several of them need are kept by the scheduler while they do."""

    def __init__(self, cluster: Cluster, reader: Reader, needed: Iterable[str]) -> None:
        self._cluster, self._reader, self._needed = cluster, reader, Counter(needed)
        self._kept: dict[str, tuple[SentFile, Any]] = {}

    def sent(self, name: str, task: Task) -> tuple[SentFile, Any]:
        """Return a file that a job names and its content, or the scheduler's copy of it."""
        if name not in self._kept:
            file, content = self._reader.read(name, task.arguments)
            if self._needed[name] < 2:
                return file, content
            self._kept[name] = file, content if len(content) < SMALL else self._cluster.shared(content)
        return self._kept[name]

    def done(self, names: Iterable[str]) -> None:
        """Forget the files that no other job needs."""
        for name in names:
            self._needed[name] -= 1
            if not self._needed[name]:
                self._kept.pop(name, None)


class _Run:
    """The state of a batch that runs."""

    def __init__(
        self,
        tasks: Sequence[Task],
        requests: Mapping[Hashable, GroupRequest],
        cluster: Cluster,
        modules: tuple[str, ...],
        reader: Reader,
        done: Callable[[Task, Any], None],
    ) -> None:
        self.batch = secrets.token_hex(8)
        self._cluster, self._modules, self._done = cluster, modules, done
        self._groups: dict[Hashable, _Group] = {}
        for task in tasks:
            group = self._groups.setdefault(task.group, _Group(len(self._groups), requests[task.group]))
            group.waiting.append(task)
        self._fresh = deque(self._groups.values())
        self._last: dict[str, _Group] = {}
        self._files = _Files(cluster, reader, (name for task in tasks for name in reader.names(task.arguments)))
        self._reader = reader

    def run(self) -> None:
        """Run all jobs."""
        for task, value in self._cluster.results(self._next):
            self._ended(task, value)

    def _next(self, worker: str) -> Call | None:
        """Return the next job for a worker."""
        while (group := self._group_for(worker)) is not None:
            task = group.waiting.popleft()
            try:
                sent = [self._files.sent(name, task) for name in self._reader.names(task.arguments)]
            except InputError as error:
                self._ended(task, (Failure(str(error)), {}))
                continue
            arguments = {key: value for key, value in task.arguments.items() if key != "out"}
            files = tuple(file for file, _ in sent)
            job = SentJob(self.batch, group.number, group.request, arguments, files, self._modules)
            return Call(task, run_sent_job, (job, *(content for _, content in sent)))
        return None

    def _group_for(self, worker: str) -> _Group | None:
        """Return the group that the worker had last; else one that none had; else the one with most to do."""
        last = self._last.get(worker)
        if last is None or not last.waiting:
            others = (group for group in self._last.values() if group.waiting)
            while self._fresh and not self._fresh[0].waiting:
                self._fresh.popleft()
            last = self._fresh.popleft() if self._fresh else max(others, key=lambda it: len(it.waiting), default=None)
        if last is not None:
            self._last[worker] = last
        return last

    def _ended(self, task: Task, value: Any) -> None:
        self._files.done(self._reader.names(task.arguments))
        group = self._groups[task.group]
        value, files = (Failure(value.message), {}) if isinstance(value, CallFailed) else value
        if not isinstance(value, Failure):
            value = self._put_in_place(task, group.request.work / str(task.number), files) or value
        require_room(value)
        self._done(task, value)
        if isinstance(value, Failure) and value.of_group:
            while group.waiting:
                self._ended(group.waiting.popleft(), (Failure(value.message), {}))

    def _put_in_place(self, task: Task, new: Path, files: Mapping[str, bytes]) -> Failure | None:
        try:
            new.mkdir(parents=True)
            for name, data in files.items():
                (new / name).write_bytes(data)
            put_job_in_place(new, task.arguments["out"])
        except InputError as error:
            return Failure(str(error), getattr(error.__cause__, "errno", None) or 0)
        except OSError as error:
            return Failure(
                f"{task.arguments['out']}: cannot be written: {(error.strerror or str(error)).lower()}",
                error.errno or 0,
            )
        finally:
            shutil.rmtree(new, ignore_errors=True)
        return None
