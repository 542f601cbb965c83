r"""One answer where several fits are equally good, by a rule that no round-off, seed or order of points can change.

If the points lie symmetrically and names are exchanged, a fit has copies that fit as well. A symmetry of the problem is
a permutation of the points that keeps all distances among the model points and all distances among the taught points.
It belongs to an isometry g of the model points and an isometry h of the taught points, and carries a fit R to the
equally good fit :math:`h R g^\top`. A permutation may also exchange the two sides, as two exchanged names do: g
carries the model points to taught ones and h back, and the fit is :math:`g R^\top h^\top`. So one copy of each kind is
enough to know them all.

Of equally good fits the one nearest to a given rotation is taken. If several are equally near, two further rotations
decide, which are the same in every problem and lie in no special place.

A minimax fit may also leave a motion free (`break_ties`). With the multipliers :math:`w` of the optimum,
:math:`\sum_i w_i d_i^2` has its least value there, so every other optimum has the points with :math:`w_i > 0` in the
same places. If they do not lie on a line the optimum is unique. If they do (two points that pull in opposite directions
are enough) the part may turn about that line until another point is as far off. Of all these fits the one with the
least sum of squares is taken: it does not depend on where the search began.

Turned by θ about the line, a point has the squared distance

.. math:: s(\theta) = s(0) + 2 C (1 - \cos\theta) - 2 S \sin\theta,

so the angles that a point forbids are one open arc, with the roots of a quadratic in tan(θ/2) as its ends. The sum of
squares has the same form, with one valley. The allowed angles are the gaps between the arcs, and the least sum of
squares is in the valley or at the end of a gap: a finite choice, not a search.
"""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.tangent import exp_rotation

SAME_LENGTH = 1e-9
"""Lengths that differ by less than this share of the cloud's size are equal. Coordinates of 1e6 mm leave 1e-10 mm."""
TIED = 1e-9  #: Singular values, eigenvalues and cosines that differ by less than this share cannot be told apart.
SAME_ROTATION = 1e-6  #: Rotations whose matrices differ by less are one.
MOST_SYMMETRIES = 480
"""Permutations that are followed. Bodies in space have at most 120, flat rings of n points 2 n. While the first points
are placed there may be n² of them."""
FURTHER = rotation_from_zyx([0.0, 0.7, -1.9], [0.0, -0.4, 0.9], [0.0, 1.3, 2.6])[1:]
"""Rotations in no special place, for fits that are equally near to the one that was asked for."""


def nearest_fit(R: FloatArray, towards: FloatArray) -> int:
    """Return which of equally good rotations is nearest to a given one.

    `R`: shape (k, 3, 3).
    `towards`: shape (3, 3).
    """
    left = np.arange(len(R))
    for aim in (towards, *FURTHER):
        near = np.einsum("ij,kij->k", aim, R[left])  # 1 + 2 cos of the angle between
        left = left[near >= near.max() - SAME_ROTATION]
    return int(left[0])


def distinct_fits(R: FloatArray, *, same: float = SAME_ROTATION) -> IntArray:
    """Return the rows of rotations, shape (k, 3, 3), that differ by more than `same` from all rows before them."""
    kept: list[int] = []
    for row, each in enumerate(R):
        if all(np.abs(each - R[other]).max() > same for other in kept):
            kept.append(row)
    return np.array(kept)


def rotation_is_free(B: FloatArray) -> bool:
    """Tell whether several rotations R have the greatest tr(Rᵀ B); B of shape (3, 3)."""
    U, s, Vt = np.linalg.svd(B)
    return bool(s[1] + np.sign(np.linalg.det(U @ Vt)) * s[2] <= TIED * s[0])


def nearest_rotation_maximising(B: FloatArray, scale: float, towards: FloatArray) -> FloatArray:
    r"""Of the rotations with the greatest tr(Rᵀ B) return the one nearest to a given rotation, shape (3, 3).

    With :math:`B = U \operatorname{diag}(s_1, s_2, s_3) V^\top`, U and V proper and :math:`s_1 \ge s_2 \ge |s_3|`, it
    is one rotation unless :math:`s_2 + s_3 = 0`. Then R may turn about the first axis. If :math:`s_1 = s_2` as well,
    :math:`R = U (I - 2 n n^\top) \operatorname{diag}(1, 1, -1) V^\top` is as good for every unit vector n. If B is
    zero, every rotation is as good.

    `B`: shape (3, 3).
    `towards`: shape (3, 3). A rotation, or the negative of one: the result is then furthest from it.
    """
    U, s, Vt = np.linalg.svd(B)
    if s[0] <= TIED * scale:
        U, _, Vt = np.linalg.svd(towards)
        return np.asarray(U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt)
    sense = float(np.sign(np.linalg.det(U @ Vt)))
    U = U * [1.0, 1.0, sense]
    if s[1] + sense * s[2] > TIED * s[0]:
        return np.asarray(U @ Vt)
    if s[0] - s[1] <= TIED * s[0]:
        return np.asarray(U @ _nearest_reflection(U, Vt, towards) @ np.diag([1.0, 1.0, -1.0]) @ Vt)
    for aim in (towards, *FURTHER):
        M = U.T @ aim @ Vt.T
        sine, cosine = M[2, 1] - M[1, 2], M[1, 1] + M[2, 2]
        if np.hypot(sine, cosine) > TIED:
            break
    angle = float(np.arctan2(sine, cosine))
    return np.asarray(U @ rotation_from_zyx(angle, 0.0, 0.0) @ Vt)


def _nearest_reflection(U: FloatArray, Vt: FloatArray, towards: FloatArray) -> FloatArray:
    """Return the I - 2 n nᵀ whose rotation is nearest: n has the least nᵀ N n with N = diag(1, 1, -1) Vᵀ Gᵀ U."""
    basis = np.eye(3)
    for aim in (towards, *FURTHER):
        N = np.diag([1.0, 1.0, -1.0]) @ Vt @ aim.T @ U
        values, vectors = np.linalg.eigh(basis.T @ (N + N.T) @ basis)
        basis = basis @ vectors[:, values <= values[0] + TIED]
        if basis.shape[1] == 1:
            break
    n = basis[:, 0]
    return np.asarray(np.eye(3) - 2.0 * np.outer(n, n))


def with_copies(p: FloatArray, q: FloatArray, R: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Add the copies of fits that the symmetry of the points makes as good.

    `p`, `q`: shape (n, 3). Points about their centroids, mm.
    `R`, `t`: shapes (k, 3, 3) and (k, 3). Fits.
    Returns `R, t`: shapes (m, 3, 3) and (m, 3). All fits, each rotation once.
    """
    g, h = _isometries((p, q), (p, q))
    turned = [R, (h[:, None] @ R @ g[:, None].transpose(0, 1, 3, 2)).reshape(-1, 3, 3)]
    shifted = [t, np.einsum("sij,kj->ski", h, t).reshape(-1, 3)]
    g, h = _isometries((p, q), (q, p))
    back = R.transpose(0, 2, 1)
    turned.append((g[:, None] @ back @ h[:, None].transpose(0, 1, 3, 2)).reshape(-1, 3, 3))
    shifted.append(-np.einsum("sij,kjl,kl->ski", g, back, t).reshape(-1, 3))
    turns, shifts = np.concatenate(turned), np.concatenate(shifted)
    kept = distinct_fits(turns)
    return turns[kept], shifts[kept]


def _isometries(
    sides: tuple[FloatArray, FloatArray], images: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return pairs of isometries (m, 3, 3) that carry both sides to their images: both proper or both improper."""
    found = []
    for order in _symmetries(sides, images):
        g, g_is_flat = _isometry(sides[0], images[0][order])
        h, h_is_flat = _isometry(sides[1], images[1][order])
        if np.linalg.det(g) * np.linalg.det(h) < 0:
            if g_is_flat:
                g = _isometry(sides[0], images[0][order], flip=True)[0]
            elif h_is_flat:
                h = _isometry(sides[1], images[1][order], flip=True)[0]
            else:
                continue
        found.append((g, h))
    pairs = np.array(found).reshape(-1, 2, 3, 3)
    return pairs[:, 0], pairs[:, 1]


def _isometry(source: FloatArray, target: FloatArray, *, flip: bool = False) -> tuple[FloatArray, bool]:
    """Orthogonal matrix that carries centred points to others, and whether flat points leave its sign open."""
    U, s, Vt = np.linalg.svd(target.T @ source)
    if flip:
        U = U * [1.0, 1.0, -1.0]
    return np.asarray(U @ Vt), bool(s[2] <= TIED * s[0])


def _symmetries(sides: tuple[FloatArray, FloatArray], images: tuple[FloatArray, FloatArray]) -> IntArray:
    """Permutations, shape (m, n), after which the images have the distances of the sides; of too many, none."""
    n = len(sides[0])
    D, E = (np.stack([np.linalg.norm(x[:, None] - x[None], axis=2) for x in both]) for both in (sides, images))
    near = SAME_LENGTH * D.max(axis=(1, 2))[:, None, None, None]
    orders = np.empty((1, 0), dtype=np.int64)
    for k in range(n):
        free = np.all(orders[:, :, None] != np.arange(n), axis=1)  # (m, n)
        fits = np.abs(E[:, orders].transpose(0, 1, 3, 2) - D[:, k, :k][:, None, None, :]) <= near
        row, image = np.nonzero(free & fits.all(axis=(0, 3)))
        orders = np.column_stack([orders[row], image])
        if len(orders) > MOST_SYMMETRIES + n * n:
            return np.empty((0, n), dtype=np.int64)
    return orders


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

    `p`, `q`: shape (B, n, 3). Points of B problems, source and target, mm.
    `R`, `t`: shapes (B, 3, 3) and (B, 3). Minimax fits, ``q ≈ R p + t``.
    `weights`: shape (B, n). Their multipliers.

    Returns `R`, `t`: Fits with the same largest distance within round-off. Those whose carrying points do not lie on
    one line are returned as they came.
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
