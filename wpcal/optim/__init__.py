"""Solvers that know no geometry: a cost of an array of states goes in, the best state and the way there come out."""

from wpcal.optim.annealing import (
    AnnealingReport,
    AnnealingSchedule,
    AnnealingTrace,
    Neighbourhood,
    StateVariables,
    StopReason,
    anneal,
)
from wpcal.optim.genetic import GeneticOptions, GeneticResult, solve_genetic
from wpcal.optim.tabu import TabuOptions, TabuResult, solve_tabu

__all__ = [
    "AnnealingReport",
    "AnnealingSchedule",
    "AnnealingTrace",
    "GeneticOptions",
    "GeneticResult",
    "Neighbourhood",
    "StateVariables",
    "StopReason",
    "TabuOptions",
    "TabuResult",
    "anneal",
    "solve_genetic",
    "solve_tabu",
]
