"""Advised points against random ones and the nearest corners: predicted and simulated error along the seams."""

from pathlib import Path

import numpy as np
from rich.table import Table

from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import open_workpiece
from wpcal.calibrate import Criterion, TeachingError
from wpcal.calibrate.errors.linear_fit import budget_of_design
from wpcal.calibrate.errors.prediction import COVERAGE
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.core.arrays import FloatArray
from wpcal.seam import SeamOptions
from wpcal.seam.limits import Level
from wpcal.seam.options import Judging
from wpcal.study.teaching_error import fit_trials
from wpcal.taught.features import FeatureKind, judge_features
from wpcal.taught.match import Places
from wpcal.touch.advice import advise

ROOT = Path(__file__).parents[2]
SHARED = ROOT.parent / "shared" / "step"
SAMPLES = {name: ROOT / "fixtures" / name / f"{name}.step" for name in ("tee", "lap", "saddle", "frame")}
REAL = ("as1-oc-214.stp", "tail_section_asm.stp")
SIGMA_MM = 0.3
POINTS = 4
RANDOM_SETS = 101
TRIALS = 2000


def main() -> Table:
    title = f"Largest 95 % error along the seams, {POINTS} points, sigma {SIGMA_MM} mm, minimax: predicted (simulated)"
    heads = "part", "advised", "median random", "nearest corners", "random / advised", "nearest / advised"
    table = Table(*heads, title=title)
    real = {path.name: path for path in (SHARED / name for name in REAL) if path.is_file()}
    for name, path in (SAMPLES | real).items():
        table.add_row(name, *_row(path))
    return table


def _row(path: Path) -> tuple[str, ...]:
    workpiece = open_workpiece(path)
    seams, workpiece = find_seams(workpiece, SeamOptions(judging=Judging(level=Level.GENEROUS)))
    accepted = [seam for seam in seams if seam.accepted]
    points = np.concatenate([seam.frames.p for seam in accepted])
    features = [feature for feature in workpiece.features if feature.kind.is_point]
    places = Places.of(features)
    advice = advise(judge_features(workpiece.graph, features), accepted, points=POINTS, sigma_mm=SIGMA_MM)
    advised = np.array([feature.p_mm for feature in advice.chosen.features])
    sets = _random_sets(np.array([feature.p_mm for feature in features]))
    errors = np.array([_predicted(p, points) for p in sets])
    median = sets[int(np.argsort(errors)[len(errors) // 2])]
    nearest = _nearest_corners(places, points)
    predicted = [_predicted(p, points) for p in (advised, median, nearest)]
    simulated = [_simulated(p, points) for p in (advised, median, nearest)]
    cells = [f"{a:.3f} ({b:.3f})" for a, b in zip(predicted, simulated, strict=True)]
    return (*cells, f"{predicted[1] / predicted[0]:.2f}", f"{predicted[2] / predicted[0]:.2f}")


def _random_sets(p: FloatArray) -> list[FloatArray]:
    """Sets of four random features of the part's list that are not on one line."""
    rng = np.random.default_rng(0)
    sets: list[FloatArray] = []
    while len(sets) < RANDOM_SETS:
        some = p[rng.choice(len(p), POINTS, replace=False)]
        if np.linalg.svd(some - some.mean(axis=0), compute_uv=False)[1] > 1.0:
            sets.append(some)
    return sets


def _nearest_corners(places: Places, seam_points: FloatArray) -> FloatArray:
    """The three corners nearest to the middle of the seams that are not on one line."""
    corners = places.p[places.of_kinds([FeatureKind.VERTEX])]
    order = np.argsort(np.linalg.norm(corners - seam_points.mean(axis=0), axis=1), kind="stable")
    for k in range(2, len(order)):
        some = corners[order[[0, 1, k]]]
        if np.linalg.svd(some - some.mean(axis=0), compute_uv=False)[1] > 1.0:
            return some
    return places.p[[0, 1, -1]]


def _predicted(p: FloatArray, seam_points: FloatArray) -> float:
    exact_robot = TeachingError(sigma_mm=SIGMA_MM, robot=RobotField.none())
    return budget_of_design(p, exact_robot, with_minimax=True).largest_error_95(seam_points)[1]


def _simulated(p: FloatArray, seam_points: FloatArray) -> float:
    """Largest over the seam points of the 95 % quantile of the error in simulated calibrations."""
    rng = np.random.default_rng(1)
    centre = p.mean(axis=0)
    taught = (p - centre) + SIGMA_MM * rng.standard_normal((TRIALS, *p.shape))
    R, t = fit_trials(p - centre, taught, Criterion.MINIMAX)
    worst = 0.0
    for s in seam_points - centre:
        worst = max(worst, float(np.quantile(np.linalg.norm(R @ s + t - s, axis=1), COVERAGE)))
    return worst
