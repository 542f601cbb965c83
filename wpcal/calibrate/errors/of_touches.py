r"""The covariance of a fit of touches.

A touch is off by a random vector :math:`\delta_i`; its residual sees :math:`A_i \delta_i`. With
:math:`d = A(\delta - J\xi)` linear and :math:`M = \sum J_i^\top A_i J_i`, least squares has
:math:`C = M^{-1} (\sum J_i^\top A_i C_i A_i J_i) M^{-1}`, which is :math:`\sigma^2 M^{-1}` for equal errors. An
error :math:`u_i` that all touches share, such as that of the stick-out, adds :math:`g g^\top` with
:math:`g = M^{-1} \sum J_i^\top A_i u_i`. The weighted fit has its weights in place of :math:`A_i`. The further motion
of the minimax fit is simulated (`wpcal.calibrate.errors.of_minimax`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.of_minimax import minimax_excess, minimax_of_stated
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
    scale, covariances = 1.0 / np.repeat([length, 1.0], 3), touches.covariances
    weights = pose.at.information(covariances if criterion is Criterion.WEIGHTED else None)
    back = J.transpose(0, 2, 1) @ weights
    gain = scale[:, None] * (-np.linalg.inv(np.einsum("nij,njk->ik", back, J)) @ back)
    belief, sigma = _believed(touches, pose, teaching)
    excess = None
    if covariances is None:
        touching = np.einsum("nij,nkj->ik", gain, gain)
        if criterion is Criterion.MINIMAX and sigma.mm > 0:
            excess = scale[:, None] * minimax_excess(J, pose.at.A, bounded=teaching.is_bounded, seed=seed) * scale
    else:
        shared = np.zeros((len(J), 3, 0)) if touches.shared is None else touches.shared
        own = covariances - shared @ shared.transpose(0, 2, 1)
        if criterion is Criterion.MINIMAX:
            touching = scale[:, None] * minimax_of_stated(J, pose.at.A, own, shared, seed=seed) * scale
        else:
            common = np.einsum("nij,njs->is", gain, shared)
            touching = np.einsum("nij,njl,nkl->ik", gain, own, gain) + common @ common.T
    return replace(
        ErrorBudget.of(touches.p_base, gain, touching, belief, sigma, excess=excess), tool_mm=teaching.tool_mm
    )


def _believed(touches: Touches, pose: Pose, teaching: TeachingError) -> tuple[Belief, Sigma]:
    """Weigh the residuals of least squares."""
    squares = fit_squares(touches, pose)
    J = scaled_jacobian(touches, squares)[0]
    information = squares.at.information(touches.covariances)
    about = touches.p_base - touches.p_base.mean(axis=0)
    return teaching.believed(ResidualRows.of(about, J, squares.at.d, information), touches.covariances)
