r"""Close the gap of a minimax fit by branch and bound over all rotations.

A cell is a ball of rotations about a centre: all within an angle θ of it. For any weights on the simplex

.. math:: \min_{R, t} \sum_i w_i d_i^2 = c(w) - 2 \max_R \operatorname{tr}(R^\top B(w)),

and within the ball :math:`\operatorname{tr}(A \exp([u]_\times \varphi))` with A = B ᵀ R₀ is at most
:math:`\operatorname{tr} A + |a| \sin\varphi + (1 - \cos\varphi)(\lambda - \operatorname{tr} A)`, where a is the torque
(twice the axial part of A) and λ the largest eigenvalue of its symmetric part. So every choice of weights bounds the
largest distance over the ball, and at a local optimum, where its multipliers leave no torque, the bound of a whole
ball around it is its value: the search does not have to split cells down to the accuracy asked for.

The weights of a cell are those of the cell it is a part of or of a pool, the multipliers of the local optima, improved
by ascent steps: with the rotation fixed these lead to the smallest ball that holds the residuals, the best
translation. Because the parts go on from the weights of the whole, the weights keep up with the size of the cells.

References: Hartley, Kahl (2009), IJCV 82, 64 (branch and bound over rotations in the ball of rotation vectors).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation

MOST_CELLS = 3_000_000
"""Cells looked at before the search gives up with the bound it has: about two minutes for ten points. Mirrored bodies
take some thousands; five unrelated pairs of points took a million."""
BATCH = 2048  #: Cells that are bounded at once.
ASCENT_STEPS = 40
"""Steps of the weights of a cell; more steps bound a cell better, fewer look at more cells in the same time."""
STEP = 0.3
"""Exponent of a step. 1 is the first order of Lawson's update with squared distances. On mirrored bodies 1.5 left gaps
open, and 0.3 needed fewer cells than 0.7."""
MOST_RISE = 4.0
"""A squared distance counts for at most this many times the mean in one step; a large ball may hold a perfect fit."""
POOL_UNTIL = 0.1
"""Half side, rad, down to which cells try the whole pool; smaller ones go on from the weights of their parent."""
TINY = 1e-300  #: Keeps a division by a zero that is then multiplied by zero.


@dataclass(frozen=True, slots=True, eq=False)
class RotationSearch:
    """What the search over all rotations proved."""

    lower_bound: float  #: No rigid transform has a smaller largest distance, mm.
    #: shape (k, 3, 3). Centres of cells that may hold a better answer than the one given; starts for a local solve.
    rotations: FloatArray
    cells: int  #: Cells bounded.
    closed: bool  #: Whether no cell was left.


@dataclass(frozen=True, slots=True, eq=False)
class CellBounds:
    """What is known of a batch of m cells."""

    bound: FloatArray  #: shape (m,). Lower bound of the largest distance over the cell, mm.
    value: FloatArray  #: shape (m,). Largest distance at the centre with a good translation, mm.
    weights: FloatArray  #: shape (m, n). The weights that bound best; a start for the parts of the cell.


def bound_cells(
    p: FloatArray, q: FloatArray, R: FloatArray, weights: FloatArray, *, angle: float, goal: float
) -> CellBounds:
    """Bound the largest distance over balls of rotations.

    `p`, `q`: shape (n, 3). Points about their centroids, mm.
    `R`: shape (m, 3, 3). Centres.
    `weights`: shape (m, k, n). For every ball k weights to start from, rows on the simplex.
    `angle`: Radius of the balls, rad.
    `goal`: A ball is left alone once its bound has reached this, mm.
    """
    residuals = q - p @ R.transpose(0, 2, 1)
    best, value = np.full(len(R), -1.0), np.full(len(R), np.inf)
    best_weights = weights[:, 0].copy()
    rows = np.arange(len(R))

    def look(w: FloatArray) -> FloatArray:
        bound, slope, at_centre = _ball_bound(p, q, R[rows], w, residuals[rows], angle)
        better = bound > best[rows]
        best[rows[better]], best_weights[rows[better]] = bound[better], w[better]
        value[rows] = np.minimum(value[rows], at_centre)
        return slope

    for k in range(weights.shape[1]):
        look(weights[rows, k])
        rows = rows[best[rows] < goal]
    # A weight of zero could never grow; the weights of a cell differ from those of its parent by the order of its size.
    w = best_weights[rows] + 0.1 * min(angle, 1.0) / len(p)
    w /= w.sum(axis=1, keepdims=True)
    for _ in range(ASCENT_STEPS):
        if not len(rows):
            break
        slope = look(w)
        mean = np.maximum(np.einsum("mi,mi->m", w, slope), TINY)[:, None]
        w = w * np.exp(STEP * np.minimum(slope / mean, MOST_RISE))
        w /= w.sum(axis=1, keepdims=True)
        still = best[rows] < goal
        rows, w = rows[still], w[still]
    return CellBounds(best, value, best_weights)


def _ball_bound(
    p: FloatArray, q: FloatArray, R: FloatArray, w: FloatArray, residuals: FloatArray, angle: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Bounds over the balls, squared distances where they are nearly reached, and largest distances at the centres."""
    centre = w[:, None, :] @ residuals
    squares = np.sum((residuals - centre) ** 2, axis=2)
    p_mean, q_mean = w @ p, w @ q
    B = (q.T * w[:, None, :]) @ p - q_mean[:, :, None] * p_mean[:, None, :]
    A = B.transpose(0, 2, 1) @ R
    torque = np.stack([A[:, 1, 2] - A[:, 2, 1], A[:, 2, 0] - A[:, 0, 2], A[:, 0, 1] - A[:, 1, 0]], axis=1)
    strength = np.linalg.norm(torque, axis=1)
    largest = np.linalg.eigvalsh(0.5 * (A + A.transpose(0, 2, 1)))[:, 2]
    stiffness = np.trace(A, axis1=1, axis2=2) - largest
    # |a| sin φ - κ (1 - cos φ) is largest at tan φ = |a| / κ, or at the rim of the ball
    turn = np.minimum(np.arctan2(strength, stiffness), angle)
    gain = strength * np.sin(turn) - stiffness * (1.0 - np.cos(turn))
    bound = np.sqrt(np.maximum(np.einsum("mi,mi->m", w, squares) - 2.0 * gain, 0.0))
    turned = R @ exp_rotation(torque * (turn / np.maximum(strength, TINY))[:, None])
    t = q_mean - (turned @ p_mean[:, :, None])[:, :, 0]
    slope = np.sum((q - p @ turned.transpose(0, 2, 1) - t[:, None, :]) ** 2, axis=2)
    return bound, slope, np.sqrt(squares.max(axis=1))


def search_rotations(
    p: FloatArray, q: FloatArray, *, value: float, tolerance: float, pool: FloatArray
) -> RotationSearch:
    """Raise the lower bound to `value` - `tolerance`, or find where a better answer may be.

    Returns: It ends early with the centres whose largest distance is below `value`.

    `p`, `q`: shape (n, 3). Points about their centroids, mm.
    `value`: Largest distance of the best answer known, mm.
    `tolerance`: Gap to reach, mm.
    `pool`: shape (k, n). Weights to try first, rows on the simplex.
    """
    half = np.pi / 2  # two cells a side hold the ball of rotation vectors of length up to pi
    centres = half * np.array(list(product((-1.0, 1.0), repeat=3)))
    weights = np.broadcast_to(pool, (len(centres), *pool.shape))
    cells, goal = 0, value - tolerance
    while len(centres):
        angle = min(float(np.sqrt(3.0) * half), np.pi)
        found = _bound_in_batches(p, q, centres, weights, angle=angle, goal=goal)
        cells += len(centres)
        if found.value.min() < goal:
            starts = centres[np.argsort(found.value)][: np.count_nonzero(found.value < goal)]
            return RotationSearch(0.0, exp_rotation(starts), cells, closed=False)
        left = found.bound < goal
        if cells + 8 * np.count_nonzero(left) > MOST_CELLS:
            order = np.argsort(found.bound)
            return RotationSearch(float(found.bound.min()), exp_rotation(centres[order]), cells, closed=False)
        centres, weights = _split(centres[left], found.weights[left], half)
        half /= 2
        if half > POOL_UNTIL:
            weights = np.concatenate([weights, np.broadcast_to(pool, (len(centres), *pool.shape))], axis=1)
    return RotationSearch(goal, np.empty((0, 3, 3)), cells, closed=True)


def _split(centres: FloatArray, weights: FloatArray, half: float) -> tuple[FloatArray, FloatArray]:
    """The eight parts of every cell, each with the weights of the whole; shapes (m, 3) and (m, 1, n)."""
    offsets = 0.5 * half * np.array(list(product((-1.0, 1.0), repeat=3)))
    parts = (centres[:, None, :] + offsets).reshape(-1, 3)
    # A part that lies outside the ball of radius pi holds rotations that other cells hold.
    inside = np.linalg.norm(parts, axis=1) <= np.pi + 0.5 * np.sqrt(3.0) * half
    return parts[inside], np.repeat(weights, 8, axis=0)[inside, None, :]


def _bound_in_batches(
    p: FloatArray, q: FloatArray, centres: FloatArray, weights: FloatArray, *, angle: float, goal: float
) -> CellBounds:
    batches = [slice(start, start + BATCH) for start in range(0, len(centres), BATCH)]
    found = [bound_cells(p, q, exp_rotation(centres[b]), weights[b], angle=angle, goal=goal) for b in batches]
    return CellBounds(
        np.concatenate([f.bound for f in found]),
        np.concatenate([f.value for f in found]),
        np.concatenate([f.weights for f in found]),
    )
