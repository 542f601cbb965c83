import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from wpcal.core.errors import InputError
from wpcal.robot.torch.attitude import (
    ToolAxis,
    TorchSettings,
    measure_torch,
    neck_directions,
    tool_rotations,
    wire_directions,
)
from wpcal.seam.judge.torch_neck import bend_directions

ROUND_OFF = 1e-12  #: A few products of rotations, entries at most 1.
ROUND_OFF_RAD = 1e-12

angles = st.floats(-0.7, 0.7)


def seam_frames(seed, n=5):
    return Rotation.random(n, rng=np.random.default_rng(seed)).as_matrix()


def test_at_zero_angles_the_tool_is_the_seam_frame_turned_about_its_x():
    R_seam = seam_frames(0)
    R_tool = tool_rotations(R_seam, TorchSettings())
    np.testing.assert_allclose(R_tool[..., 0], R_seam[..., 0], rtol=0, atol=ROUND_OFF)
    np.testing.assert_allclose(R_tool[..., 1], -R_seam[..., 1], rtol=0, atol=ROUND_OFF)
    np.testing.assert_allclose(R_tool[..., 2], -R_seam[..., 2], rtol=0, atol=ROUND_OFF)


@given(work=angles, travel=angles, seed=st.integers(0, 100), axis=st.sampled_from(ToolAxis))
def test_the_angles_measured_back_are_those_asked_for(work, travel, seed, axis):
    R_seam = seam_frames(seed)
    torch = TorchSettings(work, travel, tool_axis=axis)
    R_tool = tool_rotations(R_seam, torch)
    np.testing.assert_allclose(np.linalg.det(R_tool), 1.0, rtol=0, atol=ROUND_OFF)
    found_work, found_travel = measure_torch(R_seam, wire_directions(R_tool, axis))
    np.testing.assert_allclose(found_work, work, rtol=0, atol=ROUND_OFF_RAD)
    np.testing.assert_allclose(found_travel, travel, rtol=0, atol=ROUND_OFF_RAD)


def test_push_points_the_wire_forward_and_work_turns_it_towards_y():
    torch = TorchSettings(work_rad=math.radians(10), travel_rad=math.radians(15))
    wire = wire_directions(tool_rotations(np.eye(3)[None], torch), ToolAxis.Z)[0]
    v, w = math.radians(15), math.radians(10)
    expected = [math.sin(v), math.cos(v) * math.sin(w), -math.cos(v) * math.cos(w)]
    np.testing.assert_allclose(wire, expected, rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize("settings", [{"work_rad": 1.2}, {"travel_rad": math.nan}, {"standoff_mm": -1.0}])
def test_impossible_torches_are_refused(settings):
    with pytest.raises(InputError):
        TorchSettings(**settings)


@given(seed=st.integers(0, 100), axis=st.sampled_from(ToolAxis))
def test_a_neck_in_the_program_bends_to_where_it_was_felt(seed: int, axis: ToolAxis) -> None:
    rng = np.random.default_rng(seed)
    R_seam, lean, spin = seam_frames(seed), rng.uniform(-0.6, 0.6, (5, 2)), rng.uniform(-3.1, 3.1, 5)
    R_tool = tool_rotations(R_seam, TorchSettings(tool_axis=axis), lean, spin)
    felt = bend_directions(-wire_directions(R_tool, axis), R_seam, spin)
    np.testing.assert_allclose(neck_directions(R_tool, axis), felt, rtol=0, atol=ROUND_OFF)
