r"""The pose of a weldment and the motion of every body in it.

A point p of body b is at :math:`T (M_b\,p)` in the base, with
:math:`M_b\,p = \exp(\omega_b)(p - c_b) + c_b + v_b` in `part`, and :math:`c_b` the centroid of the body. A body that
bends is at :math:`T (M_b\,L_b(p))`: :math:`L_b` moves and turns the cross-section of p as a whole.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from wpcal.calibrate.observe.bending import MODES
from wpcal.calibrate.observe.bodies import Bodies
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.rotations import cross_matrix
from wpcal.core.tangent import exp_rotation, point_jacobian
from wpcal.core.transform import RigidTransform

SECTION_ROUNDS = 4
"""A moved point shows its cross-section to the slope of bending, 1e-2 at most; each round is as much better."""


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """Where the part and its bodies are."""

    bodies: Bodies
    T_base_part: RigidTransform
    omega: FloatArray  #: shape (b, 3). Rotation vectors of the bodies about their centroids, in `part`, rad.
    v_mm: FloatArray  #: shape (b, 3). Motions of the centroids, in `part`, mm.
    bend_mm: FloatArray = field(default_factory=lambda: np.zeros(0))  #: shape (k,). Amplitudes of bending (`Bends`).

    @classmethod
    def rigid(cls, bodies: Bodies, T_base_part: RigidTransform) -> Motions:
        """No body has moved."""
        still = np.zeros((len(bodies), 3))
        return cls(bodies, T_base_part, still, still, np.zeros(len(bodies.bends)))

    def moves(self) -> tuple[FloatArray, FloatArray]:
        """Return the rotations and translations of the M_b, without bending, shapes (b, 3, 3), (b, 3), `part`, mm."""
        R = exp_rotation(self.omega)
        c = self.bodies.centroid_part
        return R, c + self.v_mm - np.einsum("bij,bj->bi", R, c)

    def poses(self) -> tuple[FloatArray, FloatArray]:
        """Return T M_b, shapes (b, 3, 3) and (b, 3): from each body's place in the model to the base, mm."""
        R, t = self.moves()
        T = self.T_base_part
        return T.R @ R, t @ T.R.T + T.t_mm

    def poses_of(self, body: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the poses of the bodies `body`, shape (n,); of -1 that of the whole: shapes (n, 3, 3) and (n, 3)."""
        R, t = self.poses()
        is_own, T = body >= 0, self.T_base_part
        return np.where(is_own[:, None, None], R[body], T.R), np.where(is_own[:, None], t[body], T.t_mm)

    def apply(self, body: IntArray, p_part: FloatArray) -> FloatArray:
        """Move points, shape (n, 3), of bodies, shape (n,), within `part`; those of body -1 stay."""
        R, t = self.moves_at(body, p_part)
        return np.asarray(np.einsum("nij,nj->ni", R, p_part) + t)

    def moves_at(self, body: IntArray, p_part: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how the cross-sections of points of bodies moved within `part`.

        Returns tuple of ndarray, shapes (n, 3, 3) and (n, 3). Of a body that does not bend, those of `moves`.

        `body`: shape (n,). -1: a point that belongs to no body, and stays. `p_part`: shape (n, 3). In the model, mm.
        """
        R, t = (np.concatenate(pair) for pair in zip(self.moves(), (np.eye(3)[None], np.zeros((1, 3))), strict=True))
        R, t = R[body], t[body]
        if len(self.bodies.bends) == 0:
            return R, t
        middle, offset, turn = p_part.copy(), np.zeros_like(p_part), np.zeros_like(p_part)
        for m, rows, s, w, slope in self._bent(body, p_part):
            bends, own = self.bodies.bends, slice(MODES * m, MODES * (m + 1))
            middle[rows] = self.bodies.centroid_part[bends.body[m]] + s[:, None] * bends.axis[m]
            offset[rows] += np.outer(w @ self.bend_mm[own], bends.normal[m])
            turn[rows] += np.outer(slope @ self.bend_mm[own], np.cross(bends.axis[m], bends.normal[m]))
        L = exp_rotation(turn)
        shift = middle + offset - np.einsum("nij,nj->ni", L, middle)
        return R @ L, np.einsum("nij,nj->ni", R, shift) + t

    def material(self, body: IntArray, p_part: FloatArray) -> FloatArray:
        """Return where moved points, of shape (n, 3), are in the model of their bodies, of shape (n,)."""
        x = p_part
        for _ in range(SECTION_ROUNDS if len(self.bodies.bends) else 1):
            R, t = self.moves_at(body, x)
            x = np.einsum("nij,ni->nj", R, p_part - t)
        return np.asarray(x)

    def _bent(
        self, body: IntArray, p_part: FloatArray
    ) -> Iterator[tuple[int, IntArray, FloatArray, FloatArray, FloatArray]]:
        """Per direction of bending: its number, the rows of its points, their place, and modes and slopes there."""
        bends = self.bodies.bends
        for m, own in enumerate(bends.body.tolist()):
            rows = np.flatnonzero(body == own)
            s = (p_part[rows] - self.bodies.centroid_part[own]) @ bends.axis[m]
            yield m, rows, s, *bends.shapes(m, s)

    def turned(self, body: IntArray, directions: FloatArray) -> FloatArray:
        """Turn directions, of shape (n, 3), with their bodies, without bending."""
        R, _ = self.moves()
        return np.where((body >= 0)[:, None], np.einsum("nij,nj->ni", R[body], directions), directions)

    def displacement_jacobian(self, body: IntArray, p_part: FloatArray) -> FloatArray:
        """Differentiate moved points of bodies by the motion (ω, v) of the own body.

        `body`: shape (n,).
        `p_part`: shape (n, 3). In the model.
        Returns shape (n, 3, 6). Of points in `part`, mm per rad and per mm.
        """
        J = point_jacobian(self.apply(body, p_part) - self.bodies.centroid_part[body] - self.v_mm[body])
        J[:, :, :3] = J[:, :, :3] @ left_jacobian(self.omega)[body]
        return J

    def jacobian(self, body: IntArray, p_part: FloatArray) -> FloatArray:
        """Differentiate moved points by the motions of all bodies and the amplitudes of bending.

        Returns shape (n, 3, 6 b + k). Of points in `part`, mm per rad and per mm.

        `body`: shape (n,). -1: a point that belongs to no body. `p_part`: shape (n, 3). In the model.
        """
        n, b, bends = len(body), len(self.bodies), self.bodies.bends
        J = np.zeros((n, 3, 6 * b + len(bends)))
        rows = np.flatnonzero(body >= 0)
        blocks = np.zeros((n, 3, b, 6))
        blocks[rows, :, body[rows]] = self.displacement_jacobian(body[rows], p_part[rows])
        J[:, :, : 6 * b] = blocks.reshape(n, 3, 6 * b)
        if len(bends) == 0:
            return J
        R, _ = self.moves()
        for m, rows, _, w, slope in self._bent(body, p_part):
            own = int(bends.body[m])
            height = (p_part[rows] - self.bodies.centroid_part[own]) @ bends.normal[m]
            by = w[:, None, :] * bends.normal[m][:, None]
            by = by - (height[:, None] * slope)[:, None, :] * bends.axis[m][:, None]
            J[rows, :, 6 * b + MODES * m : 6 * b + MODES * (m + 1)] = R[own] @ by
        return J


def left_jacobian(omega: FloatArray) -> FloatArray:
    r"""Return :math:`J_l` with :math:`\exp(\omega + d) = \exp(J_l d) \exp(\omega)` to first order, shape (b, 3, 3).

    `omega`: shape (b, 3). Rotation vectors, rad.

    References: Barfoot, State Estimation for Robotics, 2017, equation (7.77b), as a series where the angle is small.
    """
    angle = np.linalg.norm(omega, axis=1)[:, None, None]
    small = angle < 1e-3  # the next terms of the series are below 1e-14
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    b = np.where(small, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    K = cross_matrix(omega)
    return np.asarray(np.eye(3) + a * K + b * (K @ K))
