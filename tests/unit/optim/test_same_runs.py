"""Random searches go the same way in every version: another state at one seed is a change that CHANGELOG.md tells."""

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


def genetic(seed: int) -> list[Any]:
    options = GeneticOptions(
        population=9, generations=17, crossover=0.8, mutation_first=0.4, mutation_last=0.1, elite=2
    )
    run = solve_genetic(waves, LOW, HIGH, rng=np.random.default_rng(seed), options=options)
    return [*run.state, run.cost, run.best_costs.sum(), run.mean_costs.sum(), run.evaluations]


def tabu(seed: int) -> list[Any]:
    options = TabuOptions(rings=2, points_per_ring=2, list_size=9, tenure=7, iterations=90)
    run = solve_tabu(waves, [0.2, -0.7, 1.9], LOW, HIGH, rng=np.random.default_rng(seed), options=options)
    costs = run.best_costs.sum(), run.current_costs.sum()
    return [*run.state, run.cost, *costs, run.evaluations, run.forbidden, run.aspired]


def annealed(seed: int, start: list[float] | None = None, **changes: Any) -> list[Any]:
    box = SearchBox.of(LOW, HIGH, [False, True, False])
    run = anneal(waves, box, rng=np.random.default_rng(seed), schedule=replace(SCHEDULE, **changes), start=start)
    trace = run.trace
    sums = [each.sum() for each in (trace.temperature, trace.cost, trace.best_cost, trace.accepted)]
    return [*run.state, run.cost, *sums, run.evaluations, run.temperatures]


def linear(seed: int) -> list[Any]:
    return annealed(
        seed, [0.4, 1.8, -0.6], neighbourhood=Neighbourhood.LINEAR, step_change=0.09, redraw=False, chains=7
    )


@pytest.mark.parametrize(
    ("run", "expected"),
    [
        (genetic, [0.159489153305, -1.32290983006, -0.241299833663, 0.990837833723, 18.568806362, 37.504553968, 128]),
        (tabu, [0.674511485105, -1.31838054481, -0.737440909, 0.781865007092, 109.275276639, 109.400242427, 361, 6, 1]),
        (
            annealed,
            [
                -0.753812418556,
                1.17408833161,
                -1.17960271822,
                1.10723918278,
                361.509479572,
                74.9891534403,
                8.58768264667,
                4.44444444444,
                50,
                5,
            ],
        ),
        (
            linear,
            [
                0.193011937468,
                -1.40541236713,
                -1.11542960481,
                1.46025015127,
                3212.07665358,
                87.41873264,
                13.3485143939,
                5.95238095238,
                140,
                6,
            ],
        ),
    ],
)
def test_a_run_is_the_one_of_the_versions_before(run: Callable[[int], list[Any]], expected: list[float]) -> None:
    np.testing.assert_allclose(run(1), expected, rtol=SAME, atol=0)


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
