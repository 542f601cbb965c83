"""Verdicts where the robot has a smooth error of its own: coverage of the band, and PASS beside an oracle."""

from dataclasses import dataclass, replace

import numpy as np
from rich.table import Table
from scipy.spatial.transform import Rotation

from tests.benchmarks.bench_verdict import spread_set, unit_noise
from tests.benchmarks.verdict_study import VerdictStudy, run_verdict_study
from tests.saved_graphs import saved_graph
from wpcal.calibrate import TeachingError
from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.linear_fit import budget_of_design
from wpcal.calibrate.errors.prediction import ToolError
from wpcal.calibrate.errors.robot_field import RobotField, correlation
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation
from wpcal.seam import detect_seams
from wpcal.taught.features import find_features
from wpcal.touch.design import farthest_rows

PARTS = ("tee", "lap", "saddle", "frame")
COUNTS = (4, 6, 8, 12)
FIELDS_MM = ((0.0, 500.0), (0.1, 400.0), (0.3, 300.0), (0.3, 600.0), (0.5, 1000.0))
SIGMA_MM, TOLERANCE_MM, TRIALS = 0.1, 0.5, 100
SEAM_POINTS = 60  #: Points of the seams at which fields are drawn.


@dataclass(frozen=True, slots=True)
class FieldStudy:
    """Verdicts beside those of an oracle that knows every variance."""

    study: VerdictStudy
    oracle: int  #: Calibrations that the oracle passes.


def main() -> Table:
    heads = ("part", "field", "points", "stated", "covered", "PASS", "FAIL", "PASS, outside", "FAIL, inside", "oracle")
    table = Table(*heads, title=f"{TRIALS} calibrations, sigma {SIGMA_MM} mm, tolerance {TOLERANCE_MM} mm, in %")
    for part in PARTS:
        for amplitude, length in FIELDS_MM:
            for n in COUNTS:
                for stated in ("all", "sigma", "nothing"):
                    found = field_study(part, n, RobotField(amplitude, length), stated=stated)
                    study, trials = found.study, found.study.trials
                    counts = (study.verdicts["PASS"], study.verdicts["FAIL"], study.passed_outside, study.failed_inside)
                    shares = (f"{100.0 * count / trials:.1f}" for count in (*counts, found.oracle))
                    field = f"{amplitude:g} over {length:g}"
                    table.add_row(part, field, str(n), stated, f"{100.0 * study.covered:.1f}", *shares)
    return table


def field_study(
    part: str,
    n: int,
    field: RobotField,
    *,
    stated: str,
    trials: int = TRIALS,
    scale: float = 0.0,
    noise: str = "gaussian",
) -> FieldStudy:
    """Simulate calibrations by a robot with a smooth error, n random features each."""
    rng = np.random.default_rng(n)
    sets, seams = _sets(part, n, trials, rng)
    drawn = [_field(np.concatenate([p, seams]), field, scale, rng) for p in sets]
    errors = [each[:n] + unit_noise(noise, (n, 3), rng) * SIGMA_MM for each in drawn]
    known = TeachingError(sigma_mm=SIGMA_MM, robot=field)
    teaching = {"all": known, "sigma": TeachingError(sigma_mm=SIGMA_MM), "nothing": TeachingError()}[stated]
    study = run_verdict_study(
        sets,
        seams,
        errors=errors,
        seam_errors=[each[n:] for each in drawn],
        teaching=teaching,
        tolerance_mm=TOLERANCE_MM,
    )
    budgets = (budget_of_design(p, known) for p in sets)
    oracles = (replace(each, scale=max(scale, each.scale)) for each in budgets)
    return FieldStudy(study, sum(_joint(each, seams) <= TOLERANCE_MM for each in oracles))


def tool_study(part: str, n: int, tool: ToolError, *, tilt_deg: float, trials: int = TRIALS) -> VerdictStudy:
    """Simulate calibrations by a tool that is off as stated; the postures of touches are known, welds have any."""
    rng = np.random.default_rng(n)
    sets, seams = _sets(part, n, trials, rng)
    postures = [np.array([exp_rotation(np.radians(tilt_deg) * v) for v in rng.normal(size=(n, 3))]) for _ in sets]
    off = [rng.normal(size=3) * np.sqrt(np.diag(tool.covariance)) for _ in sets]
    errors = [R @ b + SIGMA_MM * rng.normal(size=(n, 3)) for R, b in zip(postures, off, strict=True)]
    return run_verdict_study(
        sets,
        seams,
        errors=errors,
        seam_errors=[np.tile(Rotation.random(rng=rng).apply(b), (len(seams), 1)) for b in off],
        postures=postures,
        teaching=TeachingError(sigma_mm=SIGMA_MM, robot=RobotField.none(), tool=tool),
        tolerance_mm=2.0 * TOLERANCE_MM,
    )


def _sets(part: str, n: int, trials: int, rng: np.random.Generator) -> tuple[list[FloatArray], FloatArray]:
    """Draw sets of n features of a part, and take points of its seams."""
    graph = saved_graph(part)
    features = np.array([feature.p_mm for feature in find_features(graph) if feature.kind.is_point])
    seams = np.concatenate([seam.frames.p for seam in detect_seams(graph) if seam.accepted])
    return [spread_set(features, n, rng) for _ in range(trials)], seams[
        farthest_rows(seams, min(SEAM_POINTS, len(seams)))
    ]


def _field(points: FloatArray, field: RobotField, scale: float, rng: np.random.Generator) -> FloatArray:
    K = correlation(points, points, field.length_mm) + 1e-9 * np.eye(len(points))
    drawn = field.amplitude_mm * np.linalg.cholesky(K) @ rng.standard_normal(points.shape)
    return np.asarray(drawn + scale * (points - points.mean(axis=0)))


def _joint(budget: ErrorBudget, seams: FloatArray) -> float:
    return budget.joint_errors(seams).error_95_mm
