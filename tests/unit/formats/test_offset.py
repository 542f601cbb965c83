"""The part's place as the datum of a machine tool: read back by the rules of each control, it is the pose."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.running import run_here

GOLDEN = Path(__file__).parents[3] / "fixtures" / "tee" / "golden"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("offset")
    done = run_here("export", GOLDEN, "-f", "offset", "-o", folder)
    assert done.returncode == 0, done.stderr
    return folder / "offset"


@pytest.mark.parametrize(
    ("name", "place", "turn", "sequence"),
    [
        ("WPCAL.SPF", r"CTRANS\(X,(.*?),Y,(.*?),Z,(.*?)\)", r"CROT\(X,(.*?),Y,(.*?),Z,(.*?)\)", "ZYX"),
        ("WPCAL.H", r"7\.1 X(\S+)\n.*7\.2 Y(\S+)\n.*7\.3 Z(\S+)\n", r"SPA(\S+) SPB(\S+) SPC(\S+) ", "xyz"),
    ],
)
def test_the_datum_is_the_pose(written: Path, name: str, place: str, turn: str, sequence: str) -> None:
    text = (written / name).read_text()
    p, angles = (np.array(re.search(each, text).groups(), dtype=float) for each in (place, turn))  # type: ignore[union-attr]
    # Sinumerik: about Z, then the new Y, then the new X; Heidenhain: about fixed X, then Y, then Z
    R = Rotation.from_euler(sequence, angles if sequence == "xyz" else angles[::-1], degrees=True).as_matrix()
    T = np.array(json.loads((GOLDEN / "calibration.json").read_text())["T_base_part"])
    assert np.abs(p - T[:3, 3]).max() <= 1e-4
    assert np.abs(R - T[:3, :3]).max() <= 1e-7


def test_a_tilt_that_a_rotation_about_z_leaves_out_is_told(written: Path) -> None:
    text = (written / "WPCAL.nc").read_text()
    T = np.array(json.loads((GOLDEN / "calibration.json").read_text())["T_base_part"])
    tilt = np.arccos(T[2, 2])
    (off,) = re.findall(r"NOT LEVEL: .* 100 mm away that is (\S+) mm", text)
    assert float(off) == pytest.approx(100.0 * np.sin(tilt), abs=0.01)
    assert max(map(len, text.splitlines())) <= 120
