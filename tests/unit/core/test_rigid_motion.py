import numpy as np
import pytest

from wpcal.core import FrameError, InputError, PointPairs, Residuals, RigidTransform
from wpcal.core.rotations import (
    cross_matrix,
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_zyx,
    spread_rotations,
    zyx_from_rotation,
)
from wpcal.core.tangent import exp_rotation, log_rotation, point_jacobian, translation_adjoint

ROUND_OFF = 1e-12  # products of a few unit-sized float64 matrices
ROUND_OFF_MM = 1e-9  # the same on coordinates of some metres
PRINTED_MM = 0.006  # the paper prints its coordinates to 0.01 mm


def rotations(count, seed=0):
    return exp_rotation(np.random.default_rng(seed).uniform(-2, 2, (count, 3)))


def test_the_printed_six_tuple_leaves_the_largest_distance_that_follows_from_the_printed_points():
    model = [[1037.86, -39.49, -171.99], [984.42, 15.77, -149.83], [1039.49, 69.50, -172.27], [1093.40, 14.35, -150.82]]
    real = [[1040.48, -61.76, -167.58], [985.23, -7.61, -146.17], [1039.77, 47.25, -168.30], [1094.23, -6.50, -146.16]]
    printed = [-0.0030366, -44.082, -7.0137, -0.0039222, -0.010791, 0.021670]
    T = RigidTransform.from_six_tuple(printed, target="base", source="part")
    largest = Residuals.of(PointPairs(tuple("1234"), model, real), T).largest_mm
    assert largest == pytest.approx(0.224727, rel=0, abs=1e-6)
    assert abs(largest - 0.221581) < PRINTED_MM


def test_every_form_of_a_rotation_gives_the_rotation_back():
    for R in rotations(50):
        assert np.allclose(rotation_from_zyx(*zyx_from_rotation(R)), R, rtol=0, atol=ROUND_OFF)
        assert np.allclose(rotation_from_quaternion(quaternion_from_rotation(R)), R, rtol=0, atol=ROUND_OFF)
        assert np.allclose(exp_rotation(log_rotation(R)), R, rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.6, 0, 0.8]])
@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, np.pi / 2, np.pi])
def test_forms_agree_at_special_angles(axis, angle):
    R = exp_rotation(angle * np.asarray(axis, dtype=float))
    assert np.allclose(
        rotation_from_zyx(*zyx_from_rotation(R)), R, rtol=0, atol=1e-7
    )  # at 90° angles lose half the digits
    assert np.allclose(rotation_from_quaternion(quaternion_from_rotation(R)), R, rtol=0, atol=ROUND_OFF)
    assert np.linalg.norm(log_rotation(R)) == pytest.approx(angle, rel=0, abs=1e-12)


@pytest.mark.parametrize("angle", [3e-9, 9e-5, 1.1e-4])
def test_sines_of_small_turns_are_exact_to_round_off(angle):
    R = exp_rotation(np.array([0.0, 0.0, -angle]))
    assert R[0, 1] == pytest.approx(np.sin(angle), rel=1e-14, abs=0)


def test_quaternions_are_stored_with_a_positive_real_part():
    assert (quaternion_from_rotation(rotations(200))[:, 3] >= 0).all()


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.6, -0.8, 0], [0, 0.6, -0.8], [0.6, 0, -0.8]])
def test_of_the_two_quaternions_of_a_half_turn_the_first_number_is_positive(axis):
    n = np.asarray(axis, dtype=float)
    np.testing.assert_allclose(quaternion_from_rotation(2.0 * np.outer(n, n) - np.eye(3)), [*n, 0.0], atol=ROUND_OFF)


def test_the_jacobian_is_the_slope_of_a_left_perturbation():
    p, xi, h = np.array([[300.0, -200.0, 900.0]]), np.array([0.3, -0.2, 0.1, 1.0, 2.0, -1.0]), 1e-6
    moved = p @ exp_rotation(h * xi[:3]).T + h * xi[3:]
    assert np.allclose((moved - p) / h, point_jacobian(p)[0] @ xi, rtol=0, atol=1e-3)


def twist_matrix(xi):
    """Slope at zero of the motion as a 4 × 4 matrix."""
    return np.block([[cross_matrix(xi[:3]), xi[3:, None]], [np.zeros((1, 4))]])


def test_a_motion_about_a_pivot_is_the_motion_about_the_origin_that_the_adjoint_gives():
    pivot, xi = np.array([812.0, -240.0, 155.0]), np.array([0.3, -0.2, 0.1, 1.0, 2.0, -1.0])
    T = RigidTransform(np.eye(3), pivot, "base", "pivot").matrix
    expected = T @ twist_matrix(xi) @ np.linalg.inv(T)
    assert np.allclose(twist_matrix(translation_adjoint(pivot) @ xi), expected, rtol=0, atol=ROUND_OFF_MM)
    points = np.random.default_rng(2).uniform(-1000, 1000, (5, 3))
    about_pivot, about_origin = point_jacobian(points - pivot), point_jacobian(points)
    assert np.allclose(about_origin @ translation_adjoint(pivot), about_pivot, rtol=0, atol=ROUND_OFF_MM)


def test_a_covariance_carried_to_another_pivot_and_back_is_the_same():
    rng = np.random.default_rng(3)
    root = rng.standard_normal((6, 6))
    a, b = rng.uniform(-1, 1, (2, 3))  # m and rad: all entries of one size
    there, back = translation_adjoint(a), translation_adjoint(-a)
    carried = there @ (root @ root.T) @ there.T
    assert np.allclose(back @ carried @ back.T, root @ root.T, rtol=0, atol=ROUND_OFF)
    assert not np.allclose(carried, root @ root.T, rtol=0, atol=0.1)
    assert np.allclose(translation_adjoint(b) @ there, translation_adjoint(a + b), rtol=0, atol=ROUND_OFF)


def test_cross_matrix_is_the_cross_product():
    a, b = np.array([1.0, 2.0, 3.0]), np.array([-4.0, 5.0, 6.0])
    assert np.array_equal(cross_matrix(a) @ b, np.cross(a, b))


def test_transforms_compose_invert_and_refuse_frames_that_do_not_meet():
    R1, R2 = rotations(2)
    T_base_cell = RigidTransform(R1, [1000, 2, 3], "base", "cell")
    T_cell_part = RigidTransform(R2, [-5, 600, 7], "cell", "part")
    p = np.array([[10.0, 20.0, 30.0]])
    T_base_part = T_base_cell @ T_cell_part
    assert np.allclose(T_base_part.apply(p), T_base_cell.apply(T_cell_part.apply(p)), rtol=0, atol=ROUND_OFF_MM)
    assert np.allclose(T_base_part.inverse().apply(T_base_part.apply(p)), p, rtol=0, atol=ROUND_OFF_MM)
    with pytest.raises(FrameError, match="inner frames"):
        T_cell_part @ T_base_cell


@pytest.mark.parametrize("matrix", [np.diag([1.0, 1.0, -1.0]), 1.001 * np.eye(3), np.full((3, 3), np.nan)])
def test_what_is_no_rotation_is_refused(matrix):
    with pytest.raises(InputError):
        RigidTransform(matrix, np.zeros(3), "base", "part")


def test_residuals_point_at_the_taught_points():
    T = RigidTransform.identity(target="base", source="part")
    residuals = Residuals.of(PointPairs(("a", "b"), np.zeros((2, 3)), [[0, 0, 1], [3, 4, 0]]), T)
    assert (residuals.worst, residuals.largest_mm) == ("b", 5.0)
    assert residuals.vectors_mm.tolist() == [[0, 0, 1], [3, 4, 0]]
    assert residuals.rms_mm == pytest.approx(np.sqrt(13.0), rel=0, abs=ROUND_OFF)


@pytest.mark.parametrize(
    ("names", "points", "words"),
    [
        (("a", "a"), np.zeros((2, 3)), "unique"),
        (("a",), np.zeros((2, 3)), "1 names"),
        (("a",), [[0, 0, np.inf]], "finite"),
    ],
)
def test_pairs_that_are_none_are_refused(names, points, words):
    with pytest.raises(InputError, match=words):
        PointPairs(names, points, points)


def test_inputs_are_copied_and_cannot_be_written():
    points = np.zeros((2, 3))
    pairs = PointPairs(("a", "b"), points, points)
    points[:] = 7.0
    assert not pairs.p_source.any()
    with pytest.raises(ValueError, match="read-only"):
        pairs.p_source[0, 0] = 1.0


@pytest.mark.parametrize("wrong", [1e300, 1e200, 3.0, "1", True, None, 10**400])
def test_a_matrix_of_other_things_than_a_rotation_is_refused_without_a_warning(wrong):
    matrix = np.eye(4).tolist()
    matrix[0][0] = matrix[0][1] = wrong
    with pytest.raises(InputError, match=r"no rotation holds more than 1|matrix of numbers|not a rigid motion"):
        RigidTransform.from_matrix(matrix, target="base", source="part")
    with pytest.raises(InputError):
        RigidTransform(np.full((3, 3), 1e200), np.zeros(3), "base", "part")


@pytest.mark.parametrize("count", [200, 1000, 3000])
def test_spread_rotations_are_apart_and_leave_no_hole(count):
    """Both angles fall with the cube root of the number; in degrees, on quaternions."""
    spread = quaternion_from_rotation(spread_rotations(count))
    drawn = quaternion_from_rotation(rotations(3000))
    near = np.abs(spread @ spread.T) - 2.0 * np.eye(count)
    apart, hole = (
        np.degrees(2 * np.arccos(np.minimum(cos, 1.0)))
        for cos in (near.max(), np.abs(drawn @ spread.T).max(axis=1).min())
    )
    assert apart > 140.0 / np.cbrt(count)
    assert hole < 220.0 / np.cbrt(count)
