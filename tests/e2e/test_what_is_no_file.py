"""Pipes, devices, names that no record can hold: one line and exit code 2 from the commands, at once."""

import os
import shutil
from pathlib import Path

import pytest

from tests.running import run_here

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
LONG = "a" * 300


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("tee.step", "taught.csv"):
        shutil.copy(TEE / name, tmp_path / name)
    os.mkfifo(tmp_path / "pipe.step")
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "endless.step").symlink_to("/dev/zero")
    (tmp_path / "endless.csv").symlink_to("/dev/zero")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("features", "pipe.step"), "pipe.step: is a pipe, expected a STEP file"),
        (("features", "endless.step"), "endless.step: is a device"),
        (("fit", "pipe.csv"), "pipe.csv: is a pipe"),
        (("fit", "endless.csv"), "endless.csv: is a device"),
        (("calibrate", "tee.step", "pipe.csv", "-o", "out"), "pipe.csv: is a pipe"),
        (("features", "x\udcff.step"), r"x\xff.step: the name is not UTF-8 text; rename the file or the folder"),
        (("calibrate", "tee.step", "taught.csv", "-o", "x\udcff"), r"x\xff: the name is not UTF-8 text"),
        (("calibrate", "tee.step", "taught.csv", "-o", LONG), "file name too long"),
        (("advise", "tee.step", "-o", f"{LONG}.csv"), "file name too long"),
        (("sheet", "tee.step", "-o", f"{LONG}.svg"), "file name too long"),
        (("pick", "tee.step", "--no-browser", "-o", f"{LONG}.csv"), "file name too long"),
        (("export", LONG, "-f", "rapid", "-o", "out"), "file name too long"),
        (("diff", LONG, LONG), "file name too long"),
        (("report", LONG), "file name too long"),
    ],
    ids=lambda value: " ".join(value)[:40] if isinstance(value, tuple) else "",
)
def test_one_line_and_exit_code_2(folder: Path, arguments: tuple[str, ...], says: str) -> None:
    before = sorted(os.listdir(folder))
    ended = run_here(*arguments)
    assert ended.returncode == 2, ended.stderr
    assert says in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert sorted(os.listdir(folder)) == before
