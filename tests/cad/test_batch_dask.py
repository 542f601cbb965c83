"""Batches and studies on a real scheduler with two real workers: the same bytes as here, and nothing lost with them.

Deep: `test_batch` and `test_batch_processes` have the same promises for processes of this machine at each push.
"""

import asyncio
import os
import runpy
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from cad.batch.job_record import JobInputs
from cad.batch.on_dask import run_on_dask
from cad.batch.run import Task
from cad.batch.sent_files import Copies, Reader
from cad.work.group import GroupRequest
from tests.cad.batch_faults import FIXTURES, WPCAL, contents, heed_signals, told, write_jobs
from tests.cad.dask_processes import DaskProcesses, dask_processes
from tests.running import FINISHED, TIMEOUT_S, needs_proc, run_here
from wpcal.core.dask.cluster import Call, Cluster

pytestmark = [needs_proc, pytest.mark.deep]
REPEATS = 4  #: So often the jobs of the list are repeated: enough to disturb a batch before its end.
LIMIT_S, LIMIT_GB = 2.0, 2.0  #: A job that hangs is ended so soon; those that work take milliseconds.
ORPHAN_S = 10.0  #: Within this time the processes of a worker that was killed end, and what they wrote is removed.


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A list with relative, absolute and repeated names of files, and in `whole` what a batch here makes of it."""
    folder = tmp_path_factory.mktemp("list")
    write_jobs(folder, 6, wrapped=2)
    (folder / "days").mkdir()
    shutil.copy(folder / "day5.csv", folder / "days")
    head, *rows = (folder / "jobs.csv").read_text().splitlines()
    rows = [f"{row.replace(',', f'-{k},', 1)}" for k in range(REPEATS) for row in rows]
    rows[0] = rows[0].replace("tee.step", str(folder / "tee.step"))
    rows[5] = rows[5].replace("day5.csv", "days/../days/day5.csv")
    wrong = ["none,tee.step,none.csv,,,", "few,tee.step,days/short.csv,,,", f"bad,{folder}/bad.step,day0.csv,,,"]
    rows = [f"{row},{'./days/torch.json' if k == 3 else ''}" for k, row in enumerate(rows)]
    shutil.copy(next((FIXTURES.parent / "wpcal").glob("**/torches/*.json")), folder / "days" / "torch.json")
    (folder / "days" / "short.csv").write_text("name,x_mm,y_mm,z_mm\nV2,1,2,3\n")
    (folder / "bad.step").write_text("ISO-10303-21;\nnonsense")
    (folder / "jobs.csv").write_text("\n".join([f"{head},torch", *rows, *wrong]) + "\n")
    done = run_here("batch", folder / "jobs.csv", "-o", folder / "whole", "-j", "2", "--report", "none")
    assert done.returncode == 1, done.stderr
    return folder


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DaskProcesses]:
    """A scheduler with two workers."""
    with dask_processes(tmp_path_factory.mktemp("dask") / "processes") as processes:
        processes.add_worker()
        processes.add_worker()
        yield processes


def started(folder: Path, out: Path, address: str) -> subprocess.Popen[str]:
    """Start a batch, and return as soon as some of its jobs are done."""
    command = [WPCAL, "batch", folder / "jobs.csv", "-o", out, "--report", "none", "--dask", address]
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_signals,  # noqa: PLW1509  # the tests start it from one thread
    )
    while process.poll() is None and len(list(out.glob("j*"))) < 3:
        time.sleep(0.01)
    return process


def ended(process: subprocess.Popen[str], code: int) -> str:
    """Return the last line that a batch wrote on stderr; it must be one, and the batch must end with this code."""
    _, stderr = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == code, stderr
    assert "Traceback" not in stderr
    lines = told(stderr)
    assert len(lines) <= 1, stderr
    return "".join(lines)


def servers_in(folder: Path) -> list[int]:
    """Return the processes that were started for the jobs of a worker."""
    found = []
    for each in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if b"cad.work.server" in (text := each.read_bytes()) and str(folder).encode() in text:
                found.append(int(each.parent.name))
        except OSError:
            continue
    return found


def left_in(home: Path) -> list[str]:
    """Return what jobs left in the folder of a worker."""
    return [str(path) for path in home.glob("**/.wpcal-batch-*/*")]


def is_soon(true: Callable[[], bool]) -> bool:
    """Wait for what a worker does a moment after its command has ended."""
    until = time.monotonic() + ORPHAN_S
    while time.monotonic() < until and not true():
        time.sleep(0.01)
    return true()


def test_a_worker_is_killed_and_the_bytes_are_the_same(folder: Path, tmp_path: Path) -> None:
    with dask_processes(tmp_path / "processes") as dask:
        dask.add_worker()
        dask.add_worker()
        running = started(folder, tmp_path / "out", dask.address)
        dask.workers[0].kill()
        assert ended(running, 1) == ""
        assert contents(tmp_path / "out") == contents(folder / "whole")
        assert left_in(dask.homes[1]) == []
        assert is_soon(lambda: servers_in(dask.homes[0]) == [] and left_in(dask.homes[0]) == [])

        running = started(folder, tmp_path / "cut", dask.address)
        dask.scheduler.kill()
        line = ended(running, 2)
    assert line.startswith(f"wpcal: the Dask scheduler {dask.address} is gone; start it and its workers again; ")
    assert "of 27 jobs are done; continue with: wpcal batch" in line
    assert f"--dask {dask.address} --report none --resume" in line
    assert not list((tmp_path / "cut").glob(".wpcal*"))
    again = run_here("batch", folder / "jobs.csv", "-o", tmp_path / "cut", "--report", "none", "--resume", "-j", "2")
    assert again.returncode == 1, again.stderr
    assert contents(tmp_path / "cut") == contents(folder / "whole")


def test_ctrl_c_ends_the_jobs_on_the_workers_and_resume_goes_on(
    folder: Path, tmp_path: Path, dask: DaskProcesses
) -> None:
    running = started(folder, tmp_path / "out", dask.address)
    running.send_signal(signal.SIGINT)
    line = ended(running, 128 + signal.SIGINT)
    assert "of 27 jobs are done; continue with: wpcal batch" in line
    assert not list((tmp_path / "out").glob(".wpcal*"))
    assert is_soon(lambda: [left_in(home) for home in dask.homes] == [[], []])  # each worker stops its own jobs
    command = [WPCAL, "batch", folder / "jobs.csv", "-o", tmp_path / "out", "--report", "none", "--resume"]
    done = subprocess.run([*command, "--dask", dask.address], capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert contents(tmp_path / "out") == contents(folder / "whole")


def test_a_job_that_fails_in_any_way_loses_only_itself(tmp_path: Path, dask: DaskProcesses) -> None:
    kinds = {
        "crash": "the CAD kernel cannot work with this file: it crashed (SIGSEGV)",
        "hang": "stopped after 2 s, its time limit; --job-seconds allows more",
        "memory": "needs more than its limit of 2 GB of memory; --job-gb allows more",
        "refuse": "days/refuse.txt: this job cannot be done",
    }
    (tmp_path / "days").mkdir()
    (tmp_path / "work").mkdir()
    for part in ("good", "refused"):
        (tmp_path / part).write_text(part)
    for do in (*kinds, "work"):
        (tmp_path / "days" / f"{do}.txt").write_text(do)
    jobs = [("good", do) for do in ("work", *kinds, "work", "work")] + [("refused", "work"), ("refused", "crash")]
    requests = {
        part: GroupRequest(
            "dask_probe:open_group", "dask_probe:run_job", {"part": part, "words": ()}, tmp_path, tmp_path / "work",
            LIMIT_S, LIMIT_GB,
        )
        for part in ("good", "refused")
    }  # fmt: skip
    tasks = [
        Task(k, part, {"part": part, "taught": f"days/{do}.txt", "words": (), "out": tmp_path / f"out{k}"})
        for k, (part, do) in enumerate(jobs)
    ]
    values: dict[int, Any] = {}
    with Cluster(dask.address) as cluster:
        run_on_dask(
            tasks, dict(requests), cluster, (), files_of_options=lambda *_: (),
            done=lambda task, value: values.update({task.number: value}),
        )  # fmt: skip
    for task, (part, do) in zip(tasks, jobs, strict=True):
        if part == "refused":
            assert values[task.number].message == "refused: this part cannot be read"
        elif do == "work":
            text = (tmp_path / f"out{task.number}" / "result.txt").read_text()
            assert text == "good good days/work.txt"
        else:
            assert values[task.number].message == kinds[do]
    assert list((tmp_path / "work").iterdir()) == []


def test_files_that_a_file_names_are_sent_with_it(tmp_path: Path) -> None:
    """Those beside it and below. The folder of a name is the same on both machines."""
    for name in ("cells/cell.json", "cells/arms/a.json", "other.json", "part.step", "taught.csv"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    arguments = {"part": "part.step", "taught": "taught.csv", "words": ("--cell=cells/cell.json", "--wrap")}

    def files_of_options(words: Sequence[str], part: str, taught: str) -> list[str]:
        cell = Path(words[0].partition("=")[2])
        return [str(cell), str(cell.parent / "arms" / "a.json"), str(cell.parent / ".." / "other.json")]

    reader = Reader(tmp_path, files_of_options)
    sent = [reader.read(name, arguments) for name in reader.names(arguments)]
    copies = Copies(tmp_path / "there", [file for file, _ in sent], [content for _, content in sent])
    placed = copies.placed(arguments)
    cell = Path(placed["words"][0].partition("=")[2])
    assert (cell.parent / "arms" / "a.json").read_text() == "cells/arms/a.json"
    assert not (cell.parent / ".." / "other.json").exists()
    assert Path(placed["part"]).read_text() == "part.step"
    inputs = JobInputs(
        (placed["part"], ""), (placed["taught"], ""), placed["words"], ((str(cell.parent / "arms" / "a.json"), ""),)
    )
    assert inputs.called(copies.origins) == JobInputs(
        ("part.step", ""), ("taught.csv", ""), arguments["words"], (("cells/arms/a.json", ""),)
    )


def test_the_trials_of_a_study_are_the_same_numbers(dask: DaskProcesses) -> None:
    command = ("study", FIXTURES / "yin2003" / "table1.csv", "--trials", "9000", "--seed", "3", "--json")
    assert run_here(*command, "--dask", dask.address).stdout == run_here(*command).stdout


def test_a_notebook_reaches_the_scheduler_while_its_loop_runs(dask: DaskProcesses) -> None:
    async def call() -> list[object]:
        with Cluster(dask.address) as cluster:
            calls = iter([Call(7, abs, (-2,))])
            return list(cluster.results(lambda _: next(calls, None)))

    with ThreadPoolExecutor(1) as thread:  # in this one the browser of other tests may have a loop
        assert thread.submit(lambda: asyncio.run(call())).result() == [(7, 2)]


def test_a_worker_with_another_version_is_refused(
    tmp_path: Path, dask: DaskProcesses, monkeypatch: pytest.MonkeyPatch
) -> None:
    from wpcal.core.dask.same_code import versions_here

    monkeypatch.setattr("wpcal.core.dask.cluster.versions_here", lambda: {**versions_here(), "numpy": "0.1"})
    done = run_here("study", FIXTURES / "yin2003" / "table1.csv", "--dask", dask.address)
    assert done.returncode == 2
    assert done.stderr.startswith("wpcal: worker tcp://127.0.0.1:")
    assert "and 0.1 here; install the same versions on all machines" in done.stderr


def test_what_keeps_a_batch_from_starting_is_one_line(
    folder: Path, tmp_path: Path, dask: DaskProcesses, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wpcal.core.dask.cluster.CONNECT_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        refused = {
            "10.0.0.5:8786": "'10.0.0.5:8786' is not the address of a Dask scheduler; expected tcp://host:port",
            "tcp://127.0.0.1:1": "no Dask scheduler answers at tcp://127.0.0.1:1 (",
            f"tcp://127.0.0.1:{port}": "start one with: dask scheduler",
        }
        for address, expected in refused.items():
            done = run_here("batch", folder / "jobs.csv", "-o", tmp_path / "out", "--dask", address)
            assert (done.returncode, done.stdout) == (2, "")
            assert expected in done.stderr
            assert not (tmp_path / "out").exists()
    done = run_here("batch", folder / "jobs.csv", "-o", tmp_path / "out", "-j", "2", "--dask", dask.address)
    assert "-j is about this machine" in done.stderr
    monkeypatch.setitem(sys.modules, "distributed", None)
    done = run_here("study", FIXTURES / "yin2003" / "table1.csv", "--dask", dask.address)
    assert done.returncode == 2
    assert "pip install 'wpcal[dask]'" in done.stderr


def test_the_script_for_object_storage_copies_there_and_back(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import fsspec

    storage = fsspec.filesystem("memory")
    head, _, _, _, _, _, other, *_ = (folder / "jobs.csv").read_text().splitlines()
    for name in ("tee.step", "day5.csv", "days/day5.csv"):
        storage.pipe(f"/monday/{name}", (folder / name).read_bytes())
    storage.pipe("/monday/jobs.csv", f"{head}\n{other}\n".encode())
    monkeypatch.setenv("PATH", f"{WPCAL.parent}{os.pathsep}{os.environ['PATH']}")
    script = runpy.run_path(str(FIXTURES.parent / "docs" / "examples" / "batch_from_storage.py"))
    job = other.partition(",")[0]
    for again in (False, True):
        assert script["main"]("memory://monday", "memory://results", "--report", "none") in FINISHED, again
        there = {Path(path).name: storage.cat(path) for path in storage.find(f"/results/{job}")}
        assert there == {path.name: path.read_bytes() for path in (folder / "whole" / job).iterdir()}
    assert storage.exists("/results/summary.csv")
    assert not storage.exists(f"/results/results/{job}")
