"""Jobs run in processes of their own: whatever happens to one of them, no other job is lost, and nothing is left."""

import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from cad.batch.run import Task, locked_output, run_tasks
from cad.work.group import GroupRequest
from cad.work.host import Failure, Host, ServerEndedError
from tests.running import are_gone, needs_proc
from wpcal.core.errors import InputError

LIMIT_S, LIMIT_GB = 2.0, 2.0  #: A job that hangs is ended so soon; those that work take milliseconds.


class Batch:
    """The processes of a batch, and what became of its jobs."""

    def __init__(self, folder: Path, probe: str, host: Host, work: Path) -> None:
        self._folder, self._probe, self.host, self.work = folder, probe, host, work
        self.marks = folder / "marks"
        self.marks.mkdir()

    def run(self, jobs: Sequence[tuple[str, str]], *, at_once: int = 2) -> list[Any]:
        """Run jobs, each the name of its group and what it does; return what became of each."""
        tasks = [Task(k, group, {"do": do, "marks": self.marks}) for k, (group, do) in enumerate(jobs)]
        requests = {
            group: GroupRequest(
                f"{self._probe}:open_group", f"{self._probe}:run_job", {"name": group}, self._folder, self.work,
                LIMIT_S, LIMIT_GB,
            )
            for group, _ in jobs
        }  # fmt: skip
        ended: dict[int, Any] = {}
        run_tasks(
            tasks, dict(requests), self.host, at_once=at_once, done=lambda task, v: ended.update({task.number: v})
        )
        return [ended[number] for number in range(len(jobs))]


@contextmanager
def batch(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Batch]:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    with locked_output(folder / "out", overwrite=False) as (lock, work):
        host = Host(work, lock, ())
        try:
            yield Batch(folder, "batch_probe", host, work)
        finally:
            host.end()
    assert not (folder / "out").exists()


def test_a_job_that_fails_in_any_way_loses_only_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bad = {
        "crash": "SIGSEGV",
        "hang": "stopped after 2 s, its time limit; --job-seconds",
        "memory": "needs more than its limit of 2 GB of memory; --job-gb",
        "refuse": "this job cannot be done",
        "fault": "internal error (RuntimeError: a defect); this is our fault",
    }
    jobs = [(group, do) for group in ("a", "b") for do in ("work", *bad, "work", "work")]
    with batch(tmp_path, monkeypatch) as running:
        ended = running.run([*jobs, ("crash", "work"), ("refused", "work"), ("refused", "work"), ("late", "work")])
        assert list(running.work.iterdir()) == []
    for (group, do), value in zip(jobs, ended, strict=False):
        if do == "work":
            assert value["group"] == group
        else:
            assert isinstance(value, Failure)
            assert bad[do] in value.message
    assert [value.message for value in ended[-4:]] == [
        "the CAD kernel cannot work with this file: it crashed (SIGSEGV)",
        "this part cannot be read",
        "this part cannot be read",
        "stopped after 2 s, its time limit; --job-seconds allows more",
    ]


@pytest.mark.parametrize("do", ["kill me", "kill my group"])
def test_a_process_that_is_killed_is_replaced(do: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with batch(tmp_path, monkeypatch) as running:
        ended = running.run([("a", "work"), ("a", do), *[("a", "work")] * 20, ("b", "work")])
    assert [value["group"] for value in ended] == ["a"] * 22 + ["b"]


def test_few_processes_run_many_jobs_and_each_ends_after_some(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with batch(tmp_path, monkeypatch) as running:
        ended = running.run([("a", "work")] * 40, at_once=1)
    assert len({value["process"] for value in ended}) == 3
    assert len({value["parent"] for value in ended}) == 1


def test_a_full_disk_ends_the_batch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with batch(tmp_path, monkeypatch) as running, pytest.raises(InputError, match="no space left on device"):
        running.run([("a", "full"), *[("a", "work")] * 500])
    assert len(list(running.marks.iterdir())) < 100


@needs_proc
def test_if_the_server_is_killed_all_processes_end_and_the_batch_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with batch(tmp_path, monkeypatch) as running:
        [value] = running.run([("a", "work")])
        server = running.host._server.pid  # the group, its child, may have ended
        os.kill(server, signal.SIGKILL)
        with pytest.raises(ServerEndedError, match="was ended by SIGKILL"):
            running.run([("b", "work")])
    assert are_gone(server, value["parent"], value["process"], within_s=5.0)


def test_of_two_batches_into_one_folder_the_second_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cad.batch.run.WAIT_FOR_LOCK_S", 0.1)
    with (
        locked_output(tmp_path / "out", overwrite=True),
        pytest.raises(InputError, match="another run is writing into it now"),
        locked_output(tmp_path / "out", overwrite=True),
    ):
        raise AssertionError
    assert not (tmp_path / "out").exists()
