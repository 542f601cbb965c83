"""The example scripts of docs/ run as a user runs them."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def run_example(name: str, *arguments: Path | str) -> str:
    command = [sys.executable, ROOT / "docs" / "examples" / name, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_one_call_finds_the_place_it_was_moved_to() -> None:
    shown = run_example("one_call.py")
    assert "PASS: largest residual 0.000000 mm" in shown
    assert shown.count(": tee, ") == 4


def test_in_steps_writes_the_moved_part(tmp_path: Path) -> None:
    fixture, moved = ROOT / "fixtures" / "tee", tmp_path / "moved.step"
    shown = run_example("in_steps.py", fixture / "tee.step", fixture / "taught.csv", moved)
    assert "PASS" in shown
    assert "note:" not in shown
    assert moved.stat().st_size > (fixture / "tee.step").stat().st_size
