"""The part's place in the gripper, found from where robot 1 touched the part."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.saddle import CELL
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import to_json
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell_file import read_cell
from wpcal.robot.kinematics.arm_file import arm_record, find_arm
from wpcal.touch.grasp import cell_files, read_holding, solve_grasp

ROUND_OFF_MM = 1e-9
ROUND_OFF_RAD = 1e-12
JOINTS = "19,21,36,15,-77,40"


def touched(cell, T_flange2_part, joints2):
    """Where robot 1 finds the part: through the world, by plain matrices."""
    held = replace(cell, T_carrier_part=T_flange2_part)
    T = np.linalg.inv(cell.T_world_base.matrix) @ held.held_places(joints2[None])[0]
    return RigidTransform.from_matrix(T, target="base", source="part")


@pytest.mark.parametrize("seed", range(5))
def test_the_grasp_comes_back(seed, tmp_path):
    rng = np.random.default_rng(seed)
    truth = RigidTransform(
        rotation_from_zyx(*rng.uniform(-3, 3, 3)), rng.uniform(-200, 200, 3), target="flange2", source="part"
    )
    record = json.loads(CELL.read_text())
    record["torch_robot"]["T_world_base"] = {"xyz_mm": [100, -50, 20], "rpy_deg": [1, -2, 30]}
    path = tmp_path / "cell.json"
    path.write_text(json.dumps(record))
    joints2 = rng.uniform(-1, 1, 6)
    holding = read_holding(path, ",".join(repr(v) for v in np.degrees(joints2).tolist()))
    found = solve_grasp(holding, touched(holding.cell, truth, joints2))
    assert found.is_close(truth, atol_mm=ROUND_OFF_MM, atol_rad=ROUND_OFF_RAD)
    (tmp_path / "new.json").write_text(to_json(cell_files(holding, found)["cell.json"]))
    written = read_cell(tmp_path / "new.json")
    assert written.T_part.is_close(truth, atol_mm=ROUND_OFF_MM, atol_rad=ROUND_OFF_RAD)
    assert written.T_world_base.is_close(holding.cell.T_world_base, atol_mm=0, atol_rad=ROUND_OFF_RAD)


def test_a_cell_may_come_without_a_grasp_and_leaves_with_one(tmp_path):
    record = json.loads(CELL.read_text())
    del record["holder_robot"]["T_flange_part"]
    path = tmp_path / "cell.json"
    path.write_text(json.dumps(record))
    with pytest.raises(InputError, match="T_flange_part is missing"):
        read_cell(path)
    holding = read_holding(path, JOINTS)
    grasp = RigidTransform(np.eye(3), [1, 2, 3], target="flange2", source="part")
    written = cell_files(holding, grasp)["cell.json"]
    assert written["holder_robot"]["T_flange_part"] == {"xyz_mm": [1, 2, 3], "rpy_deg": [0, 0, 0]}
    rest = {**written, "holder_robot": {k: v for k, v in written["holder_robot"].items() if k != "T_flange_part"}}
    assert rest == record


def test_an_arm_beside_the_cell_goes_with_it(tmp_path):
    arm = replace(find_arm("mh6"), name="our own")
    (tmp_path / "own.json").write_text(to_json(arm_record(arm)))
    record = json.loads(CELL.read_text())
    record["holder_robot"]["arm"] = "own.json"
    (tmp_path / "cell.json").write_text(json.dumps(record))
    holding = read_holding(tmp_path / "cell.json", JOINTS)
    files = cell_files(holding, holding.cell.T_part)
    assert sorted(files) == ["cell.json", "own.json"]
    away = tmp_path / "away"
    away.mkdir()
    for name, content in files.items():
        (away / name).write_text(to_json(content))
    assert read_cell(away / "cell.json").arm2.name == "our own"


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ("1,2,3", "expected 6 angles"),
        ("a,b,c,d,e,f", "expected 6 angles"),
        ("nan,0,0,0,0,0", "expected 6 angles"),
        ("171,0,0,0,0,0", "S is 171 deg, its limits are -170 and 170"),
    ],
)
def test_joints_that_cannot_be_are_refused(joints, message):
    with pytest.raises(InputError, match=message):
        read_holding(CELL, joints)


def test_a_file_that_is_no_cell_is_refused(tmp_path):
    path = tmp_path / "cell.json"
    path.write_text('{"schema": "wpcal/cell/1"}')
    with pytest.raises(FormatError, match="'holder_robot' is missing"):
        read_holding(path, JOINTS)
