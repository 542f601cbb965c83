"""Weighted least squares on whole paths: all points move at once, with exact derivatives through both inverses.

The weighted sum of the squared objectives is minimised over the nine coordinates of every point. Only neighbouring
points share a residual (the joint steps), so the normal equations are banded and one step of Levenberg-Marquardt costs
about as much as the inverse kinematics of the path. Limits and clearance enter as squares of the excess over
them. Which limits count is decided again in every step, by the state after it. The loop is `wpcal.optim.banded`.
"""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.optim.banded import descend
from wpcal.planning.cell.closed_chain import joints_along
from wpcal.planning.search.linear_model import linearise
from wpcal.planning.search.objectives import Weights
from wpcal.planning.search.problem import CandidatePath, PlanningProblem

STIFFNESSES = (1.0, 10.0, 100.0)
"""Of limits, one after the other. Stiff limits make short steps. They are needed only where a limit opposes a heavy
objective, for example where the target weld position is not clear."""


def refine_within_limits(problem: PlanningProblem, path: CandidatePath, weights: Weights) -> CandidatePath:
    """Refine a path with stiffer and stiffer limits until it keeps them, or the stiffest do not help."""
    for stiffness in STIFFNESSES:
        path = refine_path(problem, path, weights, stiffness=stiffness)
        if problem.is_allowed(path):
            break
    return path


def refine_path(
    problem: PlanningProblem, path: CandidatePath, weights: Weights, *, stiffness: float = 1.0, iterations: int = 80
) -> CandidatePath:
    """Minimise the weighted sum of squared objectives, starting from a path. Never with a larger sum than the start."""
    return descend(
        path,
        lambda at: linearise(problem, at, weights, stiffness=stiffness),
        lambda at, step: _moved(problem, at, step),
        iterations=iterations,
    )


def _moved(problem: PlanningProblem, path: CandidatePath, step: FloatArray) -> CandidatePath | None:
    """Return the path after a step, clipped to the ranges; None where it leaves the reach."""
    coordinates = np.clip(path.coordinates + step, *problem.box)
    joints = joints_along(problem.cell, problem.path, coordinates, path.branches, path.joints[0])
    return CandidatePath(coordinates, path.branches, joints) if np.isfinite(joints).all() else None
