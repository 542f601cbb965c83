"""The same input gives the same bytes: in another process, with another hash seed, from another folder."""

import sys
from pathlib import Path

import pytest

from tests.few import few
from tests.running import run_command

FIXTURES = Path(__file__).parents[2] / "fixtures"


def calibrate(name: str, out: Path, hash_seed: str) -> dict[str, bytes]:
    source = FIXTURES / name
    files = (str(source / f"{name}.step"), str(source / "taught.csv"))
    run("calibrate", *files, "-o", str(out), "--mark-seams", out=out, hash_seed=hash_seed)
    return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


def run(*arguments: str, out: Path, hash_seed: str) -> None:
    done = run_command(sys.executable, "-m", "wpcal", *arguments, cwd=out.parent, PYTHONHASHSEED=hash_seed)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", few(["frame", "saddle"], 1))
def test_two_runs_write_the_same_bytes(name: str, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    first = calibrate(name, tmp_path / "out", "1")
    second = calibrate(name, tmp_path / "elsewhere" / "again", "2")
    assert set(first) == {
        "calibration.json",
        "seams.json",
        "seams.csv",
        f"{name}.calibrated.step",
        "part.glb",
        "job.json",
        "report.html",
    }
    assert first == second


@pytest.mark.deep
def test_two_runs_draw_the_same_dxf(tmp_path: Path) -> None:
    part = str(FIXTURES / "tee" / "tee.step")
    drawn = []
    for seed in ("1", "3"):  # with these two, the classes of the drawing came in another order
        sheet = tmp_path / f"{seed}.dxf"
        run("sheet", part, "-o", str(sheet), "--touch", "V2,V4,V16", out=sheet, hash_seed=seed)
        drawn.append(sheet.read_bytes())
    assert drawn[0] == drawn[1]
