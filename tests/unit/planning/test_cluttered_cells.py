"""Random pairs of states in three cluttered cells, judged by another kinematics and by the meshes themselves."""

import itertools

import numpy as np
import pytest

from tests.cluttered_cells import CELLS, ROBOTS, built, free_pairs
from wpcal.core.errors import GeometryError
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.sequence.air_path import AirPlanner
from wpcal.planning.sequence.motion_check import MotionChecker

pytest.importorskip("fcl", reason="python-fcl is not installed")
pytestmark = [
    pytest.mark.deep,
    pytest.mark.skipif(not ROBOTS.is_dir(), reason="the folder of URDF files lies beside the checkout and is not here"),
]
PAIRS, MOST_FAILED = 70, 1
"""Per cell: 210 pairs in all, of which 99 % must be joined."""
MOST_STATES = 12_000
"""States that the planner measures for a pair, at most once in a hundred more: 1.5 s at 0.12 ms each."""
FINER = 10  #: States between two that the planner measured.
SAME_MM = 1e-9


@pytest.mark.parametrize("name", sorted(CELLS))
def test_nearly_all_pairs_are_joined_and_no_mesh_meets_another(name, tmp_path, monkeypatch):
    from tests.real_cells import RealCell

    clutter = CELLS[name]()
    cell, clearance = built(clutter, tmp_path)
    pairs = free_pairs(clutter, cell, clearance, PAIRS, seed=1)
    real = RealCell(tmp_path / "cell.json", clutter.urdfs, clearance.part.corners)
    planner = AirPlanner(cell, MotionChecker(cell, clearance))
    measured, measure = [], CellClearance.margins
    monkeypatch.setattr(CellClearance, "margins", lambda own, q: measured.append(len(q)) or measure(own, q))
    low, high = cell.limits
    failed, slow, hits = 0, 0, []
    for start, end in pairs:
        tool = real.places(start)["tool"]
        np.testing.assert_allclose(tool, cell.tool_places(start[None])[0], rtol=0, atol=SAME_MM)
        measured.clear()
        try:
            found = planner.path(start, end)
        except GeometryError:
            failed += 1
            continue
        slow += sum(measured) > MOST_STATES
        states = found.check.states
        assert ((states >= low - 1e-12) & (states <= high + 1e-12)).all()  # rad; between two states at a limit
        shares = np.arange(FINER) / FINER
        hits += [
            hit
            for a, b in itertools.pairwise(states)
            for share in shares
            if (hit := real.collision(a + share * (b - a)))
        ]
    print(f"{name}: {PAIRS - failed} of {PAIRS} pairs joined, {slow} with more than {MOST_STATES} states")
    assert hits == []
    assert failed <= MOST_FAILED
    assert slow <= MOST_FAILED
