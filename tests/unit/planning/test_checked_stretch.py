"""A stretch that ends where the arm is singular is checked against collision up to there."""

import numpy as np
import pytest

from tests.one_robot_cells import TEE, fixed_cell
from wpcal.planning.cell.cell_clearance import CellClearance, Margins
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import seam_task
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets

pytest.importorskip("fcl", reason="python-fcl is not installed")
BLOCKED = 5  #: The first point in collision.


def test_points_before_a_singular_one_are_checked(monkeypatch):
    given = read_sequence_input(TEE, fixed_cell(), ["W2"])
    cell = given.placed(fixed_cell())
    search = SeamSearch(cell, CellClearance(cell, given.part), SequenceTargets())
    task = seam_task(given.seams[0].seam)
    way = search.whole(task)[0]
    outer, branch = np.zeros((2, 0)), (way.branch, way.q[0, :6])
    assert search.checked(task, way.angles, outer, branch)[1] is None
    monkeypatch.setattr(
        "wpcal.planning.sequence.seam_search.is_regular", lambda _, q: np.arange(len(q)) < len(task) - 2
    )
    assert search.checked(task, way.angles, outer, branch)[1] == len(task) - 2
    measure = CellClearance.margins

    def margins(own, q):
        found = measure(own, q)
        at = np.linalg.norm(q - way.q[BLOCKED], axis=1) < 1e-9
        return Margins(np.where(at, -1.0, found.margin_mm), found.pair, found.by_carriers_mm)

    monkeypatch.setattr(CellClearance, "margins", margins)
    q, bad = search.checked(task, way.angles, outer, branch)
    assert (len(q), bad) == (BLOCKED, BLOCKED)
