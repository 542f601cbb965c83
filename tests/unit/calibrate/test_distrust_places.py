"""Another place of the part counts as a rival if the touches do not exclude it, whatever its residuals."""

from dataclasses import dataclass

import numpy as np
import pytest

from tests.record_checks import check_record
from wpcal.calibrate import Criterion, Solver, TeachingError, Touches, calibrate
from wpcal.calibrate.observe.touches import Nearest
from wpcal.core import GeometryError
from wpcal.core.robot_space import RobotSpace
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

R = exp_rotation([0.2, -0.1, 0.3])
T = np.array([900.0, -150, 200])


@dataclass(frozen=True)
class Planes:
    """Unbounded planes through the touched points; the part can be turned over about the x axis."""

    p: np.ndarray
    normal: np.ndarray

    def nearest(self, rows, points):
        n = self.normal[rows]
        off = np.einsum("mi,mi->m", points - self.p[rows], n)
        return Nearest(points - off[:, None] * n, n, n[:, :, None] * n[:, None, :])

    def rough_distances(self, rows, points, radius_mm):
        return np.abs(np.einsum("mi,mi->m", points - self.p[rows], self.normal[rows]))

    def overhang(self, rows, points):
        return np.zeros(len(rows))

    @property
    def centre(self):
        return self.p.mean(axis=0)

    @property
    def reach_mm(self):
        return 150.0


SLOPE = 2e-3  #: The far side leans by this much, so the part turned over about x leaves some residual.


def turned_over(noise_mm=0.0, seed=0):
    """Touch the top, the side y = 0, its end and the far side, which leans a little: turned over it nearly fits."""
    top, side, end = [0, 0, 1.0], [0, 1.0, 0], [1.0, 0, 0]
    lean = np.array([0, 1.0, SLOPE]) / np.hypot(1.0, SLOPE)
    p = np.array(
        [
            [20, 15, 0],
            [180, 20, 0],
            [100, 90, 0],
            [30, 0, -20],
            [170, 0, -25],
            [0, 50, -30],
            [60, 0, -60],
            [200, 20, -10.0],
        ]
    )
    normal = np.array([top, top, top, side, side, end, lean, end])
    q = p + noise_mm * np.random.default_rng(seed).normal(size=p.shape)
    names = tuple(f"A{i}" for i in range(len(p)))
    return Touches(
        names, q @ R.T + T, np.zeros(len(p)), Planes(p, normal), names, None, RobotSpace.NOMINAL, np.arange(len(p))
    )


SEAM = np.array([[0, 100.0, 0], [200, 100, -50]])


def solve(touches, sigma_mm, **options):
    return calibrate(
        touches,
        criterion=Criterion.LEAST_SQUARES,
        solver=Solver.EXACT,
        teaching=TeachingError(sigma_mm=sigma_mm),
        seam_points=SEAM,
        **options,
    )


def codes(result):
    return [issue.code for issue in result.issues]


def test_a_place_that_the_stated_error_does_not_exclude_is_a_rival():
    result = solve(turned_over(), 0.1)
    rival = result.touches.starts.rivals[0]
    assert 1e-3 < rival.rms_mm < 0.2
    assert rival.apart_mm > 100
    message = next(issue.message for issue in result.issues if issue.code == "rival-placement")
    assert f"up to {rival.apart_mm:.3g} mm away" in message
    assert (result.verdict, result.judgement.reason.value) == ("UNSURE", "rival")
    check_record(result.to_record())


def test_the_nominal_place_decides_between_two_that_the_touches_cannot_tell_apart():
    near = RigidTransform(exp_rotation([0.01, 0, 0.01]) @ R, T + np.array([2.0, 1, 0]), "nominal", "part")
    result = solve(turned_over(noise_mm=0.1), 0.1, T_nominal_part=near)
    assert "rival-placement" not in codes(result)
    assert np.abs(result.T_base_part.R - R).max() < 0.02


def test_two_places_that_fit_exactly_alike_are_refused():
    touches = turned_over()
    with pytest.raises(GeometryError, match="two places"):
        solve(touches.select([0, 1, 2, 3, 4, 5]), 0.1)


@pytest.mark.parametrize(
    ("noise_mm", "sigma_mm", "is_excluded"),
    [
        (0, 0.0678, True),
        (0, 0.0692, False),
        (0.02, 0.001, True),
        (0.03, 0.001, False),
        (0.01, None, True),
        (0.02, None, False),
    ],
)
def test_a_place_is_excluded_from_nineteen_to_one_on(noise_mm, sigma_mm, is_excluded):
    """Residuals enlarge an error that is stated too small; without one, sums are compared. Eight touches leave two."""
    touches = turned_over(noise_mm)
    result, rival = solve(touches, sigma_mm), solve(touches, 10.0).touches.starts.rivals[0]
    squares, own = 8 * rival.rms_mm**2, 8 * result.rms_mm**2
    unlikely = 2 * np.log(squares / own) if sigma_mm is None else (squares - own) / max(sigma_mm**2, own / 2)
    assert (unlikely > 2 * np.log(19)) == is_excluded
    assert (result.touches.starts.rivals == ()) == is_excluded == ("rival-placement" not in codes(result))
