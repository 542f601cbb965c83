"""Inputs of a batch that change while they are read: a recorded SHA-256 is ever that of the bytes that were used."""

import itertools
import json
import os
import shutil
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cad.batch import jobs
from cad.batch.jobs import OpenedPart, open_part, run_job
from tests.cad.batch_faults import Place, told, write_jobs
from tests.running import run_here
from wpcal.core.errors import InputError
from wpcal.core.input_file import sha256_of
from wpcal.core.issue import Issue
from wpcal.core.whole_folder import flushed_later

JOBS = 40
SWAPS_S = 0.003


@pytest.fixture(scope="module", autouse=True)
def flushes() -> Iterator[None]:
    """A job says for its whole process that another one flushes; the tests after this module flush again."""
    with flushed_later():
        yield


@pytest.fixture(scope="module")
def opened() -> OpenedPart:
    return open_part(str(Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"), (), use_cache=False)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write_jobs(tmp_path, 3)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def job(folder: Path, *words: str) -> dict[str, Any]:
    return {"name": "j0", "part": "tee.step", "taught": "day0.csv", "words": words, "out": folder / "j0"}


IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
TORCH = next((Path(__file__).parents[2] / "wpcal" / "robot" / "torch" / "torches").glob("*.json"))
MOVED = [[1, 0, 0, 5], *IDENTITY[1:]]


@contextmanager
def holding(name: str, other: bytes) -> Iterator[None]:
    """Let a file have other contents for a while."""
    before = Path(name).read_bytes()
    Path(name).write_bytes(other)
    yield
    Path(name).write_bytes(before)


def test_a_table_that_is_changed_and_changed_back_fails_its_job(
    opened: OpenedPart, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its hash is the same before and after; what was read between has another."""
    read = jobs.calibrate_arguments

    def reading(*arguments: Any, **settings: Any) -> dict[str, Any]:
        with holding("day0.csv", Path("day1.csv").read_bytes()):
            return read(*arguments, **settings)

    monkeypatch.setattr(jobs, "calibrate_arguments", reading)
    with pytest.raises(InputError, match=r"day0\.csv: was changed while it was read; run this again"):
        run_job(opened, folder=folder / "w0", pages="none", **job(folder))
    assert not (folder / "j0").exists()


def test_an_option_file_is_recorded_as_it_was_read(
    opened: OpenedPart, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved, read = json.dumps(MOVED).encode(), jobs.read_words
    Path("nominal.json").write_text(json.dumps(IDENTITY))

    @contextmanager
    def reading(words: Sequence[str]) -> Iterator[Any]:
        with ExitStack() as stack:
            with holding("nominal.json", moved):
                found = stack.enter_context(read(words))
            yield found

    monkeypatch.setattr(jobs, "read_words", reading)
    run_job(opened, folder=folder / "w0", pages="none", **job(folder, "--nominal=nominal.json"))
    [file] = json.loads((folder / "j0" / "job.json").read_text())["inputs"]["files"]
    assert file == {"file": "nominal.json", "sha256": sha256_of(moved)}


def test_a_file_of_the_seams_that_changes_after_the_part_was_opened_fails_its_job(
    opened: OpenedPart, folder: Path
) -> None:
    Path("torch.json").write_bytes(TORCH.read_bytes())
    known = replace(opened, files=(("torch.json", "0" * 64),))
    with pytest.raises(InputError, match=r"torch\.json: was changed while it was read"):
        run_job(known, folder=folder / "w0", pages="none", **job(folder, "--torch=torch.json"))


def test_a_table_that_is_changed_after_it_was_read_changes_nothing(opened: OpenedPart, folder: Path) -> None:
    """The record has the hash of what was used."""
    before = sha256_of(Path("day0.csv").read_bytes())

    def changing(*arguments: object, **settings: object) -> tuple[Issue, ...]:
        shutil.copy("day1.csv", "day0.csv")
        return opened.means.write_moved(*arguments, **settings)

    changed = replace(opened, means=replace(opened.means, write_moved=changing))
    run_job(changed, folder=folder / "w0", pages="none", **job(folder))
    written = [json.loads((folder / "j0" / name).read_text())["inputs"] for name in ("calibration.json", "job.json")]
    assert {inputs["taught"]["sha256"] for inputs in written} == {before}


@contextmanager
def swapping(*swaps: tuple[Path, bytes, bytes]) -> Iterator[None]:
    """Exchange the contents of files all the time, with the same size and time of change."""
    over = threading.Event()

    def work() -> None:
        for turn in itertools.count():
            for path, *both in swaps:
                new = path.with_suffix(".next")
                new.write_bytes(both[turn % 2])
                os.utime(new, (1e9, 1e9))
                os.replace(new, path)
            if over.wait(SWAPS_S):
                return

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@pytest.mark.deep
def test_of_files_that_are_exchanged_all_the_time_every_result_is_of_its_hashes(tmp_path: Path) -> None:
    """Two parts and two tables of the same size and time: each job is one of the four results, or is refused."""
    write_jobs(tmp_path, 2)
    part = (tmp_path / "tee.step").read_bytes()
    parts = (part, part.replace(b"'tee'", b"'eet'"))
    assert parts[0] != parts[1]
    tables = tuple((tmp_path / f"day{number}.csv").read_bytes() for number in range(2))
    expected: dict[tuple[str, str], dict[str, bytes]] = {}
    for row, bytes_of_part in enumerate(parts):
        for column, bytes_of_table in enumerate(tables):
            place = tmp_path / f"{row}{column}"
            place.mkdir()
            (place / "tee.step").write_bytes(bytes_of_part)
            (place / "day0.csv").write_bytes(bytes_of_table)
            run_here("calibrate", place / "tee.step", place / "day0.csv", "-o", place / "out")
            expected[sha256_of(bytes_of_part), sha256_of(bytes_of_table)] = results(place / "out")
    lines = [f"j{number},tee.step,day0.csv" for number in range(JOBS)]
    (tmp_path / "jobs.csv").write_text("\n".join(["job,part,taught", *lines]) + "\n")
    place = Place(tmp_path / "jobs.csv", tmp_path / "swapped")
    with swapping((tmp_path / "tee.step", *parts), (tmp_path / "day0.csv", *tables)):
        done = place.run("--report", "none")
    assert done.returncode in (0, 1)
    assert told(done.stderr) == []
    found = [each for each in place.out.iterdir() if each.is_dir()]
    seen = set()
    for each in found:
        inputs = json.loads((each / "job.json").read_text())["inputs"]
        hashes = inputs["part"]["sha256"], inputs["taught"]["sha256"]
        assert results(each) == expected[hashes]
        seen.add(hashes[1])
    assert len(seen) == 2
    refused = [line for line in (place.out / "summary.jsonl").read_text().splitlines() if '"ERROR"' in line]
    assert all("was changed while it was read; run this again" in line for line in refused)
    assert len(found) + len(refused) == JOBS


def results(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name not in ("job.json", "report.html")}
