"""Help of the options that several fitting commands share."""

from __future__ import annotations

CRITERION_HELP = (
    "What is minimised: the largest distance (the published criterion), the sum of squares, the sum of squares "
    "weighted by the stated errors of the points, or the sum of squares over the points that agree."
)
SOLVER_HELP = (
    "Where the search for minimax begins: at the result of simulated annealing (as published), or at the least-squares "
    "fit (faster). Both are then refined."
)
DETAILS_HELP = "Also print the objective, its lower bound and the gap, and the correction in radians."
