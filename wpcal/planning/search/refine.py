"""Weighted least squares on whole paths: all points move at once, with exact derivatives through both inverses.

For weights of the objectives the sum of their squares is made small over the nine coordinates of every point. Only
neighbouring points share a residual (the joint steps), so the normal equations are a band, and a step of
Levenberg-Marquardt costs as much as some inverse kinematics. Limits and clearance enter as squares of what a path is
beyond them; which of them count is found again for every step, by what they are after it.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, solveh_banded

from wpcal.core.arrays import FloatArray
from wpcal.planning.cell.closed_chain import joints_along
from wpcal.planning.search.linear_model import LinearModel, Path, linearise
from wpcal.planning.search.problem import PlanningProblem

FIRST_DAMPING = 1e-2
"""Of Levenberg-Marquardt, relative to the diagonal."""
LARGEST_DAMPING = 1e6
"""Steps as short as this demands improve nothing any more."""
LEAST_DAMPING = 1e-6
"""Below this the damping has no effect on a step, and would take long to come back."""
STIFFNESSES = (1.0, 10.0, 100.0)
"""Of limits, one after the other. Stiff limits make short steps, and are needed only where a limit stands against a
heavy objective: where the wished weld position is not clear."""
WINDOW, LEAST_GAIN = 5, 2e-3
"""Ends when so many steps together gain less than this part of the sum: an objective then changes by a thousandth."""
LEAST_CURVATURE = 1e-9
"""Added to the diagonal: a coordinate without influence (the spin of a torch at rest) does not move."""
ACTIVE_ROUNDS = 4
"""Most rounds that look for the limits which count after a step; two or three settle as a rule."""


def refine_within_limits(problem: PlanningProblem, path: Path, weights: FloatArray) -> Path:
    """Refine a path with stiffer and stiffer limits until it keeps them, or the stiffest do not help.

    Parameters
    ----------
    problem : PlanningProblem
    path : Path
    weights : ndarray, shape (3,)

    Returns
    -------
    Path
        As `refine_path` leaves it; it may still break a limit.
    """
    for stiffness in STIFFNESSES:
        path = refine_path(problem, path, weights, stiffness=stiffness)
        if problem.is_allowed(path.coordinates, path.joints):
            break
    return path


def refine_path(
    problem: PlanningProblem, path: Path, weights: FloatArray, *, stiffness: float = 1.0, iterations: int = 80
) -> Path:
    """Make the weighted sum of squared objectives small, starting from a path.

    Parameters
    ----------
    problem : PlanningProblem
    path : Path
        The start; its branches stay.
    weights : ndarray, shape (3,)
        Of the squared objectives, in the order of `OBJECTIVES`.
    stiffness : float
        Factor on what a path is beyond its limits.
    iterations : int
        At most so many steps.

    Returns
    -------
    Path
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


def _moved(problem: PlanningProblem, path: Path, step: FloatArray) -> Path | None:
    """Return the path after a step, cut off at the ends of the ranges; None where it leaves the reach."""
    coordinates = np.clip(path.coordinates + step, *problem.box)
    joints = joints_along(problem.cell, problem.path, coordinates, path.branches, path.joints[0])
    return Path(coordinates, path.branches, joints) if np.isfinite(joints).all() else None


def damped_step(model: LinearModel, damping: float) -> FloatArray | None:
    """Return the step that makes the damped model small, with the limits that count after it; shape (n, 9).

    None where round-off makes the normal matrix indefinite.
    """
    active, step = model.beyond > 0, None
    for _ in range(ACTIVE_ROUNDS):
        band = model.band(active)
        band[0] += damping * band[0] + LEAST_CURVATURE
        try:
            flat = solveh_banded(band, -model.gradient(active).ravel(), lower=True, check_finite=False)
        except LinAlgError:
            return None
        step = np.asarray(flat, dtype=np.float64).reshape(len(model.wish), -1)
        after = model.beyond_after(step) > 0
        if (after == active).all():
            break
        active = after
    return step
