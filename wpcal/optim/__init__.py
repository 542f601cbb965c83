"""Solvers that know no geometry: a cost of an array of states goes in, the best state and the way there come out."""

from wpcal.optim.annealing import (
    AnnealingReport,
    AnnealingSchedule,
    AnnealingTrace,
    Neighbourhood,
    StopReason,
    anneal,
)

__all__ = ["AnnealingReport", "AnnealingSchedule", "AnnealingTrace", "Neighbourhood", "StopReason", "anneal"]
