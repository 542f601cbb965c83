"""`wpcal calibrate --cell --holder-joints`: robot 1 touches the part that robot 2 holds; the cell learns the grasp."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.running import Ended, run_here
from wpcal.planning.cell.cell_file import read_cell

pytestmark = pytest.mark.usefixtures("kernel_here")
FIXTURES = Path(__file__).parents[2] / "fixtures"
SADDLE = FIXTURES / "saddle" / "saddle.step"
CELL = FIXTURES / "cells" / "two-mh6.json"
JOINTS_DEG = (19.0, 21.0, 36.0, 15.0, -77.0, 40.0)
FILE_MM = 1e-6  #: The taught points of the fixture have nine decimals; the calibration of exact points keeps six.


def calibrate(out: Path, *arguments: str) -> Ended:
    return run_here("calibrate", SADDLE, FIXTURES / "saddle" / "taught_exact.csv", "-o", out, *arguments)


def test_the_cell_written_has_the_part_where_it_was_touched(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = calibrate(out, "--cell", str(CELL), "--holder-joints", ",".join(map(str, JOINTS_DEG)))
    assert (done.returncode, done.stderr) == (0, "")
    assert "cell.json" in done.stdout
    cell = read_cell(out / "cell.json")
    held = np.linalg.inv(cell.T_world_base.matrix) @ cell.held_places(np.radians([JOINTS_DEG]))[0]
    found = json.loads((out / "calibration.json").read_text())
    np.testing.assert_allclose(held, found["T_base_part"], rtol=0, atol=FILE_MM)
    assert not cell.T_part.is_close(read_cell(CELL).T_part, atol_mm=1.0, atol_rad=1e-3)


def test_one_of_the_two_alone_is_refused_and_nothing_is_written(tmp_path: Path) -> None:
    for arguments in (("--cell", str(CELL)), ("--holder-joints", "0,0,0,0,0,0")):
        done = calibrate(tmp_path / "out", *arguments)
        assert (done.returncode, done.stdout) == (2, "")
        assert "--cell and --holder-joints belong together" in done.stderr
        assert done.stderr.count("\n") == 1
    done = calibrate(tmp_path / "out", "--cell", str(CELL), "--holder-joints", "0,0,0,0,200,0")
    assert done.returncode == 2
    assert "B is 200 deg" in done.stderr
    assert not (tmp_path / "out").exists()
