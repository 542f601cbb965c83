"""The saddle of the fixtures and one search for its plans, which all tests of a run read."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tests.kept import kept
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.plan.seam_file import read_seam_path
from wpcal.planning.search.pareto import PlanningResult
from wpcal.planning.search.plan_seam import SWEEP, judge_paths, plan_seam, sweep_paths
from wpcal.planning.search.problem import CandidatePath, PlanningProblem, SearchProgress

CELLS = Path(__file__).parents[1] / "fixtures" / "cells"
CELL, SEAMS = CELLS / "two-mh6.json", CELLS / "saddle-seams.json"
THINNED = 4  #: Every fourth point of the saddle: the shared search takes some seconds.
COARSE, FEW_WEIGHTS = 8, SWEEP[2::5]
"""Every eighth point and three sets of weights, for tests that compare searches: each takes a second."""


class SharedSearch(NamedTuple):
    """All paths of the sweep of the thinned saddle, and the plans that came of them; and a coarse search."""

    swept: list[CandidatePath]
    result: PlanningResult
    coarse: PlanningResult


def saddle_problem(every: int = 1) -> PlanningProblem:
    """Return the planning problem of the saddle with some of its points."""
    cell = read_cell(CELL)
    path = read_seam_path(SEAMS, "W1", cell)
    return PlanningProblem(cell, path.select(np.arange(0, len(path), every)))


def coarse_search(problem: PlanningProblem) -> PlanningResult:
    """Search with few weights."""
    return plan_seam(problem, weights=FEW_WEIGHTS)


def scan_coarsely(monkeypatch: pytest.MonkeyPatch) -> None:
    """Scan few states of every place and sweep few weights: plans, and reasons why there is none, come quickly."""
    monkeypatch.setattr("wpcal.planning.search.reachable_states.TURNS", 4)
    monkeypatch.setattr("wpcal.planning.search.reachable_states.ROTATIONS_RAD", (0.0,))

    def sweep(problem: PlanningProblem, progress: SearchProgress, _: object) -> Iterator[CandidatePath]:
        return sweep_paths(problem, progress, FEW_WEIGHTS)

    monkeypatch.setattr("wpcal.planning.search.plan_seam.sweep_paths", sweep)


def shared_search() -> SharedSearch:
    """Return the searches that all tests share."""
    return SharedSearch(*kept("searches of the saddle", _searches))


def _searches() -> tuple[list[CandidatePath], PlanningResult, PlanningResult]:
    problem = saddle_problem(THINNED)
    swept = list(sweep_paths(problem, lambda what, done, of: None))
    return swept, judge_paths(problem, swept), coarse_search(saddle_problem(COARSE))


def changed(cell, *, arm2=None, T_world_base2=None, links2=None, **more):
    """The cell with changes, of robot 2 too."""
    given = {"arm": arm2, "T_world_base": T_world_base2, "links": links2}
    carrier = replace(cell.carrier, **{name: value for name, value in given.items() if value is not None})
    return replace(cell, carrier=carrier, **more)
