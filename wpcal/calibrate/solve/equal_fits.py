r"""One answer where several fits are equally good, by a rule that no round-off, seed or order of points can change.

If the points lie symmetrically and names are exchanged, a fit has copies that fit as well. A symmetry of the problem is
a permutation of the points that keeps all distances among the model points and all distances among the taught points.
It belongs to an isometry g of the model points and an isometry h of the taught points, and carries a fit R to the
equally good fit :math:`h R g^\top`. A permutation may also exchange the two sides, as two exchanged names do: g
carries the model points to taught ones and h back, and the fit is :math:`g R^\top h^\top`. So one copy of each kind is
enough to know them all.

Of equally good fits the one nearest to a given rotation is taken. If several are equally near, two further rotations
decide, which are the same in every problem and lie in no special place.
"""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.rotations import rotation_from_zyx

SAME_LENGTH = 1e-9
"""Lengths that differ by less than this share of the cloud's size are equal. Coordinates of 1e6 mm leave 1e-10 mm."""
TIED = 1e-9
"""Singular values, eigenvalues and cosines that differ by less than this share cannot be told apart."""
SAME_ROTATION = 1e-6  #: Rotations whose matrices differ by less are one.
MOST_SYMMETRIES = 480
"""Permutations that are followed. Bodies in space have at most 120, flat rings of n points 2 n. While the first points
are placed there may be n² of them."""
FURTHER = rotation_from_zyx([0.0, 0.7, -1.9], [0.0, -0.4, 0.9], [0.0, 1.3, 2.6])[1:]
"""Rotations in no special place, for fits that are equally near to the one that was asked for."""


def nearest_fit(R: FloatArray, towards: FloatArray) -> int:
    """Return which of equally good rotations is nearest to a given one.

    `R`: ndarray, shape (k, 3, 3).
    `towards`: ndarray, shape (3, 3).
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

    `B`: ndarray, shape (3, 3).
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
    Returns `R, t`: ndarray, shapes (m, 3, 3) and (m, 3). All fits, each rotation once.
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
