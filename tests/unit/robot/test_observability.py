"""Which parameters poses show, the registration of a tracker that saw them, and the published search for them."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.running import run_here
from tests.simulated_poses import XIONG_2015_ERRORS, random_joints, simulate_poses
from wpcal.core.errors import InputError
from wpcal.core.tangent import exp_rotation
from wpcal.robot.identify.genetic_tabu import PoseFitness
from wpcal.robot.identify.identifiability import TRACKER
from wpcal.robot.identify.least_squares import solve_least_squares
from wpcal.robot.identify.observability import LIMIT_MARGIN_RAD, plan_poses
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, last_link_first, link_parameters
from wpcal.robot.identify.pose_residuals import pose_errors
from wpcal.robot.identify.registration import register
from wpcal.robot.kinematics.arm_file import find_arm

MH6 = find_arm("mh6")
PARAMETERS = last_link_first(MH6.chain, None)


def plan(count, seed=0, **options):
    return plan_poses(MH6, count, parameters=PARAMETERS, rng=np.random.default_rng(seed), **options)


@pytest.mark.parametrize("count", [8, 30])
def test_a_plan_sees_more_than_random_poses_and_stays_off_the_limits(count, golden):
    found = plan(count)
    low, high = MH6.limits
    assert found.joints.shape == (count, 6)
    assert len(np.unique(found.joints, axis=0)) == count
    assert (found.joints >= low + LIMIT_MARGIN_RAD).all()
    assert (found.joints <= high - LIMIT_MARGIN_RAD).all()
    assert found.index > 1.05 * found.random_index
    assert len(found.parameters) == 24
    golden([found, found.to_record(MH6), found.expected_95()])


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


def test_too_few_poses_and_too_high_a_floor_are_refused():
    with pytest.raises(InputError, match="4 poses give 24 numbers for 24 parameters"):
        plan(4)
    with pytest.raises(InputError, match="lower the height"):
        plan(8, above_mm=3000.0)


MET_MM = 1e-8  # linear equations of positions four metres away
NEAR_MM = 1.0  # of the rounds in turns only a start is wanted
TURN, SHIFT = exp_rotation([0.4, -2.0, 1.0]), np.array([3000.0, -500.0, 200.0])
TOOL, OFFSET = exp_rotation([2.5, 0.3, -0.8]), np.array([40.0, -30.0, 120.0])


def seen(*, base, tool, poses=True):
    rng = np.random.default_rng(0)
    exact = simulate_poses(MH6, np.zeros(24), random_joints(MH6, 25, rng=rng), rng=rng)
    R = exact.R_base_flange
    p = exact.p_base + (R @ OFFSET if tool else 0.0)
    if base:
        p, R = p @ TURN.T + SHIFT, TURN @ R
    return PoseObservations(exact.joints, p, (R @ TOOL if tool else R) if poses else None)


@pytest.mark.parametrize(("poses", "within_mm"), [(True, MET_MM), (False, NEAR_MM)], ids=["poses", "positions"])
@pytest.mark.parametrize(("base", "tool"), [(True, True), (True, False), (False, True), (False, False)])
def test_full_poses_are_met_at_once_and_positions_give_a_start(base, tool, poses, within_mm):
    observations = seen(base=base, tool=tool, poses=poses)
    theta = MH6.model_angles(observations.joints)
    model = register(MH6.chain, theta, observations, free_base=base, free_tool=tool)
    np.testing.assert_allclose(pose_errors(model, theta, observations), 0, rtol=0, atol=within_mm)


POSES = Path(__file__).parents[3] / "fixtures" / "xiong2015" / "poses.csv"
SHOWN = 5e-5  # half of the last digit that is printed
SUM_MM = 1e-9  # round-off of a sum of 30 distances
PRINTED = link_parameters(MH6.chain)


def observations():
    rng = np.random.default_rng(0)
    return simulate_poses(MH6, XIONG_2015_ERRORS, random_joints(MH6, 30, rng=rng), rng=rng)


def test_fitness_is_the_sum_of_distances_written_out():
    seen = observations()
    states = np.stack([np.zeros(24), XIONG_2015_ERRORS, 0.3 * XIONG_2015_ERRORS])
    fitness = PoseFitness(KinematicModel(MH6.chain), PRINTED, MH6.model_angles(seen.joints), seen, angle_length_mm=700)
    for state, cost in zip(states, fitness(states), strict=True):
        model = KinematicModel(MH6.chain).moved(PRINTED, state)
        p, R = model.poses(MH6.model_angles(seen.joints), seen.reflector)
        rpy = Rotation.from_matrix(R).as_euler("xyz") - Rotation.from_matrix(seen.R_base_flange).as_euler("xyz")
        rpy = (rpy + np.pi) % (2 * np.pi) - np.pi
        shift = np.linalg.norm(p - seen.p_base, axis=1)
        wanted = np.hypot(shift, 700 * np.linalg.norm(rpy, axis=1)).sum()
        np.testing.assert_allclose(cost, wanted, rtol=0, atol=SUM_MM)


def test_angles_on_both_sides_of_half_a_turn_are_near():
    """The flange of an MH6 that points down has a roll of ±180°: a hair to either side must not cost a turn."""
    q = np.zeros((2, 6))
    q[:, 4] = np.pi / 2
    theta = MH6.model_angles(q)
    p, R = KinematicModel(MH6.chain).poses(theta, np.zeros(2, dtype=np.int64))
    tipped = Rotation.from_rotvec([[1e-4, 0, 0], [-1e-4, 0, 0]]).as_matrix() @ R
    rolls = Rotation.from_matrix(tipped).as_euler("xyz")[:, 0]
    assert rolls[0] * rolls[1] < 0
    assert np.abs(rolls).min() > 3
    fitness = PoseFitness(KinematicModel(MH6.chain), PRINTED, theta, PoseObservations(q, p, tipped))
    assert fitness(np.zeros((1, 24)))[0] < 1.0  # two turns of 1e-4 rad at 1000 mm, with the other angles


@pytest.mark.parametrize("method", ["least-squares", "ga-tabu"])
def test_the_two_commands_give_the_third_papers_table(method: str, tmp_path: Path) -> None:
    done = run_here("identify", "mh6", POSES, "--method", method, "-o", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    named = {each.name: error for each, error in zip(PRINTED, XIONG_2015_ERRORS, strict=True)}
    for each in json.loads(done.stdout)["parameters"]:
        error = named[each["name"]]
        wanted = np.degrees(error) if each["unit"] == "deg" else error
        assert each["change"] == pytest.approx(wanted, rel=0, abs=SHOWN), each["name"]
