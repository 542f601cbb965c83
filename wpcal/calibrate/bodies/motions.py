r"""The pose of a weldment and the motion of every body in it.

A point p of body b is at :math:`T (M_b\,p)` in the base, with
:math:`M_b\,p = \exp(\omega_b)(p - c_b) + c_b + v_b` in `part`, and :math:`c_b` the centroid of the body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.bodies.bodies import Bodies
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.rotations import cross_matrix
from wpcal.core.tangent import exp_rotation, point_jacobian
from wpcal.core.transform import RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """Where the part and its bodies are.

    Parameters
    ----------
    bodies : Bodies
    T_base_part : RigidTransform
    omega : ndarray, shape (b, 3)
        Rotation vectors of the bodies about their centroids, in `part`, rad.
    v_mm : ndarray, shape (b, 3)
        Motions of the centroids, in `part`, mm.
    """

    bodies: Bodies
    T_base_part: RigidTransform
    omega: FloatArray
    v_mm: FloatArray

    @classmethod
    def rigid(cls, bodies: Bodies, T_base_part: RigidTransform) -> Motions:
        """No body has moved."""
        still = np.zeros((len(bodies), 3))
        return cls(bodies, T_base_part, still, still)

    def moves(self) -> tuple[FloatArray, FloatArray]:
        """Return the rotations and translations of the M_b, shapes (b, 3, 3) and (b, 3), in `part`, mm."""
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
        """Move points of bodies within `part`.

        Parameters
        ----------
        body : ndarray of int, shape (n,)
            -1: a point that belongs to no body, and stays.
        p_part : ndarray, shape (n, 3)

        Returns
        -------
        ndarray, shape (n, 3)
        """
        R, t = self.moves()
        moved = np.einsum("nij,nj->ni", R[body], p_part) + t[body]
        return np.where((body >= 0)[:, None], moved, p_part)

    def turned(self, body: IntArray, directions: FloatArray) -> FloatArray:
        """Turn directions, of shape (n, 3), with their bodies, as `apply` moves points."""
        R, _ = self.moves()
        return np.where((body >= 0)[:, None], np.einsum("nij,nj->ni", R[body], directions), directions)

    def displacement_jacobian(self, body: IntArray, p_part: FloatArray) -> FloatArray:
        """Differentiate moved points of bodies by the motion (ω, v) of the own body.

        Parameters
        ----------
        body : ndarray of int, shape (n,)
        p_part : ndarray, shape (n, 3)
            In the model.

        Returns
        -------
        ndarray, shape (n, 3, 6)
            Of points in `part`, mm per rad and per mm.
        """
        R, _ = self.moves()
        arm = np.einsum("nij,nj->ni", R[body], p_part - self.bodies.centroid_part[body])
        J = point_jacobian(arm)
        J[:, :, :3] = J[:, :, :3] @ left_jacobian(self.omega)[body]
        return J


def left_jacobian(omega: FloatArray) -> FloatArray:
    r"""Return :math:`J_l` with :math:`\exp(\omega + d) = \exp(J_l d) \exp(\omega)` to first order.

    Parameters
    ----------
    omega : ndarray, shape (b, 3)
        Rotation vectors, rad.

    Returns
    -------
    ndarray, shape (b, 3, 3)

    References
    ----------
    Barfoot, State Estimation for Robotics, 2017, equation (7.77b), as a series where the angle is small.
    """
    angle = np.linalg.norm(omega, axis=1)[:, None, None]
    small = angle < 1e-3  # the next terms of the series are below 1e-14
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    b = np.where(small, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    K = cross_matrix(omega)
    return np.asarray(np.eye(3) + a * K + b * (K @ K))
