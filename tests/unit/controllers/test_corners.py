"""The torch at the corners of a run: where it turns and how far it is off the travel is in the program's comments."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wpcal.controllers.program import build_program
from wpcal.controllers.program.describe import describe_path, find_turned_corners
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import FinishedCalibration


def run_round(turn_deg, before_mm, after_mm, side_mm=60.0):
    """A run of two sides; the torch turns evenly from `before_mm` before the corner to `after_mm` after it."""
    s = np.unique([0, 20, 40, *(side_mm + np.linspace(-before_mm, after_mm, 9)), side_mm, 90, 2 * side_mm])
    turn = np.radians(turn_deg)
    second = np.array([np.cos(turn), np.sin(turn), 0.0])
    p = np.where(s[:, None] <= side_mm, s[:, None] * [1.0, 0, 0], [side_mm, 0, 0] + (s[:, None] - side_mm) * second)
    share = np.clip((s - side_mm + before_mm) / (before_mm + after_mm), 0, 1)
    return p, Rotation.from_rotvec(np.outer(share * turn, [0, 0, 1])).as_matrix()


@pytest.mark.parametrize(("turn_deg", "before", "after", "off"), [(90, 5, 5, 45), (90, 5, 4, 50), (-60, 4, 4, 30)])
def test_a_corner_is_told_with_its_place_and_the_torch(make_seam, turn_deg, before, after, off):
    p, R = run_round(turn_deg, before, after)
    seam = make_seam("W1", p, R, frame="base")
    (corner,) = find_turned_corners(seam.frames)
    found = [corner.at_mm, corner.low_mm, corner.high_mm, *np.degrees([corner.turn_rad, corner.off_rad])]
    np.testing.assert_allclose(found, [60, 60 - before, 60 + after, abs(turn_deg), off], rtol=0, atol=1e-6)
    finished = FinishedCalibration(RigidTransform.identity(target="base", source="part"), (seam,), (None,), {})
    (path,) = build_program(finished).paths
    words = f"corner of {abs(turn_deg)} deg at 60.0 mm: the torch turns from {60 - before:.1f} to {60 + after:.1f} mm"
    assert f"; {words}, up to {off} deg off the travel" in describe_path(path)


def test_a_seam_without_corners_says_nothing(make_seam):
    t = np.linspace(0, np.pi, 40)
    p = 60 * np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    R = Rotation.from_rotvec(np.outer(t + np.pi / 2, [0, 0, 1])).as_matrix()
    assert find_turned_corners(make_seam("W1", p, R).frames) == ()
