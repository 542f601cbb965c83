"""Point pairs that others published or measured: the figures printed for them, and those any right fit must give."""

import csv
from pathlib import Path

import numpy as np
import pytest

from wpcal.calibrate import fit_least_squares, solve_minimax
from wpcal.core.arrays import FloatArray
from wpcal.core.pairs import PointPairs, Residuals

SHARED = Path(__file__).parents[3] / "shared" / "registration"
LAST_DIGIT = 0.5e-3  #: Figures of SOURCES.md have three decimals.
PRINTED_SCALE = 0.5e-10  #: The scale is printed with ten decimals.
CERTIFIED_MM = 1e-6


def pairs_of(name: str, first: int) -> PointPairs:
    """Read six columns from column `first`: three coordinates in one frame, three in the other."""
    path = SHARED / name
    if not path.is_file():
        pytest.skip("the folder ../shared/registration with published point pairs is not here")
    lines = (line for line in path.read_text().splitlines() if not line.startswith("#"))
    cells = list(csv.reader(lines))
    values = np.array([row[first : first + 6] for row in cells], dtype=float)
    return PointPairs(tuple(f"P{i}" for i in range(1, len(cells) + 1)), values[:, :3], values[:, 3:])


def similarity(pairs: PointPairs) -> tuple[float, float]:
    """Scale and RMS of the similarity fit: its rotation is that of the rigid fit (Umeyama 1991)."""
    R = fit_least_squares(pairs).R
    p = pairs.p_source - pairs.p_source.mean(axis=0)
    q = pairs.p_target - pairs.p_target.mean(axis=0)
    scale = float(np.sum(q * (p @ R.T)) / np.sum(p * p))
    left: FloatArray = q - scale * p @ R.T
    return scale, float(np.sqrt(np.mean(np.sum(left**2, axis=1))))


def test_grafarend_awange_2003() -> None:
    pairs = pairs_of("grafarend_awange_7pts.csv", 1)
    scale, rms = similarity(pairs)
    assert scale == pytest.approx(1.0000055825, rel=0, abs=PRINTED_SCALE)  # printed in the paper
    assert rms == pytest.approx(0.109, rel=0, abs=LAST_DIGIT)
    assert Residuals.of(pairs, fit_least_squares(pairs)).rms_mm == pytest.approx(0.183, rel=0, abs=LAST_DIGIT)


def test_measured_points_of_a_coordinate_measuring_machine() -> None:
    pairs = pairs_of("cmm_nominal_measured_4pts.csv", 0)
    fit = Residuals.of(pairs, fit_least_squares(pairs))
    assert fit.rms_mm == pytest.approx(0.134, rel=0, abs=LAST_DIGIT)
    assert fit.largest_mm == pytest.approx(0.200, rel=0, abs=LAST_DIGIT)
    best = solve_minimax(pairs)
    assert best.lower_bound_mm <= best.objective_mm < fit.largest_mm
    assert best.gap_mm < CERTIFIED_MM
