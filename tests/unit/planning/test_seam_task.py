"""The seams of a file, and points of a planned seam between those of the file."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from tests.one_robot_cells import TEE, fixed_cell
from tests.saddle import CELLS
from wpcal.core.errors import FormatError, FrameError, InputError
from wpcal.core.ladder import cheapest_way
from wpcal.core.rotations import quaternion_from_rotation, rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.plan.seam_file import read_seam_path
from wpcal.planning.sequence.seam_search import is_swift, steps_of_branch
from wpcal.planning.sequence.seam_task import STEP_RAD, SeamTask, seam_task
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.planning.sequence.torch_poses import TorchPoses, angles_between, tool_on_seam
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.torch.attitude import TorchSettings, tool_rotations
from wpcal.seam.seam import SeamFrames

RADIUS_MM, SAID_MM = 25.0, 0.005
"""A chord of 10 mm of this circle is 0.5 mm off it."""


def seam_of(p, x):
    z = np.broadcast_to([0.0, 0.0, 1.0], x.shape)
    R = np.stack([x, np.cross(z, x), z], axis=2)
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    given = read_sequence_input(TEE, fixed_cell()).seams[0].seam
    return replace(given, frames=SeamFrames(s, p, R, 0.0 * s), lean_rad=None)


def test_points_between_those_of_a_circle_are_on_it():
    turn = np.linspace(0.0, 2.0, 6)
    p = RADIUS_MM * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    task = seam_task(seam_of(p, np.stack([-np.sin(turn), np.cos(turn), 0.0 * turn], axis=1)))
    assert len(task) > 2 * len(p)
    assert np.abs(np.linalg.norm(task.p, axis=1) - RADIUS_MM).max() < SAID_MM


@pytest.mark.parametrize("turn_deg", [0.0, 40.0])
def test_points_of_a_line_and_beside_a_corner_are_on_the_chord(turn_deg):
    corner = np.radians([0.0, 0.0, turn_deg, turn_deg])
    x = np.stack([np.cos(corner), np.sin(corner), 0.0 * corner], axis=1)
    p = np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0], [20.0, 0.0, 0.0], [20.0, 0.0, 0.0]])
    p[2] += 0.5 * (x[1] + x[2])
    p[3] = p[2] + 20.0 * x[3]
    task = seam_task(seam_of(p, x))
    first = task.p[task.s_mm <= 20.0]
    assert np.abs(first[:, 1:]).max() < 1e-9
    last = task.p[task.s_mm >= task.s_mm[-1] - 20.0] - p[3]
    assert np.abs(np.cross(last, x[3])).max() < 1e-9


def test_the_torch_leans_between_frames_as_a_program_leads_it():
    x, lean = np.tile([1.0, 0.0, 0.0], (5, 1)), np.radians([[0, -35], [0, -35], [15, -20], [0, 0], [0, 0]])
    seam = replace(seam_of(np.arange(5.0)[:, None] * [10.0, 0.0, 0.0], x), lean_rad=lean)
    task, targets = seam_task(seam), SequenceTargets()
    assert {10.0, 20.0, 30.0} <= set(task.s_mm[task.rungs()])
    rows, ends = np.arange(len(task)), np.array([0, len(task) - 1])
    angles = angles_between(task, targets, rows, ends, np.column_stack([lean[[0, -1]], [0.2, 0.2]]))
    wire = tool_on_seam(task, rows, angles)[:, :3, 2]
    assert np.linalg.norm(np.diff(wire, axis=0), axis=1).max() < STEP_RAD  # a plan is checked along joint moves
    written = Slerp(seam.frames.s_mm, Rotation.from_matrix(tool_rotations(seam.frames.R, TorchSettings(), lean)))
    led = written(task.s_mm).as_matrix()[:, :, 2]
    assert np.abs(wire - led)[task.is_source].max() < 1e-9
    assert np.degrees(np.linalg.norm(wire - led, axis=1)).max() < 1.5  # it also turns about the wire between two leans


def test_from_rung_to_rung_the_torch_leans_no_faster_than_along_a_seam():
    s, still, both = np.array([0.0, 1.0, 40.0]), np.zeros((3, 2)), np.ones((3, 2), dtype=bool)
    task = SeamTask("S", s, np.zeros((3, 3)), np.tile(np.eye(3), (3, 1, 1)), still, np.ones(3, dtype=bool))
    angles = np.tile([[0.0, 0.0, 0.0], [np.radians(8.0), 0.0, 0.0]], (3, 1, 1))
    poses = TorchPoses(np.arange(3), angles, np.tile(np.eye(4), (3, 2, 1, 1)), still, both)
    cost = np.array([[0.0, np.inf], [2, 0], [np.inf, 0]])
    for forbids, way in ((None, [0, 1, 1]), (partial(is_swift, task, poses), [0, 0, 1])):
        steps = steps_of_branch(np.zeros((3, 2, 6)), np.isfinite(cost), np.ones(6), forbids)
        assert cheapest_way(list(cost), steps) == way


ROUND_OFF_MM = 1e-9  #: There and back by a transform of a metre.


@pytest.fixture
def record():
    return json.loads((CELLS / "saddle-seams.json").read_text(encoding="utf-8"))


def written(tmp_path, record):
    file = tmp_path / "seams.json"
    file.write_text(json.dumps(record), encoding="utf-8")
    return file


def in_base(record):
    T = RigidTransform(rotation_from_zyx(0.1, 0.2, 0.3), [800.0, -200.0, 150.0], "base", "part")
    for frame in record["seams"][0]["frames"]:
        frame["p_mm"] = T.apply(frame["p_mm"]).tolist()
        frame["R"] = (T.R @ frame["R"]).tolist()
        frame["q_xyzw"] = quaternion_from_rotation(frame["R"]).tolist()
    return {**record, "frame": "base", "T_base_part": T.matrix.tolist()}


def test_frames_in_the_base_are_brought_back_to_the_part(tmp_path, cell, path, record):
    moved = read_seam_path(written(tmp_path, in_base(record)), "W1", cell)
    np.testing.assert_allclose(moved.p, path.p, rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose(moved.R, path.R, rtol=0, atol=ROUND_OFF_MM)


def test_bad_files_say_what_is_wrong(tmp_path, cell, record):
    with pytest.raises(InputError, match="no seam 'W9'; the file has W1"):
        read_seam_path(written(tmp_path, record), "W9", cell)
    with pytest.raises(FormatError, match="expected a record of schema wpcal/seams/1, found wpcal/seams/2"):
        read_seam_path(written(tmp_path, {**record, "schema": "wpcal/seams/2"}), "W1", cell)
    with pytest.raises(FormatError, match="T_base_part is missing"):
        read_seam_path(written(tmp_path, {**in_base(record), "T_base_part": None}), "W1", cell)


def test_seams_of_an_identified_robot_need_that_robot_in_the_cell(tmp_path, cell, path, record):
    identified = {**in_base(record), "robot_space": "identified"}
    with pytest.raises(FrameError, match="identified robot space and robot 1 of the cell"):
        read_seam_path(written(tmp_path, identified), "W1", cell)
    arm = find_arm("mh6")
    own = replace(cell, arm=arm.as_identified(arm.chain.with_table(arm.chain.table)))
    assert len(read_seam_path(written(tmp_path, identified), "W1", own)) == len(path)
