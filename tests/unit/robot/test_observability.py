import numpy as np
import pytest

from tests.simulated_poses import XIONG_2015_ERRORS, random_joints, simulate_poses
from wpcal.core.errors import InputError
from wpcal.robot.identify.identifiability import TRACKER
from wpcal.robot.identify.least_squares import solve_least_squares
from wpcal.robot.identify.observability import LIMIT_MARGIN_RAD, plan_poses
from wpcal.robot.identify.parameters import KinematicModel, last_link_first
from wpcal.robot.kinematics.arm_file import find_arm

MH6 = find_arm("mh6")
PARAMETERS = last_link_first(MH6.chain, None)


def plan(count, seed=0, **options):
    return plan_poses(MH6, count, parameters=PARAMETERS, rng=np.random.default_rng(seed), **options)


@pytest.mark.parametrize("count", [8, 30])
def test_a_plan_sees_more_than_random_poses_and_stays_off_the_limits(count):
    found = plan(count)
    low, high = MH6.limits
    assert found.joints.shape == (count, 6)
    assert len(np.unique(found.joints, axis=0)) == count
    assert (found.joints >= low + LIMIT_MARGIN_RAD).all()
    assert (found.joints <= high - LIMIT_MARGIN_RAD).all()
    assert found.index > 1.05 * found.random_index
    assert len(found.parameters) == 24


def test_a_plan_stays_above_the_floor():
    found = plan(12, above_mm=400.0)
    assert (MH6.forward(found.joints)[:, 2, 3] > 400).all()


def test_the_expected_spread_is_the_one_that_a_fit_states():
    found = plan(30)
    rng = np.random.default_rng(1)
    seen = simulate_poses(MH6, XIONG_2015_ERRORS, found.joints, rng=rng)
    fit = solve_least_squares(KinematicModel(MH6.chain), PARAMETERS, MH6.model_angles(seen.joints), seen, noise=TRACKER)
    # 2 %: the plan looks from the nominal arm, the fit from the real one a few tenths of a degree away
    np.testing.assert_allclose(found.expected_sigma / fit.standard_deviations, 1, rtol=0, atol=0.02)


def test_planned_poses_identify_better_than_random_ones():
    """Mean standard deviation of the parameters, each against that of random poses: the reason to plan."""
    planned = plan(12)
    worse = []
    for seed in range(5):
        joints = random_joints(MH6, 12, rng=np.random.default_rng(seed))
        seen = simulate_poses(MH6, XIONG_2015_ERRORS, joints, rng=np.random.default_rng(seed))
        fit = solve_least_squares(KinematicModel(MH6.chain), PARAMETERS, MH6.model_angles(joints), seen, noise=TRACKER)
        worse.append(np.mean(fit.standard_deviations / planned.expected_sigma))
    assert min(worse) > 1.1


def test_same_seed_same_plan():
    assert plan(8, seed=3).joints.tobytes() == plan(8, seed=3).joints.tobytes()


def test_too_few_poses_and_too_high_a_floor_are_refused():
    with pytest.raises(InputError, match="4 poses give 24 numbers for 24 parameters"):
        plan(4)
    with pytest.raises(InputError, match="lower the height"):
        plan(8, above_mm=3000.0)
