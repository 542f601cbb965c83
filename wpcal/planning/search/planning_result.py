"""`PlanningResult`: the plans that a search found, and how much each method contributed."""

from __future__ import annotations

from dataclasses import dataclass

from wpcal.core.arrays import FloatArray
from wpcal.planning.search.pareto import ParetoSet, hypervolume
from wpcal.planning.search.problem import PlanningProblem


@dataclass(frozen=True, slots=True, eq=False)
class PlanningResult:
    """What a search found."""

    problem: PlanningProblem
    front: ParetoSet  #: The best plans of all methods. Every plan was checked by hulls between its points.
    #: `ladder`, `genetic`: The front of the deterministic search alone, and of the genetic algorithm alone.
    ladder: ParetoSet | None
    genetic: ParetoSet | None
    reference: FloatArray  #: shape (k,). Corner of the hypervolumes, in the units of the k objectives.
    interrupted: bool  #: Whether the user ended the search early.
    #: Plans that were removed because the check between their points found bodies too near to each other.
    not_free: int

    def hypervolume_of(self, front: ParetoSet | None) -> float:
        """Return the volume that a front dominates; zero for None."""
        return 0.0 if front is None else hypervolume(front.values, self.reference)
