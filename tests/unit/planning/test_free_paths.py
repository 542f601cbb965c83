"""Verdicts on paths agree with bounded least squares, pair by pair, in both directions."""

from dataclasses import replace

import numpy as np
import pytest

from wpcal.planning.cell.shape import Shape
from wpcal.planning.plan.plan import CollisionVerdict
from wpcal.planning.plan.recheck import check_path

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
