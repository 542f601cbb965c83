"""The numbers asked of the calibrator, measured in this run."""

from pathlib import Path

import numpy as np
from rich.table import Table

from tests.benchmarks.timing import least_seconds
from tests.coverage_study import run_coverage_study
from wpcal.calibrate import Criterion, calibrate, fit_least_squares, solve_minimax
from wpcal.core import PointPairs
from wpcal.core.tangent import exp_rotation
from wpcal.study import StudyOptions, run_error_study
from wpcal.taught.pairs import read_pairs

TABLE1 = Path(__file__).parents[2] / "fixtures" / "yin2003" / "table1.csv"
OPTIMUM_MM = 0.2198230047896
BOX_MM = np.array([600.0, 400.0, 300.0])


def main() -> Table:
    table = Table("what", "asked", "measured", title="Calibrator")
    for row in (*_table1(), *_random_problems(), *_sizes(), *_study(), *_coverage()):
        table.add_row(*row)
    return table


def random_pairs(rng: np.random.Generator, n: int, noise_mm: float) -> PointPairs:
    p = rng.uniform(0, 1, (n, 3)) * BOX_MM
    R = exp_rotation(rng.normal(size=3) * 2.0)
    q = p @ R.T + rng.uniform(-2000, 2000, 3) + noise_mm * rng.normal(size=(n, 3))
    return PointPairs(tuple(map(str, range(n))), p, q)


def _table1() -> list[tuple[str, str, str]]:
    pairs, _ = read_pairs(TABLE1)
    result = calibrate(pairs)
    seconds = least_seconds(lambda: calibrate(pairs), 10)
    off = abs(result.objective_mm - OPTIMUM_MM)
    return [
        (
            "Table 1, calibrate(): distance from 0.2198230047896",
            "≤ 1e-9 mm",
            f"{off:.1e} mm, gap {result.gap_mm:.1e} mm",
        ),
        ("Table 1, calibrate(): warm time", "≤ 50 ms", f"{1e3 * seconds:.1f} ms"),
    ]


def _random_problems() -> list[tuple[str, str, str]]:
    rng = np.random.default_rng(0)
    gaps = [
        solve_minimax(random_pairs(rng, int(rng.integers(3, 51)), float(rng.uniform(0, 5)))).gap_mm for _ in range(1000)
    ]
    return [("1000 random problems: largest gap", "≤ 1e-6 mm", f"{max(gaps):.1e} mm")]


def _sizes() -> list[tuple[str, str, str]]:
    rng = np.random.default_rng(1)
    rows = []
    for n, asked, repeats in ((4, "≤ 3 ms", 20), (1000, "≤ 50 ms", 20), (1_000_000, "≤ 10 s", 2)):
        pairs = random_pairs(rng, n, 1.0)
        seconds = least_seconds(lambda pairs=pairs: solve_minimax(pairs), repeats)
        rows.append((f"exact minimax, {n} points", asked, f"{1e3 * seconds:.1f} ms"))
    seconds = least_seconds(lambda: fit_least_squares(pairs), 2)
    rows.append(("least squares, 1000000 points", "≤ 1 s", f"{1e3 * seconds:.1f} ms"))
    seconds = least_seconds(lambda: calibrate(pairs, criterion=Criterion.LEAST_SQUARES), 6)
    rows.append(("calibrate() by least squares, 1000000 points", "≤ 1 s", f"{1e3 * seconds:.1f} ms"))
    return rows


def _study() -> list[tuple[str, str, str]]:
    pairs, _ = read_pairs(TABLE1)
    T = fit_least_squares(pairs)
    seconds = least_seconds(lambda: run_error_study(pairs.p_source, T, StudyOptions(trials=10_000)), 2)
    exact = run_error_study(pairs.p_source, T, StudyOptions(trials=100, bound_mm=0.0))
    return [
        ("study, 10000 exact fits of 4 points", "≤ 20 s", f"{seconds:.2f} s"),
        ("study without errors: extreme", "< 0.02 mm, aim 1e-9", f"{exact.errors_mm.max():.1e} mm"),
    ]


def _coverage() -> list[tuple[str, str, str]]:
    rows = []
    for a, b in ((900, 600), (300, 200), (100, 100)):
        triangle = np.array([[0, 0, 0], [a, 0, 0], [0, b, 0.0]])
        for criterion in (Criterion.MINIMAX, Criterion.LEAST_SQUARES):
            s = run_coverage_study(triangle, np.array([1000.0, 0, 0]), sigma_mm=0.3, criterion=criterion)
            sizes = f"median error {np.median(s.errors_mm):.2f}, predicted 95 % {s.predicted_mm:.2f} mm"
            measured = f"{100 * s.coverage:.1f} % ({sizes})"
            rows.append((f"coverage, {a}×{b} triangle, {criterion.value}", "93 to 97 %", measured))
    return rows
