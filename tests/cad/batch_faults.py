"""Batches that are disturbed on purpose: what they were, what is left of them, and which of their processes run."""

from __future__ import annotations

import itertools
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.record_checks import check_record
from tests.running import TIMEOUT_S

WPCAL = Path(sys.executable).with_name("wpcal")
FIXTURES = Path(__file__).parents[2] / "fixtures"
KILLED_ONCE = Path(__file__).with_name("killed_once")
TIMES = "seconds"  #: The only field of the summary that is not the same in the next run.
FAILING_MM = 1.0  #: The points of the last job are so far off that it is FAIL and has a page.
ORPHAN_S = 20.0
"""Within this time the processes of a batch that was killed end and remove what they began; without other work on the
machine in less than a second."""
MARK = "WPCAL_TEST_BATCH"  #: In the environment of all processes of one run.
JOBS = 4
AFTER_THE_LAST = 10**9
VICTIMS = ("command", "server", "group", "job")
_runs = itertools.count()


def write_jobs(folder: Path, jobs: int, *, wrapped: int = -1) -> None:
    """Write a part, points that were touched on it, each time with other errors, and a list.

    The job `wrapped` has an option that changes the seams of the part: that is a group of its own.
    """
    shutil.copy(FIXTURES / "tee" / "tee.step", folder)
    rows = (FIXTURES / "tee" / "taught.csv").read_text().splitlines()
    at = rows[0].split(",").index("x_mm")
    for number in range(jobs):
        rng, moved = np.random.default_rng(number), [rows[0]]
        off = FAILING_MM if number == jobs - 1 else 0.1
        for row in rows[1:]:
            cells = row.split(",")
            cells[at] = f"{float(cells[at]) + rng.normal(0, off):.4f}"
            moved.append(",".join(cells))
        (folder / f"day{number}.csv").write_text("\n".join(moved) + "\n")
    options = [f"{'robust' if k == 1 else ''},{'x' if k == wrapped else ''}" for k in range(jobs)]
    lines = [f"j{k},tee.step,day{k}.csv,{cells}" for k, cells in enumerate(options)]
    (folder / "jobs.csv").write_text("\n".join(["job,part,taught,criterion,wrap", *lines]) + "\n")


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files of a folder of a batch, of the summary without what is never the same."""
    found = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    lines = [json.loads(line) for line in found.pop("summary.jsonl").splitlines()]
    for line in lines:
        check_record(line)
        line[TIMES] = None
    found["summary"] = json.dumps(lines).encode()
    rows = [row.split(",") for row in found.pop("summary.csv").decode().splitlines()]
    at = rows[0].index(TIMES)
    return {**found, "table": json.dumps([[*row[:at], *row[at + 1 :]] for row in rows]).encode()}


def processes(mark: str) -> dict[int, int]:
    """Return the processes that run with a mark in their environment, each with its parent."""
    found = {}
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if mark.encode() in (place / "environ").read_bytes():
                state, parent = (place / "stat").read_text().rpartition(")")[2].split()[:2]
                if state != "Z":
                    found[int(place.name)] = int(parent)
    return found


@dataclass(frozen=True, slots=True)
class Moment:
    """When one process of a batch gets a signal."""

    change: int = 0  #: At this change of a folder, counted over all processes; 0 if `after_s` tells the time.
    after_s: float = 0.0  #: Time since its start.
    victim: str = "command"  #: Of `VICTIMS`. If there is no such process yet, the command.


@dataclass(slots=True)
class Place:
    """Where one batch runs: its own output, cache and temporary files, beside a list of jobs that others share."""

    jobs: Path  #: The list.
    folder: Path  #: Made here, with `out`, `cache` and `tmp` in it.
    mark: str = ""
    environment: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.mark = f"{MARK}={os.getpid()}-{next(_runs)}."
        for each in (self.folder, self.cache, self.tmp):
            each.mkdir(exist_ok=True)

    @property
    def out(self) -> Path:
        return self.folder / "out"

    @property
    def cache(self) -> Path:
        return self.folder / "cache"

    @property
    def tmp(self) -> Path:
        return self.folder / "tmp"

    def start(self, *options: str, command: str = "", environment: Mapping[str, str] | None = None) -> Started:
        """Start `wpcal batch` with the list, or another command of wpcal."""
        usual = ["batch", str(self.jobs), "-o", str(self.out), "-j", "2", *options]
        name, _, value = self.mark.partition("=")
        places = {name: value, "WPCAL_CACHE": str(self.cache), "TMPDIR": str(self.tmp)}
        return subprocess.Popen(
            [WPCAL, *(command.split() if command else usual)],
            cwd=self.jobs.parent,
            env={**os.environ, **places, **self.environment, **(environment or {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=heed_signals,  # noqa: PLW1509  # the tests start it from one thread
        )

    def run(self, *options: str, command: str = "") -> subprocess.CompletedProcess[str]:
        """Run it to its end."""
        return ended(self.start(*options, command=command))

    def left(self) -> list[str]:
        """Return what should not be there when nothing runs: processes and unfinished files."""
        found = [f"process {each}" for each in processes(self.mark)]
        found += [str(path.relative_to(self.folder)) for path in self.folder.glob("out/**/.wpcal*")]
        found += [path.name for path in self.cache.rglob("*") if path.suffix != ".answer"]
        return [*found, *(path.name for path in self.tmp.rglob("*"))]

    def nothing_left(self) -> None:
        """Wait until nothing runs; then nothing unfinished may be there."""
        until = time.monotonic() + ORPHAN_S
        while (left := self.left()) and time.monotonic() < until:
            time.sleep(0.02)
        assert left == [], left

    def disturb(self, moment: Moment, *options: str) -> subprocess.CompletedProcess[str]:
        """Start the batch and kill one of its processes; return how the command ended."""
        if moment.change:
            return ended(self.start(*options, environment=self._at_change(moment)))
        process = self.start(*options)
        with suppress(subprocess.TimeoutExpired):
            process.wait(moment.after_s)
        with suppress(ProcessLookupError):
            os.kill(self._victim(process.pid, moment.victim), signal.SIGKILL)
        return ended(process)

    def _at_change(self, moment: Moment) -> dict[str, str]:
        path = os.pathsep.join(each for each in (str(KILLED_ONCE), os.environ.get("PYTHONPATH")) if each)
        notes = self.folder.with_suffix(".notes")
        shutil.rmtree(notes, ignore_errors=True)
        notes.mkdir()
        (notes / "token").touch()
        return {
            "PYTHONPATH": path,
            "KILL_PLACE": f"{self.folder}{os.sep}",
            "KILL_COUNT": str(notes / "count"),
            "KILL_TOKEN": str(notes / "token"),
            "KILL_MOMENT": str(moment.change),
            "KILL_VICTIM": moment.victim,
        }

    def changes(self) -> int:
        """Return how many changes of folders were counted in the last run."""
        return (self.folder.with_suffix(".notes") / "count").stat().st_size

    def _victim(self, command: int, role: str) -> int:
        """Return a process of a role: the server is a child of the command, a group one of the server, and so on."""
        running = processes(self.mark)
        generation = [command]
        for name in VICTIMS:
            if name == role and generation:
                return generation[0]
            generation = [child for child, parent in running.items() if parent in generation]
        return command


@dataclass(frozen=True, slots=True)
class Reference:
    """A list of jobs, what nobody disturbed makes of it, and how long that takes."""

    jobs: Path
    whole: dict[str, bytes]  #: From `contents`.
    place: Place
    changes: int  #: Changes of folders.
    seconds: float


def undisturbed(folder: Path) -> Reference:
    """Run a batch that nobody disturbs."""
    write_jobs(folder, JOBS)
    place = Place(folder / "jobs.csv", folder / "whole")
    began = time.monotonic()
    done = place.disturb(Moment(change=AFTER_THE_LAST))
    seconds = time.monotonic() - began
    assert done.returncode == 1, done.stderr
    place.nothing_left()
    assert (place.out / f"j{JOBS - 1}" / "report.html").is_file()
    return Reference(folder / "jobs.csv", contents(place.out), place, place.changes(), seconds)


Started = subprocess.Popen[str]


def heed_signals() -> None:
    """Undo what `nohup` or a shell did to the tests: a program goes on ignoring a signal that its parent ignores."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def ended(process: Started) -> subprocess.CompletedProcess[str]:
    """Wait for the end of a command."""
    stdout, stderr = process.communicate(timeout=TIMEOUT_S)
    return subprocess.CompletedProcess(process.args, process.returncode, stdout, stderr)


def told(stderr: str) -> list[str]:
    """Return the lines of an error, without those of progress and the empty one after ^C."""
    return [line for line in stderr.splitlines() if line and " … (" not in line]


def moments(count: int, rng: random.Random, *, changes: int, seconds: float) -> Iterator[Moment]:
    """Yield moments over the whole life of a batch: two of five at a change of a folder, the others by the clock."""
    for number in range(count):
        victim = rng.choice(VICTIMS)
        if number % 5 < 2:
            yield Moment(change=rng.randint(1, changes), victim=victim)
        else:
            yield Moment(after_s=rng.uniform(0.0, 1.02) * seconds, victim=victim)
