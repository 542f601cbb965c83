import json

import jsonschema
import numpy as np
import pytest

from tests.saddle import CELL
from wpcal.core.errors import FormatError, InputError
from wpcal.core.schemas import schema_text
from wpcal.planning.cell.cell_file import read_cell

ROUND_OFF = 1e-12


@pytest.fixture
def record():
    return json.loads(CELL.read_text(encoding="utf-8"))


@pytest.fixture
def read(tmp_path):
    def write_and_read(record):
        file = tmp_path / "cell.json"
        file.write_text(json.dumps(record), encoding="utf-8")
        return read_cell(file)

    return write_and_read


def test_the_shipped_cell_is_of_its_schema(record):
    validator = jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/cell/1")))
    validator.validate(record)
    del record["torch_robot"]["T_flange_tool"]
    assert not validator.is_valid(record)


def test_two_robots_face_each_other(cell):
    np.testing.assert_allclose(cell.T_base1_base2.t_mm, [1500.0, 0.0, 0.0], rtol=0, atol=ROUND_OFF)
    np.testing.assert_allclose(cell.T_base1_base2.R, np.diag([-1.0, -1.0, 1.0]), rtol=0, atol=ROUND_OFF)
    np.testing.assert_allclose(cell.T_world_middle.t_mm, [750.0, 0.0, 0.0], rtol=0, atol=ROUND_OFF)


def test_slow_joints_weigh_most_unless_the_file_says_otherwise(read, record):
    cell = read(record)
    speeds = np.array([joint.speed_rad_s for joint in cell.arm.joints])
    np.testing.assert_allclose(cell.joint_weights[:6] * speeds, np.full(6, speeds.min()), rtol=0, atol=ROUND_OFF)
    record["torch_robot"]["joint_weights"] = [6, 5, 4, 3, 2, 1]
    assert read(record).joint_weights[:6].tolist() == [6, 5, 4, 3, 2, 1]


def test_an_arm_may_stand_beside_the_cell(read, record, tmp_path):
    record["holder_robot"]["arm"] = "mine.json"
    with pytest.raises(InputError, match=r"mine.json: no such file"):
        read(record)


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        (lambda r: r["holder_robot"].pop("T_flange_part"), InputError, "holder_robot: T_flange_part is missing"),
        (lambda r: r.pop("safety_distance_mm"), FormatError, "the field 'safety_distance_mm' is missing"),
        (lambda r: r.update(schema="wpcal/cell/2"), FormatError, "expected a record of schema wpcal/cell/1"),
        (lambda r: r.update(safety_distance_mm=-1), FormatError, "safety_distance_mm: expected a number from 0"),
        (
            lambda r: r["torch_robot"].update(joint_weights=[1, 2]),
            FormatError,
            "torch_robot.joint_weights: expected 6 entries, got 2",
        ),
        (lambda r: r["torch_robot"].update(links=3), FormatError, "torch_robot.links: expected a list, got 3"),
        (
            lambda r: r["torch_robot"]["T_world_base"].update(xyz_mm=[0, 0]),
            FormatError,
            "T_world_base.xyz_mm: expected 3 entries",
        ),
        (
            lambda r: r["bench"][0]["capsules"][0].update(radius_mm=0),
            FormatError,
            "radius_mm: expected a number above 0",
        ),
        (
            lambda r: r["torch_robot"]["links"][0].update(link=7),
            FormatError,
            "link: expected a whole number from 0 to 6, got 7",
        ),
    ],
)
def test_bad_cells_say_what_is_wrong(read, record, change, error, says):
    change(record)
    with pytest.raises(error, match=says):
        read(record)
