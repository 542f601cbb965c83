"""Pairs of symmetric parts, and pairs that others published: one of several equal fits, and printed figures."""

import csv
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from tests.few import few
from wpcal.calibrate import Criterion, VerdictKind, calibrate, fit_least_squares, solve_minimax
from wpcal.calibrate.solve.least_squares import distances
from wpcal.core.arrays import FloatArray
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

SAME_PLACE_MM = 1e-6  # the finest reading of a controller is a thousand times coarser
FAR_MM = 1e6  # coordinates of this size have a round-off of 1e-10 mm
# Round-off of 1e-10 mm in the coordinates moves the lowest place of a valley that is flat within 1e-11 mm.
FLAT_VALLEYS_MM = {("cross", "mixed"): 1e-4}


def ring(n: int, z: float = 0.0) -> np.ndarray:
    angle = 2.0 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(angle), np.sin(angle), np.full(n, z)])


CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
GOLDEN = (1.0 + 5.0**0.5) / 2.0
PARTS = {
    "square": ring(4),
    "rectangle": ring(4) * [2.0, 1.0, 1.0],
    "hexagon": ring(6),
    "prism": np.vstack([ring(6, -0.7), ring(6, 0.7)]),
    "tetrahedron": CUBE[[0, 3, 5, 6]],
    "cube": CUBE,
    "octahedron": np.vstack([np.eye(3), -np.eye(3)]),
    "icosahedron": np.array(
        [np.roll([0.0, a, b * GOLDEN], k) for k in range(3) for a in (-1, 1) for b in (-1, 1)], dtype=float
    ),
    "box": CUBE * [3.0, 2.0, 1.0],
    "grid": np.array([[x, y, 0.0] for x in range(3) for y in range(3)]),
    "cross": np.vstack([ring(4), np.zeros((1, 3))]),
}


def taught(part: str, slip: str, noise_mm: float) -> PointPairs:
    rng = np.random.default_rng(sum(map(ord, part + slip)))
    p = 150.0 * PARTS[part]
    q = p.copy()
    if slip == "exchanged":
        two = rng.permutation(len(p))[:2]
        q[two] = q[two[::-1]]
    elif slip == "shifted":
        q = np.roll(q, 1, axis=0)
    elif slip == "mixed":
        q = q[rng.permutation(len(q))]
    elif slip == "mirrored":
        q = q * [1.0, -1.0, 1.0]
    q = (q + noise_mm * rng.normal(size=p.shape)) @ exp_rotation(rng.normal(size=3)).T + rng.uniform(-500, 500, 3)
    return PointPairs(tuple(f"P{i}" for i in range(len(p))), p, q)


def variants(pairs: PointPairs) -> list[tuple[PointPairs, RigidTransform | None, np.ndarray]]:
    """The same problem in another order, far from both origins, and from another start."""
    rng = np.random.default_rng(1)
    far = np.array([FAR_MM, FAR_MM / 3, -FAR_MM])
    R = exp_rotation(rng.normal(size=3))
    start = RigidTransform(R, pairs.p_target.mean(axis=0) - R @ pairs.p_source.mean(axis=0), "base", "part")
    mixed = pairs.select(rng.permutation(len(pairs)))
    return [
        (PointPairs(mixed.names, mixed.p_source + far, mixed.p_target), None, np.zeros(3)),
        (PointPairs(pairs.names, pairs.p_source, pairs.p_target - far), None, -far),
        (pairs, start, np.zeros(3)),
    ]


def assert_same_places(pairs: PointPairs, fit, within_mm: float = SAME_PLACE_MM) -> None:
    base = fit(pairs, None)
    by_name = dict(zip(pairs.names, base.apply(pairs.p_source), strict=True))
    for other, start, shift in variants(pairs):
        place = fit(other, start).apply(other.p_source) - shift
        expected = np.array([by_name[name] for name in other.names])
        np.testing.assert_allclose(place, expected, rtol=0, atol=within_mm)


@pytest.mark.parametrize("slip", few(["exchanged", "mirrored", "shifted", "none", "mixed"], 2))
@pytest.mark.parametrize("part", few(sorted(PARTS, key=lambda part: len(PARTS[part])), 3))
def test_a_symmetric_part_has_one_answer(part: str, slip: str) -> None:
    pairs = taught(part, slip, 0.0)
    within_mm = FLAT_VALLEYS_MM.get((part, slip), SAME_PLACE_MM)
    assert_same_places(pairs, lambda some, start: solve_minimax(some, start=start).T, within_mm)
    assert_same_places(pairs, lambda some, start: fit_least_squares(some))


@pytest.mark.parametrize("slip", few(["exchanged", "mirrored"], 2))
@pytest.mark.parametrize("part", few(["square", "tetrahedron", "hexagon", "box"], 2))
def test_a_noisy_symmetric_part_has_one_answer(part: str, slip: str) -> None:
    assert_same_places(taught(part, slip, 0.3), lambda some, start: solve_minimax(some, start=start).T)


@pytest.mark.parametrize("part", few(["square", "cube", "hexagon", "octahedron"], 2))
def test_the_other_placements_are_as_good(part: str) -> None:
    seen = 0
    for slip in ("exchanged", "shifted", "mixed", "mirrored"):
        pairs = taught(part, slip, 0.0)
        found = solve_minimax(pairs)
        d = distances(pairs.p_source, pairs.p_target, found.T.R, found.T.t_mm)
        for other in found.equal:
            seen += 1
            off = distances(pairs.p_source, pairs.p_target, other.R, other.t_mm)
            assert off.max() == pytest.approx(found.objective_mm, rel=0, abs=SAME_PLACE_MM)
            assert np.sum(off**2) == pytest.approx(np.sum(d**2), rel=1e-9, abs=0)
            assert np.abs(other.R - found.T.R).max() > SAME_PLACE_MM
            assert np.trace(other.R) <= np.trace(found.T.R) + SAME_PLACE_MM  # the one turned least was taken
    assert seen


def test_the_nominal_place_decides_between_equal_placements() -> None:
    pairs = taught("tetrahedron", "mirrored", 0.0)
    first = solve_minimax(pairs)
    assert first.equal
    nominal = RigidTransform(first.equal[0].R, np.zeros(3), "base", "part")
    np.testing.assert_allclose(solve_minimax(pairs, nominal=nominal).T.R, nominal.R, rtol=0, atol=SAME_PLACE_MM)


@pytest.mark.parametrize("criterion", [Criterion.MINIMAX, Criterion.LEAST_SQUARES])
def test_the_result_says_that_another_placement_is_as_good(criterion: Criterion) -> None:
    p = 150.0 * PARTS["tetrahedron"]
    pairs = PointPairs(tuple("abcd"), p, p * [1.0, 1.0, -1.0])
    result = calibrate(pairs, criterion=criterion)
    messages = [issue.message for issue in result.issues if issue.code == "rival-placement"]
    assert len(messages) == 1
    assert "another placement fits the points exactly as well" in messages[0]
    assert result.verdict is not VerdictKind.PASS


def test_an_exact_fit_from_a_far_start_is_found() -> None:
    """A search whose other starts end in the exact fit divided by zero."""
    p = 150.0 * PARTS["square"]
    pairs = PointPairs(tuple("abcd"), p, p)
    for seed in range(12):
        R = exp_rotation(np.random.default_rng(seed).normal(0.0, 2.0, 3))
        found = solve_minimax(pairs, start=RigidTransform(R, np.zeros(3), "base", "part"))
        assert found.objective_mm <= SAME_PLACE_MM


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
