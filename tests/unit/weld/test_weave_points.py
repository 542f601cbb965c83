"""Weaves made of points: across the seam, on the plates, with the pitch and the dwells that were asked for."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from wpcal.core.errors import InputError
from wpcal.seam.seam import SeamFrames
from wpcal.weld.values import Weave, WeaveShape
from wpcal.weld.weave_points import LEAST_MM, woven_frames

ROUND_OFF = 1e-9


def straight(length=100.0, between_deg=90.0):
    s = np.linspace(0, length, 11)
    angle = np.full(11, np.pi - np.radians(between_deg))  # between the normals of the plates
    return SeamFrames(s, np.outer(s, [1.0, 0, 0]), np.tile(np.eye(3), (11, 1, 1)), angle, "part")


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([WeaveShape.ZIGZAG, WeaveShape.SINE]),
    st.floats(3.0, 12.0),
    st.floats(2.0, 9.0),
    st.floats(60.0, 120.0),
)
def test_a_weave_has_its_width_and_its_swings_and_is_on_the_plates(shape, width, length, between):
    frames = woven_frames(straight(between_deg=between), Weave(shape, width, length), 5.0)
    x, y, z = frames.p.T
    assert [x[0], y[0], x[-1], y[-1]] == pytest.approx([0, 0, 100, 0], abs=ROUND_OFF)
    assert [y.max(), -y.min()] == pytest.approx([width / 2] * 2, abs=ROUND_OFF)
    assert np.sum(np.isclose(y, width / 2, rtol=0, atol=ROUND_OFF)) == round(100 / length)
    assert (np.diff(x) > 0).all()
    slope = 1 / math.tan(math.radians(between) / 2)
    np.testing.assert_allclose(z, np.abs(y) * slope, rtol=0, atol=ROUND_OFF)  # the wire follows the plates
    steps = np.linalg.norm(np.diff(frames.p, axis=0), axis=1)
    assert steps.min() >= LEAST_MM - ROUND_OFF
    np.testing.assert_allclose(frames.s_mm, np.concatenate([[0], np.cumsum(steps)]), rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize(("left_s", "right_s"), [(0.4, 0.2), (0.4, 0.0), (0.0, 0.3)])
def test_a_dwell_is_a_way_along_the_side_at_the_speed_of_travel(left_s, right_s):
    weave = Weave(WeaveShape.ZIGZAG, 5.0, 10.0, dwell_left_s=left_s, dwell_right_s=right_s)
    frames = woven_frames(straight(), weave, 5.0, between_plates=False)
    assert (np.diff(frames.s_mm) > 0).all()
    x, y, _ = frames.p.T
    sides = {2.5: 0.0, -2.5: 0.0}
    for (x0, y0), (x1, y1) in zip(zip(x[:-1], y[:-1], strict=True), zip(x[1:], y[1:], strict=True), strict=True):
        if y0 == y1 and y0:
            sides[float(y0)] += x1 - x0
    assert sides == pytest.approx({2.5: 10 * left_s * 5, -2.5: 10 * right_s * 5})


def test_a_corner_of_the_seam_is_kept():
    p = np.array([[0.0, 0, 0], [50, 0, 0], [50, 50, 0]])
    R = Rotation.from_rotvec(np.outer([0, np.pi / 4, np.pi / 2], [0, 0, 1])).as_matrix()
    frames = SeamFrames(np.array([0.0, 50, 100]), p, R, np.full(3, np.pi / 2), "part")
    woven = woven_frames(frames, Weave(WeaveShape.ZIGZAG, 3.0, 3.0), 5.0)
    across = np.linalg.norm(woven.p - [50, 0, 0], axis=1)
    assert across.min() < 1.5 + ROUND_OFF
    steps = np.linalg.norm(np.diff(woven.p, axis=0), axis=1)
    assert steps.min() > 0.5 * LEAST_MM


@pytest.mark.parametrize(
    ("weave", "message"),
    [
        (Weave(WeaveShape.CIRCLE, 3.0, 2.0), "a circle cannot be written as points; state zigzag or sine"),
        (Weave(WeaveShape.ZIGZAG, 0.5, 1.0), "points would be 0.35 mm from each other; at least 1 mm"),
        (Weave(WeaveShape.ZIGZAG, 3.0, 2.0, 0.2, 0.2), "dwells are longer than a swing"),
    ],
)
def test_what_points_cannot_do_is_said(weave, message):
    with pytest.raises(InputError, match=message):
        woven_frames(straight(), weave, 5.0)
