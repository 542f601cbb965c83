"""Points without names: how long the search takes, how many answers there are, and whether one is wrong."""

from __future__ import annotations

import time

import numpy as np
from rich.table import Table

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.tangent import exp_rotation
from wpcal.taught.match import find_assignments

BOX_MM = np.array([1000.0, 600.0, 300.0])
SIGMA_MM = 0.3
TRIALS = 5


def main() -> Table:
    table = Table(title="Points without names, 1000×600×300 mm, sigma 0.3 mm, five random parts each")
    for heading in ("what", "asked", "slowest", "answers", "the true one has the least residual"):
        table.add_column(heading)
    for features, taught, asked in ((2000, 4, "≤ 2 s"), (20_000, 5, "≤ 20 s"), (20_000, 4, "")):
        seconds, answers, best = zip(*(_trial(features, taught, seed) for seed in range(TRIALS)), strict=True)
        counts = ", ".join(map(str, answers))
        what = f"{taught} of {features} features"
        table.add_row(what, asked, f"{max(seconds):.2f} s", counts, f"{sum(best)} of {TRIALS}")
    return table


def _trial(features: int, taught: int, seed: int) -> tuple[float, int, bool]:
    points, rows, touched = _touched(np.random.default_rng(seed), features, taught)
    start = time.perf_counter()
    found = find_assignments(points, touched, sigma_mm=SIGMA_MM)
    return time.perf_counter() - start, len(found.rows), bool((found.rows[0] == rows).all())


def _touched(rng: np.random.Generator, features: int, taught: int) -> tuple[FloatArray, IntArray, FloatArray]:
    points = rng.uniform(0, 1, (features, 3)) * BOX_MM
    rows = rng.choice(features, taught, replace=False)
    R = exp_rotation(rng.normal(size=3) * 2.0)
    return points, rows, points[rows] @ R.T + [500.0, 100.0, -200.0] + SIGMA_MM * rng.standard_normal((taught, 3))
