"""Simulated annealing of many chains at once, with the cooling rules of Yin, Chen and Lu (2003).

The solver knows no geometry. A cost function maps an array of states, shape (m, d), to costs, shape (m,); every chain
is one row, so that one call of the cost function moves all of them.

References: Yin, Chen, Lu (2003), Transactions of the China Welding Institution 24(2), section 2.3, eq. (6) to (9).
Metropolis et al. (1953), J. Chem. Phys. 21, 1087 (the acceptance rule).
Hukushima, Iba (2003), AIP Conf. Proc. 690, 200 (redrawing a population between temperatures).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.optim.search_box import SearchBox

Cost = Callable[[FloatArray], FloatArray]
LEAST_TEMPERATURE = 1e-300
"""Temperature when all sampled costs are equal: any rise is then refused, and no division by zero occurs."""
DRAWN = 64  #: Moves whose random numbers are drawn at once: enough to hide the call, few enough to waste none of note.


class Neighbourhood(Enum):
    """How the box of new states around a state changes from one temperature to the next."""

    LINEAR = "linear"  #: By a fixed amount, down to a floor: Yin 2003, eq. (7).
    ACCEPTANCE = "acceptance"
    """By a factor, and only while few moves are accepted: a wide box stays as long as it is of use."""


class StateVariables(Enum):
    """Which six variables of a rigid motion make a state. The solver does not read this; the cost's author does."""

    ABOUT_CENTROID = "about_centroid"
    """The rotation about the centroid of the points and the shift of the centroid: a small angle is a small motion."""

    ABOUT_ORIGIN = "about_origin"
    """The six-tuple of Yin 2003: rotation and translation about the origin of the base, from the nominal place."""


class StopReason(Enum):
    """Why a run ended."""

    SETTLED = "settled"
    TEMPERATURES = "temperatures"


@dataclass(frozen=True, slots=True)
class AnnealingSchedule:
    """Everything that steers a run; the defaults are many chains that redraw, `yin2003` is the published method."""

    # Found by trial on the paper's table and five random parts: fewer chains or a faster cooling leave some seeds in a
    # local minimum, slower cooling only takes longer (`python -m tests.benchmarks annealing`).
    chains: int = 128  #: States that move together.
    samples: int = 120  #: Random states that set the first temperature (120 in the paper).
    initial_acceptance: float = 0.95  #: p0 of eq. (8).
    cooling: float = 0.6  #: a in t ← a t.
    #: `least_moves`, `most_moves`: Shortest and longest Markov chain of one temperature (l_u and l_w).
    least_moves: int = 5
    most_moves: int = 5
    #: Accepted moves, per chain, after which a temperature ends early (n_a). Hot chains are therefore short and grow as
    #: it cools.
    most_acceptances: int = 5
    #: `least_temperatures`, `most_temperatures`: Temperatures before the stop rule is asked, and at most.
    least_temperatures: int = 50
    most_temperatures: int = 50
    #: ε: the run has settled when the best cost falls by less between two neighbouring temperatures.
    tolerance: float = 1e-4
    neighbourhood: Neighbourhood = Neighbourhood.ACCEPTANCE  #: Rule for the factor K of the neighbourhood.
    #: `first_step`, `least_step`: K at the start and its floor; the half width of variable i is K times its range R_i.
    first_step: float = 0.5
    least_step: float = 1e-7
    step_change: float = 0.55  #: What K falls by (``LINEAR``) or is multiplied by (``ACCEPTANCE``).
    target_acceptance: float = 0.3  #: ``ACCEPTANCE`` shrinks K while a smaller share of the moves is accepted.
    redraw: bool = True  #: Redraw the chains between temperatures in proportion to exp(-f / t).
    variables: StateVariables = StateVariables.ABOUT_CENTROID  #: What a state of a rigid motion consists of.
    name: str = "custom"  #: What reports call the schedule.

    def __post_init__(self) -> None:
        counts = ("chains", "samples", "least_moves", "most_moves", "most_acceptances", "most_temperatures")
        for name in counts:
            if getattr(self, name) < 1:
                raise InputError(f"annealing schedule: {name} must be at least 1, got {getattr(self, name)}")
        for name in ("initial_acceptance", "cooling"):
            if not 0 < getattr(self, name) < 1:
                raise InputError(f"annealing schedule: {name} lies between 0 and 1, got {getattr(self, name)}")
        if self.least_moves > self.most_moves or self.least_temperatures > self.most_temperatures:
            raise InputError("annealing schedule: a least count is larger than its greatest")
        if not 0 < self.least_step <= self.first_step:
            raise InputError("annealing schedule: expected 0 < least_step <= first_step")

    @classmethod
    def default(cls) -> AnnealingSchedule:
        """Return the default values under the name ``default``."""
        return cls(name="default")

    @classmethod
    def yin2003(cls) -> AnnealingSchedule:
        """Return the published schedule: one chain, and eq. (6) to (9) with the paper's numbers.

        The paper does not print l_u, l_w, n_a, ε and when it first asks to stop. They are ours: 500, 8000 and 4000
        moves, 1e-6 and 60 temperatures, by when K has been at its floor for 10. With them the run comes to rest near
        the value that the paper prints.
        """
        return cls(
            chains=1,
            samples=120,
            initial_acceptance=0.95,
            cooling=0.85,
            least_moves=500,
            most_moves=8000,
            most_acceptances=4000,
            least_temperatures=60,
            most_temperatures=200,
            tolerance=1e-6,
            neighbourhood=Neighbourhood.LINEAR,
            first_step=0.01,  # K0 = 1.0, and q_i = K R_i / 100
            least_step=0.0002,  # K falls while it is above 0.03: 1.00, 0.98, … 0.04, 0.02
            step_change=0.0002,
            redraw=False,
            variables=StateVariables.ABOUT_ORIGIN,
            name="yin2003",
        )


@dataclass(frozen=True, slots=True, eq=False)
class AnnealingTrace:
    """One row a temperature: the paper's figure 2."""

    temperature: FloatArray  #: shape (k,). t, in the unit of the cost.
    cost: FloatArray  #: shape (k,). f at the end of each temperature (mean over the chains).
    best_cost: FloatArray  #: shape (k,). Least cost met so far, f*.
    accepted: FloatArray  #: shape (k,). Share of the moves that were accepted.


@dataclass(frozen=True, slots=True, eq=False)
class AnnealingReport:
    """The best state and how it was found."""

    state: FloatArray  #: shape (d,).
    cost: float
    evaluations: int  #: States whose cost was computed.
    trace: AnnealingTrace
    stop: StopReason

    @property
    def temperatures(self) -> int:
        """Number of temperatures."""
        return len(self.trace.temperature)


def anneal(
    cost: Cost,
    box: SearchBox,
    *,
    rng: np.random.Generator,
    schedule: AnnealingSchedule | None = None,
    start: ArrayLike | None = None,
) -> AnnealingReport:
    """Search a box for the state of least cost.

    `cost`: Maps states, shape (m, d), to costs, shape (m,).
    `box`: R_i of eq. (6) is its width. Periodic variables are brought back into the box between temperatures, so the
    cost must repeat beyond it. The others stop at its wall.
    `start`: array_like, shape (d,), optional. Where all chains start. The samples of eq. (9) are then drawn from its
    first neighbourhood. Without it both are random states of the box.
    """
    run = _Run(cost, box, schedule or AnnealingSchedule(), rng, start)
    stop = StopReason.TEMPERATURES
    for count in range(1, run.schedule.most_temperatures + 1):
        before = run.best_cost
        run.cool_once()
        if count >= run.schedule.least_temperatures and before - run.best_cost < run.schedule.tolerance:
            stop = StopReason.SETTLED
            break
    return AnnealingReport(frozen(run.box.wrapped(run.best)), run.best_cost, run.evaluations, run.trace(), stop)


def first_temperature(costs: FloatArray, initial_acceptance: float) -> float:
    """Temperature t0 at which the rise from the mean to the largest cost is accepted with p0: Yin 2003, eq. (9).

    `costs`: shape (n,). Costs of states sampled in the box.
    """
    return max(float((costs.mean() - costs.max()) / np.log(initial_acceptance)), LEAST_TEMPERATURE)


class _Run:
    """The state of a run between two temperatures."""

    def __init__(
        self, cost: Cost, box: SearchBox, schedule: AnnealingSchedule, rng: np.random.Generator, start: ArrayLike | None
    ) -> None:
        self.cost, self.box, self.schedule, self.rng = cost, box, schedule, rng
        shape = (max(schedule.samples, schedule.chains), len(box.lower))
        if start is None:
            samples = box.lower + box.width * rng.random(shape)
        else:
            first = np.asarray(start, dtype=np.float64)
            near = first + schedule.first_step * box.width * rng.uniform(-1.0, 1.0, shape)
            samples = np.minimum(np.maximum(near, box.walls[0]), box.walls[1])
        costs = cost(samples)
        self.evaluations = len(samples)
        self.temperature = first_temperature(costs[: schedule.samples], schedule.initial_acceptance)
        if start is None:
            self.states, self.costs = samples[: schedule.chains].copy(), costs[: schedule.chains].copy()
        else:
            self.states = np.tile(first, (schedule.chains, 1))
            self.costs = cost(self.states)
            self.evaluations += schedule.chains
        self.best, self.best_cost = self.states[0].copy(), np.inf
        self._note_best()
        self.step, self.walls = schedule.first_step, box.walls
        self.rows: list[tuple[float, float, float, float]] = []

    def cool_once(self) -> None:
        """Run the Markov chains of one temperature, note the trace, and cool."""
        moves, accepted = self._run_chains()
        share = accepted / (moves * self.schedule.chains)
        self.rows.append((self.temperature, float(self.costs.mean()), self.best_cost, share))
        self.temperature *= self.schedule.cooling
        self._change_step(share)
        if self.schedule.redraw:
            self._redraw()

    def _run_chains(self) -> tuple[int, int]:
        s, moves, accepted = self.schedule, 0, 0
        enough = s.most_acceptances * s.chains
        while moves < s.most_moves and not (moves >= s.least_moves and accepted > enough):
            for step, rise in zip(*self._draw(min(s.most_moves - moves, DRAWN)), strict=True):
                accepted += self._move(step, rise)
                moves += 1
                if moves >= s.least_moves and accepted > enough:
                    break
        self.evaluations += moves * s.chains
        self.states = self.box.wrapped(self.states)
        return moves, accepted

    def _draw(self, moves: int) -> tuple[FloatArray, FloatArray]:
        """Steps within the neighbourhood of eq. (6), and the rises of the cost that each of them may bring."""
        steps = self.rng.uniform(-1.0, 1.0, (moves, *self.states.shape))
        steps *= self.step * self.box.width
        # Metropolis: exp(-Δf / t) > u, as Δf < -t log u
        rises = -self.temperature * np.log(1.0 - self.rng.random(steps.shape[:2]))
        return steps, rises

    def _move(self, step: FloatArray, rise: FloatArray) -> int:
        moved = np.minimum(np.maximum(self.states + step, self.walls[0]), self.walls[1])
        costs = self.cost(moved)
        taken = costs - self.costs < rise
        np.copyto(self.states, moved, where=taken[:, None])
        np.copyto(self.costs, costs, where=taken)
        self._note_best()
        return int(np.count_nonzero(taken))

    def _note_best(self) -> None:
        i = int(self.costs.argmin())
        if self.costs[i] < self.best_cost:
            self.best, self.best_cost = self.states[i].copy(), float(self.costs[i])

    def _change_step(self, share: float) -> None:
        s = self.schedule
        if s.neighbourhood is Neighbourhood.LINEAR:
            self.step = max(self.step - s.step_change, s.least_step)
        elif share < s.target_acceptance:
            self.step = max(self.step * s.step_change, s.least_step)

    def _redraw(self) -> None:
        """Draw the chains anew with weights exp(-f / t) by systematic resampling (one random number)."""
        weights = np.exp(-(self.costs - self.costs.min()) / self.temperature)
        edges = np.cumsum(weights)
        places = (np.arange(len(weights)) + self.rng.random()) / len(weights) * edges[-1]
        chosen = np.minimum(np.searchsorted(edges, places), len(weights) - 1)
        self.states, self.costs = self.states[chosen], self.costs[chosen]

    def trace(self) -> AnnealingTrace:
        return AnnealingTrace(*(frozen(column) for column in np.array(self.rows).T))
