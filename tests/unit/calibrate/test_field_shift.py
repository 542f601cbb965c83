"""Seams follow the robot's own error where the touches tell of one, and only there."""

from functools import cache

import numpy as np
import pytest

from tests.benchmarks.bench_verdict import spread_set
from tests.saved_graphs import saved_graph
from wpcal.calibrate import Criterion, TeachingError
from wpcal.calibrate.errors.field_shift import FieldShift
from wpcal.calibrate.errors.robot_field import FieldOrigin, RobotField, believed_freedom, correlation, scale_of
from wpcal.calibrate.observe.points import PointProblem
from wpcal.core.arrays import FloatArray
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import point_jacobian
from wpcal.seam import detect_seams
from wpcal.taught.features import find_features
from wpcal.touch.design import farthest_rows

SIGMA_MM, CALIBRATIONS = 0.1, 40


@cache
def _places() -> tuple[FloatArray, FloatArray]:
    """Return features and points of seams of a frame."""
    graph = saved_graph("frame")
    features = np.array([feature.p_mm for feature in find_features(graph) if feature.kind.is_point])
    seams = np.concatenate([seam.frames.p for seam in detect_seams(graph) if seam.accepted])
    return features, seams[farthest_rows(seams, 30)]


def _drawn(field: RobotField, teaching: TeachingError, n: int) -> tuple[float, int]:
    """Return the root mean square error of seams with the shift over that without, and how often there was one."""
    (features, seams), rng = _places(), np.random.default_rng(n)
    squares, moved = np.zeros(2), 0
    for _ in range(CALIBRATIONS):
        p = spread_set(features, n, rng)
        at = np.concatenate([p, seams])
        K = correlation(at, at, field.length_mm) + 1e-9 * np.eye(len(at))
        f = field.amplitude_mm * np.linalg.cholesky(K) @ rng.standard_normal(at.shape)
        q = p + f[:n] + SIGMA_MM * rng.standard_normal(p.shape)
        names = tuple(f"p{i}" for i in range(n))
        fit = PointProblem(PointPairs(names, p, q, source="part", target="base"), teaching).fit(Criterion.LEAST_SQUARES)
        placed, shift = fit.T.apply(seams), FieldShift.of(fit.budget, teaching.robot)
        off = placed - (seams + f[n:])
        moved += shift is not None
        squares += [np.sum(off**2), np.sum((off if shift is None else off + shift.at(placed)) ** 2)]
    return float(np.sqrt(squares[1] / squares[0])), moved


@pytest.mark.parametrize("teaching", [TeachingError(), TeachingError(sigma_mm=SIGMA_MM)])
def test_seams_come_nearer_where_the_robot_errs(teaching: TeachingError) -> None:
    ratio, moved = _drawn(RobotField(0.3, 300.0), teaching, 12)
    assert ratio < 0.65  # measured: 0.49 and 0.46
    assert moved > CALIBRATIONS // 2


@pytest.mark.parametrize("teaching", [TeachingError(), TeachingError(robot=RobotField(0.3, 300.0))])
def test_seams_stay_where_the_robot_does_not_err(teaching: TeachingError) -> None:
    ratio, moved = _drawn(RobotField.none(), teaching, 6)
    assert ratio <= 1.02
    assert moved <= 2


def test_the_shift_is_what_the_touches_expect() -> None:
    """With one size of everything it is the mean of a Gaussian, computed here from the whole covariance."""
    rng, n, robot = np.random.default_rng(3), 9, RobotField(0.8, 300.0, FieldOrigin.STATED)
    p, x = 300.0 * rng.standard_normal((n, 3)), 300.0 * rng.standard_normal((4, 3))
    f = 0.8 * np.linalg.cholesky(correlation(p, p, 300.0) + 1e-9 * np.eye(n)) @ rng.standard_normal((n, 3))
    pairs = PointPairs(tuple("abcdefghi"), p, p + f, source="part", target="base")
    fit = PointProblem(pairs, TeachingError(sigma_mm=SIGMA_MM, robot=robot)).fit(Criterion.LEAST_SQUARES)
    shift = FieldShift.of(fit.budget, robot)
    q, at = fit.T.apply(p), fit.T.apply(x)
    c = q.mean(axis=0)
    J, J_at = point_jacobian(q - c).reshape(-1, 6), point_jacobian(at - c).reshape(-1, 6)

    def covariance(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.asarray(0.64 * np.kron(correlation(a, b, 300.0), np.eye(3)))

    rest = np.linalg.svd(J)[0][:, 6:]
    V = rest.T @ (covariance(q, q) + SIGMA_MM**2 * np.eye(3 * n)) @ rest
    crossed = (J_at @ np.linalg.pinv(J) @ covariance(q, q) - covariance(at, q)) @ rest
    expected = -crossed @ np.linalg.solve(V, rest.T @ (p + f - q).ravel())
    np.testing.assert_allclose(shift.at(at).ravel(), expected, rtol=0, atol=1e-6)  # the fit is not quite linear
    again = FieldShift.from_record(shift.to_record())
    np.testing.assert_allclose(again.at(at), shift.at(at), rtol=0, atol=1e-12)


def test_a_variance_that_residuals_told_has_as_many_degrees_of_freedom() -> None:
    """Of an inverse χ² distribution with ν degrees and the scale s: mean s ν / (ν − 2), variance 2 mean² / (ν − 4)."""
    freedom, scale = np.array([5.0, 9.0, 40.0]), 1.7
    mean = scale * freedom / (freedom - 2.0)
    found = believed_freedom(mean, 2.0 * mean**2 / (freedom - 4.0))
    np.testing.assert_allclose(found, freedom, rtol=1e-12)
    np.testing.assert_allclose(scale_of(found) * mean, scale, rtol=1e-12)
    assert believed_freedom(mean[:1], np.zeros(1)) == np.inf
