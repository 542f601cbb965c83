r"""How errors of points or touches become a small motion of the fitted part, for every kind and criterion.

An observation is off by a random vector :math:`\delta_i`; its residual sees :math:`A_i \delta_i` (a point: all of it).
With :math:`d = A \delta + J \xi` linear and weights :math:`W_i`, a fit of squares has the gains
:math:`G_i = -(\sum J_i^\top W_i J_i)^{-1} J_i^\top W_i` and the covariance :math:`\sum G_i C_i G_i^\top`. An error
:math:`u_i` that all share, such as that of the stick-out, adds :math:`g g^\top` with :math:`g = \sum G_i u_i`. What
minimax adds is simulated (`wpcal.calibrate.errors.of_minimax`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.of_minimax import minimax_excess, minimax_of_stated
from wpcal.calibrate.errors.prediction import Sigma, TeachingError
from wpcal.calibrate.errors.robot_field import Belief, ResidualRows, foresee
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import point_jacobian, translation_adjoint


@dataclass(frozen=True, slots=True, eq=False)
class LinearFit:
    """A fit near its answer; all motions are about the middle of the observations."""

    places: FloatArray  #: shape (n, 3). Of the observations, base frame, mm.
    J: FloatArray  #: shape (n, 3, 6). Derivative of the residuals by the motion over `scale`, projected by A.
    A: FloatArray  #: shape (n, 3, 3). Projectors on what each observation sees.
    scale: FloatArray  #: shape (6,). Of the motion (ω, v).
    weights: FloatArray  #: shape (n, 3, 3).
    own: FloatArray | None = None  #: shape (n, 3, 3). Covariances that the observations state, mm²; or unit errors.
    shared: FloatArray | None = None  #: shape (n, 3, s). What each sees of one standard deviation of shared errors.
    #: shape (n, 3, 3). The axes of the tool in the base, as columns, if all are known: its error then moves the part as
    #: the touches turned it.
    postures: FloatArray | None = None

    @classmethod
    def of_points(
        cls, p_base: FloatArray, weights: FloatArray | None = None, covariances: FloatArray | None = None
    ) -> LinearFit:
        """Return the fit of moved model points, shape (n, 3), mm; weights and covariances of shape (n, 3, 3)."""
        about, A = p_base - p_base.mean(axis=0), np.broadcast_to(np.eye(3), (len(p_base), 3, 3))
        scale = 1.0 / np.repeat([max(float(np.abs(about).max()), 1e-300), 1.0], 3)
        return cls(p_base, -point_jacobian(about) * scale, A, scale, A if weights is None else weights, covariances)

    @property
    def gain(self) -> FloatArray:
        """From errors to the motion, shape (n, 6, 3)."""
        back = self.J.transpose(0, 2, 1) @ self.weights
        return np.asarray(self.scale[:, None] * (-np.linalg.inv(np.einsum("nij,njk->ik", back, self.J)) @ back))

    @property
    def touching(self) -> FloatArray:
        """Covariance of the motion by the errors of the observations, shape (6, 6)."""
        gain = self.gain
        found = np.einsum("nij,nkj->ik", gain if self.own is None else gain @ self.own, gain)
        if self.shared is not None:
            common = np.einsum("nij,njs->is", gain, self.shared)
            found = found + common @ common.T
        return np.asarray(found)

    def excess(self, *, bounded: bool = False, seed: int = 0) -> FloatArray:
        """What minimax adds to the covariance of the motion by unit errors, shape (6, 6)."""
        return np.asarray(self.scale[:, None] * minimax_excess(self.J, self.A, bounded=bounded, seed=seed) * self.scale)

    def budget(
        self, belief: Belief, sigma: Sigma, teaching: TeachingError, *, is_minimax: bool = False, seed: int = 0
    ) -> ErrorBudget:
        """Collect what the errors do to the pose."""
        excess = None
        if is_minimax and self.own is not None:
            shared = np.zeros((len(self.J), 3, 0)) if self.shared is None else self.shared
            stated = minimax_of_stated(self.J, self.A, self.own, shared, seed=seed)
            touching = self.scale[:, None] * stated * self.scale
        else:
            touching = self.touching
            if is_minimax and sigma.mm > 0:
                excess = self.excess(bounded=teaching.is_bounded, seed=seed)
        found = ErrorBudget.of(self.places, self.gain, touching, belief, sigma, excess=excess)
        turned = None if self.postures is None else np.einsum("nij,njk->ik", self.gain, self.postures)
        return replace(found, tool=teaching.tool_covariance, tool_gain=turned)


def isotropic_covariance(p_base: FloatArray, sigma_mm: float) -> FloatArray:
    """Covariance of ξ for the least-squares fit of points, shape (n, 3), that are all off by `sigma_mm` per axis.

    Returns shape (6, 6). About the base's origin: rad², rad·mm, mm².
    """
    to_origin = translation_adjoint(p_base.mean(axis=0))
    return np.asarray(sigma_mm**2 * (to_origin @ LinearFit.of_points(p_base).touching @ to_origin.T))


def budget_of_design(
    p_base: FloatArray, teaching: TeachingError, *, with_minimax: bool = False, seed: int = 0
) -> ErrorBudget:
    """Budget of points before they are touched, shape (n, 3), mm, for least squares or for minimax."""
    sigma, about, fit = Sigma.expected(teaching.per_axis_mm), p_base - p_base.mean(axis=0), LinearFit.of_points(p_base)
    rows = ResidualRows.of(about, point_jacobian(about), np.zeros_like(p_base), fit.A)
    belief = foresee(rows, sigma.mm, teaching.robot)
    return fit.budget(belief, sigma, teaching, is_minimax=with_minimax, seed=seed)
