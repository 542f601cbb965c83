"""`kill -9` at any moment of `wpcal batch`, of the command or of any of its processes, then `--resume`."""

import random
import shutil
from itertools import islice
from pathlib import Path

import pytest

from tests.cad.batch_faults import JOBS, Moment, Place, Reference, contents, moments, told
from tests.running import needs_proc

pytestmark = needs_proc
PLACES, AT_ONCE, AGAIN = 25, 5, 2  #: Batches, how many of them are one test, and how often each is killed.
CODES = (1, 2, -9)
"""Of a batch that is killed: a job of it is FAIL; a process was ended that others need; the command itself."""


def begin(reference: Reference, folder: Path, rng: random.Random) -> Place:
    """Return a place where nothing is, or the results of an earlier batch, and answers about the part or none."""
    place = Place(reference.jobs, folder)
    if rng.random() < 0.7:
        shutil.copytree(reference.place.cache, place.cache, dirs_exist_ok=True)
    if rng.random() < 0.5:
        for name, earlier in (("j0", "j0"), ("j1", "j2"), ("j3", "j1")):  # as they will be, and of other points
            shutil.copytree(reference.place.out / earlier, place.out / name)
        shutil.copy(reference.place.out / "summary.jsonl", place.out)
    return place


def check_what_is_there(reference: Reference, place: Place) -> None:
    """Every folder of a job is one that a batch wrote as a whole."""
    place.nothing_left()
    known = {_job(reference.place.out / f"j{number}") for number in range(JOBS)}
    for each in place.out.iterdir() if place.out.exists() else ():
        assert not each.is_dir() or _job(each) in known, each


def _job(folder: Path) -> frozenset[tuple[str, bytes]]:
    return frozenset((path.name, path.read_bytes()) for path in folder.iterdir())


def kill(reference: Reference, place: Place, moment: Moment) -> None:
    killed = place.disturb(moment, "--resume")
    assert killed.returncode in CODES, (moment, killed.stderr)
    assert len(told(killed.stderr)) == (killed.returncode == 2), (moment, killed.stderr)
    check_what_is_there(reference, place)


def resume(reference: Reference, place: Place) -> None:
    done = place.run("--resume")
    assert (done.returncode, told(done.stderr)) == (1, []), done.stderr
    assert contents(place.out) == reference.whole
    place.nothing_left()


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(PLACES // AT_ONCE))
def test_killed_at_fifty_moments_and_continued_twice_all_is_as_without_it(
    seed: int, reference: Reference, tmp_path: Path
) -> None:
    rng = random.Random(seed)
    every = moments(AT_ONCE * AGAIN, rng, changes=reference.changes, seconds=reference.seconds)
    for row in range(AT_ONCE):
        place = begin(reference, tmp_path / f"{row}", rng)
        for moment in islice(every, AGAIN):
            kill(reference, place, moment)
        resume(reference, place)
