"""Segment distances against a bounded least squares and dense sampling, also of whole paths, in both directions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from wpcal.planning.cell.segments import Segments, segment_distances
from wpcal.planning.cell.shape import Shape
from wpcal.planning.plan.plan import CollisionVerdict
from wpcal.planning.plan.recheck import check_path

ROUND_OFF_MM = 1e-9  #: Coordinates of up to 1e3 mm: five orders of float64's own round-off.
SOLVER_MM = 1e-6  #: What the bounded least squares states as its own tolerance, times the coordinates.
TOUCHING_MM = 1e-5  #: Parallel and touching: the square root of the round-off of a squared length of 1e6 mm².


def segments(start, end):
    p, end = np.asarray(start, dtype=float).T, np.asarray(end, dtype=float).T
    return Segments(p, end - p)


def random_pairs(rng, n):
    ends = rng.uniform(-500, 500, (4, n, 3))
    return segments(ends[0], ends[1]), segments(ends[2], ends[3])


def least_squares_distance(first, second, i):
    A = np.stack([first.u[:, i], -second.u[:, i]], axis=1)
    answer = lsq_linear(A, second.p[:, i] - first.p[:, i], bounds=(0, 1), method="bvls", tol=1e-14)
    return np.sqrt(2 * answer.cost)


def test_bounded_least_squares_finds_the_same_distance():
    first, second = random_pairs(np.random.default_rng(0), 300)
    expected = [least_squares_distance(first, second, i) for i in range(300)]
    np.testing.assert_allclose(segment_distances(first, second), expected, rtol=0, atol=SOLVER_MM)


@pytest.mark.parametrize("lean", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3])
def test_nearly_parallel_segments(lean):
    rng = np.random.default_rng(2)
    first, _ = random_pairs(rng, 50)
    side = np.cross(first.u.T, rng.normal(size=(50, 3))).T
    u = first.u + lean * side
    second = Segments(first.p + 0.25 * first.u + 20 * side / np.linalg.norm(side, axis=0), 0.5 * u)
    expected = [least_squares_distance(first, second, i) for i in range(50)]
    np.testing.assert_allclose(segment_distances(first, second), expected, rtol=0, atol=SOLVER_MM)
    on = Segments(first.p + 0.25 * first.u, 0.5 * u)
    np.testing.assert_allclose(segment_distances(first, on), np.zeros(50), rtol=0, atol=TOUCHING_MM)


pytest.importorskip("fcl", reason="python-fcl is not installed")
ENGINES_MM = 2e-3
"""What FCL's allowance (1e-4) and the bounded least squares of coordinates of metres leave between both."""
LOOKS = 12  #: States of a path that are judged again: each takes some hundredths of a second.


def cluttered(cell, tip, rng):
    """The cell with a post and a box somewhere near the torch's way."""
    place = tip + rng.uniform(-1, 1, 3) * [260, 260, 160]
    post = Shape("post", [[*place[:2], 0]], [place], [rng.uniform(5, 30)])
    low = tip + rng.uniform(-1, 1, 3) * [320, 320, 260]
    high = low + rng.uniform(30, 120, 3)
    corners = [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    box = Shape("box", [low], [high], [1.0], hull=corners)
    return replace(cell, bench=(*cell.bench, post, box))


@pytest.mark.parametrize("cells", [6, pytest.param(25, marks=pytest.mark.deep)])
def test_the_verdict_is_that_of_another_engine(cell, simple_plan, slow_margins, cells):
    rng = np.random.default_rng(11)
    tip = cell.tool_places(simple_plan.q[:1, :6])[0, :3, 3]
    verdicts = []
    for _ in range(cells):
        around = cluttered(cell, tip, rng)
        found = check_path(simple_plan.q, simple_plan.s_mm, around)
        verdicts.append(found.verdict)
        at = np.append(rng.uniform(0, len(simple_plan) - 1, LOOKS), found.worst / found.refine)
        rows, parts = np.divmod(at, 1.0)
        rows = rows.astype(int)
        after = np.minimum(rows + 1, len(simple_plan) - 1)
        q1, q2 = (q[rows] + parts[:, None] * (q[after] - q[rows]) for q in (simple_plan.q[:, :6], simple_plan.q[:, 6:]))
        judged = [slow_margins(around, one, two, hulls=True)[0].min() for one, two in zip(q1, q2, strict=True)]
        if found.verdict is CollisionVerdict.FREE:
            assert abs(judged[-1] - found.clearance.margin_mm[found.worst]) < ENGINES_MM
            assert min(judged) > -found.motion_mm / 2  # between checked states no body goes farther
        else:
            assert judged[-1] <= ENGINES_MM
    assert {CollisionVerdict.FREE, CollisionVerdict.NOT_FREE} == set(verdicts)
