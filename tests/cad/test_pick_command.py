"""What `wpcal pick` must refuse before it reads the part."""

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from cad.cli.pick import pick
from cad.cli.pick_start import require_table, table_of
from tests.running import needs_proc
from wpcal.core.errors import InputError

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"


@pytest.mark.parametrize("target", ["tee.step", "folder", "link.csv", "drafted", "backed"])
def test_other_part_never_takes_the_part_or_a_folder_for_the_table(tmp_path: Path, target: str) -> None:
    part = Path(shutil.copy(TEE, tmp_path / "tee.step"))
    (tmp_path / "folder").mkdir()
    (tmp_path / "link.csv").symlink_to(part)
    (tmp_path / "drafted.draft").symlink_to(part)
    (tmp_path / "backed.bak").mkdir()
    before = part.read_bytes()
    result = CliRunner().invoke(pick, [str(part), "-o", str(tmp_path / target), "--other-part", "--no-browser"])
    assert isinstance(result.exception, InputError)
    assert "is the part itself" in str(result.exception) or "is a directory" in str(result.exception)
    assert [path.name for path in tmp_path.iterdir() if path.is_file() and not path.is_symlink()] == ["tee.step"]
    assert part.read_bytes() == before


def test_a_part_that_is_named_like_a_draft_is_not_taken_for_one(tmp_path: Path) -> None:
    part = Path(shutil.copy(TEE, tmp_path / "tee.draft"))
    result = CliRunner().invoke(pick, [str(part), "-o", str(tmp_path / "tee"), "--no-browser"])
    assert "is the part itself" in str(result.exception)


@pytest.mark.parametrize(
    ("taught", "out"),
    [
        (None, "taught.csv"),
        ("a/points.csv", "a/points.csv"),
        ("TEACH.dat", "taught.csv"),
        ("p.mod", "taught.csv"),
        ("a/x.csv.bak", "a/x.csv"),
        ("x.csv.draft", "x.csv"),
        ("x.csv.draft.bak", "x.csv"),
        ("p.mod.bak", "taught.csv"),
    ],
)
def test_the_table_that_is_opened_is_the_one_that_is_saved(taught: str | None, out: str) -> None:
    assert table_of(None if taught is None else Path(taught)) == Path(out)


@pytest.mark.parametrize(
    ("out", "said"),
    [
        pytest.param("/proc/taught.csv", "/proc/taught.csv: cannot be written", marks=needs_proc),
        ("x" * 250, "cannot be written: file name too long"),
        ("a\0b", "cannot be written: embedded null byte"),
        ("x.csv.bak", "is the name of a draft or a backup"),
        ("locked.csv", "is read-only"),
        ("none/x.csv", "no such folder"),
    ],
)
def test_an_out_that_cannot_be_written_is_refused_at_the_start(tmp_path: Path, out: str, said: str) -> None:
    (tmp_path / "locked.csv").touch(mode=0o444)
    with pytest.raises(InputError, match=said):
        require_table(tmp_path / out, TEE, is_asked=True)
    assert [path.name for path in tmp_path.iterdir()] == ["locked.csv"]


def test_a_table_that_was_only_opened_may_be_read_only(tmp_path: Path) -> None:
    (tmp_path / "locked.csv").touch(mode=0o444)
    require_table(tmp_path / "locked.csv", TEE, is_asked=False)
    assert [(path.name, path.stat().st_size) for path in tmp_path.iterdir()] == [("locked.csv", 0)]
