"""The genetic algorithm must gain on the deterministic front, and find allowed plans without it."""

import numpy as np
import pytest

from tests.saddle import saddle_problem
from wpcal.planning.search.nsga2 import Nsga2Options, evolve_paths
from wpcal.planning.search.pareto import hypervolume
from wpcal.planning.search.plan_seam import best_paths, sweep_paths

pytestmark = pytest.mark.many

GENERATIONS = 100
SEEDS = 5


def silent(what, done, of):
    """Show nothing."""


@pytest.fixture(scope="module")
def problem():
    return saddle_problem()


@pytest.fixture(scope="module")
def front(problem):
    return best_paths(problem, list(sweep_paths(problem, silent)))


def values_of(problem, paths):
    return np.array([problem.objectives(path.coordinates, path.joints) for path in paths])


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(SEEDS))
def test_seeded_it_enlarges_the_hypervolume(problem, front, seed):
    before = values_of(problem, front)
    reference = 1.5 * before.max(axis=0)
    paths, _ = evolve_paths(problem, front, Nsga2Options(generations=GENERATIONS, seed=seed), silent)
    both = np.concatenate([before, values_of(problem, best_paths(problem, paths))])
    assert hypervolume(both, reference) > 1.01 * hypervolume(before, reference)


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(SEEDS))
def test_unseeded_it_finds_allowed_plans(problem, seed):
    options = Nsga2Options(generations=GENERATIONS, seed=seed, seeded=False)
    paths, _ = evolve_paths(problem, (), options, silent)
    assert len(best_paths(problem, paths)) >= 1
