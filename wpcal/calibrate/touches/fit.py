r"""The least-squares and the minimax fit of touches, from a pose near by.

Least squares is damped Gauss-Newton on :math:`\sum d_i^\top \Lambda_i d_i`. The minimax fit is

.. math:: \min_{\xi, s} s \quad \text{with} \quad |d_i(\xi)| \le s,

solved by sequential quadratic programming with an active set (SciPy's SLSQP) in small motions about the last pose,
until the pose no longer changes. A touch on a face gives two smooth constraints, :math:`\pm d_i \le s`. For an edge or
a point the length itself is used, which is smooth where it is active.

References
----------
Kraft (1988), A software package for sequential quadratic programming, DFVLR-FB 88-28.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from wpcal.calibrate.touches.touches import Linearised, Touches
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation
from wpcal.optim.levenberg_marquardt import minimise_squares

MOST_STEPS = 100
"""A start that is turned by 60 degrees takes 10 to 40. Starts that creep towards no optimum are given up."""
FIRST_DAMPING = 1e-3
"""A start may be turned by 60 degrees: the first steps are held back a little."""
RESTS_MM = 1e-11
"""Residuals that change by less than this have converged: it is round-off at the size of a part of a metre."""
MOST_ROUNDS = 12
"""Rounds of sequential quadratic programming, each about the pose of the previous one; two or three are usual."""
LEAST_LARGEST_MM = 1e-9
"""A largest residual below this is an exact fit: nothing remains to minimise."""
SAME_VALUE = 1e-9
"""Relative slack within which fits count as having the same largest residual when the tie is broken."""


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """A pose ``T_base_part`` of a fit with its residuals.

    Parameters
    ----------
    R, t : ndarray, shapes (3, 3), (3,)
    at : Linearised
    """

    R: FloatArray
    t: FloatArray
    at: Linearised

    @classmethod
    def of(cls, touches: Touches, R: FloatArray, t: FloatArray) -> Pose:
        """Evaluate a pose: R of shape (3, 3), t of shape (3,), mm."""
        return cls(R, t, touches.linearised(R, t))

    @property
    def largest_mm(self) -> float:
        """Largest residual, mm."""
        return float(self.at.distances.max())

    def moved(self, touches: Touches, xi: FloatArray, scale: _Scale) -> Pose:
        """Return the pose moved by `xi`, shape (6,): L ω and v, mm, about the touches' centroid."""
        turn = exp_rotation(xi[:3] / scale.length_mm)
        return Pose.of(touches, turn @ self.R, turn @ (self.t - scale.pivot) + scale.pivot + xi[3:])


@dataclass(frozen=True, slots=True, eq=False)
class _Scale:
    """Where small motions turn about, and the length that makes an angle a length."""

    pivot: FloatArray
    length_mm: float

    @classmethod
    def of(cls, touches: Touches) -> _Scale:
        pivot = touches.p_base.mean(axis=0)
        spread = float(np.sqrt(np.mean(np.sum((touches.p_base - pivot) ** 2, axis=1))))
        return cls(pivot, max(spread, 1.0))

    def jacobian(self, at: Linearised) -> FloatArray:
        """Of the residuals by the scaled coordinates, shape (n, 3, 6)."""
        J = at.jacobian(self.pivot)
        J[:, :, :3] /= self.length_mm
        return J


def scaled_jacobian(touches: Touches, pose: Pose) -> tuple[FloatArray, FloatArray, float]:
    """Derivative of the residuals by (L ω, v) about the touches' centroid (n, 3, 6), that centroid, and L in mm."""
    scale = _Scale.of(touches)
    return scale.jacobian(pose.at), scale.pivot, scale.length_mm


def fit_squares(touches: Touches, start: Pose, *, weighted: bool = False) -> Pose:
    """Find the pose of least (weighted) sum of squares near a start.

    Parameters
    ----------
    touches : Touches
    start : Pose
    weighted : bool
        Weight with the inverse covariances of the touches instead of equally.

    Returns
    -------
    Pose
    """
    problem = _Squares(touches, _Scale.of(touches), touches.covariances if weighted else None)
    pose = Pose.of(touches, start.R, start.t)  # the start may be a fit of other touches
    unit = math.sqrt(float(pose.at.information(problem.covariances).max()))
    still = RESTS_MM * unit
    return minimise_squares(problem, pose, still=still, most_steps=MOST_STEPS, first_damping=FIRST_DAMPING).state


@dataclass(frozen=True, slots=True, eq=False)
class _Squares:
    """Σ dᵀ Λ d of touches as a `wpcal.optim.levenberg_marquardt.SquaresProblem` of poses."""

    touches: Touches
    scale: _Scale
    covariances: FloatArray | None

    def cost(self, pose: Pose) -> float:
        d = pose.at.d
        return float(np.einsum("ni,nij,nj->", d, pose.at.information(self.covariances), d))

    def normal_equations(self, pose: Pose) -> tuple[FloatArray, FloatArray]:
        J, weights = self.scale.jacobian(pose.at), pose.at.information(self.covariances)
        WJ = weights @ J
        return np.einsum("nik,ni->k", WJ, pose.at.d), np.einsum("nik,nil->kl", J, WJ)

    def moved(self, pose: Pose, step: FloatArray) -> Pose:
        return pose.moved(self.touches, step, self.scale)


def fit_minimax(touches: Touches, start: Pose) -> Pose:
    """Find the pose of least largest residual near a start; of several, the one of least sum of squares.

    Parameters
    ----------
    touches : Touches
    start : Pose
        The least-squares fit is the best choice.

    Returns
    -------
    Pose
        Never worse than the start.
    """
    scale, best = _Scale.of(touches), Pose.of(touches, start.R, start.t)
    for _ in range(MOST_ROUNDS):
        if best.largest_mm <= LEAST_LARGEST_MM:
            return best
        trial = best.moved(touches, _solve_largest(touches, best, scale), scale)
        if not trial.largest_mm < best.largest_mm * (1.0 - SAME_VALUE):
            best = trial if trial.largest_mm < best.largest_mm else best
            break
        best = trial
    return _without_ties(touches, best, scale)


def _solve_largest(touches: Touches, pose: Pose, scale: _Scale) -> FloatArray:
    """Scaled motion to a smaller largest residual; residuals in units of the one at the start."""
    unit = pose.largest_mm
    model = _Model(touches, pose, scale, unit)
    within: Any = {
        "type": "ineq",
        "fun": lambda z: z[6] - model.values(z[:6]),
        "jac": lambda z: np.column_stack([-model.slopes(z[:6]), np.ones(model.count)]),
    }
    slope = np.zeros(7)
    slope[6] = 1.0  # of s, the last variable; and where the search starts
    found = _minimised(_last, slope, partial(_always, slope), within, 1e-15)
    return np.asarray(found.x[:6] * unit)


def _minimised(value: Any, start: FloatArray, slope: Any, within: Any, ftol: float) -> Any:
    """Minimise a function under constraints, from `start`."""
    from scipy.optimize import minimize

    options: Any = {"maxiter": 100, "ftol": ftol}
    return minimize(value, start, jac=slope, method="SLSQP", constraints=within, options=options)


def _last(z: FloatArray) -> float:
    return float(z[-1])


def _always(value: FloatArray, _: FloatArray) -> FloatArray:
    return value


def _without_ties(touches: Touches, best: Pose, scale: _Scale) -> Pose:
    """Take the pose of least sum of squares among those with the same largest residual."""
    unit = best.largest_mm
    if unit <= LEAST_LARGEST_MM:
        return best
    model = _Model(touches, best, scale, unit)
    within: Any = {
        "type": "ineq",
        "fun": lambda z: 1.0 + SAME_VALUE - model.values(z),
        "jac": lambda z: -model.slopes(z),
    }
    found = _minimised(model.half_squares, np.zeros(6), model.half_squares_slope, within, 1e-14)
    trial = best.moved(touches, found.x * unit, scale)
    smaller = np.sum(trial.at.d**2) < np.sum(best.at.d**2)
    return trial if smaller and trial.largest_mm <= unit * (1.0 + 2.0 * SAME_VALUE) else best


class _Model:
    """Residuals near a pose as smooth functions of the scaled motion, in units of `unit` mm."""

    def __init__(self, touches: Touches, pose: Pose, scale: _Scale, unit: float) -> None:
        self.touches, self.pose, self.scale, self.unit = touches, pose, scale, unit
        self.on_face = pose.at.rank == 1
        self.count = len(touches) + int(self.on_face.sum())
        self._sense = self._axes(pose.at)
        self._last: tuple[bytes, Pose] | None = None

    def _at(self, z: FloatArray) -> Linearised:
        key = z.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = (key, self.pose.moved(self.touches, z * self.unit, self.scale))
        return self._last[1].at

    def values(self, z: FloatArray) -> FloatArray:
        """Lengths of edge and point rows, signed distances of face rows, and the face rows' negatives."""
        signed, _ = self._rows(self._at(z))
        return np.concatenate([signed, -signed[self.on_face]])

    def slopes(self, z: FloatArray) -> FloatArray:
        """Their derivatives by z."""
        at = self._at(z)
        _, along = self._rows(at)
        slope = np.einsum("ni,nik->nk", along, self.scale.jacobian(at))
        return np.concatenate([slope, -slope[self.on_face]])

    def half_squares(self, z: FloatArray) -> float:
        """Half the sum of squares."""
        return float(0.5 * np.sum((self._at(z).d / self.unit) ** 2))

    def half_squares_slope(self, z: FloatArray) -> FloatArray:
        """Its derivative by z."""
        at = self._at(z)
        return np.asarray(np.einsum("ni,nik->k", at.d / self.unit, self.scale.jacobian(at)))

    def _rows(self, at: Linearised) -> tuple[FloatArray, FloatArray]:
        """Values of the rows and the directions in which they grow."""
        length = at.distances
        along = at.d / np.where(length > 0, length, 1.0)[:, None]
        axis = self._axes(at)
        axis *= np.where(np.einsum("ni,ni->n", axis, self._sense) < 0, -1.0, 1.0)[:, None]
        along[self.on_face] = axis[self.on_face]
        value = np.where(self.on_face, np.einsum("ni,ni->n", axis, at.d), length)
        return value / self.unit, along

    @staticmethod
    def _axes(at: Linearised) -> FloatArray:
        """Normal of each face row, up to its sign: the longest column of n nᵀ."""
        column = at.A[np.arange(len(at.A)), :, np.argmax(np.einsum("nii->ni", at.A), axis=1)]
        return np.asarray(column / np.linalg.norm(column, axis=1, keepdims=True))
