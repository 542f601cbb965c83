"""Points that contradict the others are distrusted, with what holds without them, and where others must be."""

from dataclasses import dataclass

import numpy as np
import pytest

from tests.record_checks import check_record
from wpcal.calibrate import Criterion, PointProblem, Solver, TeachingError, Touches, calibrate, compare_without
from wpcal.calibrate.observe.touches import Nearest
from wpcal.core import GeometryError, PointPairs
from wpcal.core.robot_space import RobotSpace
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.results.next_steps import next_steps

BODY = np.array([[0, 0, 0], [600, 0, 20], [580, 400, 0], [10, 390, 60], [300, 200, 300], [100, 350, 210.0]])
SEAM = np.array([[0, 0, 0], [900.0, 0, 0]])
R = exp_rotation([0.3, -1.2, 0.4])
NOISE_MM = 0.1
ROUND_OFF_MM = 1e-9  # float64 on coordinates of a metre
OTHER_START_MM = 1e-6  # the minimax fit rests here, wherever its search began


def touched(**blunders):
    """Touch the body, with the named points off by these vectors."""
    real = BODY + NOISE_MM * np.random.default_rng(5).normal(size=BODY.shape)
    for name, vector in blunders.items():
        real["abcdef".index(name)] += vector
    return PointPairs(tuple("abcdef"), BODY, real @ R.T + [1000, -200, 300])


@pytest.mark.parametrize("criterion", [c for c in Criterion if c is not Criterion.WEIGHTED])
def test_a_mis_taught_point_is_left_out_as_use_no_leaves_it_out(criterion):
    pairs = touched(c=[0, 6.0, 2.0])
    used = Criterion.LEAST_SQUARES if criterion is Criterion.ROBUST else criterion
    found = calibrate(pairs, criterion=criterion, seam_points=SEAM).distrusted
    by_hand = calibrate(pairs.select([0, 1, 3, 4, 5]), criterion=used, seam_points=SEAM)
    everything = calibrate(pairs, criterion=used, seam_points=SEAM)
    assert (found.names, found.criterion, found.without_them.points) == (("c",), used, 5)
    for summary, fit in ((found.without_them, by_hand), (found.with_them, everything)):
        mine = (summary.largest_mm, summary.rms_mm)
        np.testing.assert_allclose(mine, (fit.largest_mm, fit.rms_mm), rtol=0, atol=OTHER_START_MM)
        error = fit.predict_error_mm(SEAM).max()
        np.testing.assert_allclose(summary.seam_error_95_mm, error, rtol=0, atol=1e-3)  # its own simulated samples
    moved = by_hand.T_base_part.apply(SEAM) - everything.T_base_part.apply(SEAM)
    shift = np.linalg.norm(moved, axis=1).max()
    np.testing.assert_allclose(found.shift_mm, shift, rtol=0, atol=OTHER_START_MM)
    off = np.linalg.norm(pairs.p_target[2] - by_hand.T_base_part.apply(BODY[2]))
    np.testing.assert_allclose(found.off_mm[0], off, rtol=0, atol=OTHER_START_MM)


def test_too_few_left_are_refused():
    problem = PointProblem(touched(), TeachingError())
    with pytest.raises(GeometryError, match="at least 3"):
        compare_without(problem, tuple("abcd"), problem.fit(Criterion.MINIMAX), seam_points=SEAM)


def test_two_wrong_points_of_four_are_named_though_two_cannot_be_fitted():
    """Two check points say which of four fitted points are wrong; the two that are left do not fix a rotation."""
    part = np.array([[0, 0, 10], [0, 120, 10], [200, 120, 10], [175, 64, 90], [25, 56, 90], [20, 20, 10.0]])
    base = np.array(
        [
            [812.987, -240.730, 165.929], [745.526, -141.679, 168.376], [910.239, -28.948, 175.418],
            [919.753, -92.109, 253.400], [800.721, -183.467, 247.960], [818.232, -212.988, 167.031],
        ]
    )  # fmt: skip
    pairs = PointPairs(tuple("abcdef"), part, base)
    result = calibrate(pairs.select([0, 1, 2, 3]), check=pairs.select([4, 5]), seam_points=part[:2])
    assert result.distrusted is None
    assert [issue.ids for issue in result.issues if issue.code == "blunder"] == [("b", "d")]
    assert result.verdict == "FAIL"


@pytest.mark.parametrize("wrong", [("w0", "w1", "w2"), ("w0", "w1", "w2", "w3"), ("w0", "b0"), ("w1",)])
def test_several_wrong_points_of_one_body_are_first_explained_by_that_body(wrong):
    names = (*(f"b{i}" for i in range(6)), "w0", "w1", "w2", *wrong[3:])
    p = np.array([[0, 0, 0], [600, 0, 20], [0, 400, 20], [600, 400, 0], [0, 0, 20], [600, 400, 20.0]])
    p = np.concatenate([p, [[100, 200, 20], [400, 200, 20], [100, 200, 220.0], [400, 200, 220]][: len(names) - 6]])
    q = p + np.random.default_rng(5).normal(0.0, 0.05, p.shape)
    q[[names.index(name) for name in wrong]] += [0.0, 10.0, 0.0]
    found = calibrate(PointPairs(names, p, q), body_of={name: "base" if name[0] == "b" else "web" for name in names})
    assert found.suspect.body == ("web" if len(wrong) > 2 else "")
    assert found.suspect.names == wrong[::-1] or found.suspect.names == wrong
    steps = " ".join(next_steps(found.to_record()))
    assert ("--bodies" in steps and "write no" not in steps) is (len(wrong) > 2)
    assert ("web stands elsewhere" in found.judgement.sentence) is (len(wrong) > 2)


TURN = exp_rotation([0.2, -0.1, 0.3])
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
        names, q @ TURN.T + T, np.zeros(len(p)), Planes(p, normal), names, None, RobotSpace.NOMINAL, np.arange(len(p))
    )


WELD = np.array([[0, 100.0, 0], [200, 100, -50]])


def solve(touches, sigma_mm, **options):
    return calibrate(
        touches,
        criterion=Criterion.LEAST_SQUARES,
        solver=Solver.EXACT,
        teaching=TeachingError(sigma_mm=sigma_mm),
        seam_points=WELD,
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
    near = RigidTransform(exp_rotation([0.01, 0, 0.01]) @ TURN, T + np.array([2.0, 1, 0]), "nominal", "part")
    result = solve(turned_over(noise_mm=0.1), 0.1, T_nominal_part=near)
    assert "rival-placement" not in codes(result)
    assert np.abs(result.T_base_part.R - TURN).max() < 0.02


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
