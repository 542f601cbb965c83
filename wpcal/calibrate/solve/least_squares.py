r"""The closed-form weighted least-squares fit and the lower bound it proves for the largest distance.

For weights :math:`w` on the simplex the problem :math:`\min_T \sum_i w_i d_i^2` splits: the translation carries one
weighted centroid to the other, and the rotation maximises :math:`\operatorname{tr}(R^\top B)` with
:math:`B = \sum_i w_i \bar q_i \bar p_i^\top`, which one 3×3 singular value decomposition does over *all* rotations.

References: Kabsch, W. (1976), Acta Cryst. A32, 922; Umeyama, S. (1991), IEEE TPAMI 13(4), 376 (the sign that keeps det
R = +1).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wpcal.calibrate.solve.ties import SAME_ROTATION, nearest_rotation_maximising, rotation_is_free
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.transform import RigidTransform

COLLINEAR_RATIO = 1e-6
"""Least ratio of the second to the first spread of the points. At 1e-6 a 0.1 mm error turns a 1 m row of points about
its own line by more than a full turn, so a smaller ratio leaves the rotation unknown for every real teaching error."""


def rotation_maximising(B: FloatArray) -> FloatArray:
    """Rotations, determinant +1, that maximise tr(Rᵀ B); shape (..., 3, 3) in and out."""
    U, _, Vt = np.linalg.svd(B)
    sign = np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    U[..., :, 2] *= sign[..., None]
    return np.asarray(U @ Vt, dtype=np.float64)


def kabsch(p: FloatArray, q: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fit q ≈ R p + t with the least weighted sum of squares; any leading axes are a batch.

    Returns `R`: shape (..., 3, 3).
    Returns `t`: shape (..., 3). mm.

    `p`, `q`: shape (..., n, 3). Source and target points, mm.
    `weights`: shape (..., n). Not negative, each row summing to one.
    """
    w = weights[..., None, :]
    p_mean, q_mean = w @ p, w @ q  # (..., 1, 3)
    B = np.swapaxes(q - q_mean, -1, -2) @ (np.swapaxes(w, -1, -2) * (p - p_mean))
    R = rotation_maximising(B)
    t = (q_mean - p_mean @ np.swapaxes(R, -1, -2))[..., 0, :]
    return R, np.asarray(t, dtype=np.float64)


def distances(p: FloatArray, q: FloatArray, R: FloatArray, t: FloatArray) -> FloatArray:
    """Distances |q - R p - t|, shape (..., n), mm: the d_i of Yin 2003, eq. (3)."""
    residuals = q - p @ np.swapaxes(R, -1, -2) - t[..., None, :]
    return np.asarray(np.sqrt(np.einsum("...ij,...ij->...i", residuals, residuals)), dtype=np.float64)


def fit_least_squares(
    pairs: PointPairs, weights: ArrayLike | None = None, *, nominal: RigidTransform | None = None
) -> RigidTransform:
    """Fit the rigid transform with the least (weighted) sum of squared distances, in closed form.

    Raises `GeometryError` when there are fewer than three pairs or they are collinear or coincident.
    Raises `InputError` when the weights are not n finite numbers that are not negative and not all zero.

    `pairs`: At least three pairs that are not collinear, mm.
    `weights`: shape (n,). Not negative; scaled to sum to one. Equal where not given.
    `nominal`: Of equally good fits, as mirrored or exchanged points have, the one turned least from this is taken. By
    default the one turned least at all.

    Returns: ``T_target_source`` of the pairs' frames. Determinant +1 also for coplanar and for mirrored sets.

    A plate turned by a quarter turn about z and set down 10 mm along x:

    >>> model = [[0, 0, 0], [100, 0, 0], [0, 50, 0]]
    >>> taught = [[10, 0, 0], [10, 100, 0], [-40, 0, 0]]
    >>> T_base_part = fit_least_squares(PointPairs(("a", "b", "c"), model, taught))
    >>> [round(float(v), 6) + 0.0 for v in T_base_part.t_mm]
    [10.0, 0.0, 0.0]
    """
    require_spread(pairs)
    w = np.full(len(pairs), 1.0 / len(pairs)) if weights is None else _simplex(weights, len(pairs))
    return _nearest(pairs, w, np.eye(3) if nominal is None else nominal.R)


def other_least_squares(pairs: PointPairs, T: RigidTransform) -> RigidTransform | None:
    """Return the equally good least-squares fit that is turned furthest from a given one, or None if there is no other.

    `pairs`: mm.
    """
    other = _nearest(pairs, np.full(len(pairs), 1.0 / len(pairs)), -T.R)
    return other if np.abs(other.R - T.R).max() > SAME_ROTATION else None


def _nearest(pairs: PointPairs, w: FloatArray, towards: FloatArray) -> RigidTransform:
    """Of the fits of least weighted sum of squares the one nearest to `towards`, shape (3, 3)."""
    p_mean, q_mean = pairs.p_source.mean(axis=0), pairs.p_target.mean(axis=0)
    p, q = pairs.p_source - p_mean, pairs.p_target - q_mean
    R, t = kabsch(p, q, w)
    u, v = p - w @ p, q - w @ q
    B = (v.T * w) @ u
    if rotation_is_free(B):
        scale = float(w @ (np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)))
        R = nearest_rotation_maximising(B, scale, towards)
        t = w @ q - R @ (w @ p)
    return RigidTransform(R, t + q_mean - R @ p_mean, pairs.target, pairs.source)


def weighted_rms(p: FloatArray, q: FloatArray, weights: FloatArray) -> FloatArray:
    """Least weighted root mean square distance over all rigid motions; batched like `kabsch`, shape (...)."""
    R, t = kabsch(p, q, weights)
    d = distances(p, q, R, t)
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", weights, d**2)), dtype=np.float64)


def centred(points: FloatArray) -> FloatArray:
    """Points, shape (..., n, 3), about their centroid: round-off then depends on the cloud's size, not on its place."""
    return np.asarray(points - points.mean(axis=-2, keepdims=True), dtype=np.float64)


def require_spread(pairs: PointPairs) -> None:
    """Refuse pairs that do not fix the rotation.

    Raises `GeometryError` when there are fewer than three pairs, or the points of either side are coincident or
    collinear.
    """
    if len(pairs) < 3:
        raise GeometryError(f"a rigid fit needs at least 3 pairs of points, got {len(pairs)}")
    for points, side in ((pairs.p_source, "model"), (pairs.p_target, "taught")):
        offsets = centred(points)
        first, second = _spread(offsets)
        if first <= COLLINEAR_RATIO * float(np.abs(points).max()):
            raise GeometryError(f"the {side} points coincide; at least 3 points that are not on one line are needed")
        if second <= COLLINEAR_RATIO * first:
            which = ", ".join(pairs.names[:4]) + (", …" if len(pairs) > 4 else "")
            raise GeometryError(
                f"the {side} points {which} lie on one line; the rotation about it is unknown: "
                "teach a point off the line"
            )


def _spread(offsets: FloatArray) -> tuple[float, float]:
    """First and second singular value. A Gram matrix is fast but loses half of the digits: it decides clear cases."""
    values = np.sqrt(np.maximum(np.linalg.eigvalsh(offsets.T @ offsets), 0.0))
    if values[1] > 1e3 * COLLINEAR_RATIO * values[2]:
        return float(values[2]), float(values[1])
    exact = np.linalg.svd(offsets, compute_uv=False)
    return float(exact[0]), float(exact[1])


def _simplex(weights: ArrayLike, n: int) -> FloatArray:
    w = np.asarray(weights, dtype=np.float64)
    if w.shape != (n,) or not np.isfinite(w).all() or w.min() < 0 or w.sum() <= 0:
        raise InputError(f"expected {n} finite weights, none negative and not all zero, got shape {w.shape}")
    return np.asarray(w / w.sum(), dtype=np.float64)
