import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.running import run_here
from tests.simulated_poses import XIONG_2015_ERRORS, random_joints, simulate_poses
from wpcal.robot.identify.genetic_tabu import PoseFitness
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, link_parameters
from wpcal.robot.kinematics.arm_file import find_arm

POSES = Path(__file__).parents[3] / "fixtures" / "xiong2015" / "poses.csv"
SHOWN = 5e-5  # half of the last digit that is printed
SUM_MM = 1e-9  # round-off of a sum of 30 distances
MH6 = find_arm("mh6")
PARAMETERS = link_parameters(MH6.chain)


def observations():
    rng = np.random.default_rng(0)
    return simulate_poses(MH6, XIONG_2015_ERRORS, random_joints(MH6, 30, rng=rng), rng=rng)


def test_fitness_is_the_sum_of_distances_written_out():
    seen = observations()
    states = np.stack([np.zeros(24), XIONG_2015_ERRORS, 0.3 * XIONG_2015_ERRORS])
    fitness = PoseFitness(
        KinematicModel(MH6.chain), PARAMETERS, MH6.model_angles(seen.joints), seen, angle_length_mm=700
    )
    for state, cost in zip(states, fitness(states), strict=True):
        model = KinematicModel(MH6.chain).moved(PARAMETERS, state)
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
    fitness = PoseFitness(KinematicModel(MH6.chain), PARAMETERS, theta, PoseObservations(q, p, tipped))
    assert fitness(np.zeros((1, 24)))[0] < 1.0  # two turns of 1e-4 rad at 1000 mm, with the other angles


def test_positions_alone_have_a_fitness_too():
    seen = observations()
    alone = PoseObservations(seen.joints, seen.p_base)
    fitness = PoseFitness(KinematicModel(MH6.chain), PARAMETERS, MH6.model_angles(seen.joints), alone)
    np.testing.assert_allclose(fitness(XIONG_2015_ERRORS[None]), 0, rtol=0, atol=SUM_MM)


@pytest.mark.parametrize("method", ["least-squares", "ga-tabu"])
def test_the_two_commands_give_the_third_papers_table(method: str, tmp_path: Path) -> None:
    done = run_here("identify", "mh6", POSES, "--method", method, "-o", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    named = {each.name: error for each, error in zip(PARAMETERS, XIONG_2015_ERRORS, strict=True)}
    for each in json.loads(done.stdout)["parameters"]:
        error = named[each["name"]]
        wanted = np.degrees(error) if each["unit"] == "deg" else error
        assert each["change"] == pytest.approx(wanted, rel=0, abs=SHOWN), each["name"]
