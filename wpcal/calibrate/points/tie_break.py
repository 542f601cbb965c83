r"""One answer if the least largest distance leaves a motion free.

At the optimum with multipliers :math:`w`, :math:`\sum_i w_i d_i^2` has its least value there, so every other optimum
has the points with :math:`w_i > 0` in the same places. If they do not lie on a line the optimum is unique. If they do
(two points that pull in opposite directions are enough) the part may turn about that line until another point is as far
off. Of all these fits the one with the least sum of squares is taken: it does not depend on where the search began.
"""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation

CARRIES = 1e-6
"""A point with a smaller share of the multipliers does not carry: the solver leaves 1e-9 and less on such points."""
STAYS = 1e-11
"""A point whose squared distance changes by less than this share of the largest one lies on the line itself."""
COLLINEAR = 1e-6
"""Carrying points whose spread across their line is this share of their spread along it lie on the line."""


def break_ties(
    p: FloatArray, q: FloatArray, R: FloatArray, t: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Turn minimax fits about the line of their carrying points to the least sum of squares.

    Parameters
    ----------
    p, q : ndarray, shape (B, n, 3)
        Points of B problems, source and target, mm.
    R, t : ndarray, shapes (B, 3, 3) and (B, 3)
        Minimax fits, ``q ≈ R p + t``.
    weights : ndarray, shape (B, n)
        Their multipliers.

    Returns
    -------
    R, t : ndarray
        Fits with the same largest distance within round-off. Those whose carrying points do not lie on one line are
        returned as they came.
    """
    moved = np.einsum("bij,bnj->bni", R, p) + t[:, None]
    w = np.where(weights > CARRIES * weights.max(axis=1, keepdims=True), weights, 0.0)
    w = w / w.sum(axis=1, keepdims=True)
    centre = np.einsum("bn,bni->bi", w, moved)
    _, spread, axes = np.linalg.svd(np.sqrt(w)[..., None] * (moved - centre[:, None]), full_matrices=False)
    loose = (spread[:, 1] <= COLLINEAR * spread[:, 0]) & (spread[:, 0] > 0)
    axis = axes[:, 0]
    angle = np.where(loose, _best_angle(moved - centre[:, None], q - centre[:, None], axis), 0.0)
    turn = exp_rotation(angle[:, None] * axis)
    return turn @ R, centre + np.einsum("bij,bj->bi", turn, t - centre)


def _best_angle(u: FloatArray, v: FloatArray, axis: FloatArray) -> FloatArray:
    """Angle about an axis through the origin that brings u nearest to v while no distance exceeds the largest one now.

    Of points u turned by θ, the squared distance is ``a - 2 b cos(θ - φ)``: below the largest one it holds θ to an
    interval about φ, and the sum of squares has one valley within half a turn.
    """
    across_u = u - np.einsum("bni,bi->bn", u, axis)[..., None] * axis[:, None]
    cosine = np.einsum("bni,bni->bn", across_u, v)
    sine = np.einsum("bni,bni->bn", np.cross(axis[:, None], across_u), v)
    squares = ((u - v) ** 2).sum(axis=2)
    largest = squares.max(axis=1, keepdims=True)
    b, phi = np.hypot(cosine, sine), np.arctan2(sine, cosine)
    a = squares + 2.0 * cosine
    free = b <= STAYS * largest
    share = (a - largest) / np.where(free, 1.0, 2.0 * b)
    half = np.where(free | (share <= -1.0), np.inf, np.arccos(np.clip(share, -1.0, 1.0)))
    low = np.minimum((phi - half).max(axis=1), 0.0)
    high = np.maximum((phi + half).min(axis=1), 0.0)
    return np.asarray(np.clip(np.arctan2(sine.sum(axis=1), cosine.sum(axis=1)), low, high), dtype=np.float64)
