"""The answer with and without the points that the others contradict."""

import numpy as np
import pytest

from wpcal.calibrate import Criterion, PointProblem, calibrate, compare_without
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.core import GeometryError, PointPairs
from wpcal.core.tangent import exp_rotation
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


def test_two_mis_taught_points_are_left_out_together():
    big = np.vstack([BODY, BODY * [1, 0.5, 0.2] + [50, 20, 10]])
    real = big + NOISE_MM * np.random.default_rng(6).normal(size=big.shape)
    real[[1, 9]] += [[0, 0, 7.0], [0, -5.0, 0]]
    result = calibrate(PointPairs(tuple("abcdefghijkl"), big, real))
    assert result.distrusted.names == ("b", "j")
    assert result.distrusted.without_them.largest_mm < 4 * NOISE_MM < result.distrusted.with_them.largest_mm


def test_nothing_is_compared_where_no_point_is_distrusted():
    result = calibrate(touched())
    assert result.distrusted is None
    assert result.to_record()["distrusted"] is None


def test_the_angle_between_the_fits_is_that_of_the_turn():
    problem = PointProblem(touched(), TeachingError())
    names = ("a", "b")
    same = compare_without(problem, (), problem.fit(Criterion.LEAST_SQUARES), seam_points=SEAM)
    np.testing.assert_allclose((same.turn_rad, same.shift_mm), 0, rtol=0, atol=ROUND_OFF_MM)
    other = compare_without(problem, names, problem.fit(Criterion.LEAST_SQUARES), seam_points=SEAM)
    assert other.turn_rad > 1e-5


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
    assert found.suspect is not None
    assert found.suspect.body == ("web" if len(wrong) > 2 else "")
    assert found.suspect.names == wrong[::-1] or found.suspect.names == wrong
    steps = " ".join(next_steps(found.to_record()))
    assert ("--bodies" in steps and "write no" not in steps) is (len(wrong) > 2)
    assert ("web stands elsewhere" in found.judgement.sentence) is (len(wrong) > 2)
