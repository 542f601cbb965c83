"""The same points give the same pose, for every seed, processor, origin and order; least squares resolves ties."""

import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.few import few
from tests.running import run_command
from wpcal.calibrate import anneal_pairs
from wpcal.calibrate.solve.least_squares import distances
from wpcal.calibrate.solve.minimax import solve_minimax
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

FIXTURES = Path(__file__).parents[2] / "fixtures"

SAME_PLACE_MM = 1e-6  # the finest reading of a controller is a thousand times coarser
SAME_VALUE_MM = 1e-9  # a touched limit counts as kept within 1e-12 of the cloud's size
WORTH_OF_ROOM = 1e-3  # share of the sum of squares that the room in the limit is worth; its root counts
FAR_MM = 1e6  # coordinates of this size have a round-off of 1e-10 mm
KERNELS = ("Prescott", "Nehalem", "Sandybridge", "Haswell", "Zen")

BOX = np.array([[x, y, z] for x in (-200, 200) for y in (-150, 150) for z in (0, 100)], dtype=float)


def random_set(rng: np.random.Generator) -> PointPairs:
    return taught(rng, scattered(rng), float(rng.choice([0.05, 0.3, 2.0])))


def planar_set(rng: np.random.Generator) -> PointPairs:
    return taught(rng, scattered(rng) * [1, 1, 0], 0.3)


def symmetric_set(rng: np.random.Generator) -> PointPairs:
    return taught(rng, BOX[rng.permutation(8)[: rng.integers(4, 9)]], 0.3)


def tied_set(rng: np.random.Generator) -> PointPairs:
    """Corners that are all off by the same length: many sets of points carry the optimum."""
    corners = BOX[rng.permutation(8)[: rng.integers(4, 9)]]
    off = corners * 1e-3 if rng.random() < 0.5 else np.sign(corners) * [0.5, -0.5, 0.25]
    return taught(rng, corners, 0.0, off)


def pulled_set(rng: np.random.Generator, noise_mm: float = 0.03) -> PointPairs:
    """Two points off by 1 mm along their line: the part may turn about it."""
    p = scattered(rng)
    along = (p[1] - p[0]) / np.linalg.norm(p[1] - p[0])
    off = np.zeros_like(p)
    off[0], off[1] = -along, along
    return taught(rng, p, noise_mm, off)


def rounded_set(rng: np.random.Generator) -> PointPairs:
    """Coordinates as a controller shows them."""
    pairs = taught(rng, scattered(rng).round(0), 0.3)
    return PointPairs(pairs.names, pairs.p_source, pairs.p_target.round(2))


def scattered(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(0, 1, (int(rng.integers(3, 21)), 3)) * [600, 400, 300]


def taught(rng: np.random.Generator, p: np.ndarray, noise_mm: float, off: np.ndarray | float = 0.0) -> PointPairs:
    turn, shift = exp_rotation(rng.normal(0, 1.5, 3)), rng.uniform(-1000, 1000, 3)
    q = (p + off + noise_mm * rng.normal(size=p.shape)) @ turn.T + shift
    return PointPairs(tuple(f"P{i}" for i in range(len(p))), p, q)


KINDS = {make.__name__: make for make in (random_set, planar_set, tied_set, rounded_set, symmetric_set, pulled_set)}


def tee() -> PointPairs:
    record = json.loads((FIXTURES / "tee" / "golden" / "calibration.json").read_text(encoding="utf-8"))
    rows = [row for row in record["points"] if row["use"] == "yes"]
    return PointPairs(
        tuple(row["name"] for row in rows), [row["p_part_mm"] for row in rows], [row["p_base_mm"] for row in rows]
    )


def all_sets(per_kind: int) -> list[PointPairs]:
    return [tee(), *(make(np.random.default_rng(k)) for make in KINDS.values() for k in range(per_kind))]


def annealed(pairs: PointPairs, seed: int) -> np.ndarray:
    """The points moved by the fit that starts where the annealer ended."""
    return solve_minimax(pairs, start=anneal_pairs(pairs, seed=seed)[0]).T.apply(pairs.p_source)


def test_the_tee_has_one_pose_for_every_seed_and_it_is_that_of_least_squares() -> None:
    pairs = tee()
    places = [annealed(pairs, seed) for seed in range(7)]
    for place in places[1:]:
        np.testing.assert_allclose(place, places[0], rtol=0, atol=SAME_PLACE_MM)
    root_mean_square = np.sqrt(np.mean(np.sum((pairs.p_target - places[0]) ** 2, axis=1)))
    assert root_mean_square == pytest.approx(0.116903, rel=0, abs=5e-7)  # found by an independent solver


@pytest.mark.parametrize("make", few(KINDS.values(), 2), ids=KINDS)
def test_the_seed_does_not_change_the_pose(make: Callable[[np.random.Generator], PointPairs]) -> None:
    for k in range(8):
        pairs = make(np.random.default_rng(k))
        base = solve_minimax(pairs).T.apply(pairs.p_source)
        for seed in range(3):
            np.testing.assert_allclose(annealed(pairs, seed), base, rtol=0, atol=SAME_PLACE_MM, err_msg=f"set {k}")


@pytest.mark.parametrize("make", few(KINDS.values(), 2), ids=KINDS)
def test_the_order_of_the_points_does_not_change_the_pose(make: Callable[[np.random.Generator], PointPairs]) -> None:
    for k in range(30):
        rng = np.random.default_rng(k)
        pairs = make(rng)
        base = solve_minimax(pairs).T.apply(pairs.p_source)
        for _ in range(2):
            place = solve_minimax(pairs.select(rng.permutation(len(pairs)))).T.apply(pairs.p_source)
            np.testing.assert_allclose(place, base, rtol=0, atol=SAME_PLACE_MM, err_msg=f"set {k}")


@pytest.mark.parametrize("make", few(KINDS.values(), 2), ids=KINDS)
def test_far_origins_do_not_change_the_pose(make: Callable[[np.random.Generator], PointPairs]) -> None:
    for k in range(20):
        pairs = make(np.random.default_rng(k))
        base = solve_minimax(pairs).T.apply(pairs.p_source)
        for a, b in ((FAR_MM, 0.0), (0.0, FAR_MM), (FAR_MM, -FAR_MM)):
            at_source, at_target = np.array([a, a / 3, -a]), np.array([b, -b, b / 7])
            far = PointPairs(pairs.names, pairs.p_source + at_source, pairs.p_target + at_target)
            place = solve_minimax(far).T.apply(far.p_source) - at_target
            np.testing.assert_allclose(place, base, rtol=0, atol=SAME_PLACE_MM, err_msg=f"set {k}, {a}, {b}")


@pytest.mark.many
@pytest.mark.parametrize("sets", few([range(1), range(1, 6)], 1))
@pytest.mark.parametrize("make", few(KINDS.values(), 2), ids=KINDS)
def test_no_other_optimum_has_a_smaller_sum_of_squares(
    make: Callable[[np.random.Generator], PointPairs], sets: range
) -> None:
    """SLSQP, a method that shares nothing with ours, looks for one from places around the answer."""
    for k in sets:
        rng = np.random.default_rng(k)
        pairs = make(rng)
        p, q = pairs.p_source - pairs.p_source.mean(axis=0), pairs.p_target
        found = solve_minimax(pairs)
        R, t = found.T.R, found.T.apply(pairs.p_source.mean(axis=0))
        limit = (found.objective_mm + SAME_VALUE_MM) ** 2

        def squares(x: np.ndarray, p=p, q=q, R=R, t=t) -> np.ndarray:
            return distances(p, q, exp_rotation(x[:3] / 300.0) @ R, t + x[3:]) ** 2

        best = squares(np.zeros(6)).sum()
        for _ in range(4):
            other = minimize(
                lambda x, f=squares: f(x).sum(),
                rng.normal(0, found.objective_mm, 6),
                method="SLSQP",
                constraints={"type": "ineq", "fun": lambda x, f=squares, limit=limit: limit - f(x)},
                options={"ftol": 1e-14, "maxiter": 300},
            )
            if squares(other.x).max() <= limit + SAME_VALUE_MM:
                assert squares(other.x).sum() >= best * (1.0 - WORTH_OF_ROOM), f"set {k}"


@pytest.mark.deep
@pytest.mark.many
def test_every_processor_gives_the_same_pose() -> None:
    """OpenBLAS picks its kernels by processor; a variable makes it pick those of another one."""
    code = (
        "import json; from tests.laws.test_same_pose import all_sets, annealed\n"
        "print(json.dumps([annealed(pairs, 0).tolist() for pairs in all_sets(3)]))"
    )
    base = [annealed(pairs, 1) for pairs in all_sets(3)]
    for kernel in KERNELS:
        done = run_command(sys.executable, "-c", code, cwd=FIXTURES.parent, OPENBLAS_CORETYPE=kernel)
        for i, (place, kept) in enumerate(zip(json.loads(done.stdout), base, strict=True)):
            np.testing.assert_allclose(place, kept, rtol=0, atol=SAME_PLACE_MM, err_msg=f"set {i}, {kernel}")


FLAT_PLACE_MM = 1e-5  # the solver stops at a gap of 1e-13; across a flat optimum that is a few 1e-6 mm

CORNERS = np.array([[0, 0, 0], [200, 0, 0], [200, 120, 0], [0, 120, 0], [90, 60, 80]], dtype=float)


def pulled_apart(rng: np.random.Generator) -> PointPairs:
    """Two points off by 1 mm along their line, the others by a tenth: the part may turn about that line."""
    q = CORNERS + rng.uniform(-0.1, 0.1, CORNERS.shape)
    along = (CORNERS[2] - CORNERS[0]) / np.linalg.norm(CORNERS[2] - CORNERS[0])
    q[0], q[2] = CORNERS[0] - along, CORNERS[2] + along
    return PointPairs(tuple("abcde"), CORNERS, q)


@pytest.mark.parametrize("seed", range(6))
def test_the_answer_does_not_depend_on_the_start(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pairs = pulled_apart(rng)
    base = solve_minimax(pairs)
    assert base.certified
    assert np.count_nonzero(base.weights > 1e-3) == 2
    for _ in range(4):
        off = RigidTransform(exp_rotation(rng.normal(0, 0.2, 3)), rng.normal(0, 20, 3), "base", "part")
        other = solve_minimax(pairs, start=off)
        assert other.objective_mm == pytest.approx(base.objective_mm, rel=0, abs=SAME_VALUE_MM)
        np.testing.assert_allclose(other.T.apply(CORNERS), base.T.apply(CORNERS), rtol=0, atol=FLAT_PLACE_MM)


def test_a_point_that_would_be_further_off_holds_the_turn() -> None:
    pairs = pulled_apart(np.random.default_rng(3))
    q = np.array(pairs.p_target)
    q[4] += [0.0, 0.0, 3.0]  # least squares would turn for it until another point is further off than the pair
    found = solve_minimax(PointPairs(pairs.names, CORNERS, q))
    assert found.certified
    assert found.objective_mm == pytest.approx(found.lower_bound_mm, rel=0, abs=SAME_VALUE_MM)


@pytest.mark.parametrize("seed", few(range(8), 1))
def test_a_place_that_was_taught_twice_leaves_every_turn_to_least_squares(seed: int) -> None:
    """Where the two lie farthest apart, half their distance is the optimum whatever the part is turned by."""
    rng = np.random.default_rng(seed)
    p = np.array([[-53.25, 0, 37.5], [-182.25, 0, -12.5], [117.75, 0, -12.5], [117.75, 0, -12.5]])
    q = p + rng.uniform(-0.1, 0.1, p.shape)
    q[2, 0], q[3, 0] = p[2, 0] + 0.3, p[3, 0] - 0.3
    pairs = PointPairs(tuple("abcd"), p, q)
    base = solve_minimax(pairs)
    assert base.objective_mm == pytest.approx(np.linalg.norm(q[2] - q[3]) / 2, rel=0, abs=SAME_VALUE_MM)
    off = np.linalg.norm(q - base.T.apply(p), axis=1)
    assert off[:2].max() < base.objective_mm
    for _ in range(3):
        start = RigidTransform(exp_rotation(rng.normal(0, 0.05, 3)), rng.normal(0, 20, 3), "base", "part")
        place = solve_minimax(pairs, start=start).T.apply(p)
        np.testing.assert_allclose(place, base.T.apply(p), rtol=0, atol=FLAT_PLACE_MM)
