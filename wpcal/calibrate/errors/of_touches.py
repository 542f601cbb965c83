"""The error budget of a fit of touches, and what is believed of their errors."""

from __future__ import annotations

import numpy as np

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.linear_fit import LinearFit
from wpcal.calibrate.errors.prediction import Sigma, TeachingError
from wpcal.calibrate.errors.robot_field import Belief, ResidualRows
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.touches import Pose, fit_squares, scaled_jacobian
from wpcal.calibrate.trust.criteria import Criterion


def budget_of_touches(
    touches: Touches, pose: Pose, criterion: Criterion, teaching: TeachingError, *, seed: int = 0
) -> ErrorBudget:
    """Collect what the errors of touches do to the pose of a fit, and what is believed of these errors.

    The usual teaching error is assumed if nothing is stated and there are as many touches as freedoms.
    """
    J, _, length = scaled_jacobian(touches, pose)
    scale, stated = 1.0 / np.repeat([length, 1.0], 3), touches.covariances
    weights = pose.at.information(stated if criterion is Criterion.WEIGHTED else None)
    shared = None if stated is None else touches.shared
    own = stated if stated is None or shared is None else stated - shared @ shared.transpose(0, 2, 1)
    belief, sigma = _believed(touches, pose, teaching)
    fit = LinearFit(touches.p_base, J, pose.at.A, scale, weights, own, shared)
    return fit.budget(belief, sigma, teaching, is_minimax=criterion is Criterion.MINIMAX, seed=seed)


def _believed(touches: Touches, pose: Pose, teaching: TeachingError) -> tuple[Belief, Sigma]:
    """Weigh the residuals of least squares."""
    squares = fit_squares(touches, pose)
    J = scaled_jacobian(touches, squares)[0]
    information = squares.at.information(touches.covariances)
    about = touches.p_base - touches.p_base.mean(axis=0)
    return teaching.believed(ResidualRows.of(about, J, squares.at.d, information), touches.covariances)
