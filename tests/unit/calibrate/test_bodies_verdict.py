"""The verdict on a weldment whose bodies may have moved: never PASS on what nothing tests."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.weldments import uprights
from wpcal.calibrate import Sigma, SigmaSource
from wpcal.calibrate.errors.of_bodies import MeetingPoints, meeting_errors
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.trust.bodies import BodiesEvidence, unchecked_touches
from wpcal.calibrate.trust.verdict import Verdict, VerdictKind, VerdictReason, judge_evidence
from wpcal.core.issue import Issue

SIGMA_MM = 0.05


def judged(
    seed: int, *, touches_each: int = 6, sigma_mm: float = SIGMA_MM, source: SigmaSource = SigmaSource.STATED,
    check_off_mm: float | None = None, issues: tuple[Issue, ...] = (), tolerance_mm: float = 0.5, scale: float = 1.0,
    noise_mm: float = SIGMA_MM,
) -> Verdict:  # fmt: skip
    """Judge the touched points of the weldment, as for a part without seams."""
    rng = np.random.default_rng(seed)
    part = uprights(touches_each)
    part = replace(part, bodies=part.bodies.scaled(scale, scale))
    true = part.drawn(rng, scale=min(1.0, 1.0 / scale))
    touches = part.touched(true, noise_mm, rng)
    moved = part.moved(touches, true.T_base_part, sigma_mm)
    pairs = moved.fit.paired(touches, part.body)
    check = None
    if check_off_mm is not None:
        off = replace(pairs, p_target=pairs.p_target + check_off_mm * true.T_base_part.R[:, 2], covariances=None)
        check = (off, part.body)
    points = MeetingPoints.on(part.body, pairs.p_source)
    seams = ["W1"] * len(part.body)
    sigma = Sigma(sigma_mm, source)
    return judge_evidence(BodiesEvidence(moved, touches.names, points, seams, sigma, check, issues, tolerance_mm))


@pytest.mark.parametrize(
    ("options", "kind", "reason"),
    [
        ({"tolerance_mm": 5.0}, VerdictKind.PASS, VerdictReason.WITHIN),
        ({"tolerance_mm": 0.01}, VerdictKind.UNSURE, VerdictReason.ERROR),
        ({"tolerance_mm": 50.0, "noise_mm": 0.6}, VerdictKind.FAIL, VerdictReason.CONTRADICTION),
        (
            {"tolerance_mm": 50.0, "noise_mm": 0.08, "seed": 10, "scale": 0.02},
            VerdictKind.FAIL,
            VerdictReason.STATED_ERROR,
        ),
        (
            {"tolerance_mm": 50.0, "noise_mm": 0.08, "seed": 10, "scale": 0.02, "source": SigmaSource.ASSUMED},
            VerdictKind.UNSURE,
            VerdictReason.LARGE_RESIDUALS,
        ),
        ({"tolerance_mm": 5.0, "check_off_mm": 30.0}, VerdictKind.FAIL, VerdictReason.CHECK_CONTRADICTS),
        ({"tolerance_mm": 50.0, "touches_each": 2, "scale": 10.0}, VerdictKind.UNSURE, VerdictReason.UNCHECKED),
        (
            {"tolerance_mm": 5.0, "issues": (Issue("rival-placement", "another: look"),)},
            VerdictKind.UNSURE,
            VerdictReason.RIVAL,
        ),
    ],
)
def test_reasons(options: dict[str, object], kind: VerdictKind, reason: VerdictReason, golden: Any) -> None:
    found = judged(**{"seed": 11, **options})  # type: ignore[arg-type]
    assert (found.kind, found.reason) == (kind, reason), found.sentence
    golden(found)


def test_the_worst_seam_is_told_with_its_own_error_and_with_the_allowance_for_the_tool() -> None:
    rng, bias_mm = np.random.default_rng(11), 0.4
    part = uprights(6)
    true = part.drawn(rng)
    touches = part.touched(true, SIGMA_MM, rng)
    tools = (TeachingError(tcp_bias_mm=each, robot=RobotField.none()) for each in (0.0, bias_mm))
    without, moved = (part.moved(touches, true.T_base_part, SIGMA_MM, teaching=each) for each in tools)
    points = MeetingPoints.on(part.body, moved.fit.paired(touches, part.body).p_source)
    assert (meeting_errors(moved.fit, points).total_mm > meeting_errors(without.fit, points).total_mm + 0.02).all()
    own, names = meeting_errors(moved.fit, points).total_mm, [f"W{k}" for k in range(len(part.body))]
    stated = Sigma(SIGMA_MM, SigmaSource.STATED)
    found = judge_evidence(BodiesEvidence(moved, touches.names, points, names, stated, None, (), 0.01))
    assert found.to_record()["seam"] == names[int(own.argmax())]
    told = f"may be off by {own.max():.3g} mm, all seams together by {found.error_95_mm:.3g} mm"
    assert told in found.sentence


def test_good_touches_pass_in_almost_every_part() -> None:
    """Three tests with a false alarm in a hundred each."""
    kinds = [judged(seed, tolerance_mm=5.0).kind for seed in range(30)]
    assert kinds.count(VerdictKind.PASS) >= 26


def test_a_touch_is_unchecked_where_the_tack_tolerance_hides_it() -> None:
    rng = np.random.default_rng(1)
    part = uprights(2)
    true = part.drawn(rng)
    touches = part.touched(true, SIGMA_MM, rng)
    loose = replace(part, bodies=part.bodies.scaled(10.0, 10.0))
    names = unchecked_touches(loose.moved(touches, true.T_base_part, SIGMA_MM), touches.names, SIGMA_MM)
    assert set(names) >= {touches.names[i] for i in np.flatnonzero(part.body > 0).tolist()}
    tight = replace(part, bodies=part.bodies.scaled(0.1, 0.1))
    names = unchecked_touches(tight.moved(touches, true.T_base_part, SIGMA_MM), touches.names, SIGMA_MM)
    assert not {touches.names[i] for i in np.flatnonzero(part.body > 0).tolist()} & set(names)


@pytest.mark.parametrize("touches_each", [6, 1])
def test_a_body_beyond_its_tolerance_is_named_instead_of_its_touches(touches_each: int, golden: Any) -> None:
    rng = np.random.default_rng(3)
    part = uprights(touches_each)
    true = part.drawn(rng)
    v = true.v_mm.copy()
    v[3] += 9.0 * part.n[part.body == 3][0]
    touches = part.touched(replace(true, v_mm=v), SIGMA_MM, rng)
    moved = part.moved(touches, true.T_base_part, SIGMA_MM)
    assert (moved.far, moved.wrong) == (("U3",), ())
    points = MeetingPoints.on(part.body, moved.fit.paired(touches, part.body).p_source)
    stated, seams = Sigma(SIGMA_MM, SigmaSource.STATED), ["W1"] * len(part.body)
    found = judge_evidence(BodiesEvidence(moved, touches.names, points, seams, stated, None, (), 50.0))
    assert found.kind is VerdictKind.FAIL
    assert found.sentence.startswith("body U3 is farther from its place in the model"), found.sentence
    assert "state a larger tolerance" in found.sentence
    golden([found, moved, moved.to_record(), meeting_errors(moved.fit, points)])
