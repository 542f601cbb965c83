"""Weld positions: the principal ones by their names, and the rotation's law."""

import numpy as np
import pytest

from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.seam.path.position import weld_positions, weld_rotation, weld_slope
from wpcal.seam.seam import WeldType

ROUND_OFF_RAD = 1e-12  # a handful of float64 operations on unit vectors


def frame(x: list[float], z: list[float]) -> np.ndarray:
    x_axis, z_axis = np.array(x, dtype=float), np.array(z, dtype=float)
    z_axis = z_axis - (z_axis @ x_axis) * x_axis
    z_axis /= np.linalg.norm(z_axis)
    return np.stack([x_axis, np.cross(z_axis, x_axis), z_axis], axis=1)[None]


@pytest.mark.parametrize(
    ("x", "z", "weld", "name"),
    [
        ([1, 0, 0], [0, 0, 1], WeldType.GROOVE, "PA"),
        ([1, 0, 0], [0, 1, 1], WeldType.FILLET, "PB"),
        ([1, 0, 0], [0, -1, 1], WeldType.FILLET, "PB"),
        ([1, 0, 0], [0, 1, 0], WeldType.GROOVE, "PC"),
        ([1, 0, 0], [0, 1, -1], WeldType.FILLET, "PD"),
        ([1, 0, 0], [0, 0, -1], WeldType.GROOVE, "PE"),
        ([0, 0, 1], [1, 0, 0], WeldType.FILLET, "PF"),
        ([0, 0, -1], [1, 0, 0], WeldType.FILLET, "PG"),
    ],
)
def test_principal_positions(x: list[float], z: list[float], weld: WeldType, name: str) -> None:
    assert weld_positions(frame(x, z), weld).name == (name,)


def test_turning_about_the_weld_axis_adds_to_the_rotation() -> None:
    x, turn = np.array([1.0, 0.0, 0.0]), np.linspace(-3.0, 3.0, 13)
    z = np.stack([np.zeros_like(turn), -np.sin(turn), np.cos(turn)], axis=1)
    rotation = weld_rotation(np.broadcast_to(x, z.shape), z)
    np.testing.assert_allclose(rotation, turn, rtol=0, atol=ROUND_OFF_RAD)


def test_positions_do_not_depend_on_the_compass() -> None:
    R = frame([0.6, 0.0, 0.8], [0.0, 0.3, 1.0])
    turned = rotation_from_zyx(0.0, 0.0, 1.1) @ R
    a, b = weld_positions(R, WeldType.FILLET), weld_positions(turned, WeldType.FILLET)
    np.testing.assert_allclose(a.slope_rad, b.slope_rad, rtol=0, atol=ROUND_OFF_RAD)
    np.testing.assert_allclose(a.rotation_rad, b.rotation_rad, rtol=0, atol=ROUND_OFF_RAD)


def test_vertical_travel_has_no_rotation() -> None:
    assert np.isnan(weld_rotation([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
    assert weld_slope([0.0, 0.0, -1.0]) == pytest.approx(-np.pi / 2, rel=0, abs=ROUND_OFF_RAD)


def test_up_without_length_is_refused() -> None:
    with pytest.raises(InputError, match="against gravity"):
        weld_positions(frame([1, 0, 0], [0, 0, 1]), WeldType.FILLET, up=(0, 0, 0))
