"""`wpcal seams --png`: a picture with the seams on it, never over one that exists."""

import subprocess
import sys
from pathlib import Path

import matplotlib.image as images
import numpy as np

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"


def wpcal(*arguments: Path | str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "wpcal", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)


def test_seams_are_drawn_in_red_and_the_same_bytes_come_again(tmp_path: Path) -> None:
    done = wpcal("seams", TEE, "--png", tmp_path / "a.png")
    assert (done.returncode, done.stderr) == (0, "")
    picture = images.imread(tmp_path / "a.png")[..., :3]
    red = (picture[..., 0] > 0.6) & (picture[..., 1] < 0.4) & (picture[..., 2] < 0.4)
    halves = np.split(red, 2, axis=1)
    assert min(int(half.sum()) for half in halves) > 500  # four lines of 2 pixels and some hundred long, in each view
    assert picture[:, [0, -1]].min() == 1.0  # nothing is cut off at the sides
    wpcal("seams", TEE, "--png", tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_picture_is_not_overwritten_without_force(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("mine", encoding="utf-8")
    done = wpcal("seams", TEE, "--png", tmp_path / "a.png")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "(--force)" in done.stderr
    assert (tmp_path / "a.png").read_text(encoding="utf-8") == "mine"
    assert wpcal("seams", TEE, "--png", tmp_path / "a.png", "--force").returncode == 0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
