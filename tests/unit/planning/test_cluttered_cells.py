"""Random pairs of states in three cluttered cells, judged by another kinematics and by the meshes themselves."""

import itertools

import numpy as np
import pytest

from tests.cluttered_cells import CELLS, ROBOTS, built, free_pairs
from wpcal.core.errors import GeometryError
from wpcal.planning.sequence.air_path import AirPlanner
from wpcal.planning.sequence.motion_check import MotionChecker

pytest.importorskip("fcl", reason="python-fcl is not installed")
pytest.importorskip("ompl", reason="ompl is not installed")
pytestmark = [
    pytest.mark.deep,
    pytest.mark.skipif(not ROBOTS.is_dir(), reason="the folder of URDF files lies beside the checkout and is not here"),
]
PAIRS, MOST_FAILED = 70, 1
"""Per cell: 210 pairs in all. One of the positioner's has not been joined by anything yet."""
FINER, LOOKED_AT = 10, 10
"""States between two that the planner measured; and every so many pairs are looked at this finely."""
SAME_MM = 1e-9


@pytest.mark.parametrize("name", sorted(CELLS))
def test_nearly_all_pairs_are_joined_and_no_mesh_meets_another(name, tmp_path):
    from tests.real_cells import RealCell

    clutter = CELLS[name]()
    cell, clearance = built(clutter, tmp_path)
    real = RealCell(tmp_path / "cell.json", clutter.urdfs, clearance.part.corners)
    planner = AirPlanner(cell, MotionChecker(cell, clearance))
    failed = 0
    for row, (start, end) in enumerate(free_pairs(clutter, cell, clearance, PAIRS, seed=1)):
        tool = real.places(start)["tool"]
        np.testing.assert_allclose(tool, cell.tool_places(start[None])[0], rtol=0, atol=SAME_MM)
        try:
            found = planner.path(start, end)
        except GeometryError:
            failed += 1
            continue
        states = found.check.states
        count = FINER if row % LOOKED_AT == 0 else 1
        shares = np.arange(count) / count
        for a, b in itertools.pairwise(states):
            assert not [hit for share in shares if (hit := real.collision(a + share * (b - a)))]
    assert failed <= MOST_FAILED
