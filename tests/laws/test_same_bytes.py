"""The same input gives the same bytes: in another process, with another hash seed, from another folder."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

FIXTURES = Path(__file__).parents[2] / "fixtures"


def calibrate(name: str, out: Path, hash_seed: str) -> dict[str, bytes]:
    source = FIXTURES / name
    command = [sys.executable, "-m", "wpcal", "calibrate", str(source / f"{name}.step"), str(source / "taught.csv")]
    done = subprocess.run(
        [*command, "-o", str(out), "--mark-seams"],
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        cwd=out.parent,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


@pytest.mark.parametrize("name", ["saddle", "frame"])
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
        "report.html",
    }
    assert first == second
