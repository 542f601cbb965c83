"""`wpcal seams --png`: a picture with the seams on it, never over one that exists."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.image as images
import numpy as np

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"


def test_seams_are_drawn_in_red_and_another_process_gives_the_same_bytes(
    wpcal: Callable[..., Any], tmp_path: Path
) -> None:
    command = [sys.executable, "-m", "wpcal", "seams", str(TEE), "--png", str(tmp_path / "a.png")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    picture = images.imread(tmp_path / "a.png")[..., :3]
    red = (picture[..., 0] > 0.6) & (picture[..., 1] < 0.4) & (picture[..., 2] < 0.4)
    halves = np.split(red, 2, axis=1)
    assert min(int(half.sum()) for half in halves) > 500  # four lines of 2 pixels and some hundred long, in each view
    assert picture[:, [0, -1]].min() == 1.0  # nothing is cut off at the sides
    wpcal("seams", TEE, "--png", tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_picture_is_not_overwritten_without_force(wpcal: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("mine", encoding="utf-8")
    done = wpcal("seams", TEE, "--png", tmp_path / "a.png")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "(--force)" in done.stderr
    assert (tmp_path / "a.png").read_text(encoding="utf-8") == "mine"
    assert wpcal("seams", TEE, "--png", tmp_path / "a.png", "--force").returncode == 0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
