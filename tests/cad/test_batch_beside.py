"""Other commands beside a batch, on its folder and its cache, and what a power cut leaves in them."""

import os
import shutil
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.cad.batch_faults import JOBS, Place, Reference, Started, contents, ended, processes, told
from tests.running import TIMEOUT_S, needs_proc, run_here

pytestmark = needs_proc
REFUSED = "another run is writing into it now; wait for its end"


@contextmanager
def stopped(place: Place, process: Started) -> Iterator[None]:
    """Let a batch stand still as soon as it has a server, and go on at the end of the block."""
    until = time.monotonic() + TIMEOUT_S
    while len(processes(place.mark)) < 2 and time.monotonic() < until:
        time.sleep(0.01)
    still = list(processes(place.mark))
    for each in still:
        os.kill(each, signal.SIGSTOP)
    try:
        yield
    finally:
        for each in still:
            os.kill(each, signal.SIGCONT)


@pytest.mark.deep
def test_beside_a_batch_no_other_writes_into_its_folder_and_no_result_of_others_is_lost(
    reference: Reference, tmp_path: Path
) -> None:
    place = Place(reference.jobs, tmp_path / "place")
    shutil.copytree(reference.place.cache, place.cache, dirs_exist_ok=True)
    first = place.start()
    with stopped(place, first):
        second = Place(reference.jobs, place.folder)  # the same folder, processes of its own
        for options in ((), ("--resume",)):
            refused = second.run(*options)
            assert (refused.returncode, refused.stdout) == (2, "")
            assert told(refused.stderr) == [f"wpcal: {place.out}: {REFUSED}"]
        for name in ("own", f"j{JOBS - 2}"):
            command = f"calibrate tee.step day{JOBS - 2}.csv -o {place.out / name}"
            assert second.run(command=command).returncode == 0
        own = {path.name: path.read_bytes() for path in (place.out / "own").iterdir()}
    done = ended(first)
    assert done.returncode == 1
    assert f"j{JOBS - 2}: {place.out / f'j{JOBS - 2}'}: holds other results, of wpcal calibrate" in done.stdout
    for name in ("own", f"j{JOBS - 2}"):
        assert {path.name: path.read_bytes() for path in (place.out / name).iterdir()} == own
        shutil.rmtree(place.out / name)
    assert place.run("--resume").returncode == 1
    assert contents(place.out) == reference.whole
    place.nothing_left()


@pytest.mark.deep
def test_what_a_power_cut_left_half_is_mended(reference: Reference, tmp_path: Path) -> None:
    """Half a line of the summary, half a record, half of each kept answer."""
    place = Place(reference.jobs, tmp_path / "place")
    for source, target in ((reference.place.cache, place.cache), (reference.place.out, place.out)):
        shutil.copytree(source, target, dirs_exist_ok=True)
    for file in (*place.cache.iterdir(), place.out / "summary.jsonl", place.out / "j1" / "job.json"):
        data = file.read_bytes()
        file.write_bytes(data[: 2 * len(data) // 3])
    with (place.out / "summary.csv").open("ab") as table:
        table.write(b"j")
    for command in (("drift", place.out, "-o", place.folder / "drift.html"), ("verify", place.out)):
        refused = run_here(*command)
        assert refused.returncode in (1, 2)
        assert "summary.jsonl" in refused.stderr + refused.stdout
        assert refused.stderr.count("\n") <= 1
    done = place.run("--resume")
    assert (done.returncode, told(done.stderr)) == (1, [])
    assert f"{JOBS - 1} of them complete before" in done.stdout
    assert contents(place.out) == reference.whole
    for file in place.cache.iterdir():
        assert file.read_bytes() == (reference.place.cache / file.name).read_bytes(), file.name
    place.nothing_left()


@pytest.mark.deep
def test_two_batches_that_find_the_same_part_at_once_share_a_cache(reference: Reference, tmp_path: Path) -> None:
    places = [Place(reference.jobs, tmp_path / name) for name in "ab"]
    shared = {"WPCAL_CACHE": str(places[0].cache)}
    for process in [place.start(environment=shared) for place in places]:
        done = ended(process)
        assert (done.returncode, told(done.stderr)) == (1, [])
    for place in places:
        assert contents(place.out) == reference.whole
        place.nothing_left()
    kept = {path.name: path.read_bytes() for path in places[0].cache.iterdir()}
    assert kept == {path.name: path.read_bytes() for path in reference.place.cache.iterdir()}
