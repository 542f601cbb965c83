"""Verdicts and their reasons; parts that are larger than their models."""

import math
from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from wpcal.calibrate import Criterion, TeachingError, VerdictKind, VerdictReason, calibrate
from wpcal.calibrate.errors.linear_fit import budget_of_design
from wpcal.calibrate.errors.robot_field import PRIOR_SCALE, RobotField
from wpcal.calibrate.size import PartSize
from wpcal.calibrate.trust.residuals import ResidualEvidence
from wpcal.calibrate.trust.scale import ScaleFit
from wpcal.core.errors import InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.wording import MOST_NAMED, listed

BOX = np.array([[x, y, z] for x in (0.0, 300.0) for y in (0.0, 200.0) for z in (0.0, 100.0)])
SEAM = np.array([[50.0, 100.0, 20.0], [250.0, 100.0, 20.0]])
SMALL = TeachingError(sigma_mm=0.05)


def pairs_of(p: np.ndarray, error: np.ndarray) -> PointPairs:
    return PointPairs(tuple(f"P{i}" for i in range(len(p))), p, p + error)


def judged(p, error, **options):
    return calibrate(pairs_of(p, error), seam_points=SEAM, seam_names=["W1", "W1"], **options)


def stated(sigma_mm):
    robot = RobotField.none() if sigma_mm is None else None
    return {"teaching": TeachingError(sigma_mm=sigma_mm, robot=robot)}


def noise(n: int, sigma: float = 0.05, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, sigma, (n, 3))


TRIANGLE, CORNERS = BOX[[0, 2, 4]], BOX[[0, 3, 5, 6]]
LARGE = (BOX[:, None] * np.linspace(0.4, 1.6, 60)[:, None]).reshape(-1, 3)
CLOSE = np.vstack([BOX, BOX + 10.0, BOX - 10.0, BOX + np.array([10.0, -10.0, 0.0])])
ON_A_LINE = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [200.0, 0.0, 0.0], [300.0, 0.0, 0.0], [150.0, 90.0, 0.0]])
PASS, UNSURE, FAIL = VerdictKind.PASS, VerdictKind.UNSURE, VerdictKind.FAIL
SQUARES = Criterion.LEAST_SQUARES
CASES: dict[str, tuple[Any, Any, dict[str, Any], VerdictKind, VerdictReason, str]] = {
    "many good points pass though a residual is above the tolerance": (
        CLOSE, noise(32, 0.3), {"criterion": SQUARES, **stated(0.3)}, PASS, VerdictReason.WITHIN, ""
    ),
    "three points with one off their plane": (
        TRIANGLE, np.array([[0.0, 0, 0], [0, 0, 5], [0, 0, 0]]), {}, UNSURE, VerdictReason.ERROR, "assumed"
    ),
    "three points with a stated error": (
        TRIANGLE, noise(3), stated(0.05), UNSURE, VerdictReason.UNCHECKED, "P0, P1, P2"
    ),
    "a point alone holds a motion": (ON_A_LINE, noise(5, 0.01), {}, UNSURE, VerdictReason.UNCHECKED, "tests P4"),
    "a point alone holds a motion and its error is stated": (
        ON_A_LINE, noise(5, 0.01), stated(0.01), PASS, VerdictReason.WITHIN, "P4: one check point ends this doubt"
    ),
    "three exact points never predict zero": (TRIANGLE, 0.0 * TRIANGLE, {}, UNSURE, VerdictReason.ERROR, "assumed"),
    "exact points predict the last digit of a controller": (
        CORNERS, 0.0 * CORNERS, {}, PASS, VerdictReason.WITHIN, "assumed: a controller shows 0.01 mm"
    ),
    "an error of zero is the last digit of a controller": (
        CORNERS, 0.0 * CORNERS, stated(0.0), PASS, VerdictReason.WITHIN, "assumed: a controller shows 0.01 mm"
    ),
    "residuals contradict the stated error": (BOX, noise(8, 0.2), stated(0.05), FAIL, VerdictReason.STATED_ERROR, ""),
    "a seam is shown to be outside": (BOX, noise(8, 30.0), {"tolerance_mm": 0.05}, FAIL, VerdictReason.BEYOND, ""),
    "rough touches without a stated error": (
        LARGE, noise(480, 1.0), {"criterion": SQUARES, **stated(None)}, UNSURE, VerdictReason.LARGE_RESIDUALS, ""
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_the_verdict_with_its_reason_and_every_value(name, golden):
    p, error, options, kind, reason, words = CASES[name]
    found = judged(p, error, **options)
    assert (found.verdict, found.judgement.reason) == (kind, reason)
    assert words in found.judgement.sentence
    golden(found)


def test_a_check_point_tests_three_points():
    pairs = pairs_of(BOX[[0, 2, 4, 7]], noise(4))
    options = {"teaching": SMALL, "seam_points": SEAM}
    assert calibrate(pairs.select([0, 1, 2]), check=pairs.select([3]), **options).verdict is VerdictKind.PASS
    wrong = PointPairs(("K",), pairs.p_source[3:], pairs.p_target[3:] + np.array([0.0, 0.0, 3.0]))
    found = calibrate(pairs.select([0, 1, 2]), check=wrong, **options).judgement
    assert (found.kind, found.reason) == (VerdictKind.FAIL, VerdictReason.CHECK_CONTRADICTS)
    assert "K" in found.sentence


def test_the_next_point_is_asked_for_when_it_helps_and_stands_in_the_sentence():
    asked: list[float] = []
    suggest = lambda shares: asked.extend(shares) or ("H4",)  # noqa: E731
    few = judged(BOX[[0, 3, 5, 6]], noise(4, 0.3), teaching=TeachingError(sigma_mm=0.3), suggest=suggest)
    assert asked == pytest.approx(
        [few.tolerance_mm / few.judgement.error_95_mm] * 4
    )  # a stated error is no better known
    assert (few.verdict, few.judgement.next_points, few.judgement.seam) == (VerdictKind.UNSURE, ("H4",), "W1")
    assert few.judgement.to_record()["seam"] == "W1"
    own = few.predict_error_mm(SEAM).max()
    assert f"seam W1 may be off by {own:.3g} mm, all seams together by {few.judgement.error_95_mm:.3g} mm" in str(
        few.judgement
    )
    assert "touch H4 as well" in few.judgement.sentence

    def unasked(_: object) -> tuple[str, ...]:
        raise AssertionError

    assert judged(BOX, noise(8), teaching=SMALL, suggest=unasked).verdict is VerdictKind.PASS


def test_touches_that_measure_the_scale_leave_little_of_its_prior():
    walls = 57.0 * BOX[[0, 3, 5, 6, 7]]  # 17 m: the usual scale of 100 ppm alone would be 1.7 mm
    exact = calibrate(pairs_of(walls, 0.0 * walls), seam_points=57.0 * SEAM)
    assert exact.verdict is VerdictKind.PASS
    assert exact.judgement.error_95_mm < 0.02
    known, rng = TeachingError(sigma_mm=0.3, robot=RobotField.none()), np.random.default_rng(3)
    for p in (walls, BOX[[0, 3, 5, 6, 7]]):
        promised = budget_of_design(p, known).scale
        found = [
            calibrate(pairs_of(p, rng.normal(0.0, 0.3, p.shape)), teaching=known).budget.belief.scale for _ in range(40)
        ]
        # the scale that errors of touches feign has at most the variance of the scale that they leave, or of the prior
        most = math.sqrt(2.0) * max(promised, PRIOR_SCALE)
        assert 0.999 * promised <= np.sqrt(np.mean(np.square(found))) <= 1.1 * most
    warm = calibrate(pairs_of(walls, 5e-4 * walls + rng.normal(0.0, 0.3, walls.shape)), seam_points=57.0 * SEAM)
    assert warm.judgement.reason is VerdictReason.SCALE
    assert warm.judgement.error_95_mm > 2.0


@pytest.mark.parametrize("freedom", [0, 1, 7])
def test_residuals_contradict_a_stated_error_above_the_last_digit(freedom):
    for chance, rms_mm in product((0.0099, 0.0101), repeat=2):
        told = ResidualEvidence(9 * rms_mm**2, chance, freedom, 9, ())
        assert told.contradicts_stated is (chance < 0.01 < rms_mm)
        assert told.birge_ratio == pytest.approx(math.sqrt(chi2.isf(chance, max(freedom, 1)) / max(freedom, 1)))


def test_more_than_six_names_are_counted():
    assert listed("abcdefgh", MOST_NAMED) == "a, b, c, d, e, f and 2 more"


def test_a_temperature_and_a_fit_are_applied_one_after_the_other():
    size = PartSize.stated(45.0, 1.2e-5).freed(ScaleFit(-7e-4, 0.053, 1e-4))
    assert size.scale == pytest.approx(1.0003 * 0.9993 - 1.0, rel=1e-12)
    assert size.told == "45 °C, 12 ppm per K, and then fitted to the touches, ± 53.00 mm per metre"
    assert "are those of a part that is 0.40 mm per metre smaller than its model (45 °C" in size.issue.message
    assert size.teaching(TeachingError()).scale_error == pytest.approx(0.053 / 1.959964, rel=1e-6)
    p = np.array([[30.0, -50, 70], [900, 20, -10], [-5, 400, 3]])
    pairs = size.of_model(PointPairs(tuple("abc"), p, p + 1000.0))
    np.testing.assert_allclose(pairs.p_target * (1.0 + size.scale), p + 1000.0, rtol=1e-12)
    np.testing.assert_array_equal(pairs.p_source, p)


def test_without_a_temperature_it_has_the_size_of_its_model_and_few_touches_free_none():
    assert PartSize.stated(None, 1.2e-5) == PartSize(0.0, "", None)
    with pytest.raises(InputError, match="a free scale needs at least"):
        PartSize().freed(None)
