"""What an identification must not claim: slips in the file, outliers, dependent rows, and what no pose shows."""

from dataclasses import replace

import numpy as np
import pytest

from tests.simulated_poses import random_joints, simulate_poses
from wpcal.core.errors import InputError, UnitError
from wpcal.core.rotations import quaternion_from_rotation, rotation_from_quaternion, rotation_from_zyx, zyx_angles
from wpcal.core.tangent import exp_rotation
from wpcal.robot.identify.error_summary import judge
from wpcal.robot.identify.identifiability import Noise
from wpcal.robot.identify.identification import IdentificationSolver, IdentifyOptions, identify_arm
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, link_parameters
from wpcal.robot.identify.pose_residuals import pose_errors
from wpcal.robot.kinematics.arm_file import find_arm

pytestmark = pytest.mark.many

MH6 = find_arm("mh6")
LINKS = link_parameters(MH6.chain)
NOISE = Noise(0.05, float(np.deg2rad(0.005)))
LENGTH_MM, ANGLE_RAD = 1.0, float(np.deg2rad(0.15))
"""Standard deviations of the true links about the nominal ones, and what the options are told of them."""
EXPECTED = {"expected_mm": LENGTH_MM, "expected_rad": ANGLE_RAD}
OFFSETS = np.array([[50.0, 0, 30], [-20, 60, 10], [0, -50, 80]])
TEST_POSES = 8


def true_errors(rng):
    return np.array([rng.normal(0.0, LENGTH_MM if p.is_length else ANGLE_RAD) for p in LINKS])


def measured(seed, count=40):
    rng = np.random.default_rng(seed)
    errors = true_errors(rng)
    return errors, simulate_poses(MH6, errors, random_joints(MH6, count, rng=rng), rng=rng, noise=NOISE)


def with_reflectors(seed, count=50, joint_rad=0.0):
    """Positions of three reflectors in a tracker's frame; the joints stop a little beside what they show."""
    rng = np.random.default_rng(seed)
    errors, q = true_errors(rng), random_joints(MH6, count, rng=rng)
    stopped = MH6.model_angles(q + rng.normal(0.0, joint_rad, q.shape))
    p, R = KinematicModel(MH6.chain).moved(LINKS, errors).poses(stopped, np.zeros(count, dtype=np.int64))
    points = np.concatenate([p + R @ offset for offset in OFFSETS])
    points = points @ exp_rotation([0.1, 0.2, 1.0]).T + [3000, -500, 200]
    points += rng.normal(0.0, NOISE.sigma_mm, points.shape)
    return errors, PoseObservations(
        np.tile(q, (3, 1)), points, reflectors=("A", "B", "C"), reflector=np.repeat(range(3), count)
    )


def coverage(make, options, trials):
    """Share of link parameters whose interval holds the truth, over simulated identifications."""
    hits = []
    for seed in range(trials):
        errors, observations = make(seed)
        test = np.isin(observations.poses, range(TEST_POSES))
        found = identify_arm(MH6, observations, options=options, test=test)
        truth = dict(zip((p.name for p in LINKS), errors, strict=True))
        hits += [
            abs(step - truth[parameter.name]) <= half
            for parameter, step, half in zip(found.fit.parameters, found.fit.steps, found.half_widths, strict=True)
            if parameter.name in truth
        ]
    return float(np.mean(hits))


def scalar_first(o):
    q = quaternion_from_rotation(o.R_base_flange)
    return replace(o, R_base_flange=rotation_from_quaternion(np.roll(q, 1, axis=1)))


def radians_as_degrees(o):
    return replace(o, R_base_flange=rotation_from_zyx(*np.deg2rad(zyx_angles(o.R_base_flange)).T))


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize(
    ("slip", "error", "words"),
    [
        (lambda o: replace(o, p_base=o.p_base / 1000.0), UnitError, "metres"),
        (lambda o: replace(o, p_base=o.p_base / 25.4), UnitError, "inches"),
        (scalar_first, InputError, "w, x, y, z"),
        (lambda o: replace(o, R_base_flange=np.swapaxes(o.R_base_flange, 1, 2)), InputError, "base to the flange"),
        (radians_as_degrees, UnitError, "radians"),
    ],
)
def test_a_slip_of_unit_or_convention_is_named(slip, error, words, known):
    options = IdentifyOptions(free_base=not known, free_tool=not known)
    with pytest.raises(error, match=words):
        identify_arm(MH6, slip(measured(1)[1]), options=options)


def test_orientations_of_other_poses_are_not_an_improvement():
    observations = measured(2)[1]
    turned = np.roll(observations.R_base_flange, 1, axis=0)
    assert not identify_arm(MH6, replace(observations, R_base_flange=turned)).verdict.improved


def test_worse_orientations_or_an_impossible_arm_are_not_an_improvement():
    rng = np.random.default_rng(0)
    before = rng.normal(0.0, [1e-4] * 3 + [1.0] * 3, (20, 6))
    better = before * [1, 1, 1, 0.1, 0.1, 0.1]
    assert judge(before, better).improved
    assert "orientations became worse" in judge(before, better * [5, 5, 5, 1, 1, 1]).reasons[0]
    assert "d4 would change by -639" in judge(before, better, changes={"d4": (-639.4, True)}).reasons[0]


@pytest.mark.parametrize("seed", range(4))
def test_a_pose_20_mm_off_is_named_and_hardly_bends_the_arm(seed):
    errors, observations = measured(seed, count=50)
    bad = 20 + seed  # not among the test poses
    test = np.arange(50) < TEST_POSES
    slipped = observations.p_base.copy()
    slipped[bad] += [0.0, 20.0, 0.0]
    clean, off_by_20 = identify_arm(MH6, observations, test=test), replace(observations, p_base=slipped)
    found = identify_arm(MH6, off_by_20, test=test)
    assert not clean.outliers
    assert [outlier.rows for outlier in found.outliers] == [(bad + 1,)]
    assert found.outliers[0].distance_mm == pytest.approx(20.0, abs=5 * NOISE.sigma_mm)
    assert str(bad + 1) in found.issues[0].message
    assert found.after.distance_mm.rms < 1.1 * clean.after.distance_mm.rms  # a bounded pull of 1.5 sigma
    without = identify_arm(MH6, off_by_20, test=test, options=IdentifyOptions(leave_out=(bad + 1,)))
    assert not without.outliers
    assert len(without.train) == len(found.train) - 1
    exact = simulate_poses(MH6, errors, observations.joints, rng=np.random.default_rng(0))
    off = pose_errors(without.fit.model, MH6.model_angles(observations.joints), exact)
    assert np.linalg.norm(off[:, 3:], axis=1).mean() < NOISE.sigma_mm


def test_a_bad_test_pose_is_named_too():
    _, observations = measured(7, count=50)
    slipped = observations.p_base.copy()
    slipped[3] += [5.0, 0.0, 0.0]
    found = identify_arm(MH6, replace(observations, p_base=slipped), test=np.arange(50) < TEST_POSES)
    assert [(outlier.rows, outlier.held_back) for outlier in found.outliers] == [((4,), True)]


@pytest.mark.deep
def test_clean_poses_are_hardly_ever_named():
    """At a false alarm in a hundred files, more than two of thirty has a chance of 0.3 %."""
    named = sum(bool(identify_arm(MH6, measured(100 + seed)[1]).outliers) for seed in range(30))
    assert named <= 2


def test_a_row_that_is_not_in_the_file_is_refused():
    with pytest.raises(InputError, match="row 99"):
        identify_arm(MH6, measured(0)[1], options=IdentifyOptions(leave_out=(99,)))


@pytest.mark.deep
@pytest.mark.parametrize(("joint_rad", "files"), [(0.0, 20), (2e-5, 8), (2e-5, 20)])
def test_intervals_with_three_reflectors_cover_the_truth(joint_rad, files):
    """Issue: 93 to 97 % (rows taken as independent: 69 %). 20 files of 18 parameters: sigma about 2 %; 8 files: 3 %."""
    options = IdentifyOptions(free_base=True, free_tool=True, **EXPECTED)
    share = coverage(lambda seed: with_reflectors(seed, joint_rad=joint_rad), options, files)
    assert 0.91 <= share <= 0.99


@pytest.mark.deep
def test_intervals_of_parameters_that_absorb_an_unseen_one_cover_the_truth():
    def positions_only(seed):
        errors, o = measured(seed, count=60)
        return errors, PoseObservations(o.joints, o.p_base)

    assert 0.91 <= coverage(positions_only, IdentifyOptions(**EXPECTED), 20) <= 0.99


@pytest.mark.deep
def test_the_published_search_states_no_interval():
    found = identify_arm(MH6, measured(0)[1], options=IdentifyOptions(solver=IdentificationSolver.GENETIC_TABU))
    assert found.half_widths is None


def test_an_unknown_tool_is_told():
    _, observations = with_reflectors(0)
    found = identify_arm(MH6, observations, options=IdentifyOptions(free_base=True, free_tool=True))
    issue = next(issue for issue in found.issues if issue.code == "tool-unknown")
    assert set(issue.ids) == {"theta6", "d6", "a6", "alpha6"}


@pytest.mark.parametrize(("range_deg", "count", "improved"), [(5.0, 40, False), (300.0, 40, True)])
def test_an_arm_is_improved_only_where_the_interval_over_all_poses_says_so(range_deg, count, improved):
    low, high = MH6.limits
    every = MH6.model_angles(random_joints(MH6, 400, rng=np.random.default_rng(9)))
    one, predicted, real = np.zeros(400, dtype=np.int64), [], []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        truth = KinematicModel(MH6.chain).moved(LINKS, true_errors(rng))
        q = (low + high) / 2 + np.clip(np.deg2rad(range_deg) * (rng.random((count, 6)) - 0.5), -0.45 * (high - low), 2)
        p, _ = truth.poses(MH6.model_angles(q), one[:count])
        seen = PoseObservations(q, p + rng.normal(0.0, 0.1, p.shape))
        found = identify_arm(MH6, seen, options=IdentifyOptions(free_base=True, free_tool=True, folds=5, **EXPECTED))
        off = [model.poses(every, one)[0] - truth.poses(every, one)[0] for model in (found.nominal, found.fit.model)]
        real.append([np.sqrt(np.mean(np.sum(each**2, axis=1))) for each in off])
        predicted.append([found.whole_range.nominal_mm, found.whole_range.identified_mm])
        assert found.verdict.improved is found.whole_range.is_better is improved
        assert improved or "the nominal arm stays in use" in found.verdict.reasons[-1]
    nominal, identified = np.sqrt(np.mean(np.square(predicted), axis=0) / np.mean(np.square(real), axis=0))
    assert 0.7 < nominal < 2.0
    assert 0.7 < identified < 2.0
