r"""The least-squares and the minimax fit of touches, from a pose near by.

Least squares is damped Gauss-Newton on :math:`\sum d_i^\top \Lambda_i d_i`. The minimax fit is

.. math:: \min_{\xi, s} s \quad \text{with} \quad |d_i(\xi)| \le s,

solved for residuals that are linear in small motions about the last pose (`wpcal.optim.least_largest`), until the pose
no longer changes. A step that does not lower the largest residual is halved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.observe.touches import Linearised, Touches
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.tangent import exp_rotation
from wpcal.optim.least_largest import least_largest, least_squares_within
from wpcal.optim.levenberg_marquardt import LEAST_SINGULAR
from wpcal.optim.many_squares import minimise_many_squares

MOST_STEPS = 100
"""A start that is turned by 60 degrees takes 10 to 40. Starts that creep towards no optimum are given up."""
FIRST_DAMPING = 1e-3  #: A start may be turned by 60 degrees: the first steps are held back a little.
RESTS_MM = 1e-11
"""Residuals that change by less than this have converged: it is round-off at the size of a part of a metre."""
MOST_ROUNDS = 40
"""Rounds of the minimax fit, each linear about the pose of the previous one. Two or three are usual; residuals that are
large beside the radius of a hole take more."""
MOST_HALVINGS = 12  #: Halvings of a step before the largest residual counts as the least.
BENT = 1e-4
"""Step of the differences behind the curvature, in largest residuals: the error is of its square, round-off of 1e-8."""
CARRIES = 1e-6
"""Least multiplier, of a sum of one, of a touch that carries the minimax answer; those of the others are round-off."""
UNSEEN = 1e-6  #: Share of the largest singular value below which the touches that carry the answer do not see a motion.
SETTLED = 1e-9  #: Steps below this share of the largest residual change nothing.
LEAST_LARGEST_MM = 1e-9  #: A largest residual below this is an exact fit: nothing remains to minimise.
SAME_VALUE = 1e-9  #: Relative slack within which fits count as having the same largest residual when the tie is broken.


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """A pose ``T_base_part`` of a fit with its residuals."""

    #: `R`, `t`: shapes (3, 3), (3,).
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
        return Pose.of(touches, *scale.moved(self.R, self.t, xi))


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

    def moved(self, R: FloatArray, t: FloatArray, xi: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Move poses R (..., 3, 3), t (..., 3) by (L ω, v), shape (..., 6)."""
        turn = exp_rotation(xi[..., :3] / self.length_mm)
        return turn @ R, (turn @ (t - self.pivot)[..., None])[..., 0] + self.pivot + xi[..., 3:]

    def jacobian(self, at: Linearised) -> FloatArray:
        """Of the residuals by the scaled coordinates, shape (..., n, 3, 6)."""
        J = at.jacobian(self.pivot)
        J[..., :3] /= self.length_mm
        return J


def scaled_jacobian(touches: Touches, pose: Pose) -> tuple[FloatArray, FloatArray, float]:
    """Derivative of the residuals by (L ω, v) about the touches' centroid (n, 3, 6), that centroid, and L in mm."""
    scale = _Scale.of(touches)
    return scale.jacobian(pose.at), scale.pivot, scale.length_mm


def fit_squares(touches: Touches, start: Pose, *, weighted: bool = False) -> Pose:
    """Find the pose of least (weighted) sum of squares near a start."""
    starts = fit_squares_of(touches, start.R[None], start.t[None], weighted=weighted)
    return starts.pose(0)


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """Fits of touches from many starts."""

    #: `R`, `t`: shapes (m, 3, 3), (m, 3). ``T_base_part``.
    R: FloatArray
    t: FloatArray
    sums: FloatArray  #: shape (m,). Weighted sums of squares.
    at: Linearised  #: With m as its first axis.

    def pose(self, k: int) -> Pose:
        """Return one of the fits."""
        return Pose(self.R[k], self.t[k], self.at.at(k))


def fit_squares_of(
    touches: Touches, R: FloatArray, t: FloatArray, *, weighted: bool = False, kept: FloatArray | None = None
) -> Fits:
    """Find the poses of least (weighted) sums of squares near many starts.

    `R`, `t`: shapes (m, 3, 3), (m, 3). The starts ``T_base_part``.
    `kept`: shape (m, n). 1 for touches that a fit takes, 0 for those it leaves out. By default each fit takes all.
    """
    covariances = touches.covariances if weighted else None
    unit = math.sqrt(float(touches.linearised(R[0], t[0]).information(covariances).max()))
    mask = np.ones((len(R), len(touches))) if kept is None else kept
    ends, sums = minimise_many_squares(
        _Squares(touches, _Scale.of(touches), covariances, mask),
        np.concatenate([R, t[:, :, None]], axis=2),
        still=RESTS_MM * unit,
        most_steps=MOST_STEPS,
        first_damping=FIRST_DAMPING,
    )
    R_end, t_end = ends[:, :, :3], ends[:, :, 3]
    return Fits(R_end, t_end, sums, touches.linearised(R_end, t_end))


@dataclass(frozen=True, slots=True, eq=False)
class _Squares:
    """Σ dᵀ Λ d of touches as a `ManySquares` of poses [R t], shape (m, 3, 4)."""

    touches: Touches
    scale: _Scale
    covariances: FloatArray | None
    kept: FloatArray

    def evaluate(self, states: FloatArray, numbers: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        at = self.touches.linearised(states[:, :, :3], states[:, :, 3])
        J, m = self.scale.jacobian(at), len(states)
        weighted = at.information(self.covariances) * self.kept[numbers, :, None, None]
        WJ, Wd = weighted @ J, (weighted @ at.d[..., None])[..., 0]
        flat = J.reshape(m, -1, 6).swapaxes(1, 2)
        H, gradient = flat @ WJ.reshape(m, -1, 6), flat @ Wd.reshape(m, -1, 1)
        return np.einsum("mni,mni->m", at.d, Wd), gradient[..., 0], H

    def moved(self, states: FloatArray, steps: FloatArray) -> FloatArray:
        R, t = self.scale.moved(states[:, :, :3], states[:, :, 3], steps)
        return np.concatenate([R, t[..., None]], axis=2)


def fit_minimax(touches: Touches, start: Pose) -> Pose:
    """Find the pose of least largest residual near a start; of several, the one of least sum of squares.

    Returns: Never worse than the start.
    """
    scale, best = _Scale.of(touches), Pose.of(touches, start.R, start.t)
    weights = np.zeros(len(touches))
    for _ in range(MOST_ROUNDS):
        if best.largest_mm <= LEAST_LARGEST_MM:
            return best
        steps, found = least_largest(best.at.d[None], scale.jacobian(best.at))
        step, weights = steps[0], found[0]
        if not best.moved(touches, step, scale).largest_mm < best.largest_mm:
            bend = _curvature(touches, best, scale, weights)
            step = least_largest(best.at.d[None], scale.jacobian(best.at), curvature=bend)[0][0]
        for _ in range(MOST_HALVINGS):
            trial = best.moved(touches, step, scale)
            if trial.largest_mm < best.largest_mm:
                break
            step = step / 2.0
        settled = not trial.largest_mm < best.largest_mm * (1.0 - SAME_VALUE)
        best = trial if trial.largest_mm < best.largest_mm else best
        if settled:
            break
    return _without_ties(touches, best, scale, weights > CARRIES)


def _curvature(touches: Touches, pose: Pose, scale: _Scale, weights: FloatArray) -> FloatArray:
    """What turning adds to the Hessian of Σ w d² beyond 2 Σ w JᵀJ, by differences; its positive part, (6, 6)."""
    h = BENT * max(pose.largest_mm, BENT)
    at = touches.linearised(*scale.moved(pose.R, pose.t, h * np.concatenate([np.eye(6), -np.eye(6)])))
    pull = 2.0 * np.einsum("n,mnik,mni->mk", weights, scale.jacobian(at), at.d)
    J = scale.jacobian(pose.at)
    H = (pull[:6] - pull[6:]) / (2.0 * h) - 2.0 * np.einsum("n,nik,nil->kl", weights, J, J)
    values, vectors = np.linalg.eigh((H + H.T) / 2.0)
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _without_ties(touches: Touches, best: Pose, scale: _Scale, carry: BoolArray) -> Pose:
    """Take the pose of least sum of squares among those with the same largest residual.

    All of them have the residuals of the touches that `carry` the answer, (n,). Each round moves the part in the
    directions that these touches do not see, and back to their residuals in the others.
    """
    unit, held, trial = best.largest_mm, best.at.d[carry].ravel(), best
    for _ in range(MOST_ROUNDS):
        J, d = scale.jacobian(trial.at), trial.at.d
        _, values, Vt = np.linalg.svd(J[carry].reshape(-1, 6))
        seen = np.zeros(6, dtype=bool)
        seen[: len(values)] = values > UNSEEN * max(float(values.max(initial=0.0)), UNSEEN)
        if seen.all():
            return best
        back = -Vt[seen].T @ np.linalg.lstsq(J[carry].reshape(-1, 6) @ Vt[seen].T, d[carry].ravel() - held)[0]
        free, rest = Vt[~seen].T, (J[~carry] @ Vt[~seen].T).reshape(-1, 6 - int(seen.sum()))
        left = d[~carry] + (J[~carry] @ back)
        along = -np.linalg.lstsq(rest, left.ravel(), rcond=LEAST_SINGULAR)[0]
        if np.linalg.norm(left + (rest @ along).reshape(-1, 3), axis=1).max() > unit:
            along = least_squares_within(left[None], rest.reshape(len(left), 3, -1), np.array([unit]))[0]
        step = back + free @ along
        trial = trial.moved(touches, step, scale)
        if float(np.abs(step).max()) <= SETTLED * unit:
            break
    smaller = np.sum(trial.at.d**2) < np.sum(best.at.d**2)
    return trial if smaller and trial.largest_mm <= unit * (1.0 + 2.0 * SAME_VALUE) else best
