r"""Touches of a tip or a ball on a part, and how each constrains the pose of the part.

A touch i was made at :math:`q_i` (base). In the part's coordinates that is :math:`x = T^{-1} q_i`; its target has the
nearest point :math:`f(x)` and, on a face, the outward normal :math:`n`. The centre of a ball of radius r that touches
the face is r away from it, so the residual is

.. math:: d_i = x - f(x) - r_i n, \qquad \partial d_i = A_i \, \partial x,

with :math:`A = n n^\top` on a face (one number), :math:`I - t t^\top` on an edge (two) and :math:`I` at a point
(three).
On a face :math:`d` is the signed distance along n, whose gradient is n exactly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, IntArray, as_points
from wpcal.core.errors import InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.robot_space import RobotSpace
from wpcal.core.tangent import point_jacobian
from wpcal.core.transform import RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """The nearest points of targets, and how they constrain the part there."""

    p: FloatArray  #: shape (m, 3). Nearest points, in `part`, mm.
    #: shape (m, 3). Outward unit normals in `part`; zero at points and on edges, where the radius of a ball is ignored.
    normal: FloatArray
    projector: FloatArray  #: shape (m, 3, 3). Projectors A onto the directions in which the touch constrains the part.


class TouchTargets(Protocol):
    """What the touches lie on; row i is the target of touch i.

    `wpcal.calibrate.observe.targets.GraphTargets` implements this for the faces and edges of a `BrepGraph`. Another
    geometry must provide the six members of this protocol.
    """

    def nearest(self, rows: IntArray, points: FloatArray) -> Nearest:
        """Find the nearest points of the targets `rows`, shape (m,), to points (m, 3) in `part`, mm, to round-off."""

    def rough_distances(self, rows: IntArray, points: FloatArray, radius_mm: FloatArray) -> FloatArray:
        """Estimate how far balls are from touching their targets; a distance beyond the end of a target counts as well.

        Returns shape (m,). mm.

        `rows`: shape (m,).
        `points`: shape (m, 3). Centres of the balls in `part`, mm.
        `radius_mm`: shape (m,).
        """

    def overhang(self, rows: IntArray, points: FloatArray) -> FloatArray:
        """Return how far the nearest points lie beyond the border of their face or edge.

        `rows`: shape (m,).
        `points`: shape (m, 3). In `part`, mm.
        Returns shape (m,). mm; 0 within the border.
        """

    def joined(self, other: Any) -> tuple[TouchTargets, int]:
        """Return these targets followed by other ones of the same part and class, and the row of the first of those."""

    @property
    def centre(self) -> FloatArray:
        """A point in the middle of the targets, in `part`, mm, shape (3,)."""

    @property
    def reach_mm(self) -> float:
        """Greatest distance of a target's points from the centre, mm."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedAxis:
    """An axis of the part that has a name: of a hole or a cylinder."""

    name: str
    #: `point`, `direction`: shape (3,). In `part`; mm and a unit vector.
    point: FloatArray
    direction: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Touches:
    """n touches and what they lie on.

    Raises `InputError` when the lengths differ, or a radius is negative or not finite.
    """

    names: tuple[str, ...]
    #: shape (n, 3). The controlled point (wire tip or centre of the ball) at each touch, in `base`, mm.
    p_base: FloatArray
    #: shape (n,). Distance of that point from the face along the outward normal: radius of the ball, or the wire's
    #: stick-out beyond the point that the controller shows. Zero at points and edges.
    radius_mm: FloatArray
    targets: TouchTargets
    words: tuple[str, ...]  #: length n. What each touch lies on, in words: ``plane F3``.
    covariances: FloatArray | None  #: shape (n, 3, 3). Of the touched positions in `base`, mm².
    space: RobotSpace
    rows: IntArray  #: shape (n,). The target of each touch.
    axes: tuple[NamedAxis, ...] = ()  #: Axes of the part by which messages name a motion.
    #: shape (n, 3, s). What each position sees of one standard deviation of s errors that all touches share, in `base`,
    #: mm: of the stick-out, of the latency. The covariances contain these errors, too.
    shared: FloatArray | None = None

    def __post_init__(self) -> None:
        n = len(as_points(self.p_base, name="touches"))
        if not (len(self.names) == len(self.radius_mm) == len(self.words) == len(self.rows) == n):
            raise InputError(f"{len(self.names)} names, {n} touches and {len(self.radius_mm)} radii")
        if not (np.isfinite(self.radius_mm) & (self.radius_mm >= 0)).all():
            raise InputError("the radius of a ball is a length that is not negative")

    def __len__(self) -> int:
        return len(self.names)

    def select(self, indices: ArrayLike) -> Touches:
        """Return the touches at `indices` (integers, shape (m,)), in that order."""
        at = np.asarray(indices, dtype=np.int64)
        return replace(
            self,
            names=tuple(self.names[i] for i in at),
            p_base=self.p_base[at],
            radius_mm=self.radius_mm[at],
            words=tuple(self.words[i] for i in at),
            covariances=None if self.covariances is None else self.covariances[at],
            rows=self.rows[at],
            shared=None if self.shared is None else self.shared[at],
        )

    def joined(self, other: Touches) -> Touches:
        """Return these touches followed by others of the same part, with other names.

        Where the errors of one group alone are stated, or a name is in both, only these touches are returned.
        """
        if (self.covariances is None) != (other.covariances is None) or set(self.names) & set(other.names):
            return self
        covariances = None
        if self.covariances is not None and other.covariances is not None:
            covariances = np.concatenate([self.covariances, other.covariances])
        shared = None
        if self.shared is not None and other.shared is not None and self.shared.shape[2] == other.shared.shape[2]:
            shared = np.concatenate([self.shared, other.shared])
        targets, first = self.targets.joined(other.targets)
        return replace(
            self,
            names=(*self.names, *other.names),
            p_base=np.concatenate([self.p_base, other.p_base]),
            radius_mm=np.concatenate([self.radius_mm, other.radius_mm]),
            targets=targets,
            words=(*self.words, *other.words),
            covariances=covariances,
            rows=np.concatenate([self.rows, first + other.rows]),
            shared=shared,
        )

    def paired(self, T_base_part: RigidTransform) -> PointPairs:
        """Pair every touch with the point of the part where, at that pose, it should have been."""
        contact = self.linearised(T_base_part.R, T_base_part.t_mm).contact_part
        return PointPairs(self.names, contact, self.p_base, self.covariances, space=self.space)

    def linearised(self, R: FloatArray, t: FloatArray) -> Linearised:
        """Residuals at poses ``T_base_part``, and how they change with a small motion of the part.

        `R`, `t`: shapes (..., 3, 3), (..., 3). One pose, or many at once.
        Returns: With the same leading axes.
        """
        x = (self.p_base - t[..., None, :]) @ R
        many = x.reshape(-1, 3)
        near = self.targets.nearest(np.tile(self.rows, len(many) // max(len(self), 1)), many)
        p, normal = near.p.reshape(x.shape), near.normal.reshape(x.shape)
        projector = near.projector.reshape(*x.shape, 3)
        contact = p + self.radius_mm[:, None] * normal
        d = (projector @ (x - contact)[..., None])[..., 0]
        turned, back = R[..., None, :, :], R.swapaxes(-1, -2)
        A = turned @ projector @ back[..., None, :, :]
        return Linearised(contact, d @ back, A, contact @ back + t[..., None, :])


@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """The residuals of touches at one pose, in `base`, and their derivative; at many poses with more leading axes."""

    contact_part: FloatArray  #: shape (..., n, 3). Where the controlled point should have been, in `part`, mm.
    d: FloatArray  #: shape (..., n, 3). Residual vectors: touched minus modelled, mm.
    A: FloatArray  #: shape (..., n, 3, 3). Projectors onto the directions that each touch constrains.
    centre: FloatArray  #: shape (..., n, 3). `contact_part` in `base`, mm.

    def at(self, k: int) -> Linearised:
        """Return the residuals at the k-th of many poses."""
        return Linearised(self.contact_part[k], self.d[k], self.A[k], self.centre[k])

    @property
    def distances(self) -> FloatArray:
        """Lengths of the residuals, mm, shape (..., n)."""
        return np.asarray(np.linalg.norm(self.d, axis=-1))

    @property
    def rank(self) -> IntArray:
        """How many numbers each touch gives: 1 on a face, 2 on an edge, 3 at a point; shape (..., n)."""
        return np.asarray(np.rint(np.einsum("...ii->...", self.A)), dtype=np.int64)

    def jacobian(self, pivot: FloatArray) -> FloatArray:
        """Derivative of the residuals by the small motion (ω, v) about `pivot`.

        `pivot`: shape (3,). In `base`, mm.
        Returns shape (..., n, 3, 6). -A [-[c - pivot]×, I].
        """
        return np.asarray(-self.A @ point_jacobian(self.centre - pivot))

    def information(self, covariances: FloatArray | None) -> FloatArray:
        """Weights Λ of the residuals, shape (..., n, 3, 3): A, or the inverse of A C A within the range of A."""
        if covariances is None:
            return self.A
        seen = np.einsum("...ij,...ji->...", self.A, np.broadcast_to(covariances, self.A.shape))
        weights = np.asarray(self.A / seen[..., None, None])  # of a touch that gives one number: n nᵀ / nᵀ C n
        several = self.rank > 1
        A = self.A[several]
        C = np.broadcast_to(covariances, self.A.shape)[several]
        weights[several] = np.linalg.pinv(A @ C @ A, rcond=1e-9, hermitian=True)
        return weights
