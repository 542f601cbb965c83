"""The place of robot 2 from points that both robots touched: through the command, into a cell that can be read."""

import csv
import json

import numpy as np
import pytest
from click.testing import CliRunner

from tests.saddle import CELL
from wpcal.cli.bases import bases
from wpcal.core.errors import FormatError, GeometryError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell_file import read_cell
from wpcal.touch.grasp import BASE1_COLUMNS, BASE2_COLUMNS, measure_bases, read_base_points

EXACT_MM = 1e-6  #: Exact points of two metres through the minimax fit.
EXACT_RAD = 1e-9


@pytest.fixture
def cell_json(tmp_path):
    """A cell without a grasp, whose robot 1 is not in the origin."""
    record = json.loads(CELL.read_text())
    record["torch_robot"]["T_world_base"] = {"xyz_mm": [-100, 40, 15], "rpy_deg": [0.5, -1, 30]}
    del record["holder_robot"]["T_flange_part"]
    path = tmp_path / "cell.json"
    path.write_text(json.dumps(record))
    return path


def write_touched(path, T_base1_base2, n=5, noise=0.0):
    rng = np.random.default_rng(4)
    p2 = rng.uniform(-700, 700, (n, 3))
    p1 = T_base1_base2.apply(p2) + noise * rng.normal(size=(n, 3))
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["name", *BASE1_COLUMNS, *BASE2_COLUMNS])
        writer.writerows(
            [f"P{i}", *map(repr, one.tolist()), *map(repr, two.tolist())]
            for i, (one, two) in enumerate(zip(p1, p2, strict=True))
        )


TRUTH = RigidTransform(rotation_from_zyx(0.01, -0.02, 3.0), [1480, -22, 7], target="base1", source="base2")


def test_robot_2_is_where_the_points_say(cell_json, tmp_path):
    write_touched(tmp_path / "touched.csv", TRUTH)
    done = CliRunner().invoke(
        bases, [str(cell_json), str(tmp_path / "touched.csv"), "-o", str(tmp_path / "out")], standalone_mode=False
    )
    assert done.return_value == 0, done.output
    assert "wrote cell.json" in done.output
    record = json.loads((tmp_path / "out" / "cell.json").read_text())
    assert "T_flange_part" not in record["holder_robot"]
    record["holder_robot"]["T_flange_part"] = {"xyz_mm": [0, 0, 0], "rpy_deg": [0, 0, 0]}
    (tmp_path / "whole.json").write_text(json.dumps(record))
    cell = read_cell(tmp_path / "whole.json")
    assert cell.T_base1_base2.is_close(TRUTH, atol_mm=EXACT_MM, atol_rad=EXACT_RAD)


def test_points_that_do_not_agree_miss_the_tolerance_and_are_written(cell_json, tmp_path):
    write_touched(tmp_path / "touched.csv", TRUTH, n=8, noise=2.0)
    arguments = [str(cell_json), str(tmp_path / "touched.csv"), "-o", str(tmp_path / "out"), "--json"]
    done = CliRunner().invoke(bases, arguments, standalone_mode=False)
    assert done.return_value == 1
    assert json.loads(done.output)["verdict"] == "FAIL"
    assert (tmp_path / "out" / "cell.json").exists()


def test_points_in_a_line_two_points_and_a_missing_column_are_refused(cell_json, tmp_path):
    line = "\n".join(f"P{i},{i},0,0,{i},0,0" for i in range(1, 5))
    (tmp_path / "touched.csv").write_text(",".join(["name", *BASE1_COLUMNS, *BASE2_COLUMNS]) + "\n" + line + "\n")
    with pytest.raises(GeometryError):
        measure_bases(cell_json, read_base_points(tmp_path / "touched.csv"), tolerance_mm=0.5)
    write_touched(tmp_path / "touched.csv", TRUTH, n=2)
    with pytest.raises(FormatError, match="at least 3 points that both robots touched, got 2"):
        read_base_points(tmp_path / "touched.csv")
    (tmp_path / "touched.csv").write_text("name,base1_x_mm\nP1,1\n")
    with pytest.raises(FormatError, match="base1_y_mm"):
        read_base_points(tmp_path / "touched.csv")
