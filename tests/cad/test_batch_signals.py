"""Ctrl-C, SIGTERM and SIGHUP at random moments: one line, the exit code of the signal, and nothing is left."""

import os
import random
import shutil
import signal
import subprocess
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

import wpcal
from tests.cad.batch_faults import Place, Reference, contents, ended, told
from tests.running import needs_proc

pytestmark = needs_proc
NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
COMMANDS = {"batch": "", "calibrate": "calibrate tee.step day0.csv -o {out}/own", "features": "features tee.step"}
START_S = 1.2
"""Within this time a command has imported what it needs; without other work on the machine in half of it."""
SOON_S = 0.05  #: A second signal comes so soon.
SOURCE = Path(wpcal.__file__).parent
DEEP, AT_ONCE = 60, 6


@dataclass(frozen=True, slots=True)
class Asked:
    """Which signals a command gets, and when."""

    command: str
    numbers: tuple[signal.Signals, ...]
    after_s: float
    again_s: float


def asked(rng: random.Random, *, seconds: float) -> Asked:
    """Return a command and its signals: a third of them twice in short succession, half of them at the start."""
    command = rng.choice(tuple(COMMANDS))
    numbers = tuple(rng.choice(NUMBERS) for _ in range(rng.choice((1, 1, 2))))
    whole = seconds if command == "batch" else START_S
    return Asked(command, numbers, rng.uniform(0.0, rng.choice((START_S, whole))), rng.uniform(0.0, SOON_S))


def check(reference: Reference, place: Place, what: Asked) -> None:
    """Send signals to a command."""
    process = place.start("--resume", command=COMMANDS[what.command].format(out=place.out))
    with suppress(subprocess.TimeoutExpired):
        process.wait(what.after_s)
    for number in what.numbers:
        process.send_signal(number)
        time.sleep(what.again_s)
    done = ended(process)
    place.nothing_left()
    lines = told(done.stderr)
    if done.returncode < 0:  # before wpcal takes signals; also after all was said
        assert done.returncode in {-number for number in what.numbers}, (what, done.stderr)
        if not before_wpcal(lines):
            assert len(lines) < len(what.numbers), (what, done.stderr)
    elif done.returncode not in (0, 1):
        assert done.returncode in {128 + number for number in what.numbers}, (what, done.stderr)
        assert len(lines) == 1, (what, done.stderr)
        assert lines[0].startswith(("wpcal: interrupted", "wpcal: ended by SIG")), what


def before_wpcal(lines: list[str]) -> bool:
    """Whether Python itself, which still starts, tells of Ctrl-C: no line of wpcal was run."""
    ours = [line for line in lines if f"{SOURCE}{os.sep}" in line]
    return lines[-1:] == ["KeyboardInterrupt"] and not ours


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(DEEP // AT_ONCE))
def test_signals_at_sixty_moments_end_a_command_in_one_line(seed: int, reference: Reference, tmp_path: Path) -> None:
    rng = random.Random(seed)
    place = Place(reference.jobs, tmp_path / "place")
    shutil.copytree(reference.place.cache, place.cache, dirs_exist_ok=True)
    for _ in range(AT_ONCE):
        check(reference, place, asked(rng, seconds=reference.seconds))
    shutil.rmtree(place.out / "own", ignore_errors=True)
    done = place.run("--resume")
    assert (done.returncode, told(done.stderr)) == (1, [])
    assert contents(place.out) == reference.whole
    place.nothing_left()
