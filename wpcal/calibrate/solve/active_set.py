r"""The optimum of a minimax fit to the last digit, from the answer of the interior-point method.

The interior-point method stops at a gap of round-off. Its value is then exact, but its pose is not: the largest
distance of a nearly flat problem grows with the square of the motion, and a gap of 1e-14 leaves 1e-7 of the size. Here
Newton's method solves the optimality conditions of the points that carry,

.. math:: \sum_i w_i \nabla f_i(\xi) = 0, \quad \sum_i w_i = 1, \quad f_i(\xi) = s,

with exact second derivatives, so that the pose is exact as well. A point whose multiplier comes out negative leaves the
set, a point that is further off than the carrying ones enters it. Motions that the conditions leave free stay as they
are; `tie_break` decides them.

References: Nocedal, Wright (2006), Numerical Optimization, ch. 18 (local SQP) and 16.5 (active sets).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.solve.least_squares import distances
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.rotations import cross_matrix
from wpcal.core.tangent import exp_rotation

NEWTON_STEPS = 12
"""From a gap of 1e-11 Newton's method needs 2 or 3 steps; more are taken where the interior point gave up."""
SET_CHANGES = 24  #: Changes of the carrying set. The set is right at once in almost every problem.
AT_REST = 1e-14  #: Motion in sizes of the cloud, per step, that is round-off.
FREE = 1e-10
"""Singular values of the scaled conditions below this share of the largest are motions that nothing holds, or points
that say the same. Coordinates of 1e6 mm leave 1e-12 in them."""
SAME = 1e-8  #: Share of the largest singular value below which conditions of the multipliers say the same.
NO_WEIGHT = 1e-9
"""Multipliers below this are round-off of the conditions: the point touches the limit and carries nothing."""
ROUND_OFF = 1e-12
"""Round-off of a distance after Newton's method on odd sets, in sizes of the cloud; usual sets leave 1e-15. Fits with
smaller distances are exact."""
MOST_MOTION = 0.01
"""A correction that turns further, in rad, or moves further, in sizes, does not start from an optimum; the answer is
then left as it is."""


@dataclass(frozen=True, slots=True, eq=False)
class ExactOptimum:
    """A fit that satisfies the optimality conditions to round-off."""

    #: `R`, `t`: shapes (3, 3) and (3,).
    R: FloatArray
    t: FloatArray
    weights: FloatArray  #: shape (n,). Multipliers on the simplex, zero on the points that do not carry.


def refine_optimum(
    p: FloatArray, q: FloatArray, R: FloatArray, t: FloatArray, weights: FloatArray
) -> ExactOptimum | None:
    """Solve the optimality conditions of a minimax fit to round-off.

    `p`, `q`: shape (n, 3). Points about their centroids, mm.
    `R`, `t`: shapes (3, 3) and (3,). A fit near the optimum.
    `weights`: shape (n,). Its multipliers.

    Returns: None where no set of carrying points satisfies the conditions, and for exact fits, which carry nothing.
    """
    size = float(np.sqrt(np.mean(np.sum(p**2, axis=1))))
    d = distances(p, q, R, t)
    unit = float(d.max())
    if unit <= ROUND_OFF * size:
        return None
    # On the central path w (1 - f) is the same small number everywhere: the larger factor tells.
    carries = weights >= 1.0 - (d / unit) ** 2
    slack = ROUND_OFF * size
    for _ in range(SET_CHANGES):
        rows = np.flatnonzero(carries)
        found = _newton(p, q, ExactOptimum(R, t, weights), rows, unit, size)
        if found is None:
            return None
        if found.weights.min() < -NO_WEIGHT:
            carries[np.argmin(found.weights)] = False
            continue
        d = distances(p, q, found.R, found.t)
        over = np.where(carries, -np.inf, d) - float(d[rows].max())
        if over.max() > slack:
            carries[np.argmax(over)] = True
            continue
        return None if d.max() > unit + slack else _without_touching(p, q, found, rows, unit, size)
    return None


def _without_touching(
    p: FloatArray, q: FloatArray, found: ExactOptimum, rows: IntArray, unit: float, size: float
) -> ExactOptimum:
    """Solve again without the points that touch the limit and carry nothing: they blur the conditions of the others."""
    carrying = np.flatnonzero(found.weights >= NO_WEIGHT)
    alone = _newton(p, q, found, carrying, unit, size) if len(carrying) < len(rows) else None
    best = alone or found
    weights = np.where(best.weights < NO_WEIGHT, 0.0, best.weights)
    return ExactOptimum(best.R, best.t, weights / weights.sum())


def _newton(
    p: FloatArray, q: FloatArray, start: ExactOptimum, rows: IntArray, unit: float, size: float
) -> ExactOptimum | None:
    """Newton's method on the conditions of the points `rows`; lengths in units, turns in units per size."""
    R, t, w = start.R, start.t, start.weights[rows] / start.weights[rows].sum()
    turned = 0.0
    for _ in range(NEWTON_STEPS):
        y = p[rows] @ R.T
        r = (q[rows] - y - t) / unit
        y = y / size
        solution = _newton_step(y, r, w, unit / size)
        step, w = solution[:6] * (unit / size), solution[6:-1]
        R, t = exp_rotation(step[:3]) @ R, t + step[3:] * size
        turned += float(np.abs(step).max())
        if turned > MOST_MOTION:
            return None
        if np.abs(step).max() <= AT_REST:
            break
    whole = np.zeros(len(p))
    whole[rows] = _central(p[rows] @ R.T / size, (q[rows] - p[rows] @ R.T - t) / unit, w)
    return ExactOptimum(R, t, whole)


def _central(y: FloatArray, r: FloatArray, w: FloatArray) -> FloatArray:
    """Of all multipliers those of least norm: round-off may carry Newton's to the border of the possible ones."""
    conditions = np.vstack([np.cross(y, r).T, r.T, np.ones(len(w))])
    least = np.linalg.lstsq(conditions, np.array([0.0] * 6 + [1.0]), rcond=SAME)[0]
    return np.asarray(least) if least.min() > 0 and np.abs(conditions[:6] @ least).max() <= SAME else w


def _newton_step(y: FloatArray, r: FloatArray, w: FloatArray, ratio: float) -> FloatArray:
    """Motion (6), multipliers (m) and s that solve the linearised conditions of scaled points and residuals."""
    m = len(w)
    C = -2.0 * np.hstack([np.cross(y, r), r])
    K = np.zeros((m + 7, m + 7))
    K[:6, :6] = _curvature(y, r, w, ratio)
    K[:6, 6:-1], K[6:-1, :6] = C.T, C
    K[6:-1, -1] = K[-1, 6:-1] = -1.0
    rhs = np.concatenate([np.zeros(6), -np.einsum("ij,ij->i", r, r), [-1.0]])
    return np.asarray(np.linalg.lstsq(K, rhs, rcond=FREE)[0], dtype=np.float64)


def _curvature(y: FloatArray, r: FloatArray, w: FloatArray, ratio: float) -> FloatArray:
    """Hessian of Σ w f in the scaled motion; `ratio` is the unit of the residuals per size, y and r are scaled."""
    outer, mixed = (y.T * w) @ y, ratio * (r.T * w) @ y
    H = np.empty((6, 6))
    H[:3, :3] = 2.0 * (np.trace(outer) * np.eye(3) - outer)
    H[:3, :3] += 2.0 * np.trace(mixed) * np.eye(3) - mixed - mixed.T
    H[:3, 3:] = 2.0 * cross_matrix((w @ y)[None])[0]
    H[3:, :3] = H[:3, 3:].T
    H[3:, 3:] = 2.0 * w.sum() * np.eye(3)
    return H
