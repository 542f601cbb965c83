"""Random searches come down and stay in the box; another way at one seed is a change that CHANGELOG.md tells."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from wpcal.core.errors import InputError
from wpcal.optim import AnnealingSchedule, GeneticOptions, Neighbourhood, TabuOptions, anneal, solve_genetic, solve_tabu
from wpcal.optim.search_box import SearchBox

SAME = 1e-9  #: Logarithms and exponentials of processors differ by less.
LOW, HIGH = np.array([-1.0, -2.0, -3.5]), np.array([1.5, 2.0, 3.0])
SCHEDULE = AnnealingSchedule(
    chains=3, samples=5, cooling=0.7, least_moves=3, most_moves=9, most_acceptances=2, least_temperatures=4,
    most_temperatures=7, tolerance=1e-3, first_step=0.4, least_step=0.03, step_change=0.8, target_acceptance=0.6,
)  # fmt: skip


def waves(states: np.ndarray) -> np.ndarray:
    """Return a cost with many valleys, of sums and products alone: every processor rounds it alike."""
    x, y, z = states.T
    return (x * x - 0.3) ** 2 + (y * y - 1.7) ** 2 + (z - 0.4 * x * y) ** 2 + 0.11 * (z * z - 2.9) ** 2


def genetic(seed: int) -> Any:
    options = GeneticOptions(
        population=9, generations=17, crossover=0.8, mutation_first=0.4, mutation_last=0.1, elite=2
    )
    return solve_genetic(waves, LOW, HIGH, rng=np.random.default_rng(seed), options=options)


def tabu(seed: int) -> Any:
    options = TabuOptions(rings=2, points_per_ring=2, list_size=9, tenure=7, iterations=90)
    return solve_tabu(waves, [0.2, -0.7, 1.9], LOW, HIGH, rng=np.random.default_rng(seed), options=options)


def annealed(seed: int, start: list[float] | None = None, **changes: Any) -> Any:
    box = SearchBox.of(LOW, HIGH, [False, True, False])
    return anneal(waves, box, rng=np.random.default_rng(seed), schedule=replace(SCHEDULE, **changes), start=start)


def linear(seed: int) -> Any:
    changes: dict[str, Any] = {"neighbourhood": Neighbourhood.LINEAR, "step_change": 0.09, "redraw": False, "chains": 7}
    return annealed(seed, [0.4, 1.8, -0.6], **changes)


@pytest.mark.parametrize("run", [genetic, tabu, annealed, linear], ids=lambda run: run.__name__)
def test_a_run_is_the_one_of_the_versions_before(run: Callable[[int], Any], golden: Any) -> None:
    golden(run(1))


LEAST_TABU = {"rings": 1, "points_per_ring": 1, "list_size": 1, "tenure": 1, "iterations": 1}
LEAST = {"population": 4, "generations": 1, "elite": 3, "crossover": 1.0, "mutation_first": 1.0, "mutation_last": 0.0}


def test_the_sizes_are_those_of_the_papers() -> None:
    o, t = GeneticOptions(), TabuOptions()
    assert (o.population, o.generations, o.elite) == (40, 300, 2)
    assert (o.crossover, o.mutation_first, o.mutation_last) == (0.95, 0.2, 0.05)
    assert (t.rings, t.points_per_ring, t.list_size, t.tenure, t.iterations) == (4, 5, 40, 36, 2500)


def test_the_smallest_sizes_run() -> None:
    for start in (LOW, HIGH):
        rng = np.random.default_rng(0)
        assert solve_tabu(waves, start, LOW, HIGH, rng=rng, options=TabuOptions(**LEAST_TABU)).evaluations == 2
        assert solve_genetic(waves, LOW, HIGH, rng=rng, options=GeneticOptions(**LEAST)).evaluations == 5


@pytest.mark.parametrize(
    "call",
    [
        lambda rng: solve_genetic(waves, HIGH, LOW, rng=rng),
        lambda rng: solve_genetic(waves, LOW, [HIGH[0], LOW[1], HIGH[2]], rng=rng),
        lambda rng: solve_genetic(waves, [0, 0], [1, 1, 1], rng=rng),
        lambda rng: solve_tabu(waves, 2 * HIGH, LOW, HIGH, rng=rng),
        *(
            lambda rng, one=one: GeneticOptions(**{**LEAST, **one})
            for one in ({"population": 3}, {"elite": 4}, {"elite": -1}, {"generations": 0}, {"crossover": 1.5})
        ),
        lambda rng: TabuOptions(rings=0),
    ],
)
def test_wrong_bounds_and_sizes_are_refused(call: Callable[[np.random.Generator], Any]) -> None:
    with pytest.raises(InputError):
        call(np.random.default_rng(0))


TARGET = np.array([0.3, -1.1, 2.2])
FOUND = 1e-4  # the radius shrinks with the cost: 400 iterations on a bowl leave about 1e-5
SHORT = TabuOptions(iterations=400)


def bowl(states):
    """Distance to the target in parts of the bounds: not smooth at its least, as sums of distances are not."""
    return np.linalg.norm((states - TARGET) / (HIGH - LOW), axis=1)


def two_bowls(states):
    """A shallow wide bowl at -0.5 and a deep narrow one at +0.5 of the first coordinate."""
    return np.minimum(0.2 + np.abs(states[:, 0] + 0.5), 5.0 * np.abs(states[:, 0] - 0.5)) + np.abs(states[:, 1])


def test_both_come_down_and_stay_within_the_bounds():
    seen = []

    def watched(states):
        seen.append(states)
        return bowl(states)

    genetic = solve_genetic(watched, LOW, HIGH, rng=np.random.default_rng(1))
    tabu = solve_tabu(watched, genetic.state, LOW, HIGH, rng=np.random.default_rng(1), options=SHORT)
    states = np.concatenate(seen)
    assert (states >= LOW).all()
    assert (states <= HIGH).all()
    assert (np.diff(genetic.best_costs) <= 0).all()  # the elite passes on
    assert (np.diff(tabu.best_costs) <= 0).all()
    assert len(states) == genetic.evaluations + tabu.evaluations
    assert genetic.cost == bowl(genetic.state[None])[0] == genetic.best_costs[-1]
    assert tabu.cost == bowl(tabu.state[None])[0] == tabu.best_costs[-1]
    assert genetic.cost < 0.05
    np.testing.assert_allclose(tabu.state, TARGET, rtol=0, atol=FOUND)


def test_the_genetic_algorithm_leaves_a_wide_shallow_bowl():
    found = [solve_genetic(two_bowls, LOW, HIGH, rng=np.random.default_rng(seed)).state[0] for seed in range(10)]
    assert sum(abs(x - 0.5) < 0.05 for x in found) >= 9


def test_tabu_search_accepts_worse_places_and_remembers():
    result = solve_tabu(bowl, np.zeros(3), LOW, HIGH, rng=np.random.default_rng(2), options=SHORT)
    assert (np.diff(result.current_costs) > 0).any()
    assert result.forbidden > 0
    assert (result.current_costs >= result.best_costs).all()


def test_a_start_that_is_the_answer_stays():
    result = solve_tabu(bowl, TARGET, LOW, HIGH, rng=np.random.default_rng(3), options=TabuOptions(iterations=5))
    assert result.cost == 0.0
    assert result.state.tolist() == TARGET.tolist()


def test_selection_alone_lets_the_best_take_over():
    options = GeneticOptions(crossover=0.0, mutation_first=0.0, mutation_last=0.0, elite=0)
    result = solve_genetic(bowl, LOW, HIGH, rng=np.random.default_rng(4), options=options)
    np.testing.assert_allclose(result.mean_costs[-1], result.best_costs[-1], rtol=0, atol=1e-12)  # a mean of equals
    assert result.best_costs[-1] < 0.5 * result.mean_costs[0]
