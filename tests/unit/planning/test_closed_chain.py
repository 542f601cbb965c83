"""Two robots as a closed chain; the part's place in the gripper, found from where robot 1 touched the part."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.chain_error import chain_error
from tests.saddle import CELL
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import to_json
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.cell.closed_chain import (
    COORDINATES,
    ROTATION,
    SLOPE,
    SPIN,
    TRAVEL,
    WORK,
    YAW,
    SeamPath,
    all_joints,
    joint_slopes,
    joints_along,
    seam_in_middle,
    torch_on_seam,
    unwrap,
)
from wpcal.robot.kinematics.arm_file import arm_record, find_arm
from wpcal.robot.torch.attitude import measure_torch
from wpcal.seam.path.position import weld_rotation, weld_slope
from wpcal.seam.seam import SeamFrames
from wpcal.touch.grasp import cell_files, read_holding, solve_grasp

CLOSED_MM, CLOSED_RAD = 1e-6, 1e-9
"""Asked of the closed chain at every point; round-off of a metre is four orders below."""
ROUND_OFF_RAD = 1e-12  #: Some sines and arc tangents of one angle.
SLOPE_ATOL = 1e-7  #: Round-off of the difference quotient with `STEP`: 1e-15 / 1e-6 times the size of a joint angle.
STEP = 1e-6


@pytest.fixture
def coordinates(path):
    """Coordinates at which several branches of both arms reach, different at every point."""
    rng = np.random.default_rng(3)
    middle = np.zeros((len(path), COORDINATES))
    middle[:, :3] = (-50.0, 60.0, 750.0)
    middle[:, YAW], middle[:, SLOPE], middle[:, ROTATION] = 1.4, 0.17, 0.26
    middle[:, WORK], middle[:, TRAVEL], middle[:, SPIN] = 0.1, -0.2, 0.7
    return middle + rng.normal(0.0, 0.02, middle.shape)


def test_every_branch_closes_the_chain_exactly(cell, path, coordinates):
    one, two = all_joints(cell, path, coordinates)
    tried = 0
    for a in range(8):
        for b in range(8):
            if np.isfinite(one[:, a]).all() and np.isfinite(two[:, b]).all():
                off_mm, off_rad = chain_error(
                    cell, path, np.concatenate([one[:, a], two[:, b]], axis=1), torch_on_seam(coordinates)
                )
                assert off_mm.max() <= CLOSED_MM
                assert off_rad.max() <= CLOSED_RAD
                tried += 1
    assert tried >= 4


def test_slope_rotation_work_and_travel_are_those_of_the_conventions(coordinates):
    R = seam_in_middle(coordinates)
    np.testing.assert_allclose(weld_slope(R[..., 0]), coordinates[:, SLOPE], rtol=0, atol=ROUND_OFF_RAD)
    np.testing.assert_allclose(
        weld_rotation(R[..., 0], R[..., 2]), coordinates[:, ROTATION], rtol=0, atol=ROUND_OFF_RAD
    )
    wire = np.einsum("nij,nj->ni", R, torch_on_seam(coordinates)[..., 2])
    work, travel = measure_torch(R, wire)
    np.testing.assert_allclose(work, coordinates[:, WORK], rtol=0, atol=ROUND_OFF_RAD)
    np.testing.assert_allclose(travel, coordinates[:, TRAVEL], rtol=0, atol=ROUND_OFF_RAD)


@pytest.mark.parametrize("column", range(COORDINATES))
def test_derivatives_are_those_of_difference_quotients(cell, path, coordinates, column):
    joints = joints_along(cell, path, coordinates, (0, 0), np.zeros(12))
    step = np.zeros(COORDINATES)
    step[column] = STEP
    ahead, back = (joints_along(cell, path, coordinates + way * step, (0, 0), joints[0]) for way in (1, -1))
    slopes = joint_slopes(cell, coordinates, joints)
    np.testing.assert_allclose(slopes[:, :, column], (ahead - back) / (2 * STEP), rtol=0, atol=SLOPE_ATOL)


def test_a_turning_axis_goes_on_beyond_half_a_turn():
    true = np.linspace(0.0, 8.0, 50)[:, None]
    wrapped = (true + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(unwrap(wrapped, np.zeros(1)), true, rtol=0, atol=ROUND_OFF_RAD)
    np.testing.assert_allclose(unwrap(wrapped, np.array([6.0])), true + 2 * np.pi, rtol=0, atol=ROUND_OFF_RAD)


def test_a_path_is_given_in_the_part():
    frames = SeamFrames(np.arange(2.0), np.zeros((2, 3)), np.stack([np.eye(3)] * 2), np.zeros(2), "base")
    with pytest.raises(InputError, match="expected frames in part, got base"):
        SeamPath.of_frames("W1", frames)
    with pytest.raises(InputError, match="at least two points, got 1"):
        SeamPath.of_frames("W1", SeamFrames(np.zeros(1), np.zeros((1, 3)), np.eye(3)[None], np.zeros(1)))


ROUND_OFF_MM = 1e-9
TYPED = "19,21,36,15,-77,40"


def touched(cell, T_flange2_part, joints2):
    """Where robot 1 finds the part: through the world, by plain matrices."""
    held = replace(cell, T_carrier_part=T_flange2_part)
    T = np.linalg.inv(cell.T_world_base.matrix) @ held.held_places(joints2[None])[0]
    return RigidTransform.from_matrix(T, target="base", source="part")


@pytest.mark.parametrize("seed", range(5))
def test_the_grasp_comes_back(seed, tmp_path, golden):
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
    golden(found)


def test_a_cell_may_come_without_a_grasp_and_leaves_with_one(tmp_path):
    record = json.loads(CELL.read_text())
    del record["holder_robot"]["T_flange_part"]
    path = tmp_path / "cell.json"
    path.write_text(json.dumps(record))
    with pytest.raises(InputError, match="T_flange_part is missing"):
        read_cell(path)
    holding = read_holding(path, TYPED)
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
    holding = read_holding(tmp_path / "cell.json", TYPED)
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
        read_holding(path, TYPED)
