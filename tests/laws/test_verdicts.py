"""The verdict is seldom wrong about the seams: simulated calibrations of sample parts."""

import pytest

from tests.benchmarks.bench_verdict import pooled_study
from tests.few import few
from wpcal.calibrate import Criterion, VerdictKind

MOST_WRONG = 0.05  #: Share of calibrations in which a PASS or a FAIL may be wrong.


@pytest.mark.parametrize(("n", "stated"), few([(4, False), (4, True), (8, False), (8, True)], 1))
def test_a_verdict_is_seldom_wrong(n, stated):
    study = pooled_study(
        n, noise="gaussian", criterion=Criterion.LEAST_SQUARES, stated=stated, trials=150, parts=("tee", "lap")
    )
    assert study.passed_outside <= MOST_WRONG * study.trials
    assert study.failed_inside <= MOST_WRONG * study.trials


@pytest.mark.parametrize("n", few([8, 12], 1))
def test_heavy_tails_seldom_fail_a_part_whose_seams_are_inside(n):
    """A point far off is named; it is a FAIL only if the seams move out of the tolerance without it."""
    study = pooled_study(
        n, noise="t3", criterion=Criterion.LEAST_SQUARES, stated=False, trials=60, parts=("tee", "lap")
    )
    assert study.passed_outside <= MOST_WRONG * study.trials
    assert study.failed_inside <= MOST_WRONG * study.trials


def test_many_points_pass_and_three_do_not():
    options = {"noise": "gaussian", "criterion": Criterion.LEAST_SQUARES, "stated": True, "trials": 20}
    many = pooled_study(12, parts=("tee",), **options)
    assert many.verdicts[VerdictKind.PASS] > 0.8 * many.trials
    few = pooled_study(3, parts=("tee",), **options)
    assert few.verdicts[VerdictKind.PASS] == 0


@pytest.mark.deep
@pytest.mark.parametrize("noise", ["gaussian", "bounded", "t3"])
@pytest.mark.parametrize("criterion", [Criterion.MINIMAX, Criterion.LEAST_SQUARES])
@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("n", [3, 4, 5, 6, 8, 12])
def test_a_verdict_is_seldom_wrong_on_every_part(n, stated, criterion, noise):
    trials = 400 if noise == "t3" else 100  # near the bound: 12 to 21 of 400, 52 of 1600 (n = 6, stated)
    study = pooled_study(n, noise=noise, criterion=criterion, stated=stated, trials=trials)
    assert study.passed_outside <= MOST_WRONG * study.trials
    assert study.failed_inside <= MOST_WRONG * study.trials
