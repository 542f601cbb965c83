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
from wpcal.core.arrays import FloatArray


def budget_of_touches(
    touches: Touches,
    pose: Pose,
    criterion: Criterion,
    teaching: TeachingError,
    *,
    seed: int = 0,
    postures: FloatArray | None = None,
) -> ErrorBudget:
    """Collect what the errors of touches do to the pose of a fit, and what is believed of these errors.

    The usual teaching error is assumed if nothing is stated and there are as many touches as freedoms.
    `postures`: shape (n, 3, 3). The axes of the tool in the base, if all are known.
    """
    J, _, length = scaled_jacobian(touches, pose)
    scale, stated = 1.0 / np.repeat([length, 1.0], 3), touches.covariances
    weights = pose.at.information(stated if criterion is Criterion.WEIGHTED else None)
    shared = None if stated is None else touches.shared
    own = stated if stated is None or shared is None else stated - shared @ shared.transpose(0, 2, 1)
    common = shared if shared is not None else teaching.shared(postures)
    belief, sigma = _believed(touches, pose, teaching, own, common)
    turned = postures if shared is None else None  # shared errors of a touch program hold that of the stick-out
    fit = LinearFit(touches.p_base, J, pose.at.A, scale, weights, own, shared, turned)
    return fit.budget(belief, sigma, teaching, is_minimax=criterion is Criterion.MINIMAX, seed=seed)


def _believed(
    touches: Touches, pose: Pose, teaching: TeachingError, own: FloatArray | None, shared: FloatArray | None
) -> tuple[Belief, Sigma]:
    """Weigh the residuals of least squares; `own` and `shared` are what a touch sees of its own and of all errors."""
    squares = fit_squares(touches, pose)
    J = scaled_jacobian(touches, squares)[0]
    information = squares.at.information(own)
    about = touches.p_base - touches.p_base.mean(axis=0)
    rows = ResidualRows.of(about, J, squares.at.d, information, shared)
    return teaching.believed(rows, touches.covariances)
