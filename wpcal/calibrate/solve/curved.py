r"""What a touch on a curved face does not tell: the direction of its normal, as far as its body may have slid along it.

The fit takes a touch near the tangent plane of its face. If the body is elsewhere by :math:`\delta`, the residual there
differs from that of the plane by

.. math:: e(\delta) = A\,(d(x + \delta) - d(x)) - A\,\delta,

about :math:`\tau^2 / 2 \rho` in a hole of radius :math:`\rho`, for a part :math:`\tau` of :math:`\delta` along the
wall. Its second moment is added to the variance of the touch, as in a filter of second order: with the covariance of
:math:`\delta` *before* the touches are used. With that after the fit, a touch on the wrong side of a small hole would
confirm itself. On planes e is zero; in a hole that is smaller than the motion it is not more than the hole allows.

References: Bar-Shalom, Li and Kirubarajan (2001), Estimation with applications to tracking and navigation, section
10.3.2.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from wpcal.calibrate.solve.bodies_problem import BodiesState, Problem, touched_poses

NODES, WEIGHT = math.sqrt(3.0), 1.0 / 6.0
"""Gauss-Hermite with three nodes along each axis is exact for the square of a curvature; the one in the middle is 0."""
BOTH = 2.0  #: Of the variance of a body's motion: the rigid fit of the whole is off by such a motion, too.
MOST_MM = 5.0  #: Motions are small. A tolerance that says that nothing is known must not make round faces useless.
LEAST_SHARE = 0.02  #: Of the variance of a touch: a smaller second moment changes no error by more than 1 %.


def on_curved_faces(problem: Problem, first: BodiesState) -> Problem:
    """Return the problem with the variance that touches on curved faces have besides.

    Returns: Its variances grow in all directions: the fit turns normals, and must not gain by that. The same problem
    where all touched faces are plane, or nearly.
    """
    touches, n = problem.touches, len(problem.touches)
    R, t = touched_poses(touches, problem.body, first.motions)
    J = R.transpose(0, 2, 1) @ problem.material_jacobian(first)[:, :, problem.of_bodies]
    values, vectors = np.linalg.eigh(BOTH * J @ J.transpose(0, 2, 1))
    spread = np.sqrt(np.clip(values, 0.0, MOST_MM**2))
    along = (vectors * spread[:, None, :]).transpose(0, 2, 1)  # axis, then coordinate
    shifts = NODES * np.concatenate([along, -along], axis=1)
    x = np.einsum("nij,ni->nj", R, touches.p_base - problem.shared @ first.shared - t)
    again = np.repeat(np.arange(n), 1 + shifts.shape[1])
    at = np.concatenate([x[:, None], x[:, None] + shifts], axis=1).reshape(-1, 3)
    near = touches.targets.nearest(touches.rows[again], at)
    off = at - near.p - touches.radius_mm[again, None] * near.normal
    d = np.einsum("nij,nj->ni", near.projector, off).reshape(n, -1, 3)
    A = near.projector.reshape(n, -1, 3, 3)[:, 0]
    left_out = np.einsum("nij,nkj->nki", A, d[:, 1:] - d[:, :1] - shifts)
    moments = WEIGHT * np.einsum("nki,nki->n", left_out, left_out)
    if (moments <= LEAST_SHARE / 3.0 * np.einsum("nii->n", problem.own)).all():
        return problem
    return replace(problem, own=problem.own + moments[:, None, None] * np.eye(3))
