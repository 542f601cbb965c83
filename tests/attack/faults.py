"""Faults against a command that replaces an old result: what a reader finds afterwards must be all old or all new.

The same input gives the same bytes, so every file is compared with a run that nothing disturbed.
"""

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from tests.running import are_gone, children_of

WPCAL = Path(sys.executable).with_name("wpcal")
INJECTED = Path(__file__).with_name("injected")
ORPHAN_S = 0.4  #: Longest time for which the kernel's process may outlive a killed command.
TIMEOUT_S = 300
MOST_CHANGES = 60  #: Far above the number of changes of folders in one run.
OLD_S = 3600
ONE_LINE = 1


@dataclass(slots=True)
class Job:
    """A command with two inputs, the results of undisturbed runs with them, and how long these took."""

    folder: Path  #: The working folder.
    commands: dict[str, list[str]]  #: By the name of the input (`old`, `new`): the command without its output.
    results: dict[str, dict[str, bytes]] = field(default_factory=dict)
    seconds: float = 0.0
    codes: tuple[int, ...] = (0, 1)

    def __post_init__(self) -> None:
        for name in self.commands:
            began = time.monotonic()
            assert self.run(name, f"reference-{name}").returncode in self.codes
            self.seconds = max(self.seconds, time.monotonic() - began)
            self.results[name] = contents(self.folder / f"reference-{name}")
        assert self.results["old"] != self.results["new"]

    def start(
        self, name: str, out: str, *options: str, cwd: Path | None = None, **environment: str
    ) -> subprocess.Popen[str]:
        """Start the command."""
        return subprocess.Popen(
            [WPCAL, *self.commands[name], "-o", out, *options],
            cwd=cwd or self.folder,
            env={**os.environ, **environment},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, name: str, out: str, *options: str, **environment: str) -> subprocess.CompletedProcess[str]:
        """Run the command to its end."""
        process = self.start(name, out, *options, **environment)
        _, errors = process.communicate(timeout=TIMEOUT_S)
        return subprocess.CompletedProcess(process.args, process.returncode, "", errors)

    def begin(self, out: Path) -> None:
        """Put the old result in place, with nothing beside it."""
        shutil.rmtree(out, ignore_errors=True)
        for left in out.parent.glob(".wpcal-*"):
            shutil.rmtree(left)
        out.mkdir(parents=True)
        for name, data in self.results["old"].items():
            (out / name).write_bytes(data)

    def state(self, out: Path) -> str:
        """Say whether a folder is the old result, the new one, or anything else."""
        found = contents(out) if out.is_dir() else {}
        return next((name for name, result in self.results.items() if result == found), "MIXED" if found else "nothing")


def contents(folder: Path) -> dict[str, bytes]:
    """Return the bytes of every file in a folder."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def left_over(out: Path) -> bool:
    """Whether a temporary folder or file lies beside a result."""
    return any(out.parent.glob(".wpcal-*"))


def kill_at_every_change(job: Job) -> Counter[str]:
    """Kill the process that writes at each change of a folder: every rename, link, removal and the exchange."""
    found: Counter[str] = Counter()
    out = job.folder / "out"
    for moment in range(1, MOST_CHANGES):
        job.begin(out)
        path = os.pathsep.join(each for each in (str(INJECTED), os.environ.get("PYTHONPATH")) if each)
        place = {"PYTHONPATH": path, "ATTACK_PLACE": str(job.folder), "ATTACK_MOMENT": str(moment)}
        done = job.run("new", str(out), "--force", **place)
        found[job.state(out)] += 1
        if done.returncode in job.codes:
            return found
    raise AssertionError("the command never ended by itself")


def kill_at_random(job: Job, number: signal.Signals, count: int, rng: random.Random) -> Counter[str]:
    """Send a signal to the command at random moments; its child must end, and the result must be whole."""
    found: Counter[str] = Counter()
    out = job.folder / "out"
    for _ in range(count):
        job.begin(out)
        process = job.start("new", str(out), "--force")
        with suppress(subprocess.TimeoutExpired):
            process.wait(rng.uniform(0.0, 1.1 * job.seconds))
        children = children_of(process.pid)
        process.send_signal(number)
        process.communicate(timeout=TIMEOUT_S)
        found["orphan after 0.4 s"] += not are_gone(*children, within_s=ORPHAN_S)
        found[job.state(out)] += 1
        found["temporary folder left"] += left_over(out)
        found["had a child"] += bool(children)
        expected = {-signal.SIGKILL} if number is signal.SIGKILL else {128 + number, -number}
        found["other exit code"] += process.returncode not in expected and process.returncode not in job.codes
    return found


def fill_disk(job: Job, sizes_kb: tuple[int, ...]) -> Counter[str]:
    """Run on a disk that is too small, or with a limit to the size of a file where nothing may be mounted."""
    found: Counter[str] = Counter()
    for size in sizes_kb:
        with small_disk(job.folder / "disk", size) as disk:
            out = disk / "out"
            with suppress(OSError):
                job.begin(out)
            before = contents(out)
            before_count = len(before)
            done = job.run("new", str(out), "--force")
            found["old"] += done.returncode == 2 and contents(out) == before and before_count > 0
            found["new"] += done.returncode in job.codes and job.state(out) == "new"
            found["temporary folder left"] += left_over(out)
            found["not one line"] += done.returncode == 2 and done.stderr.count("\n") != ONE_LINE
            found["runs"] += 1
    return found


@contextmanager
def small_disk(place: Path, size_kb: int) -> Iterator[Path]:
    """Yield a folder on a disk of a size; without the right to mount one, a folder and a limit to every file."""
    place.mkdir(exist_ok=True)
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size_kb}k", "tmpfs", str(place)], capture_output=True, check=False
    )
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    if mounted.returncode:
        resource.setrlimit(resource.RLIMIT_FSIZE, (size_kb * 1024, before[1]))
    try:
        yield place
    finally:
        if mounted.returncode:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
        else:
            subprocess.run(["umount", str(place)], check=True)


def forbid_writing(job: Job) -> Counter[str]:
    """Run where nothing can be written: exit code 2, one line, and nothing changed."""
    found: Counter[str] = Counter()
    for out in (Path("/proc/out"), Path("/dev/null/out"), job.folder / "file" / "out"):
        (job.folder / "file").touch()
        done = job.run("new", str(out), "--force")
        found["refused in one line"] += (done.returncode, done.stderr.count("\n")) == (2, ONE_LINE)
        found["runs"] += 1
    return found


def change_input(job: Job, count: int, rng: random.Random) -> Counter[str]:
    """Exchange the input of a running command: the result is that of one of the two files, with its hash."""
    found: Counter[str] = Counter()
    out, taught = job.folder / "out", job.folder / "taught.csv"
    old, new = taught.read_bytes(), (job.folder / "other.csv").read_bytes()
    job.results["changed"] = _result_of(job, new)
    for _ in range(count):
        job.begin(out)
        (job.folder / "next.csv").write_bytes(new)
        exchange = threading.Timer(
            rng.uniform(0, job.seconds), os.replace, (job.folder / "next.csv", job.folder / "taught.csv")
        )
        exchange.start()
        done = job.run("new", str(out), "--force")
        exchange.join()
        taught.write_bytes(old)
        found[job.state(out)] += 1
        found["not finished"] += done.returncode not in job.codes
    return found


def _result_of(job: Job, taught: bytes) -> dict[str, bytes]:
    before = (job.folder / "taught.csv").read_bytes()
    (job.folder / "taught.csv").write_bytes(taught)
    job.run("new", "reference-changed", "--force")
    (job.folder / "taught.csv").write_bytes(before)
    return contents(job.folder / "reference-changed")


def write_twice(job: Job, count: int, *, force: bool) -> Counter[str]:
    """Start two commands that write into one folder at the same time."""
    found: Counter[str] = Counter()
    out = job.folder / "out"
    for _ in range(count):
        job.begin(out)
        if not force:
            shutil.rmtree(out)
        both = [job.start(name, str(out), *(("--force",) if force else ())) for name in ("new", "old")]
        for one in both:
            one.communicate(timeout=TIMEOUT_S)
        finished = sum(one.returncode in job.codes for one in both)
        found[f"{finished} finished, {sum(one.returncode == 2 for one in both)} refused"] += 1
        found[job.state(out)] += 1
        found["temporary folder left"] += left_over(out)
    return found
