r"""One answer if the least largest distance leaves a motion free.

At the optimum with multipliers :math:`w`, :math:`\sum_i w_i d_i^2` has its least value there, so every other optimum
has the points with :math:`w_i > 0` in the same places. If they do not lie on a line the optimum is unique. If they do
(two points that pull in opposite directions are enough) the part may turn about that line until another point is as far
off. Of all these fits the one with the least sum of squares is taken: it does not depend on where the search began.

Turned by θ about the line, a point has the squared distance

.. math:: s(\theta) = s(0) + 2 C (1 - \cos\theta) - 2 S \sin\theta,

so the angles that a point forbids are one open arc, with the roots of a quadratic in tan(θ/2) as its ends. The sum of
squares has the same form, with one valley. The allowed angles are the gaps between the arcs, and the least sum of
squares is in the valley or at the end of a gap: a finite choice, not a search.
"""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation

CARRIES = 1e-6
"""A point with a smaller share of the multipliers does not carry: the solver leaves 1e-9 and less on such points."""
COLLINEAR = 1e-6
"""Carrying points whose spread across their line is this share of their spread along it lie on the line."""
TOUCH = 1e-12  #: A distance above the limit by less than this share of the cloud's size touches it.
FULL_TURN = 2.0 * np.pi
TINY = 1e-300  #: Keeps a division by a zero that is then not used.


def break_ties(
    p: FloatArray, q: FloatArray, R: FloatArray, t: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Turn minimax fits about the line of their carrying points to the least sum of squares.

    Parameters
    ----------
    p, q : shape (B, n, 3). Points of B problems, source and target, mm.
    R, t : shapes (B, 3, 3) and (B, 3). Minimax fits, ``q ≈ R p + t``.
    weights : shape (B, n). Their multipliers.

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
    loose = np.flatnonzero((spread[:, 1] <= COLLINEAR * spread[:, 0]) & (spread[:, 0] > 0))
    if not len(loose):
        return R, t
    axis, about = axes[loose, 0], centre[loose]
    angle = _best_angle(moved[loose] - about[:, None], q[loose] - about[:, None], axis, w[loose] > 0)
    turn = exp_rotation(angle[:, None] * axis)
    R, t = R.copy(), t.copy()
    R[loose], t[loose] = turn @ R[loose], about + np.einsum("bij,bj->bi", turn, t[loose] - about)
    return R, t


def _best_angle(u: FloatArray, v: FloatArray, axis: FloatArray, carries: FloatArray) -> FloatArray:
    """Angle about an axis through the origin that brings u nearest to v while no distance exceeds the largest one now.

    The carrying points lie on the axis: what they seem to move is round-off and does not limit the turn.
    """
    residual = v - u
    across = u - np.einsum("bni,bi->bn", u, axis)[..., None] * axis[:, None]
    cosine = np.einsum("bni,bni->bn", across, v)
    sine = np.einsum("bni,bni->bn", np.cross(axis[:, None], across), residual)
    squares = np.einsum("bni,bni->bn", residual, residual)
    room = np.maximum(squares.max(axis=1, keepdims=True) - squares, 0.0)
    starts, ends = _forbidden(cosine, sine, np.where(carries, np.inf, room))
    order = np.argsort(starts, axis=1)
    starts = np.take_along_axis(starts, order, axis=1)
    ends = np.maximum.accumulate(np.take_along_axis(ends, order, axis=1), axis=1)
    zero, full = np.zeros((len(u), 1)), np.full((len(u), 1), FULL_TURN)
    low, high = np.hstack([zero, ends]), np.hstack([starts, full])
    # The derivative of the sum of squares vanishes here; the cosine tells how near an angle is to the valley.
    valley = np.mod(np.arctan2(sine.sum(axis=1), cosine.sum(axis=1)), FULL_TURN)[:, None]
    nearer = np.where(np.cos(low - valley) >= np.cos(high - valley), low, high)
    best = np.where((low <= valley) & (valley <= high), valley, nearer)
    depth = np.where(low <= high, np.cos(best - valley), -np.inf)
    best = np.take_along_axis(best, np.argmax(depth, axis=1)[:, None], axis=1)
    # A limit that is touched in the valley itself, as by symmetric sets, would hold the turn by its round-off.
    over = 2.0 * cosine * (1.0 - np.cos(valley)) - 2.0 * sine * np.sin(valley) - room
    touch = 2.0 * TOUCH * np.sqrt(squares.max(axis=1) * np.mean(np.sum(u**2, axis=2), axis=1))
    return np.where(np.where(carries, -np.inf, over).max(axis=1) <= touch, valley[:, 0], best[:, 0])


def _forbidden(cosine: FloatArray, sine: FloatArray, room: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Start and end, in 0 to 2π, of the angles at which 2 C (1 - cos θ) - 2 S sin θ exceeds `room`; shapes (B, n).

    With τ = tan(θ/2) that is A τ² - 4 S τ - room > 0, A = 4 C - room. An empty arc starts and ends at 2π.
    """
    bounded = np.isfinite(room)
    c = np.where(bounded, room, 0.0)
    A = 4.0 * cosine - c
    discriminant = 4.0 * sine**2 + A * c
    root = np.sqrt(np.maximum(discriminant, 0.0))
    big = 2.0 * sine + np.where(sine >= 0, root, -root)  # of the two, the sum without cancellation
    first = np.arctan2(np.sign(A) * big, np.abs(A))
    second = np.arctan2(-c * np.sign(big), np.maximum(np.abs(big), TINY))
    angles = np.sort(np.mod(2.0 * np.stack([first, second]), FULL_TURN), axis=0)
    # Just after the first root the arc is forbidden, unless zero is a root and the distance falls there.
    ends = np.where((angles[0] == 0.0) & (sine > 0), FULL_TURN, angles[1])
    starts = np.where((angles[0] == 0.0) & (sine > 0), angles[1], angles[0])
    none = ~bounded | (discriminant <= 0.0)
    return np.where(none, FULL_TURN, starts), np.where(none, FULL_TURN, ends)
