"""`make attack`: every fault, many times, with a table of counts. Ends with 1 if a result was lost or mixed."""

import random
import shutil
import signal
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tests.attack.faults import (
    Job,
    change_input,
    fill_disk,
    forbid_writing,
    kill_at_every_change,
    kill_at_random,
    write_twice,
)
from tests.attack.picker import CODES, end_while_reading, end_while_serving
from tests.attack.read_only import WRITING, NotMountedError, write_on_read_only
from tests.e2e.every_command import write_inputs

FIXTURES = Path(__file__).parents[2] / "fixtures"
NEVER = ("MIXED", "nothing", "orphan after 0.4 s", "other exit code", "not one line", "not finished")
KILLS, SIGNALS, CHANGES, WRITERS = 50, 10, 6, 5
READING = 12
DISKS_KB = (16, 64, 300, 500, 700, 900, 5000)


def calibration(folder: Path) -> Job:
    """Return the main job: two tolerances give two results."""
    for name in ("tee.step", "taught.csv"):
        shutil.copy(FIXTURES / "tee" / name, folder)
    rows = (folder / "taught.csv").read_text().splitlines()
    (folder / "other.csv").write_text("\n".join(rows[:-1]) + "\n")
    main = ["calibrate", "tee.step", "taught.csv", "--tolerance-mm"]
    return Job(folder, {"old": [*main, "0.5"], "new": [*main, "0.6"]})


def main() -> int:
    rng = random.Random(15)
    with tempfile.TemporaryDirectory(prefix="wpcal-attack-") as place:
        job = calibration(Path(place))
        rows: dict[str, Counter[str]] = {}
        for name, attack in {
            "kill -9 at every change of a folder": lambda: kill_at_every_change(job),
            f"kill -9 at {KILLS} random moments": lambda: kill_at_random(job, signal.SIGKILL, KILLS, rng),
            f"SIGTERM, {SIGNALS} times": lambda: kill_at_random(job, signal.SIGTERM, SIGNALS, rng),
            f"Ctrl-C, {SIGNALS} times": lambda: kill_at_random(job, signal.SIGINT, SIGNALS, rng),
            f"SIGHUP, {SIGNALS} times": lambda: kill_at_random(job, signal.SIGHUP, SIGNALS, rng),
            "full disk": lambda: fill_disk(job, DISKS_KB),
            "nowhere to write": lambda: forbid_writing(job),
            "disk mounted read-only": lambda: write_on_read_only(job, tuple(WRITING), write_inputs),
            "picker ended by a signal while it serves": lambda: end_while_serving(job.folder, tuple(CODES)),
            f"picker ended {READING} times while it reads": lambda: end_while_reading(
                job.folder, READING, rng, longest_s=job.seconds
            ),
            "input changed meanwhile": lambda: change_input(job, CHANGES, rng),
            "two into one new folder": lambda: write_twice(job, WRITERS, force=False),
            "two with --force": lambda: write_twice(job, WRITERS, force=True),
        }.items():
            try:
                rows[name] = attack()
            except NotMountedError as error:
                print(f"{name}: skipped: {error}", flush=True)
                continue
            told = ", ".join(f"{what} {count}" for what, count in sorted(rows[name].items()) if count)
            print(f"{name}: {told}", flush=True)
    bad = sum(counts[what] for counts in rows.values() for what in NEVER)
    print(f"faults that did harm: {bad}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
