"""A tool centre point that is not at the tip: told where the postures of the touches show it, and only there."""

import json

import numpy as np
import pytest

from tests.few import few
from tests.record_checks import check_record
from wpcal.calibrate import Solver, TeachingError
from wpcal.calibrate import calibrate as calibrate_points
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.trust.diagnose import diagnose_pairs
from wpcal.core import PointPairs
from wpcal.core.tangent import exp_rotation

SIGMA_MM = 0.15
ALONE = RobotField.none()
BODY = np.array(
    [[0, 0, 0], [200, 0, 0], [200, 120, 10], [0, 120, 0], [20, 50, 90], [180, 62, 90], [100, 0, 10], [20, 62, 90.0]]
)
TIP_MM = np.array([0.6, -0.7, 0.4])  # 1 mm beside the tool centre point of the controller
R = exp_rotation([0.3, -1.2, 0.4])
CAREFUL = TeachingError(sigma_mm=SIGMA_MM)


def touched(rng, n=8, tip=TIP_MM, tilt_deg=25.0):
    """Touch with the tip; the controller shows the point that it believes the tip to be. Returns the postures, too."""
    frames = [exp_rotation(np.radians(tilt_deg) * rng.normal(size=3)) for _ in range(n)]
    shown = BODY[:n] @ R.T + [1000, -200, 300] - np.array([frame @ tip for frame in frames])
    names = tuple(f"P{i}" for i in range(n))
    pairs = PointPairs(names, BODY[:n], shown + SIGMA_MM * rng.normal(size=(n, 3)))
    return pairs, dict(zip(names, frames, strict=True))


@pytest.mark.parametrize(("sigma", "least"), [(None, 36), (SIGMA_MM, 39)], ids=["sigma from residuals", "stated"])
def test_a_wrong_tool_is_told_with_its_size_and_no_point_is_blamed(sigma, least):
    rng, told = np.random.default_rng(0), []
    for _ in range(40):
        pairs, postures = touched(rng)
        found = diagnose_pairs(pairs, postures=postures, teaching=TeachingError(sigma_mm=sigma, robot=ALONE))
        if found.tool is not None:
            assert found.suspect is None
            told.append(float(np.linalg.norm(found.tool.tip_mm - TIP_MM)) <= found.tool.error_95_mm)
    assert len(told) >= least
    assert np.mean(told) >= 0.85  # "about 95 %": the offsets that are told are the larger estimates


@pytest.mark.parametrize("sigma", few([None, SIGMA_MM], 1), ids=["sigma from residuals", "stated"])
@pytest.mark.many
def test_a_right_tool_is_left_in_peace(sigma):
    rng = np.random.default_rng(1)
    sets = [touched(rng, 4 + k % 5, np.zeros(3)) for k in range(400)]
    alarms = sum(
        diagnose_pairs(pairs, postures=p, teaching=TeachingError(sigma_mm=sigma, robot=ALONE)).tool is not None
        for pairs, p in sets
    )
    assert alarms <= 8  # 1 % of 400 and two standard deviations


def test_one_posture_shows_nothing_and_nothing_is_said():
    pairs, postures = touched(np.random.default_rng(2), tilt_deg=0.0)
    assert diagnose_pairs(pairs, postures=postures).tool is None
    assert diagnose_pairs(pairs).tool is None


def test_one_wrong_point_is_not_called_a_wrong_tool():
    rng, named = np.random.default_rng(3), []
    for _ in range(30):
        pairs, postures = touched(rng, 8, np.zeros(3))
        off = pairs.p_target.copy()
        off[2] += [1.0, -1.0, 1.5]
        found = diagnose_pairs(PointPairs(pairs.names, BODY, off), postures=postures)
        named.append(found.suspect.names if found.tool is None else "tool")
    assert "tool" not in named
    assert named.count(("P2",)) >= 28


def test_the_verdict_fails_where_a_wrong_tool_may_carry_a_seam_out_and_says_what_to_do():
    pairs, postures = touched(np.random.default_rng(4))
    options = {"postures": postures, "teaching": CAREFUL, "solver": Solver.EXACT}
    narrow = calibrate_points(pairs, tolerance_mm=0.5, **options)
    assert narrow.verdict == "FAIL"
    assert narrow.judgement.sentence.startswith("the tip is 1")
    assert "wpcal tcp" in narrow.judgement.sentence
    wide = calibrate_points(pairs, tolerance_mm=4.0, **options)
    assert wide.verdict == "PASS"
    assert wide.judgement.error_95_mm > np.sqrt(2.0) * wide.tool.size_mm
    record = json.loads(json.dumps(wide.to_record()))
    check_record(record)
    assert record["tool_offset"]["is_complete"]
    assert record["issues"][0]["code"] == "tool-centre-point"


@pytest.mark.many
def test_the_predicted_error_covers_a_weld_in_another_posture():
    """The weld is a quarter turn from the touches. Without the allowance the band held 17 to 55 % (0.5 mm)."""
    rng, held = np.random.default_rng(5), []
    seam = np.array([[100.0, 60, 10]])
    for _ in range(40):
        pairs, postures = touched(rng, tip=TIP_MM)
        found = calibrate_points(pairs, postures=postures, teaching=CAREFUL, solver=Solver.EXACT)
        tip_there = (R @ exp_rotation([np.pi / 2, 0, 0])) @ TIP_MM
        place = found.T_base_part.apply(seam) + tip_there - seam @ R.T - [1000, -200, 300]
        held.append(float(np.linalg.norm(place)) <= found.predict_error_mm(seam)[0])
    assert np.mean(held) >= 0.9
