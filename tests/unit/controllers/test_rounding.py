import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wpcal.controllers.language.rounding import rounded, rounded_frame, zyx_degrees

HALF_UNITS = np.sqrt(3) / 2  #: The bound of `zyx_degrees`, in units of the last digit.
SLACK = 1e-3  #: Of a unit: second order in the rounding errors, and round-off.


@pytest.mark.parametrize("decimals", [1, 3, 6])
def test_rounded_angles_keep_the_rotation_within_the_bound(random_poses, decimals):
    _, R = random_poses(3, 20_000)
    back = Rotation.from_euler("ZYX", zyx_degrees(R, decimals=decimals)[:, ::-1], degrees=True)
    off = np.degrees((Rotation.from_matrix(R).inv() * back).magnitude()) * 10.0**decimals
    assert off.max() <= HALF_UNITS + SLACK


def test_at_a_quarter_turn_the_first_angle_is_zero(random_poses):
    _, R = random_poses(4, 8)
    angles = zyx_degrees(R[::8], decimals=6)
    assert abs(angles[0, 1]) == 90.0
    assert angles[0, 0] == 0.0


def test_zero_has_no_sign():
    assert str(rounded(-1e-9, 3)) == "0.0"


def test_a_rounded_frame_has_the_numbers_that_are_written(random_place):
    T = rounded_frame(random_place(1), mm_decimals=3, deg_decimals=3)
    np.testing.assert_array_equal(T.t_mm, np.round(T.t_mm, 3))
    again = rounded_frame(T, mm_decimals=3, deg_decimals=3)
    assert T.is_close(again, atol_mm=1e-12, atol_rad=1e-12)
