"""Robot: speed of the kinematics, and identification beside its peers, all measured in this run."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.optimize import least_squares

from tests.benchmarks.timing import least_seconds
from tests.simulated_poses import XIONG_2015_ERRORS, random_joints, simulate_poses
from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import rotation_from_quaternion
from wpcal.robot.identify.error_summary import distances_mm
from wpcal.robot.identify.genetic_tabu import solve_genetic_tabu
from wpcal.robot.identify.identifiability import Noise
from wpcal.robot.identify.identification import IdentifyOptions, identify_arm
from wpcal.robot.identify.least_squares import solve_least_squares
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, link_parameters
from wpcal.robot.identify.pose_residuals import Prior, pose_errors
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.kinematics.forward import MDHChain, forward_kinematics
from wpcal.robot.kinematics.inverse import solve_inverse
from wpcal.robot.kinematics.opw import OPWGeometry, solve_opw

POSES = 20_000
REPEATS = 7
SEEDS = 10
NOISE = Noise(0.05, float(np.deg2rad(0.005)))
ROKAE = Path(__file__).parents[3] / "shared" / "ident" / "rokae_30poses.csv"


def main() -> None:
    """Print the tables."""
    console = Console(width=120)
    console.print(kinematics())
    console.print(identification(None, "the paper's experiment, noise-free: 50 poses fitted, 20 judged, 10 seeds"))
    console.print(
        identification(NOISE, "the same with 0.05 mm and 0.005 deg of noise; errors against noise-free poses")
    )
    if ROKAE.is_file():
        console.print(real_poses())
    else:
        console.print("real poses: the file lies beside the checkout and is not here")


def kinematics() -> Table:
    """Time a pose, batched, with what was asked for."""
    arm, rng = find_arm("mh6"), np.random.default_rng(0)
    theta = rng.uniform(-np.pi, np.pi, (POSES, 6))
    T = forward_kinematics(arm.chain, theta)
    model, parameters = KinematicModel(arm.chain), link_parameters(arm.chain)
    first = np.zeros(POSES, dtype=np.int64)
    geometry = OPWGeometry.of_chain(arm.chain)
    real = arm.as_identified(model.moved(parameters, XIONG_2015_ERRORS).chain)
    few = T[:500]
    rows = [
        ("forward kinematics", "≤ 2", least_seconds(lambda: forward_kinematics(arm.chain, theta), REPEATS) / POSES),
        (
            "Jacobian, 24 columns",
            "≤ 40",
            least_seconds(lambda: model.jacobian(parameters, theta, first), REPEATS) / POSES,
        ),
        ("closed-form inverse, 8 branches", "≤ 3", least_seconds(lambda: solve_opw(geometry, T), REPEATS) / POSES),
        ("the same with couplings and turns", "", least_seconds(lambda: solve_inverse(arm, T), REPEATS) / POSES),
        ("inverse of an identified arm", "", least_seconds(lambda: solve_inverse(real, few), 3) / len(few)),
    ]
    table = Table(title=f"Kinematics, µs a pose ({POSES} poses at once)")
    for heading in ("", "asked", "measured"):
        table.add_column(heading, justify="right" if heading else "left")
    for name, asked, seconds in rows:
        table.add_row(name, asked, f"{1e6 * seconds:.2f}")
    return table


def identification(noise: Noise | None, title: str) -> Table:
    """Least squares, SciPy's least squares with numeric derivatives, and the published search, side by side."""
    arm = find_arm("mh6")
    table = Table(title=title)
    for heading in ("solver", "time ms", "test error mm: median", "largest", "worst parameter %: median", "largest"):
        table.add_column(heading, justify="left" if heading == "solver" else "right")
    for name, solve in (("least squares", ours), ("scipy, numeric Jacobian", scipy_peer), ("ga-tabu", published)):
        seconds, errors, worst = [], [], []
        for seed in range(SEEDS):
            rng = np.random.default_rng(seed)
            joints = random_joints(arm, 70, rng=rng)
            seen = simulate_poses(arm, XIONG_2015_ERRORS, joints, rng=rng, noise=noise).select(range(50))
            exact = simulate_poses(arm, XIONG_2015_ERRORS, joints, rng=rng).select(range(50, 70))
            start = time.perf_counter()
            model, steps = solve(arm, seen, seed)
            seconds.append(time.perf_counter() - start)
            errors.append(distances_mm(pose_errors(model, arm.model_angles(exact.joints), exact)).mean())
            worst.append(100 * np.abs(steps / XIONG_2015_ERRORS - 1).max())
        cells = (np.median(errors), np.max(errors), np.median(worst), np.max(worst))
        table.add_row(name, f"{1e3 * min(seconds):.1f}", *(f"{cell:.2g}" for cell in cells))
    return table


def ours(arm: Arm, seen: PoseObservations, seed: int) -> tuple[KinematicModel, FloatArray]:
    """Least squares with the analytic Jacobian."""
    fit = solve_least_squares(
        KinematicModel(arm.chain), link_parameters(arm.chain), arm.model_angles(seen.joints), seen
    )
    return fit.model, fit.steps


def scipy_peer(arm: Arm, seen: PoseObservations, seed: int) -> tuple[KinematicModel, FloatArray]:
    """`scipy.optimize.least_squares` with its own differences, the true weights and tight tolerances."""
    start, parameters, theta = KinematicModel(arm.chain), link_parameters(arm.chain), arm.model_angles(seen.joints)
    weights = 1 / np.repeat([NOISE.sigma_rad, NOISE.sigma_mm], 3)
    scale = np.where([parameter.is_length for parameter in parameters], 1.0, 1e-3)
    answer = least_squares(
        lambda x: (pose_errors(start.moved(parameters, x), theta, seen) * weights).ravel(),
        np.zeros(len(parameters)),
        x_scale=scale,
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-14,
    )
    return start.moved(parameters, answer.x), answer.x


def published(arm: Arm, seen: PoseObservations, seed: int) -> tuple[KinematicModel, FloatArray]:
    """Genetic algorithm and tabu search with the paper's sizes."""
    start, parameters, theta = KinematicModel(arm.chain), link_parameters(arm.chain), arm.model_angles(seen.joints)
    fit = solve_genetic_tabu(Prior.of(start, tuple(parameters), None), theta, seen, rng=np.random.default_rng(seed))
    return fit.model, fit.steps


def real_poses() -> Table:
    """Thirty measured poses of a Rokae arm, each judged by the fit of the 29 others."""
    rows = np.loadtxt(ROKAE, delimiter=",")
    lengths = {"d": [487, 0, 0, 720, 0, 75], "a": [85, 640, 205, 0, 0, 0]}
    mh6 = find_arm("mh6")
    table_of_links = mh6.chain.table.copy()
    table_of_links[1], table_of_links[2] = lengths["d"], lengths["a"]
    chain: MDHChain = mh6.chain.with_table(table_of_links)
    arm = replace(mh6, name="Rokae", chain=chain)
    seen = PoseObservations(np.deg2rad(rows[:, :6]), rows[:, 6:9], rotation_from_quaternion(rows[:, 9:13]))
    options = IdentifyOptions(free_base=True, free_tool=True, folds=30)
    result = identify_arm(arm, seen, options=options)
    seconds = least_seconds(lambda: identify_arm(arm, seen, options=options), 2) / 31  # 30 folds and all poses
    table = Table(title="Real poses, leave one out (asked: mean ≤ 0.13, largest ≤ 0.30 mm, ≤ 50 ms a fit)")
    for heading in ("", "mean mm", "largest mm", "ms a fit"):
        table.add_column(heading, justify="right" if heading else "left")
    for name, figures in (("nominal", result.before.distance_mm), ("identified", result.after.distance_mm)):
        table.add_row(name, f"{figures.mean:.3f}", f"{figures.largest:.3f}", f"{1e3 * seconds:.1f}")
    return table


if __name__ == "__main__":
    main()
