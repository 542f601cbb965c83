"""A real-coded genetic algorithm whose pressure, crossover and mutation change with the generation.

References: Xiong, Yang, Wang 2015, §2.1, eq. (8) to (10): the three schedules. The operators themselves are not named
there; taken here are linear ranking with stochastic universal sampling (Baker 1985, 1987), extended intermediate
recombination and the mutation of the breeder genetic algorithm (Mühlenbein and Schlierkamp-Voosen 1993).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError

BatchedCost = Callable[[FloatArray], FloatArray]  #: Costs, shape (m,), of states, shape (m, d).
OVERSHOOT = 0.25
"""Recombination draws a child's coordinate from the stretch between its parents made longer by this part at each end;
the usual value, at which the spread of a population neither grows nor shrinks by recombination alone."""
MUTATION_RANGE = 0.5  #: Largest mutation, as a part of the bounds: from the middle it reaches every place.
MUTATION_BITS = 16
"""A mutation is 2^-u of the largest, u uniform up to this: small steps are as likely in every power of two."""


@dataclass(frozen=True, slots=True)
class GeneticOptions:
    """Size and schedules; the defaults are those of the paper's §3.2."""

    population: int = 40
    generations: int = 300  #: MAXGEN.
    crossover: float = 0.95  #: Pc(0) of eq. (9).
    #: `mutation_first`, `mutation_last`: Pm(0) and Pmin of eq. (10), a coordinate.
    mutation_first: float = 0.2
    mutation_last: float = 0.05
    elite: int = 2  #: Best states that pass on unchanged; ours, the paper does not say.

    def __post_init__(self) -> None:
        if self.population < 4 or not 0 <= self.elite < self.population or self.generations < 1:
            raise InputError("expected a population of at least 4, an elite below it and at least one generation")
        if not all(0.0 <= p <= 1.0 for p in (self.crossover, self.mutation_first, self.mutation_last)):
            raise InputError("crossover and mutation are probabilities between 0 and 1")


@dataclass(frozen=True, slots=True, eq=False)
class GeneticResult:
    """The best state of the last generation and how the population got there."""

    state: FloatArray  #: shape (d,).
    cost: float
    #: `best_costs`, `mean_costs`: shape (generations + 1,). Of each generation, the first one drawn at random.
    best_costs: FloatArray
    mean_costs: FloatArray
    evaluations: int


def solve_genetic(
    cost: BatchedCost,
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    rng: np.random.Generator,
    options: GeneticOptions | None = None,
) -> GeneticResult:
    """Search the box between `lower` and `upper` for the least cost.

    `cost`: Costs (m,) of states (m, d); finite.
    `lower`, `upper`: array_like, shape (d,).
    Raises `InputError` when the bounds are not an upper above a lower one.

    >>> bowl = lambda states: np.sum((states - 0.3) ** 2, axis=1)
    >>> found = solve_genetic(bowl, [-1, -1], [1, 1], rng=np.random.default_rng(1))
    >>> bool(np.allclose(found.state, 0.3, rtol=0, atol=0.01))
    True
    """
    o = options or GeneticOptions()
    low, high = _bounds(lower, upper)
    states = rng.uniform(low, high, (o.population, len(low)))
    costs = cost(states)
    best, mean = [float(costs.min())], [float(costs.mean())]
    for i in range(o.generations):
        order = np.argsort(costs, kind="stable")
        states, costs = states[order], costs[order]
        time = i / o.generations
        parents = states[_select(1.0 + time, o.population, rng)]  # eq. (8): the pressure
        children = _recombine(parents, o.crossover * (1.0 - time) ** 2, rng)  # eq. (9)
        rate = o.mutation_first - (o.mutation_first - o.mutation_last) * time  # eq. (10)
        children = np.clip(_mutate(children, rate, MUTATION_RANGE * (high - low), rng), low, high)
        children = children[o.elite :]
        states = np.concatenate([states[: o.elite], children])
        costs = np.concatenate([costs[: o.elite], cost(children)])
        best.append(float(costs.min()))
        mean.append(float(costs.mean()))
    winner = int(np.argmin(costs))
    evaluations = o.population + o.generations * (o.population - o.elite)
    return GeneticResult(states[winner], float(costs[winner]), np.array(best), np.array(mean), evaluations)


def _bounds(lower: ArrayLike, upper: ArrayLike) -> tuple[FloatArray, FloatArray]:
    low, high = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
    if low.ndim != 1 or low.shape != high.shape or not (low < high).all():
        raise InputError("expected two bounds of one shape (d,), each lower one below its upper one")
    return low, high


def _select(pressure: float, n: int, rng: np.random.Generator) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """Draw n ranks (0 the best): linear ranking, with one turn of a wheel that has n evenly spaced pointers."""
    share = (2.0 - pressure + 2.0 * (pressure - 1.0) * np.arange(n)[::-1] / (n - 1)) / n
    pointers = (np.arange(n) + rng.random()) / n
    chosen = np.minimum(np.searchsorted(np.cumsum(share), pointers), n - 1)
    return np.asarray(rng.permutation(chosen), dtype=np.int64)


def _recombine(parents: FloatArray, probability: float, rng: np.random.Generator) -> FloatArray:
    """Mix each parent with its neighbour, coordinate by coordinate, or pass it on."""
    mates = np.roll(parents, 1, axis=0)
    part = rng.uniform(-OVERSHOOT, 1.0 + OVERSHOOT, parents.shape)
    crossed = rng.random((len(parents), 1)) < probability
    return np.where(crossed, parents + part * (mates - parents), parents)


def _mutate(states: FloatArray, rate: float, largest: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Shift a part `rate` of all coordinates by steps of every size up to `largest`."""
    step = largest * 2.0 ** (-MUTATION_BITS * rng.random(states.shape)) * rng.choice([-1.0, 1.0], states.shape)
    return states + np.where(rng.random(states.shape) < rate, step, 0.0)
