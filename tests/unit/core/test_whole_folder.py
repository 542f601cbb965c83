"""Killed at any moment, a run leaves all old files or all new ones, and never loses a file of the user."""

import errno
import os
import signal
import sys
import warnings
from pathlib import Path

import pytest

from tests.few import few
from wpcal.core import whole_folder
from wpcal.core.errors import ErrorCode, InputError
from wpcal.core.records import new_directory, write_file

HEAD = "calibration.json"
OURS = (HEAD, "a.calibrated.step", "seams.json")
USERS = {"notes.txt": "mine", "rapid/WPCAL.mod": "program", "rapid/deep/x": "x"}
MOST_MOMENTS = 400  #: Far above the number of system calls of one run.
OLD_S = 2 * whole_folder.ABANDONED_S


def fill(folder: Path, text: str) -> None:
    with new_directory(folder, overwrite=True, head=HEAD, leave_out=("b.calibrated.step",)) as temporary:
        for name in OURS:
            (temporary / name).write_text(text)


def started(tmp_path: Path) -> Path:
    """A folder with an old result, a file of an earlier part, and files of the user."""
    out = tmp_path / "out"
    fill(out, "old")
    (out / "b.calibrated.step").write_text("old")
    for name, text in USERS.items():
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_text(text)
    (out / "link").symlink_to("nowhere")
    return out


def state(out: Path) -> str:
    """Say what a reader finds; the files of the user must be there in every case."""
    assert {name: (out / name).read_text() for name in USERS} == USERS
    assert (out / "link").is_symlink()
    if not (out / HEAD).exists():
        return "no result"
    found = {(out / name).read_text() for name in OURS}
    assert len(found) == 1, "old and new files are mixed"
    return found.pop()


def fill_and_be_killed(out: Path, moment: int) -> bool:
    """Write a new result in a process that is killed with signal 9 at its nth system call; whether it was killed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of fork beside threads, which the child does not use
        child = os.fork()
    if child == 0:
        count = 0

        def kill_at(event: str, _arguments: object) -> None:
            nonlocal count
            if event.startswith(("os.", "open", "shutil.", "ctypes.")):
                count += 1
                if count == moment:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(kill_at)
        fill(out, "new")
        os._exit(0)
    _, status = os.waitpid(child, 0)
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) == 0
    return os.WIFSIGNALED(status)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("exchanges", few([True, False], 1))
def test_killed_at_every_system_call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, exchanges: bool) -> None:
    if not exchanges:
        monkeypatch.setattr(whole_folder, "_exchange", lambda *_: False)
    seen = set()
    for moment in range(1, MOST_MOMENTS):
        place = tmp_path / str(moment)
        place.mkdir()
        out = started(place)
        killed = fill_and_be_killed(out, moment)
        seen.add(state(out))
        for left in place.glob(".*"):
            os.utime(left, (0, 0))
        fill(out, "third")
        assert state(out) == "third"
        assert [path.name for path in place.iterdir()] == ["out"]
        if not killed:
            break
    assert not killed
    assert seen == ({"old", "new"} if exchanges else {"old", "new", "no result"})


def test_files_of_an_earlier_part_do_not_stay(tmp_path: Path) -> None:
    out = started(tmp_path)
    fill(out, "new")
    assert not (out / "b.calibrated.step").exists()
    assert state(out) == "new"


def test_what_is_saved_during_the_exchange_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out, exchange = started(tmp_path), whole_folder._exchange

    def save_and_exchange(first: Path, second: Path) -> bool:
        (second / "late.csv").write_text("late")
        (second / "rapid" / "WPCAL.mod").unlink()
        (second / "rapid" / "WPCAL.mod").write_text("saved again")
        return exchange(first, second)

    monkeypatch.setattr(whole_folder, "_exchange", save_and_exchange)
    fill(out, "new")
    assert (out / "late.csv").read_text() == "late"
    assert (out / "rapid" / "WPCAL.mod").read_text() == "saved again"
    assert (out / HEAD).read_text() == "new"


def test_a_folder_under_the_name_of_a_file_is_refused_before_anything_is_replaced(tmp_path: Path) -> None:
    out = started(tmp_path)
    (out / "seams.json").unlink()
    (out / "seams.json").mkdir()
    with pytest.raises(InputError, match=r"seams\.json: is a folder"):
        fill(out, "new")
    assert (out / HEAD).read_text() == (out / "a.calibrated.step").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("empty_before", [True, False])
def test_of_two_runs_into_one_new_folder_the_second_is_refused(tmp_path: Path, empty_before: bool) -> None:
    out = tmp_path / "out"
    if empty_before:
        out.mkdir()

    def run_second_inside_first() -> None:
        with new_directory(out, overwrite=False) as first:
            (first / HEAD).write_text("first")
            with new_directory(out, overwrite=False) as second:
                (second / HEAD).write_text("second")

    with pytest.raises(InputError, match="another run wrote into it") as refused:
        run_second_inside_first()
    assert refused.value.code is ErrorCode.EXISTS
    assert (out / HEAD).read_text() == "second"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_linked_folder_stays_linked(tmp_path: Path) -> None:
    started(tmp_path)
    (tmp_path / "link").symlink_to("out")
    fill(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert state(tmp_path / "out") == "new"


def test_the_folder_of_the_shell_stays_the_same_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = started(tmp_path)
    monkeypatch.chdir(out)
    fill(Path(), "new")
    assert os.path.samestat(Path().stat(), out.stat())
    assert state(Path()) == "new"


def test_modes_are_those_of_the_user(tmp_path: Path) -> None:
    out = tmp_path / "out"
    fill(out, "old")
    (tmp_path / "plain").mkdir()
    assert out.stat().st_mode == (tmp_path / "plain").stat().st_mode
    out.chmod(0o750)
    fill(out, "new")
    assert out.stat().st_mode & 0o777 == 0o750


def test_a_link_at_a_temporary_name_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("precious")
    (tmp_path / ".a.txt.part").symlink_to("precious")
    write_file(tmp_path / "a.txt", "new", overwrite=False)
    assert (tmp_path / "precious").read_text() == "precious"
    assert (tmp_path / "a.txt").read_text() == "new"


def test_a_file_that_appears_meanwhile_is_not_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sync = os.fsync

    def sync_while_another_writes(descriptor: int) -> None:
        sync(descriptor)
        (tmp_path / "a.txt").write_text("other")

    monkeypatch.setattr(os, "fsync", sync_while_another_writes)
    with pytest.raises(InputError, match="exists"):
        write_file(tmp_path / "a.txt", "mine", overwrite=False)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a.txt": "other"}


def test_a_run_that_another_disturbs_is_refused_and_mixes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = started(tmp_path)
    exchange, refused = whole_folder._exchange, []

    def second_run_meanwhile(first: Path, second: Path) -> bool:
        monkeypatch.setattr(whole_folder, "_exchange", exchange)
        with pytest.raises(InputError, match="another run is writing into it now") as error:
            fill(out, "second")
        refused.append(error)
        return exchange(first, second)

    monkeypatch.setattr(whole_folder, "_exchange", second_run_meanwhile)
    fill(out, "first")
    assert len(refused) == 1
    assert state(out) == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("number", [errno.EIO, errno.ENOSPC, errno.EDQUOT])
def test_what_the_disk_did_not_take_is_an_error_and_the_old_result_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    out = started(tmp_path)

    def refuse(_: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(InputError, match=r"out: cannot be written: "):
        fill(out, "new")
    with pytest.raises(InputError, match=r"notes\.txt: cannot be written: "):
        write_file(out / "notes.txt", "new", overwrite=True)
    assert {(out / name).read_text() for name in OURS} == {"old"}
    assert (out / "notes.txt").read_text() == "mine"
