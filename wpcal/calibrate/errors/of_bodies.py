r"""The error of points where two moved faces meet.

A point stays on both faces, and its plane across the seam goes with the wall. Small motions of the two bodies move it
by dp with

.. math:: n_w \cdot dp = n_w \cdot dp_w, \quad n_b \cdot dp = n_b \cdot dp_b, \quad x \cdot dp = x \cdot dp_w,

where :math:`dp_w` and :math:`dp_b` are the motions of the material of wall and base at the point. Where faces do not
fix the place, it goes with the mean of both bodies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from scipy.special import ndtri

from wpcal.calibrate.errors.prediction import COVERAGE, length_quantile, symmetric_root
from wpcal.calibrate.observe.motions import Motions
from wpcal.calibrate.solve.bodies import BodiesFit
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.tangent import point_jacobian

SAMPLES = 2000
MOST_POINTS = 200  #: The largest error of all seams is among the points with the largest errors of their own.


@dataclass(frozen=True, slots=True, eq=False)
class MeetingPoints:
    """n points at which two moved faces meet, in `part`, after the motions."""

    p_part: FloatArray  #: shape (n, 3).
    wall_body: IntArray  #: shape (n,), as `base_body`. -1: a face that does not move within the part.
    base_body: IntArray
    #: `n_wall`, `n_base`, `x`: shape (n, 3). Outward normals of the faces, and of the plane that goes with the wall,
    #: across the seam.
    n_wall: FloatArray
    n_base: FloatArray
    x: FloatArray
    is_met: BoolArray  #: shape (n,). Whether the faces fix the place across the seam.

    @classmethod
    def on(cls, body: IntArray, p_part: FloatArray) -> MeetingPoints:
        """Return points that go with one body each; shapes (n,) and (n, 3), `part` after the motions, mm."""
        nothing = np.zeros_like(p_part)
        return cls(p_part, body, body, nothing, nothing, nothing, np.zeros(len(p_part), dtype=np.bool_))

    @classmethod
    def joined(cls, several: Sequence[MeetingPoints]) -> MeetingPoints:
        """Return the points of several seams together."""
        return cls(*(np.concatenate([getattr(each, field.name) for each in several]) for field in fields(cls)))

    def select(self, rows: IntArray) -> MeetingPoints:
        """Return the points at `rows`, of shape (k,)."""
        return MeetingPoints(*(getattr(self, field.name)[rows] for field in fields(self)))


@dataclass(frozen=True, slots=True, eq=False)
class MeetingErrors:
    """95 % errors of points, mm, each of shape (n,)."""

    total_mm: FloatArray
    across_mm: FloatArray  #: Across the seam. A seam goes on along itself, so only its ends see the rest.
    placing_mm: FloatArray  #: What the errors of the touches leave.
    unseen_mm: FloatArray  #: What motions of the bodies leave that no touch saw.


def meeting_jacobian(motions: Motions, points: MeetingPoints) -> FloatArray:
    """Differentiate points by the motions of `BodiesFit.covariance`.

    Returns shape (n, 3, 6 + 6 b + k). In `base`, mm per rad and per mm.
    """
    T, n = motions.T_base_part, len(points.p_part)
    A = np.stack([points.n_wall, points.n_base, points.x], axis=1)
    B_wall = np.stack([points.n_wall, np.zeros((n, 3)), points.x], axis=1)
    B_base = np.stack([np.zeros((n, 3)), points.n_base, np.zeros((n, 3))], axis=1)
    A[~points.is_met], B_wall[~points.is_met], B_base[~points.is_met] = np.eye(3), np.eye(3) / 2.0, np.eye(3) / 2.0
    by_wall, by_base = (_by_motions(motions, body, points.p_part) for body in (points.wall_body, points.base_body))
    own = np.linalg.solve(A, B_wall @ by_wall + B_base @ by_base)
    return np.concatenate([point_jacobian(T.apply(points.p_part)), T.R @ own], axis=2)


def meeting_errors(fit: BodiesFit, points: MeetingPoints) -> MeetingErrors:
    """Return the 95 % errors of points where moved faces meet."""
    found = np.empty((4, len(points.p_part)))
    pairs, pair = np.unique(np.stack([points.wall_body, points.base_body]), axis=1, return_inverse=True)
    for number in range(pairs.shape[1]):  # points of two bodies depend on few of the unknowns
        rows = np.flatnonzero(pair == number)
        found[:, rows] = _errors_of_pair(fit, points.select(rows))
    return MeetingErrors(*found)


def _errors_of_pair(fit: BodiesFit, points: MeetingPoints) -> FloatArray:
    """Return the fields of `MeetingErrors` of points between the same two bodies, shape (4, n)."""
    J, rest = error_jacobian(fit, points)
    used = np.flatnonzero(J.any(axis=(0, 1)))
    J, own = J[:, :, used], np.ix_(used, used)
    total, unseen = (J @ C[own] @ J.transpose(0, 2, 1) for C in (fit.covariance, fit.unseen))
    total = total + np.diag(rest)[:, None, None] * np.eye(3)
    x = points.x @ fit.T_base_part.R.T
    to_across = np.eye(3) - x[:, :, None] * x[:, None, :]
    each = (total, to_across @ total @ to_across, total - unseen, unseen)
    return np.stack([length_quantile(C, COVERAGE) for C in each])


def error_jacobian(fit: BodiesFit, points: MeetingPoints) -> tuple[FloatArray, FloatArray]:
    """Return how the wire misses points by the unknowns of a fit, and the covariance per axis of what none stands for.

    Returns tuple of ndarray, shapes (n, 3, m) and (n, n). mm; of `BodiesFit.covariance`.
    """
    J = meeting_jacobian(fit.motions, points)
    if fit.modes is None:
        return J, np.zeros((len(J), len(J)))
    places = fit.T_base_part.apply(points.p_part)
    return np.concatenate([J, fit.modes.at(places)], axis=2), fit.modes.rest(places)


def joint_error(J: FloatArray, covariance: FloatArray, rest: FloatArray | None = None) -> float:
    """Return the length that no point's error exceeds, with 95 % probability, mm.

    Every point stays below its own 95 % error with 95 % probability. That all of them do is less probable.

    `J`: shape (n, 3, m). Derivative of n points by m unknowns. The `MOST_POINTS` with the largest errors of their own
    are drawn.
    `covariance`: shape (m, m). Of the unknowns.
    `rest`: shape (n, n), optional. Covariance per axis of what is independent of them, mm².
    """
    if len(J) > MOST_POINTS:
        own = J @ covariance @ J.transpose(0, 2, 1)
        own = own if rest is None else own + np.diag(rest)[:, None, None] * np.eye(3)
        worst = np.argsort(-length_quantile(own, COVERAGE), kind="stable")[:MOST_POINTS]
        J, rest = J[worst], None if rest is None else rest[np.ix_(worst, worst)]
    rng = np.random.default_rng(0)
    drawn = symmetric_root(covariance) @ rng.standard_normal((len(covariance), SAMPLES))
    off = (J.reshape(-1, J.shape[2]) @ drawn).reshape(len(J), 3, SAMPLES)
    if rest is not None:
        off += np.tensordot(symmetric_root(rest), rng.standard_normal((len(J), 3, SAMPLES)), axes=1)
    return float(np.quantile(np.linalg.norm(off, axis=1).max(axis=0), COVERAGE))


def gap_errors_mm(fit: BodiesFit, points: MeetingPoints) -> FloatArray:
    """Return the 95 % errors of the gaps between the bodies of the wall and the faces of the base.

    Returns shape (n,). A gap is off by more, to either side, with 5 % probability; mm.
    """
    by_wall, by_base = (_by_motions(fit.motions, body, points.p_part) for body in (points.wall_body, points.base_body))
    flat = np.einsum("ni,nij->nj", points.n_base, by_wall - by_base)
    own = slice(6, 6 + flat.shape[1])
    variance = np.einsum("ni,ij,nj->n", flat, fit.covariance[own, own], flat)
    return np.asarray(ndtri((1.0 + COVERAGE) / 2.0) * np.sqrt(np.maximum(variance, 0.0)))


def _by_motions(motions: Motions, body: IntArray, p_part: FloatArray) -> FloatArray:
    """Return how points of moved bodies move with the unknowns of the bodies, shape (n, 3, 6 b + k)."""
    return motions.jacobian(body, motions.material(body, p_part))
