"""A disk mounted read-only: what is on it is read, and what would be written on it is refused in one line, at once."""

import os
import shutil
import subprocess
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.attack.faults import ONE_LINE, TIMEOUT_S, WPCAL, Job, contents

WRITING = {
    "advise": "tee.step -o template.csv",
    "bases": "cell/two-mh6.json touched.csv -o new",
    "calibrate": "tee.step taught.csv -o old --force",
    "correct": "joints.csv --robot mh6 -o points.csv",
    "demo": "-o new",
    "export": "old -f rapid",
    "identify": "mh6 poses.csv -o new --no-charts",
    "pick": "tee.step --no-browser -o new.csv",
    "plan": "cell/two-mh6.json seams.json --seam W1 -o new",
    "report": "old --force",
    "seams": "tee.step --html seams.html",
    "sheet": "tee.step -o sheet.svg",
    "study": "table1.csv --trials 10 -o study.json",
    "taught": "points.mod --uframe base -o points.csv",
    "tcp": "joints.csv --robot mh6 -o tool.json",
    "welds": "old -o welds.json",
}
"""Every command that writes, from a working folder on the disk, with `old`, the result of an earlier run."""


class NotMountedError(Exception):
    """This user may neither mount a disk nor make a folder immutable."""


@contextmanager
def read_only_disk(place: Path, fill: Callable[[Path], None]) -> Iterator[Path]:
    """Yield a folder in which nothing can be changed: a disk mounted read-only.

    Raises `NotMountedError` when this user may not mount one.
    """
    place.mkdir(exist_ok=True)
    mounted = subprocess.run(["mount", "-t", "tmpfs", "tmpfs", str(place)], capture_output=True, text=True, check=False)
    if mounted.returncode:
        raise NotMountedError(f"no disk can be mounted here: {mounted.stderr.strip()}")
    try:
        fill(place)
        subprocess.run(["mount", "-o", "remount,ro", str(place)], check=True)
        yield place
    finally:
        subprocess.run(["umount", str(place)], check=True)


def write_on_read_only(job: Job, names: tuple[str, ...], fill: Callable[[Path], None]) -> Counter[str]:
    """Run commands that write on a read-only disk, and the job with its input on one and its output beside it.

    `names`: Of `WRITING`.
    `fill`: Puts the input of these commands into a folder.
    Raises `NotMountedError` when this user may not mount one.
    """
    found: Counter[str] = Counter()

    def filled(disk: Path) -> None:
        fill(disk)
        for file in job.folder.glob("*.csv"):
            shutil.copy(file, disk)
        job.begin(disk / "old")

    with read_only_disk(job.folder / "read-only", filled) as disk:
        before = contents(disk)
        for name in names:
            code, said = _ended([name, *WRITING[name].split()], disk)
            found["refused in one line"] += code == 2 and "read-only file system" in said
            found["not one line"] += code != 2 or said.count("\n") != ONE_LINE
            found["MIXED"] += contents(disk) != before
        out = job.folder / "out"
        job.begin(out)
        done = job.start("new", str(out), "--force", cwd=disk)
        done.communicate(timeout=TIMEOUT_S)
        found["input on the disk is read"] += done.returncode in job.codes and job.state(out) == "new"
        found["MIXED"] += contents(disk) != before
    return found


def _ended(words: list[str], cwd: Path) -> tuple[int, str]:
    quiet = {**os.environ, "WPCAL_PROGRESS_AFTER_S": "600"}
    done = subprocess.run(
        [WPCAL, *words], cwd=cwd, env=quiet, capture_output=True, text=True, check=False, timeout=TIMEOUT_S
    )
    return done.returncode, done.stderr
