r"""Close the gap of a minimax fit by branch and bound over all rotations.

A cell is a ball of rotations about a centre: all within an angle θ of it. For any weights on the simplex

.. math:: \min_{R, t} \sum_i w_i d_i^2 = c(w) - 2 \max_R \operatorname{tr}(R^\top B(w)),

and within the ball :math:`\operatorname{tr}(A \exp([u]_\times \varphi))` with A = B ᵀ R₀ is at most
:math:`\operatorname{tr} A + |a| \sin\varphi + (1 - \cos\varphi)(\lambda - \operatorname{tr} A)`, where a is the torque
(twice the axial part of A) and λ the largest eigenvalue of its symmetric part. So every choice of weights bounds the
largest distance over the ball, and at a local optimum, where its multipliers leave no torque, the bound of a whole
ball around it is its value: the search does not have to split cells down to the accuracy asked for.

The weights of a cell come from the smallest ball that holds the residuals at its centre (the best translation there)
and are then improved by a few ascent steps.

References
----------
Hartley, Kahl (2009), IJCV 82, 64 (branch and bound over rotations in the ball of rotation vectors).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation

MOST_CELLS = 400_000
"""Cells looked at before the search gives up with the bound it has: about two minutes for ten points."""

BATCH = 2048
"""Cells that are bounded at once."""

ASCENT_STEPS = 24
"""Steps of the weights of a cell; more steps bound a cell better, fewer look at more cells in the same time."""


@dataclass(frozen=True, slots=True, eq=False)
class RotationSearch:
    """What the search over all rotations proved.

    Parameters
    ----------
    lower_bound : float
        No rigid transform has a smaller largest distance, mm.
    rotations : ndarray, shape (k, 3, 3)
        Centres of cells that may hold a better answer than the one given; starts for a local solve.
    cells : int
        Cells bounded.
    closed : bool
        Whether no cell was left.
    """

    lower_bound: float
    rotations: FloatArray
    cells: int
    closed: bool


def bound_cells(p: FloatArray, q: FloatArray, R: FloatArray, angle: float) -> tuple[FloatArray, FloatArray]:
    """Bound the largest distance over balls of rotations.

    Parameters
    ----------
    p, q : ndarray, shape (n, 3)
        Points about their centroids, mm.
    R : ndarray, shape (m, 3, 3)
        Centres.
    angle : float
        Radius of the balls, rad.

    Returns
    -------
    bound : ndarray, shape (m,)
        mm.
    value : ndarray, shape (m,)
        Largest distance at the centre with a good translation, mm.
    """
    m, n = len(R), len(p)
    residuals = q - p @ R.transpose(0, 2, 1)
    w = np.full((m, n), 1.0 / n)
    best, value = np.zeros(m), np.full(m, np.inf)
    for k in range(1, ASCENT_STEPS + 1):
        centre = (w[:, None, :] @ residuals)[:, 0]
        squares = np.sum((residuals - centre[:, None, :]) ** 2, axis=2)
        value = np.minimum(value, np.sqrt(squares.max(axis=1)))
        bound, slope = _ball_bound(p, q, R, w, squares=squares, angle=angle)
        best = np.maximum(best, bound)
        w = w * np.exp(slope / np.maximum(slope.max(axis=1, keepdims=True), 1e-300) * (2.0 / np.sqrt(k)))
        w /= w.sum(axis=1, keepdims=True)
    return np.sqrt(best), value


def _ball_bound(
    p: FloatArray, q: FloatArray, R: FloatArray, w: FloatArray, *, squares: FloatArray, angle: float
) -> tuple[FloatArray, FloatArray]:
    """Bound of the squared weighted distances over the balls, and the squared distances where it is reached."""
    p_mean, q_mean = w @ p, w @ q
    B = (q.T * w[:, None, :]) @ p - q_mean[:, :, None] * p_mean[:, None, :]
    A = B.transpose(0, 2, 1) @ R
    trace = np.trace(A, axis1=1, axis2=2)
    symmetric = 0.5 * (A + A.transpose(0, 2, 1))
    values, vectors = np.linalg.eigh(symmetric)
    torque = np.stack([A[:, 1, 2] - A[:, 2, 1], A[:, 2, 0] - A[:, 0, 2], A[:, 0, 1] - A[:, 1, 0]], axis=1)
    strength = np.linalg.norm(torque, axis=1)
    stiffness = trace - values[:, 2]
    turn = np.minimum(np.where(stiffness > 0, np.arctan2(strength, stiffness), angle), angle)
    turn = np.where((stiffness <= 0) & (strength <= 0) & (stiffness == 0), 0.0, turn)
    gain = strength * np.sin(turn) - stiffness * (1.0 - np.cos(turn))
    bound = np.maximum(np.einsum("mi,mi->m", w, squares) - 2.0 * np.maximum(gain, 0.0), 0.0)
    axis = np.where(strength[:, None] > 0, torque / np.maximum(strength, 1e-300)[:, None], vectors[:, :, 2])
    turned = R @ exp_rotation(axis * turn[:, None])
    moved = p @ turned.transpose(0, 2, 1)
    t = q_mean - (turned @ p_mean[:, :, None])[:, :, 0]
    slope = np.sum((q - moved - t[:, None, :]) ** 2, axis=2)
    return bound, slope


def search_rotations(p: FloatArray, q: FloatArray, *, value: float, tolerance: float) -> RotationSearch:
    """Raise the lower bound to `value` - `tolerance`, or find where a better answer may be.

    Parameters
    ----------
    p, q : ndarray, shape (n, 3)
        Points about their centroids, mm.
    value : float
        Largest distance of the best answer known, mm.
    tolerance : float
        Gap to reach, mm.

    Returns
    -------
    RotationSearch
        It ends early with the centres whose largest distance is below `value`.
    """
    half = np.pi / 2  # two cells a side hold the ball of rotation vectors of length up to pi
    centres = half * np.array(list(product((-1.0, 1.0), repeat=3)))
    offsets = np.array(list(product((-0.5, 0.5), repeat=3)))
    cells, proved = 0, value
    goal = value - tolerance
    while len(centres):
        left = []
        for start in range(0, len(centres), BATCH):
            some = centres[start : start + BATCH]
            R = exp_rotation(some)
            bounds, values = bound_cells(p, q, R, min(float(np.sqrt(3.0) * half), np.pi))
            cells += len(some)
            if values.min() < goal:
                return RotationSearch(0.0, R[values < goal], cells, closed=False)
            open_cells = bounds < goal
            left.append((some[open_cells], bounds[open_cells]))
        centres = np.concatenate([c for c, _ in left])
        bounds = np.concatenate([b for _, b in left])
        if cells + 8 * len(centres) > MOST_CELLS:
            proved = float(bounds.min()) if len(bounds) else goal
            return RotationSearch(proved, exp_rotation(centres[np.argsort(bounds)[:32]]), cells, closed=False)
        centres = (centres[:, None, :] + half * offsets).reshape(-1, 3)
        half /= 2
        # A cell that lies outside the ball of radius pi holds rotations that other cells hold.
        centres = centres[np.linalg.norm(centres, axis=1) <= np.pi + np.sqrt(3.0) * half]
    return RotationSearch(goal, np.empty((0, 3, 3)), cells, closed=True)
