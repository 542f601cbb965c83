"""Only regular files of a sensible size are read, under names that can be written down."""

import os
from pathlib import Path

import pytest

from tests.running import needs_proc
from wpcal.core.errors import InputError
from wpcal.core.input_file import LIMIT_VARIABLE, holds_file, read_bytes, require_name


def test_a_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "Träger.csv"
    path.write_bytes(b"0123456789")
    link = tmp_path / "link"
    link.symlink_to(path)
    assert read_bytes(link) == b"0123456789"
    assert read_bytes(path, first=4) == b"0123"


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "endless").symlink_to("/dev/zero")
    for name, says in {
        "pipe": "is a pipe",
        "endless": "is a device",
        ".": "is a folder",
        "none": "no such file",
    }.items():
        with pytest.raises(InputError, match=says):
            read_bytes(tmp_path / name)


def test_the_limit_is_said_and_can_be_raised(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "large"
    with path.open("wb") as file:
        file.truncate(3_000_000)
    with pytest.raises(InputError, match=f"has 3 MB, more than the limit of 2 MB; .*{LIMIT_VARIABLE}"):
        read_bytes(path, most_mb=2)
    monkeypatch.setenv(LIMIT_VARIABLE, "4")
    assert len(read_bytes(path, most_mb=2)) == 3_000_000
    monkeypatch.setenv(LIMIT_VARIABLE, "many")
    with pytest.raises(InputError, match=f"{LIMIT_VARIABLE}: expected a size in MB"):
        read_bytes(path)


@needs_proc
def test_a_file_whose_size_is_not_known_is_limited_too() -> None:
    with pytest.raises(InputError, match="has more than"):
        read_bytes(Path("/proc/self/status"), most_mb=1e-4)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("x\udcff.csv", r"x\\xff.csv: the name is not UTF-8 text"),
        ("a\0b", "null character"),
        ("a" * 300, "name too long"),
    ],
)
def test_names_that_no_record_can_hold(name: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=says):
        require_name(tmp_path / name)
    with pytest.raises(InputError, match=says):
        read_bytes(tmp_path / name)


def test_a_name_that_was_read_is_a_file_of_that_folder_or_none(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    for name in ("here", "inner/there"):
        (tmp_path / name).write_bytes(b"")
    assert holds_file(tmp_path, "here")
    for name in ("inner/there", "../here", "/etc/passwd", "none", "", ".", "a" * 300, "a\0b", "\ud800"):
        assert not holds_file(tmp_path, name)
