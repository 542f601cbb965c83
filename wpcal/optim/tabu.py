"""Tabu search in a box: the best allowed neighbour is taken even if it is worse; recent places are forbidden.

References: Xiong, Yang, Wang 2015, §2.2: neighbourhoods of k rings of hyper-rectangles whose radius follows the fitness
(eq. 11, 12), a tabu list, aspiration, a limit on iterations. The formulas of eq. (11) and (12) are lost in the text at
hand: how the radius follows the cost, how wide the rings are and what a place on the list forbids are ours, marked
below.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import InputError
from wpcal.optim.genetic import BatchedCost

RING_RATIO = 4.0
"""Ours: each ring is smaller than the next one by this factor, so that four rings span two orders of magnitude and some
neighbour is always of a useful size. Equal widths (ratio towards 1) stall at a tenth of the start's cost."""
FIRST_RADIUS = 0.1  #: Ours, the lost factor of eq. (11): outer radius at the start, as a part of the bounds.


@dataclass(frozen=True, slots=True)
class TabuOptions:
    """Size of the search; the defaults are those of the paper's §3.3."""

    rings: int = 4  #: k of eq. (12).
    points_per_ring: int = 5
    list_size: int = 40  #: Places remembered.
    tenure: int = 36  #: Iterations that a place stays forbidden.
    iterations: int = 2500

    def __post_init__(self) -> None:
        if min(self.rings, self.points_per_ring, self.list_size, self.tenure, self.iterations) < 1:
            raise InputError("every size of a tabu search is at least 1")


@dataclass(frozen=True, slots=True, eq=False)
class TabuResult:
    """The best state met and how the search went."""

    state: FloatArray  #: shape (d,).
    cost: float
    #: `best_costs`, `current_costs`: shape (iterations + 1,). Least cost so far, and cost of the current place.
    best_costs: FloatArray
    current_costs: FloatArray
    evaluations: int
    forbidden: int  #: Neighbours that were passed over because they were tabu.
    aspired: int  #: Tabu neighbours taken all the same, for being better than everything before.


def solve_tabu(
    cost: BatchedCost,
    start: ArrayLike,
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    rng: np.random.Generator,
    options: TabuOptions | None = None,
) -> TabuResult:
    """Search from `start` for the least cost in the box between `lower` and `upper`.

    Raises `InputError` when the start is outside the bounds.

    `cost`: Costs (m,) of states (m, d); finite and not negative, zero at the best conceivable state: the radius shrinks
    in proportion.
    `start`: array_like, shape (d,).
    `lower`, `upper`: array_like, shape (d,).
    """
    o = options or TabuOptions()
    low, high = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
    here = np.array(start, dtype=np.float64)
    if here.ndim != 1 or not (low.shape == high.shape == here.shape and (low <= here).all() and (here <= high).all()):
        raise InputError("the start of a tabu search must lie between its bounds, all of one shape (d,)")
    here_cost = first_cost = best_cost = float(cost(here[None])[0])
    best, width = here, high - low
    best_costs, current_costs = [best_cost], [here_cost]
    tabu: deque[tuple[int, FloatArray, float]] = deque(maxlen=o.list_size)
    forbidden = aspired = 0
    for iteration in range(o.iterations):
        radius = FIRST_RADIUS * here_cost / first_cost if first_cost > 0.0 else 0.0  # eq. (11)
        neighbours = np.clip(here + width * _rings(radius, o, len(here), rng), low, high)
        costs = cost(neighbours)
        while tabu and iteration - tabu[0][0] >= o.tenure:
            tabu.popleft()
        banned = _is_tabu(neighbours / width, tabu)
        better = costs < best_cost  # aspiration
        allowed = np.where(banned & ~better, np.inf, costs)
        forbidden += int((banned & ~better).sum())
        pick = int(np.argmin(allowed))
        if np.isfinite(allowed[pick]):
            aspired += int(banned[pick])
            tabu.append((iteration, here / width, radius * RING_RATIO**-o.rings))
            here, here_cost = neighbours[pick], float(costs[pick])
        if here_cost < best_cost:
            best, best_cost = here, here_cost
        best_costs.append(best_cost)
        current_costs.append(here_cost)
    return TabuResult(
        state=best,
        cost=best_cost,
        best_costs=np.array(best_costs),
        current_costs=np.array(current_costs),
        evaluations=1 + o.iterations * o.rings * o.points_per_ring,
        forbidden=forbidden,
        aspired=aspired,
    )


def _rings(radius: float, o: TabuOptions, d: int, rng: np.random.Generator) -> FloatArray:
    """Random steps, as parts of the bounds, shape (rings · points, d); eq. (12).

    Ring i lies between two hyper-rectangles around the place: its largest coordinate is between
    ``radius · RING_RATIO^-(i+1)`` (0 for the innermost ring) and ``radius · RING_RATIO^-i``.
    """
    outer = radius * RING_RATIO ** -np.arange(o.rings, dtype=np.float64)
    inner = np.append(outer[1:], 0.0)
    direction = rng.uniform(-1.0, 1.0, (o.rings, o.points_per_ring, d))
    direction /= np.abs(direction).max(axis=2, keepdims=True)
    size = rng.uniform(inner[:, None], outer[:, None], (o.rings, o.points_per_ring))
    return (direction * size[:, :, None]).reshape(-1, d)


def _is_tabu(states: FloatArray, tabu: deque[tuple[int, FloatArray, float]]) -> BoolArray:
    """Tell which states lie within a remembered place; ours: its box has the innermost ring's smallest size."""
    if not tabu:
        return np.zeros(len(states), dtype=np.bool_)
    places = np.array([place for _, place, _ in tabu])
    sizes = np.array([size for _, _, size in tabu])
    distance = np.abs(states[:, None] - places).max(axis=2)
    return np.asarray((distance < sizes).any(axis=1))
