"""`wpcal batch` on disks that are full: one line, nothing half written, and `--resume` completes it when there is room.

The disks are file systems in memory of a few hundred kB, mounted for the test; they fill as a real disk does.
"""

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.cad.batch_faults import Place, Reference, contents, told

ROOM_KB = (0, 16, 60, 150, 250, 330, 400, 440, 470, 500, 560)
"""From nothing to nearly all: a job has 110 kB, that with a page more."""


@contextmanager
def small_disk(folder: Path, size_kb: int) -> Iterator[None]:
    """Mount a disk of a size; `grow` makes room on it."""
    options = f"size={size_kb}k" if size_kb else "nr_inodes=1,size=4k"
    command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    sees_mounts = Path("/proc/self/mountinfo").exists()
    if not sees_mounts or subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("no disk can be mounted")
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def grow(folder: Path) -> None:
    subprocess.run(["mount", "-o", "remount,size=50m,nr_inodes=0", str(folder)], check=True)


@pytest.mark.deep
@pytest.mark.parametrize("size_kb", ROOM_KB)
def test_the_disk_of_the_output_is_full_sooner_or_later(size_kb: int, reference: Reference, tmp_path: Path) -> None:
    """What is complete stays, and the rest is done when there is room."""
    place = Place(reference.jobs, tmp_path / "place")
    shutil.copytree(reference.place.cache, place.cache, dirs_exist_ok=True)
    place.out.mkdir()
    with small_disk(place.out, size_kb):
        done = place.run()
        place.nothing_left()
        [line] = told(done.stderr)
        assert (done.returncode, done.stdout) == (2, "")
        assert line.startswith(f"wpcal: {place.out}")
        assert "cannot be written: no space left on device" in line
        assert ".wpcal" not in line
        assert "of 4 jobs are done; continue with: wpcal batch" in line
        there = [each for each in place.out.iterdir() if each.is_dir()]
        assert all((each / "job.json").is_file() for each in there)
        done_jobs = int(line.partition(" of 4 jobs are done")[0].rpartition(" ")[2])
        assert done_jobs <= len(there) <= done_jobs + 1  # two run at a time: the other one may just have ended
        lines = (place.out / "summary.jsonl").read_bytes() if done_jobs else b""
        assert lines.count(b"\n") == done_jobs
        assert lines[-1:] in (b"\n", b"")
        grow(place.out)
        done = place.run("--resume")
        assert (done.returncode, told(done.stderr)) == (1, [])
        assert contents(place.out) == reference.whole
        place.nothing_left()


@pytest.mark.deep
def test_full_disks_of_the_cache_and_of_temporary_files_change_nothing(reference: Reference, tmp_path: Path) -> None:
    """What cannot be kept is found again by the next command."""
    place = Place(reference.jobs, tmp_path / "place")
    with small_disk(place.cache, 16), small_disk(place.tmp, 8):
        (place.tmp / "full").write_bytes(b"x" * 8192)
        done = place.run()
        (place.tmp / "full").unlink()
        assert (done.returncode, told(done.stderr)) == (1, [])
        assert contents(place.out) == reference.whole
        place.nothing_left()
        answers = {path.name: path.read_bytes() for path in place.cache.iterdir()}
    assert answers.items() <= {path.name: path.read_bytes() for path in reference.place.cache.iterdir()}.items()
