"""Identification recovers what was put in, says what it cannot see, and claims nothing on shuffled measurements."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.few import few
from tests.simulated_poses import XIONG_2015_ERRORS, random_joints, simulate_poses
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.rotations import rotation_from_quaternion
from wpcal.core.tangent import exp_rotation
from wpcal.robot.identify.error_summary import distances_mm, judge
from wpcal.robot.identify.identifiability import Noise
from wpcal.robot.identify.identification import IdentificationSolver, IdentifyOptions, identify_arm
from wpcal.robot.identify.identification_record import identification_record
from wpcal.robot.identify.least_squares import solve_least_squares
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, link_parameters
from wpcal.robot.identify.pose_residuals import pose_errors
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.kinematics.forward import MDHChain

pytestmark = pytest.mark.many

MH6 = find_arm("mh6")
PARAMETERS = link_parameters(MH6.chain)
GENETIC = IdentificationSolver.GENETIC_TABU
NOISE = Noise(0.05, float(np.deg2rad(0.005)))  # the issue's: 0.05 mm, 0.005°
SAME_PARAMETER = 1e-9  # relative, the issue's bound
NOISE_FREE_MM = 1e-9  # round-off of poses a metre away
ROKAE = Path(__file__).parents[3] / "shared" / "ident" / "rokae_30poses.csv"


def measured(seed, count=70, noise=None):
    rng = np.random.default_rng(seed)
    return simulate_poses(MH6, XIONG_2015_ERRORS, random_joints(MH6, count, rng=rng), rng=rng, noise=noise)


def fit(observations, **options):
    theta = MH6.model_angles(observations.joints)
    return solve_least_squares(KinematicModel(MH6.chain), PARAMETERS, theta, observations, **options)


def true_errors_mm(model, joints):
    exact = simulate_poses(MH6, XIONG_2015_ERRORS, joints, rng=np.random.default_rng(0))
    return distances_mm(pose_errors(model, MH6.model_angles(joints), exact))


@pytest.mark.parametrize("seed", range(5))
def test_exact_poses_give_every_parameter_of_the_paper(seed):
    found = fit(measured(seed).select(range(50)))
    np.testing.assert_allclose(found.steps / XIONG_2015_ERRORS, 1, rtol=0, atol=SAME_PARAMETER)
    assert found.rank == 24
    assert not found.unseen
    assert found.converged


@pytest.mark.parametrize("seed", range(5))
def test_noisy_poses_give_true_poses_below_the_noise(seed):
    observations = measured(seed, noise=NOISE)
    found = fit(observations.select(range(50)))
    assert true_errors_mm(found.model, observations.joints[50:]).mean() <= 0.04  # the issue's bound
    assert found.noise.sigma_mm == pytest.approx(NOISE.sigma_mm, rel=0.25)  # of about 140 degrees of freedom: 4 sigma
    assert found.noise.sigma_rad == pytest.approx(NOISE.sigma_rad, rel=0.25)


def test_the_order_of_poses_does_not_matter():
    observations = measured(0, noise=NOISE)
    one, other = fit(observations), fit(observations.select(np.random.default_rng(1).permutation(70)))
    np.testing.assert_allclose(one.steps, other.steps, rtol=0, atol=1e-7)  # the last step is a part of the noise


def test_with_d2_in_place_of_beta2_the_rank_is_23_and_d2_is_named():
    names = tuple(p.name.replace("beta2", "d2") for p in PARAMETERS)
    result = identify_arm(MH6, measured(0), options=IdentifyOptions(parameters=names))
    assert result.fit.rank == 23
    assert [(unseen.name, unseen.like) for unseen in result.fit.unseen] == [("d2", ("d3",))]
    assert "d2 cannot be told from d3" in result.issues[0].message


@pytest.mark.parametrize("reflectors", few([1, 3], 1))
def test_base_and_tool_are_found_with_the_arm(reflectors):
    observations = measured(3)
    offsets = np.array([[50.0, 0, 30], [-20, 60, 10], [0, -50, 80]])[:reflectors]
    R = observations.R_base_flange
    points = np.concatenate([observations.p_base + R @ offset for offset in offsets])
    turned = points @ exp_rotation([0.1, 0.2, 1.0]).T + [3000, -500, 200]
    seen = PoseObservations(
        np.tile(observations.joints, (reflectors, 1)),
        turned,
        reflectors=tuple("ABC"[:reflectors]),
        reflector=np.repeat(range(reflectors), 70),
    )
    result = identify_arm(MH6, seen, options=IdentifyOptions(free_base=True, free_tool=True))
    assert result.after.distance_mm.largest < NOISE_FREE_MM * 100  # errors multiplied by the condition of the problem
    assert {unseen.name for unseen in result.fit.unseen} == {"theta1", "d1", "theta6", "d6", "a6", "alpha6"}
    assert len(np.unique(result.test % 70)) * reflectors == len(result.test)  # reflectors of a pose stay together


def test_full_poses_with_unknown_base_and_tool_are_met():
    observations = measured(4)
    turn, tool = exp_rotation([0.1, 0.2, 1.0]), exp_rotation([0.5, -0.2, 0.3])
    seen = PoseObservations(
        observations.joints,
        (observations.p_base + observations.R_base_flange @ [10, 20, 150]) @ turn.T + [3000, -500, 200],
        turn @ observations.R_base_flange @ tool,
    )
    result = identify_arm(MH6, seen, options=IdentifyOptions(free_base=True, free_tool=True))
    assert result.fit.rank == 30  # 4 · 6 links + 6: all that six revolute joints can show
    assert result.after.distance_mm.largest < NOISE_FREE_MM * 100
    assert result.arm.chain.T_base_dh0 is MH6.chain.T_base_dh0  # the set-up of the instrument is no part of the arm


@pytest.mark.parametrize("name", ["poses", "places", "reflectors", "wrong", "folds"])
def test_every_value_of_an_identification(name, golden):
    seen, which = measured(5, 43, NOISE), np.arange(43) % 3
    p, R = seen.p_base.copy(), seen.R_base_flange
    p[7] += [3.1, -2.2, 1.7] if name == "wrong" else 0.0
    seen = replace(seen, p_base=p)
    if name == "places":
        seen = PoseObservations(seen.joints, p + 0.3 * np.sin(p / 400.0))
    elif name == "reflectors":
        offsets = np.array([[41.0, -9, 77], [-52, 33, 81], [7, 63, -18]])[which]
        seen = PoseObservations(seen.joints, p + np.einsum("nij,nj->ni", R, offsets), None, ("A", "B", "C"), which)
    asked = IdentifyOptions(expected_mm=1.7, free_base=name == "poses", folds=3 if name == "folds" else None)
    found = identify_arm(MH6, seen, options=asked, test=which == 1 if name in ("poses", "wrong") else None)
    golden([found, identification_record(found)])


@pytest.mark.parametrize("seed", few(range(10), 1))
@pytest.mark.parametrize("unknown", [False, True])
def test_shuffled_measurements_claim_no_improvement(seed, unknown):
    observations = measured(6, noise=NOISE)
    order = np.random.default_rng(seed).permutation(70)
    shuffled = PoseObservations(observations.joints, observations.p_base[order], observations.R_base_flange[order])
    result = identify_arm(MH6, shuffled, options=IdentifyOptions(free_base=unknown, free_tool=unknown))
    assert not result.verdict.improved


@pytest.mark.parametrize("seed", few(range(10), 2))
def test_shuffled_deviations_claim_no_improvement(seed):
    """Errors of the right size on the wrong poses: no arm explains them, and the fit must not seem to."""
    observations = measured(7)
    p, R = KinematicModel(MH6.chain).poses(MH6.model_angles(observations.joints), observations.reflector)
    shift, turn = 0.2 * (observations.p_base - p), observations.R_base_flange @ np.swapaxes(R, 1, 2)
    order = np.random.default_rng(seed).permutation(70)
    shuffled = PoseObservations(observations.joints, p + shift[order], turn[order] @ R)
    assert not identify_arm(MH6, shuffled).verdict.improved


def test_a_few_test_poses_prove_nothing():
    before = np.full((6, 3), 5.0)
    assert not judge(before, 0.01 * before).improved
    assert judge(np.full((12, 3), 5.0), np.full((12, 3), 0.05)).improved


def test_too_few_poses_and_far_positions_are_refused():
    observations = measured(8)
    with pytest.raises(GeometryError, match="too few poses: 4 give 24 numbers for 24 parameters; 5 poses"):
        fit(observations.select(range(4)))
    far = PoseObservations(observations.joints, observations.p_base * 10)
    with pytest.raises(InputError, match=r"row \d+ is \d+ mm from the base, out of reach"):
        identify_arm(MH6, far)
    with pytest.raises(InputError, match="2 to 70 folds"):
        identify_arm(MH6, observations, options=IdentifyOptions(folds=71))
    with pytest.raises(InputError, match="known base and tool"):
        identify_arm(MH6, observations, options=IdentifyOptions(solver=GENETIC, free_base=True))


def random_errors(rng):
    """Errors as the issue describes them: 0.1° or 0.2°, 1 to 2 mm, of either sign."""
    lengths = np.array([parameter.is_length for parameter in PARAMETERS])
    sizes = np.where(lengths, rng.uniform(1, 2, 24), np.deg2rad(rng.choice([0.1, 0.2], 24)))
    return sizes * rng.choice([-1, 1], 24)


@pytest.mark.deep
@pytest.mark.parametrize("preset", [True, False])
def test_genetic_tabu_reaches_what_the_paper_did(preset):
    """Ten seeds: test error ≤ 0.05 mm in nine, worst parameter ≤ 3 % in the median (the issue's bounds)."""
    tested, worst = [], []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        errors = XIONG_2015_ERRORS if preset else random_errors(rng)
        observations = simulate_poses(MH6, errors, random_joints(MH6, 70, rng=rng), rng=rng)
        result = identify_arm(MH6, observations, options=IdentifyOptions(solver=GENETIC, seed=seed))
        tested.append(result.after.distance_mm.mean)
        steps = dict(zip((p.name for p in result.fit.parameters), result.fit.steps, strict=True))
        found = np.array([steps[p.name] for p in PARAMETERS])
        worst.append(np.abs(found / errors - 1).max())
    assert sorted(tested)[8] <= 0.05
    assert np.median(worst) <= 0.03


@pytest.mark.deep
def test_genetic_tabu_never_beats_least_squares_by_its_own_measure():
    observations = measured(9, noise=NOISE)
    search = identify_arm(MH6, observations, options=IdentifyOptions(solver=GENETIC))
    exact = identify_arm(MH6, observations)
    r = [np.sum((pose_errors(result.fit.model, MH6.model_angles(observations.joints[result.train]),
                             observations.select(result.train)) / np.repeat([NOISE.sigma_rad, NOISE.sigma_mm], 3)) ** 2)
         for result in (search, exact)]  # fmt: skip
    assert r[1] <= r[0] * 1.001  # the weights of the second are estimated: a hair from those used here
    assert search.verdict.improved


@pytest.mark.deep
def test_stated_intervals_cover_the_truth_in_2000_runs():
    """Each 95 % interval covers in 93 to 97 % of the runs: 4 standard deviations of 2000 draws to each side."""
    rng = np.random.default_rng(0)
    joints = random_joints(MH6, 50, rng=rng)
    covered = np.zeros(24)
    for _ in range(2000):
        found = fit(simulate_poses(MH6, XIONG_2015_ERRORS, joints, rng=rng, noise=NOISE))
        covered += np.abs(found.steps - XIONG_2015_ERRORS) <= found.half_widths()
    assert covered.min() / 2000 >= 0.93
    assert covered.max() / 2000 <= 0.97


@pytest.mark.skipif(not ROKAE.is_file(), reason="the measured poses lie beside the checkout and are not here")
def test_real_poses_left_out_one_at_a_time():
    degrees = np.deg2rad
    rows = np.loadtxt(ROKAE, delimiter=",")
    chain = MDHChain(
        degrees([0, -90, 0, 0, 0, 0]),
        [487, 0, 0, 720, 0, 75],
        [85, 640, 205, 0, 0, 0],
        degrees([-90, 0, -90, 90, -90, 0]),
        np.zeros(6),
        (False, True, False, False, False, False),
    )
    arm = replace(MH6, name="Rokae", chain=chain)
    observations = PoseObservations(degrees(rows[:, :6]), rows[:, 6:9], rotation_from_quaternion(rows[:, 9:13]))
    result = identify_arm(arm, observations, options=IdentifyOptions(free_base=True, free_tool=True, folds=30))
    assert result.after.distance_mm.mean <= 0.13  # the issue's bounds
    assert result.after.distance_mm.largest <= 0.30
    assert result.before.distance_mm.mean > 2
    assert result.verdict.improved


def test_held_out_poses_prove_the_improvement_and_folds_agree():
    observations = measured(5, noise=NOISE)
    split = identify_arm(MH6, observations)
    folds = identify_arm(MH6, observations, options=IdentifyOptions(folds=7))
    assert split.verdict.improved
    assert folds.verdict.improved
    assert len(split.test) == 20
    assert sorted(folds.test.tolist()) == list(range(70))
    assert not set(split.test.tolist()) & set(split.train.tolist())
    assert split.before.distance_mm.mean > 3
    assert split.after.distance_mm.mean < 0.12  # three times a coordinate's noise would be 0.15
