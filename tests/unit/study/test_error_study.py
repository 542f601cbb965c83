from pathlib import Path

import numpy as np
import pytest

from wpcal.calibrate import Criterion, TeachingError, fit_least_squares
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.core import InputError
from wpcal.study import ErrorPlace, StudyOptions, run_error_study
from wpcal.study.teaching_error import UNSTATED
from wpcal.taught.pairs import read_pairs

PAIRS = read_pairs(Path(__file__).parents[3] / "fixtures" / "yin2003" / "table1.csv")[0]
EXACT_MM = 1e-9  # the paper asks for 0.02 mm without teaching errors
TRIALS = 2000
NO_ERROR = RobotField.none()


def study(teaching=UNSTATED, **options):
    asked = StudyOptions(trials=TRIALS, **options)
    return run_error_study(PAIRS.p_source, fit_least_squares(PAIRS), asked, teaching=teaching)


@pytest.mark.parametrize("criterion", [Criterion.MINIMAX, Criterion.LEAST_SQUARES])
def test_without_errors_the_motion_is_recovered(criterion):
    assert study(bound_mm=0.0, criterion=criterion).errors_mm.max() <= EXACT_MM


def test_errors_scale_with_their_bound():
    one, two = study(bound_mm=0.5).errors_mm, study(bound_mm=1.0).errors_mm
    assert np.median(two / one) == pytest.approx(2.0, rel=0, abs=0.02)  # rotations are linear up to their square


def test_errors_are_usually_below_half_a_millimetre_and_partly_cancel(golden):
    result = study(bound_mm=0.5)
    assert 0.55 < result.share_below_usual < 0.7
    assert result.errors_mm.max() < 1.3
    assert sum(result.histogram()[0]) == TRIALS
    golden(result)


def test_corners_are_worse_and_a_common_error_moves_the_part_by_itself():
    assert study(place=ErrorPlace.CORNERS).errors_mm.mean() > study(place=ErrorPlace.CUBE).errors_mm.mean()
    common = study(place=ErrorPlace.COMMON).errors_mm
    assert common.max() <= np.sqrt(3) * 0.5 + EXACT_MM
    assert common.max() > 0.8


def test_the_same_seed_gives_the_same_errors():
    assert np.array_equal(study(seed=5).errors_mm, study(seed=5).errors_mm)
    assert not np.array_equal(study(seed=5).errors_mm, study(seed=6).errors_mm)


@pytest.mark.parametrize("options", [{"bound_mm": -1.0}, {"bound_mm": np.nan}, {"criterion": Criterion.ROBUST}])
def test_a_study_that_cannot_be_is_refused(options):
    with pytest.raises(InputError):
        study(**options)


@pytest.mark.parametrize("criterion", [Criterion.MINIMAX, Criterion.LEAST_SQUARES])
def test_the_budget_of_an_exact_robot_is_that_of_the_trials(criterion):
    exact, usual = (study(criterion=criterion, teaching=TeachingError(robot=robot)) for robot in (NO_ERROR, None))
    assert exact.budget_95_mm == pytest.approx(exact.quantiles_mm[0.95], rel=0.12)  # as of Gaussian errors, and a scale
    assert usual.budget_95_mm > exact.budget_95_mm
