"""`wpcal batch`: the calibrations of a list, many at once, and one line for each."""

from __future__ import annotations

import os
import shlex
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.options import no_cache_option
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import DASK_HELP, JSON_HELP, path_argument, path_option
from wpcal.cli.signals import ENDING
from wpcal.core.options import group, opt
from wpcal.core.result_files import PAGE_FILE, SUMMARY_FILE, SUMMARY_TABLE

if TYPE_CHECKING:
    from collections import Counter

    from cad.batch.job_list import Job
    from cad.batch.run import Task
    from cad.batch.summary import Summary
    from cad.work.child import Limits
    from cad.work.host import Host
    from wpcal.core.dask.cluster import Cluster

MOST_AT_ONCE = 256
MOST_SHOWN = 10  #: Failed jobs that the terminal lists; the summary lists all.
RESUME = "--resume"


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchAsked:
    """How a batch is run."""

    at_once: int | None = opt(
        None, "Processes at the same time.  [default: one per processor]", "-j", "--jobs", least=1, most=MOST_AT_ONCE
    )
    dask: str | None = opt(
        None, f"{DASK_HELP}: each runs as many jobs at the same time as it has threads.", metavar="tcp://HOST:PORT"
    )
    resume: bool = opt(
        False,
        "Continue in a folder of results: what is complete and made of the same inputs is not done again.",
        RESUME,
    )
    pages: str = opt(
        "fail",
        "Write report.html of all jobs, of those whose verdict is not PASS, or of none.",
        "--report",
        choices=("all", "fail", "none"),
    )
    limits: Limits = group("cad.work.child:Limits")
    as_json: bool = opt(False, f"{JSON_HELP}: the summary.", "--json")


@command()
@path_argument("jobs_csv", metavar="JOBS.csv")
@path_option("-o", "--out", required=True, help="Output: a folder.")
@takes("flags", BatchAsked)
@no_cache_option
def batch(*, jobs_csv: Path, out: Path, flags: BatchAsked, no_cache: bool) -> int:
    """Calibrate every row of JOBS.csv into a folder of its own.

    The columns are job (the name, and that of the folder), part, taught, and any option of `wpcal calibrate` under its
    name (criterion, sigma_mm; yes or no for an option without a value). A column when may hold the time of each job.
    Names of files are relative to the folder of the list.

    Each part is read once. A job that cannot be done, crashes or exceeds its limits loses only itself. Every job ends
    as OUT/JOB, complete or not at all, and as one line in OUT/summary.jsonl and OUT/summary.csv. OUT/JOB holds the
    files of `wpcal calibrate`; its job.json says from what they were made (see `wpcal verify`).

    Ends with code 0 if every job would end `wpcal calibrate` with 0, otherwise with 1.
    """
    from cad.batch.job_list import read_jobs
    from cad.batch.jobs import option_columns
    from cad.batch.run import locked_output
    from cad.batch.summary import Summary
    from wpcal.cli.progress import counted_progress
    from wpcal.core.errors import InputError
    from wpcal.core.whole_folder import flush_all

    if flags.dask is not None and flags.at_once is not None:
        raise InputError("-j is about this machine; with --dask every worker runs as many jobs as it has threads")
    jobs = read_jobs(jobs_csv, option_columns(), _said_by_shop(jobs_csv))
    if flags.dask is None:
        _require_forks()
    began = time.monotonic()
    with locked_output(out, overwrite=flags.resume) as (lock, work), ExitStack() as running:
        summary = Summary(out, work)
        plan = _Batch(jobs, jobs_csv.resolve().parent, out.resolve(), work, flags, use_cache=not no_cache)
        with _finished_in_any_case(summary, plan, _again(jobs_csv, out, flags, no_cache=no_cache)):
            with counted_progress("reading the list") as progress:
                plan.run(lock, summary, progress, running)
            summary.finish()
            flush_all(out)
        seconds = time.monotonic() - began
    _show(plan, summary, out, seconds, as_json=flags.as_json)
    return 0 if plan.bad == 0 else 1


def _said_by_shop(jobs_csv: Path) -> dict[str, str]:
    """Return the cells that the shop says for every job, by flag."""
    from cad.batch.job_list import BETWEEN
    from cad.batch.request import request_command
    from wpcal.cli.shop_file import find_shop, said_of

    said = said_of(request_command(), "calibrate", find_shop([str(jobs_csv)])).values()
    if said:
        click.echo(f"wpcal: for every job the shop says {', '.join(map(str, said))}", err=True)
    yes = {True: "yes", False: "no"}
    return {
        each.flag: BETWEEN.join(each.value) if isinstance(each.value, list) else yes.get(each.value, str(each.value))
        for each in said
    }


def _require_forks() -> None:
    from wpcal.core.errors import InputError

    if not hasattr(os, "fork"):
        raise InputError("wpcal batch needs Linux or macOS: this system cannot fork processes")


class _Batch:
    """The jobs of a list, and what becomes of them."""

    def __init__(
        self, jobs: Sequence[Job], folder: Path, out: Path, work: Path, flags: BatchAsked, *, use_cache: bool
    ) -> None:
        self.jobs, self._folder, self._out, self._work, self._flags = jobs, folder, out, work, flags
        self._use_cache = use_cache
        self._began = time.monotonic()
        self.done = self.kept = self.bad = 0

    def run(self, lock: int, summary: Summary, progress: Any, running: ExitStack) -> None:
        """Run what is to be run; every job gets its line in the summary. The end of `running` ends the processes."""
        tasks, requests = self._tasks(summary, progress)
        if not tasks:
            return

        def done(task: Task, value: Any) -> None:
            self._done(summary, progress, task, value)

        if self._flags.dask is not None:
            progress(f"connecting to {self._flags.dask}", 0, len(tasks))
            self._run_on_dask(self._flags.dask, tasks, requests, done, running)
            return
        from cad.batch.jobs import PRELOADED
        from cad.batch.run import run_tasks
        from cad.work.host import Host

        progress("starting the CAD kernel", 0, len(tasks))
        self._began = time.monotonic()
        host = Host(self._work, lock, PRELOADED)
        running.callback(_end, host)
        run_tasks(tasks, requests, host, at_once=self._flags.at_once or os.cpu_count() or 1, done=done)

    def _run_on_dask(
        self,
        address: str,
        tasks: list[Task],
        requests: dict[Any, Any],
        done: Callable[[Task, Any], None],
        running: ExitStack,
    ) -> None:
        from cad.batch.jobs import PRELOADED, files_of_options
        from cad.batch.on_dask import run_on_dask
        from wpcal.core.dask.cluster import Cluster

        cluster = Cluster(address)
        running.callback(_end, cluster)
        cluster.start()
        self._began = time.monotonic()
        run_on_dask(tasks, requests, cluster, PRELOADED, files_of_options=files_of_options, done=done)

    def _tasks(self, summary: Summary, progress: Any) -> tuple[list[Task], dict[Any, Any]]:
        """Return the jobs to run, and how their parts are opened; jobs that cannot be run get their line here."""
        from cad.batch.job_list import words_of
        from cad.batch.jobs import option_columns
        from cad.batch.run import Task
        from cad.work.group import GroupRequest
        from wpcal.core.errors import InputError

        columns, hashes = option_columns(), _Hashes(self._folder)
        of_part = {column.flag for column in columns.values() if column.shapes_part}
        earlier = _Earlier(self._out, self._folder, self._flags.pages) if self._flags.resume else None
        tasks, requests = [], {}
        for job in self.jobs:
            progress("looking at the files of jobs", job.number, len(self.jobs))
            try:
                job.require_sound()
                sha256, words = hashes.of(job.part), words_of(job.cells, columns)
                shaping = words_of([cell for cell in job.cells if cell[0] in of_part], columns)
            except InputError as error:
                self._add(summary, job, None, error=str(error))
                continue
            known = None if earlier is None else earlier.result(job, sha256, words)
            if known is not None:
                self.kept += 1
                self._add(summary, job, known, seconds=earlier.seconds.get(job.name) if earlier else None)
                continue
            group = (Path(job.part).name, sha256, shaping)
            if group not in requests:
                requests[group] = GroupRequest(
                    "cad.batch.jobs:open_part",
                    "cad.batch.jobs:run_job",
                    {"part": job.part, "words": shaping, "use_cache": self._use_cache},
                    self._folder,
                    self._work,
                    self._flags.limits.time_s,
                    self._flags.limits.memory_gb,
                )
            arguments: dict[str, Any] = {"name": job.name, "part": job.part, "taught": job.taught, "words": words}
            arguments |= {"out": self._out / job.name, "pages": self._flags.pages}
            tasks.append(Task(job.number, group, arguments))
        return tasks, requests

    def _done(self, summary: Summary, progress: Any, task: Task, value: Any) -> None:
        from cad.work.host import Failure

        job = self.jobs[task.number]
        if isinstance(value, Failure):
            self._add(summary, job, None, error=value.message)
        else:
            self._add(summary, job, value, seconds=value["seconds"])
        done = self.done - self.kept
        rate = done / max(time.monotonic() - self._began, 1e-3)
        left = round((len(self.jobs) - self.done) / rate)
        progress(f"jobs, {rate:.1f} per s, {left // 60}:{left % 60:02d} min left", self.done, len(self.jobs))

    def _add(self, summary: Summary, job: Job, result: Any, *, seconds: float | None = None, error: str = "") -> None:
        from cad.batch.summary import FAILED, summary_line

        verdict = FAILED if result is None else str(result["verdict"])
        summary.add(job.number, verdict, summary_line(job, result, seconds=seconds, error=error))
        self.done += 1
        self.bad += result is None or result["exit_code"] != 0


class _Hashes:
    """SHA-256 of parts; each file is read once."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._known: dict[str, str] = {}

    def of(self, name: str) -> str:
        from cad.batch.job_record import sha256_at

        if name not in self._known:
            self._known[name] = sha256_at(name, self._folder)
        return self._known[name]


class _Earlier:
    """What an earlier run of this batch left in the output folder."""

    def __init__(self, out: Path, folder: Path, pages: str) -> None:
        from cad.batch.summary import seconds_of

        self._out, self._folder, self._pages = out, folder, pages
        self.seconds = seconds_of(out)

    def result(self, job: Job, part_sha256: str, words: tuple[str, ...]) -> dict[str, Any] | None:
        """Return the result of a job whose folder is complete and was made of the same inputs; otherwise None."""
        from cad.batch.job_record import JobInputs, is_made_of, read_job_record, sha256_at
        from wpcal.core.errors import InputError

        record = read_job_record(self._out / job.name)
        if record is None:
            return None
        try:
            taught = sha256_at(job.taught, self._folder)
        except InputError:  # the job itself says what is wrong
            return None
        inputs = JobInputs((job.part, part_sha256), (job.taught, taught), words)
        if not is_made_of(record, inputs, self._out / job.name, beside=self._folder):
            return None
        result: dict[str, Any] = record["result"]
        wants_page = self._pages == "all" or (self._pages == "fail" and result["exit_code"] != 0)
        return None if wants_page and PAGE_FILE not in record["files"] else result


@contextmanager
def _finished_in_any_case(summary: Summary, plan: _Batch, again: str) -> Iterator[None]:
    """Write the summary in its order also when the batch ends before its end, and say how it is continued."""
    from wpcal.core.errors import WpcalError

    try:
        yield
    except (KeyboardInterrupt, WpcalError) as error:
        with _undisturbed(), suppress(WpcalError):
            summary.finish()
        what = f"{plan.done} of {len(plan.jobs)} jobs are done; continue with: {again}"
        if isinstance(error, WpcalError):
            raise type(error)(f"{error}; {what}", code=error.code) from None
        error.add_note(what)
        raise


def _end(place: Host | Cluster) -> None:
    with _undisturbed():
        place.end()


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Heed no further signal while things are put in order: that takes less than a second."""
    before = {number: signal.signal(number, signal.SIG_IGN) for number in ENDING}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _again(jobs_csv: Path, out: Path, flags: BatchAsked, *, no_cache: bool) -> str:
    """Return the command that continues a batch."""
    words = ["wpcal", "batch", str(jobs_csv), "-o", str(out)]
    words += [] if flags.at_once is None else ["-j", str(flags.at_once)]
    words += [] if flags.dask is None else ["--dask", flags.dask]
    words += [] if flags.pages == "fail" else ["--report", flags.pages]
    limits, usual = flags.limits, type(flags.limits)()
    words += [] if limits.time_s == usual.time_s else ["--job-seconds", f"{limits.time_s:g}"]
    words += [] if limits.memory_gb == usual.memory_gb else ["--job-gb", f"{limits.memory_gb:g}"]
    return shlex.join([*words, *(["--no-cache"] if no_cache else []), RESUME])


def _show(plan: _Batch, summary: Summary, out: Path, seconds: float, *, as_json: bool) -> None:
    import json

    from cad.batch.summary import FAILED
    from wpcal.cli.console import plain_console

    lines = ((out / SUMMARY_FILE).read_bytes()).splitlines()
    if as_json:
        record = {
            "schema": "wpcal/batch/1",
            "seconds": round(seconds, 3),
            "kept": plan.kept,
            "verdicts": dict(sorted(summary.verdicts.items())),
            "jobs": [json.loads(line) for line in lines],
        }
        print_json(record)
        return
    console = plain_console()
    failed = [line for line in map(json.loads, lines) if line["verdict"] == FAILED]
    for line in failed[:MOST_SHOWN]:
        console.print(f"{line['job']}: {line['error']}", soft_wrap=True)
    if len(failed) > MOST_SHOWN:
        console.print(f"and {len(failed) - MOST_SHOWN} more that failed")
    console.print(_counts(summary.verdicts, plan.kept, seconds, len(plan.jobs)))
    wrote = f"wrote a folder for each job, {SUMMARY_FILE} and {SUMMARY_TABLE} to {out}"
    console.print(wrote, soft_wrap=True)


def _counts(verdicts: Counter[str], kept: int, seconds: float, jobs: int) -> str:
    from wpcal.core.wording import counted

    told = ", ".join(f"{verdicts[verdict]} {verdict}" for verdict in sorted(verdicts, reverse=True))
    earlier = f", {kept} of them complete before" if kept else ""
    return f"{counted(jobs, 'job')} in {seconds:.1f} s{earlier}: {told}"
