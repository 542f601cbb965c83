"""Weighted least squares on whole paths: all points move at once, with exact derivatives through both inverses.

The weighted sum of the squared objectives is minimised over the nine coordinates of every point. Only neighbouring
points share a residual (the joint steps), so the normal equations are banded and one step of Levenberg-Marquardt costs
about as much as the inverse kinematics of the path. Limits and clearance enter as squares of the excess over
them. Which limits count is decided again in every step, by the state after it.

The loop is not the solver of `wpcal.optim.levenberg_marquardt` because of this structure: that solver forms dense
normal matrices (657 rows for 73 points), and it has no set of active limits.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, solveh_banded

from wpcal.core.arrays import FloatArray
from wpcal.planning.cell.closed_chain import joints_along
from wpcal.planning.search.linear_model import LinearModel, linearise
from wpcal.planning.search.objectives import Weights
from wpcal.planning.search.problem import CandidatePath, PlanningProblem

FIRST_DAMPING = 1e-2
"""Of Levenberg-Marquardt, relative to the diagonal."""
LARGEST_DAMPING = 1e6
"""Steps as short as this demands improve nothing any more."""
LEAST_DAMPING = 1e-6
"""Below this the damping has no effect on a step, and would take long to come back."""
STIFFNESSES = (1.0, 10.0, 100.0)
"""Of limits, one after the other. Stiff limits make short steps. They are needed only where a limit opposes a heavy
objective, for example where the target weld position is not clear."""
WINDOW, LEAST_GAIN = 5, 2e-3
"""The loop ends if this many steps together gain less than this part of the sum: an objective then changes by a
thousandth."""
LEAST_CURVATURE = 1e-9
"""Added to the diagonal: a coordinate without influence (the spin of a torch at rest) does not move."""
ACTIVE_ROUNDS = 4
"""Most rounds that look for the limits which count after a step. Two or three are usually enough."""


def refine_within_limits(problem: PlanningProblem, path: CandidatePath, weights: Weights) -> CandidatePath:
    """Refine a path with stiffer and stiffer limits until it keeps them, or the stiffest do not help.

    Parameters
    ----------
    problem : PlanningProblem
    path : CandidatePath
    weights : mapping of Objective to float

    Returns
    -------
    CandidatePath
        As `refine_path` leaves it; it may still break a limit.
    """
    for stiffness in STIFFNESSES:
        path = refine_path(problem, path, weights, stiffness=stiffness)
        if problem.is_allowed(path):
            break
    return path


def refine_path(
    problem: PlanningProblem, path: CandidatePath, weights: Weights, *, stiffness: float = 1.0, iterations: int = 80
) -> CandidatePath:
    """Minimise the weighted sum of squared objectives, starting from a path.

    Parameters
    ----------
    problem : PlanningProblem
    path : CandidatePath
        The start; its branches stay.
    weights : mapping of Objective to float
        Of the squared objectives.
    stiffness : float
        Factor on the excess over the limits.
    iterations : int
        Most steps.

    Returns
    -------
    CandidatePath
        Never with a larger sum than the start.
    """
    damping, model = FIRST_DAMPING, linearise(problem, path, weights, stiffness=stiffness)
    costs = [model.cost]
    while len(costs) <= iterations and damping < LARGEST_DAMPING:
        step = damped_step(model, damping)
        moved = None if step is None else _moved(problem, path, step)
        model_moved = None if moved is None else linearise(problem, moved, weights, stiffness=stiffness)
        if step is None or moved is None or model_moved is None or not model_moved.cost < model.cost:
            damping *= 4.0
            continue
        ratio = (model.cost - model_moved.cost) / max(model.cost - model.predicted_cost(step), 1e-300)
        damping = max(damping * max(0.2, 1.0 - (2.0 * min(ratio, 1.0) - 1.0) ** 3), LEAST_DAMPING)  # Nielsen 1999
        path, model = moved, model_moved
        costs.append(model.cost)
        if len(costs) > WINDOW and costs[-1] > (1.0 - LEAST_GAIN) * costs[-1 - WINDOW]:
            break
    return path


def _moved(problem: PlanningProblem, path: CandidatePath, step: FloatArray) -> CandidatePath | None:
    """Return the path after a step, clipped to the ranges; None where it leaves the reach."""
    coordinates = np.clip(path.coordinates + step, *problem.box)
    joints = joints_along(problem.cell, problem.path, coordinates, path.branches, path.joints[0])
    return CandidatePath(coordinates, path.branches, joints) if np.isfinite(joints).all() else None


def damped_step(model: LinearModel, damping: float) -> FloatArray | None:
    """Return the step that minimises the damped model with the limits that count after it.

    Parameters
    ----------
    model : LinearModel
        Of n points.
    damping : float
        Relative to the diagonal of the normal matrix.

    Returns
    -------
    ndarray, shape (n, 9), or None
        mm and rad. None where round-off makes the normal matrix indefinite.
    """
    active, step = model.beyond > 0, None
    for _ in range(ACTIVE_ROUNDS):
        band = model.band(active)
        band[0] += damping * band[0] + LEAST_CURVATURE
        try:
            flat = solveh_banded(band, -model.gradient(active).ravel(), lower=True, check_finite=False)
        except LinAlgError:
            return None
        step = np.asarray(flat, dtype=np.float64).reshape(len(model.deviation), -1)
        after = model.beyond_after(step) > 0
        if (after == active).all():
            break
        active = after
    return step
