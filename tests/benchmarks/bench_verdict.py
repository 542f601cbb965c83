"""Verdicts of simulated calibrations against the truth: PASS with a seam outside, FAIL with all seams inside."""

import sys

import numpy as np
from rich.table import Table

from tests.benchmarks.verdict_study import VerdictStudy, run_verdict_study
from tests.saved_graphs import saved_graph
from wpcal.calibrate import Criterion, TeachingError
from wpcal.core.arrays import FloatArray
from wpcal.seam import detect_seams
from wpcal.taught.features import find_features

PARTS = ("tee", "lap", "saddle", "frame")
COUNTS = (3, 4, 5, 6, 8, 12)
SIGMA_MM = 0.3
TOLERANCE_MM = 0.5
TRIALS = 100
LEAST_SPREAD = 0.1  #: Second to first spread of a random set of points: a person does not touch points on one line.
NOISES = ("gaussian", "bounded", "t3")


def main() -> Table:
    heads = "noise", "criterion", "sigma", "points", "PASS", "UNSURE", "FAIL", "PASS, outside", "FAIL, inside"
    title = f"{TRIALS} calibrations per part, true sigma {SIGMA_MM} mm, tolerance {TOLERANCE_MM} mm, in %"
    table = Table(*heads, "covered", title=title)
    for noise in NOISES:
        for criterion in (Criterion.MINIMAX, Criterion.LEAST_SQUARES):
            for stated in (True, False):
                for n in COUNTS:
                    study = pooled_study(n, noise=noise, criterion=criterion, stated=stated)
                    table.add_row(noise, criterion.value, "stated" if stated else "not stated", str(n), *_cells(study))
    return table


def pooled_study(
    n: int, *, noise: str, criterion: Criterion, stated: bool, trials: int = TRIALS, parts: tuple[str, ...] = PARTS
) -> VerdictStudy:
    """Simulate calibrations of the sample parts with n random features each."""
    total = None
    for part in parts:
        graph = saved_graph(part)
        features = np.array([feature.p_mm for feature in find_features(graph) if feature.kind.is_point])
        seam_points = np.concatenate([seam.frames.p for seam in detect_seams(graph) if seam.accepted])
        rng = np.random.default_rng(n)
        sets = [spread_set(features, n, rng) for _ in range(trials)]
        teaching = TeachingError()
        if stated:
            bounded = noise == "bounded"
            teaching = TeachingError(bound_mm=SIGMA_MM * 3**0.5) if bounded else TeachingError(sigma_mm=SIGMA_MM)
        study = run_verdict_study(
            sets,
            seam_points,
            errors=[unit_noise(noise, (n, 3), rng) * SIGMA_MM for _ in sets],
            teaching=teaching,
            criterion=criterion,
            tolerance_mm=TOLERANCE_MM,
        )
        total = study if total is None else total + study
    assert total is not None
    return total


def unit_noise(noise: str, shape: tuple[int, int], rng: np.random.Generator) -> FloatArray:
    """Errors with unit standard deviation per axis."""
    if noise == "gaussian":
        return rng.standard_normal(shape)
    if noise == "bounded":
        return rng.uniform(-(3**0.5), 3**0.5, shape)
    return np.asarray(rng.standard_t(3, shape) / 3**0.5)


def spread_set(features: FloatArray, n: int, rng: np.random.Generator) -> FloatArray:
    """Draw n features that are not on one line."""
    while True:
        p = features[rng.choice(len(features), n, replace=False)]
        spread = np.linalg.svd(p - p.mean(axis=0), compute_uv=False)
        if spread[1] > LEAST_SPREAD * spread[0]:
            return np.asarray(p)


def _cells(study: VerdictStudy) -> tuple[str, ...]:
    counts = [study.verdicts[kind] for kind in ("PASS", "UNSURE", "FAIL")]
    shares = [100.0 * count / study.trials for count in (*counts, study.passed_outside, study.failed_inside)]
    return (*(f"{share:.1f}" for share in shares), f"{100.0 * study.covered:.1f}")


if __name__ == "__main__":
    sys.exit()
