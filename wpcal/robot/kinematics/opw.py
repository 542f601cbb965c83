r"""Closed-form inverse kinematics of 6R arms with a parallel elbow and a spherical wrist (ortho-parallel, OPW).

Most welding robots belong here: axis 2 normal to axis 1, axis 3 parallel to axis 2, and axes 4, 5, 6 meeting in one
point at right angles. The geometry is read off a chain's axes, whatever its signs and offsets, so that the arm's
Denavit-Hartenberg numbers are the only ones kept.

References: Brandstötter, Angerer, Hofbaur 2014, An analytical solution of the inverse kinematics problem of industrial
serial manipulators with an ortho-parallel basis and a spherical wrist. The seven lengths have its names; the angles are
found through sines and cosines of one another, which keeps the answer at round-off next to stretched elbows and
straight wrists, where the printed arc cosines lose half of the digits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import GeometryError
from wpcal.core.rotations import rotation_from_zyx, rotation_from_zyz
from wpcal.core.same_bits import arc_tangent, inverse_pose, length, product, sine_cosine
from wpcal.robot.kinematics.forward import MDHChain, forward_kinematics, start_frames, walk

FAMILY_ATOL = 1e-9
"""Axes that are off being parallel, normal or meeting by more than this (rad, or parts of the reach) are another
family; numbers of a data file are exact, rounding of degrees leaves 1e-15."""
REACH_SLACK = 1e-12
"""Squared sines and distances below zero by this part are round-off of a pose at the very edge of the reach; taking
them as zero moves the flange by less than 1e-9 mm."""
BRANCHES = 8  #: Shoulder front or back, elbow one way or the other, wrist straight or flipped.


@dataclass(frozen=True, slots=True, eq=False)
class OPWGeometry:
    """The seven lengths of the family, and how its angles and frames follow from a chain's."""

    #: `a1`, `a2`, `b`, `c1`, `c2`, `c3`: Lengths, mm, with the names of the paper; its c4 is part of `T_wrist_flange`.
    a1: float
    a2: float
    b: float
    c1: float
    c2: float
    c3: float
    #: `signs`, `offsets`: shape (6,). ``θ_opw = signs · θ_model + offsets``, θ_model without the chain's offsets, rad.
    signs: FloatArray
    offsets: FloatArray
    #: `T_base_opw`, `T_wrist_flange`: shape (4, 4). From the base to the family's own base frame, and from its wrist
    #: frame to the flange.
    T_base_opw: FloatArray
    T_wrist_flange: FloatArray

    @classmethod
    def of_chain(cls, chain: MDHChain) -> OPWGeometry:
        """Read the geometry off the axes of a chain.

        Raises `GeometryError` when the chain is not of the family; the message says which axes are not as they should
        be.
        """
        return _geometry(chain)


@lru_cache(maxsize=64)
def _geometry(chain: MDHChain) -> OPWGeometry:
    if len(chain) != 6:
        raise GeometryError(f"the closed form needs 6 joints, the chain has {len(chain)}")
    axes, origins, wrist = _axes_at_zero(chain)
    T_base_opw = np.eye(4)
    T_base_opw[:3, :4] = np.column_stack([np.cross(axes[1], axes[0]), axes[1], axes[0], origins[0]])
    rows = T_base_opw[:3, :3]  # a row vector times this is the vector in the family's base
    bare = _measure(product(axes, rows), product(origins - origins[0], rows), product(wrist - origins[0], rows))
    return _with_flange(replace(bare, T_base_opw=frozen(T_base_opw)), chain)


def _measure(axes: FloatArray, origins: FloatArray, wrist: FloatArray) -> OPWGeometry:
    """Read lengths, signs and offsets off the axes at zero, all in the family's base, where axis 2 is +y.

    Turning about +y by an angle carries z towards x, so tilts in the plane of the arm are ``atan2(x, z)``.
    """
    zero, upper, fore = np.zeros(()), origins[2] - origins[1], wrist - origins[2]
    s3 = float(np.sign(axes[2][1]))
    s4 = -1.0 if product(fore, axes[3]) < 0 else 1.0
    forward = s4 * axes[3]
    across = np.array([forward[2], 0.0, -forward[0]])  # the x axis of the forearm
    tilt_upper, tilt_fore = arc_tangent(upper[0], upper[2]), arc_tangent(forward[0], forward[2])
    turn4 = arc_tangent(-product(axes[4], across), axes[4][1])  # axis 5 lies along y when θ4 is zero
    turn5 = arc_tangent(product(np.cross(forward, axes[5]), axes[4]), product(forward, axes[5]))
    return OPWGeometry(
        a1=float(origins[1][0]),
        a2=float(product(fore, across)),
        b=float(wrist[1]),
        c1=float(origins[1][2]),
        c2=float(length([upper[0], upper[2]])),
        c3=float(product(fore, forward)),
        signs=frozen([1.0, 1.0, s3, s4, 1.0, 1.0]),
        offsets=frozen(np.stack([zero, tilt_upper, tilt_fore - tilt_upper, turn4, turn5, zero])),
        T_base_opw=frozen(np.eye(4)),
        T_wrist_flange=frozen(np.eye(4)),
    )


def _axes_at_zero(chain: MDHChain) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return directions and points of the six axes at zero, and the wrist centre; all in the base."""
    motions = list(walk(start_frames(chain.T_base_dh0, 1), chain.table, np.zeros((6, 1))))
    axes = np.array([motion.z[:, 0] for motion in motions])
    origins = np.array([motion.p_before[:, 0] for motion in motions])
    reach = max(1.0, float(np.abs(np.diff(origins, axis=0)).sum()))
    # The wrist centre is the point of axis 4 nearest to axis 5.
    n = np.cross(axes[3], axes[4])
    gap = origins[4] - origins[3]
    wrist = origins[3] + axes[3] * product(np.cross(gap, axes[4]), n) / max(float(product(n, n)), FAMILY_ATOL)
    faults = {
        "axis 2 is not normal to axis 1": abs(axes[0] @ axes[1]),
        "axis 3 is not parallel to axis 2": np.linalg.norm(np.cross(axes[1], axes[2])),
        "axis 4 is not normal to axis 3": abs(axes[2] @ axes[3]),
        "axis 5 is not normal to axis 4": abs(axes[3] @ axes[4]),
        "axis 6 is not normal to axis 5": abs(axes[4] @ axes[5]),
        "axes 4 and 5 do not meet": abs(gap @ n) / reach,
        "axis 6 misses the wrist centre": np.linalg.norm(np.cross(wrist - origins[5], axes[5])) / reach,
    }
    for fault, size in faults.items():
        if size > FAMILY_ATOL:
            raise GeometryError(f"no closed form for this arm: {fault} (off by {size:.2g})")
    return axes, origins, wrist


def _with_flange(geometry: OPWGeometry, chain: MDHChain) -> OPWGeometry:
    """Complete the geometry with the constant step from its wrist frame to the chain's flange."""
    zero = np.zeros((1, 6))
    T_base_wrist = product(geometry.T_base_opw, forward_opw(geometry, zero)[0])
    flange = product(inverse_pose(T_base_wrist), forward_kinematics(chain, zero)[0])
    return replace(geometry, T_wrist_flange=frozen(flange))


def forward_opw(geometry: OPWGeometry, theta: ArrayLike) -> FloatArray:
    """Return the wrist frame in the family's base for model angles of shape (N, 6), rad; shape (N, 4, 4)."""
    t1, t2, t3, t4, t5, t6 = (np.asarray(theta) * geometry.signs + geometry.offsets).T
    g = geometry
    T = np.zeros((len(t1), 4, 4))
    (s1, s2, s23), (c1, c2, c23) = sine_cosine(np.stack([t1, t2, t2 + t3]))
    r = g.a1 + g.c2 * s2 + g.a2 * c23 + g.c3 * s23
    z = g.c1 + g.c2 * c2 - g.a2 * s23 + g.c3 * c23
    T[:, 0, 3], T[:, 1, 3], T[:, 2, 3] = c1 * r - s1 * g.b, s1 * r + c1 * g.b, z
    T[:, 3, 3] = 1.0
    zero = np.zeros(len(t1))
    arm, wrist = rotation_from_zyx(zero, t2 + t3, t1), rotation_from_zyz(t4, t5, t6)
    T[:, :3, :3] = product(arm, wrist)
    return T


def solve_opw(geometry: OPWGeometry, T_base_flange: ArrayLike, *, least_bend: float = 0.0) -> FloatArray:
    """Return all eight solutions for every pose.

    `T_base_flange`: shape (N, 4, 4). Flange poses, mm.
    `least_bend`: Sine of the elbow angle that a start for other steps keeps off the stretched arm; poses that are out
    of reach by as little get this bend instead of NaN. With 0 the answers are exact.
    Returns ndarray, shape (N, 8, 6). Angles of the model without the chain's offsets, rad, in (-π, π]. NaN where the
    arm does not reach. Branch number: 4 for the shoulder turned back, plus 2 for the other elbow, plus 1 for the
    flipped wrist.

    At a straight wrist only the sum of θ4 and θ6 is defined; both are finite and the pose is met.
    """
    T = np.asarray(T_base_flange, dtype=np.float64)
    to_opw, to_wrist = inverse_pose(geometry.T_base_opw), inverse_pose(geometry.T_wrist_flange)
    # T_opw_wrist as rows: frames[j] holds column j of all poses, shape (3, N)
    local = np.ascontiguousarray(np.moveaxis(T[:, :3, :], 0, 2))  # (3, 4, N)
    columns = np.einsum("ij,jkn->ikn", to_opw[:3, :3], local)
    columns[:, 3] += to_opw[:3, 3, None]
    R = np.einsum("ikn,kj->ijn", columns[:, :3], to_wrist[:3, :3])
    wrist = np.einsum("ikn,k->in", columns[:, :3], to_wrist[:3, 3]) + columns[:, 3]

    angles = np.empty((6, 2, 2, 2, T.shape[0]))
    t1, t2, t3 = _solve_arm(geometry, wrist, least_bend)
    t4, t5, t6 = _solve_wrist(R, t1[:, None], t2 + t3)
    angles[0], angles[1], angles[2] = t1[:, None, None], t2[:, :, None], t3[:, :, None]
    angles[3, :, :, 0], angles[4, :, :, 0], angles[5, :, :, 0] = t4, t5, t6
    angles[3, :, :, 1], angles[4, :, :, 1], angles[5, :, :, 1] = t4 + np.pi, -t5, t6 + np.pi
    # where the elbow does not reach, the shoulder's angle is not an answer either
    angles[0] = np.where(np.isnan(angles[1]), np.nan, angles[0])
    flat = angles.reshape(6, BRANCHES, -1)
    flat -= geometry.offsets[:, None, None]
    flat *= geometry.signs[:, None, None]
    flat -= 2 * np.pi * np.ceil(flat / (2 * np.pi) - 0.5)  # into (-π, π]
    return np.ascontiguousarray(flat.transpose(2, 1, 0))


def _solve_arm(g: OPWGeometry, wrist: FloatArray, least_bend: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Angles 1 (2, N), 2 and 3 (2, 2, N) that put the wrist centre in its place; NaN where they cannot."""
    x, y, z = wrist
    rho = _root(x * x + y * y - g.b * g.b, scale=g.c2 * g.c2)
    side = np.stack([rho, -rho])  # shoulder in front of axis 1, or turned back
    t1 = arc_tangent(y, x) - arc_tangent(g.b, side)
    r, h = side - g.a1, z - g.c1
    kappa2 = g.a2 * g.a2 + g.c3 * g.c3
    kappa = np.sqrt(kappa2)
    cos3 = (r * r + h * h - g.c2 * g.c2 - kappa2) / (2.0 * g.c2 * kappa)
    square = (1.0 - cos3) * (1.0 + cos3)
    sin3 = _root(np.where(np.abs(square) < least_bend**2, least_bend**2, square), scale=1.0)
    sin3 = np.stack([sin3, -sin3], axis=1)
    t3 = arc_tangent(sin3, cos3[:, None])
    t2 = arc_tangent(r, h)[:, None] - arc_tangent(kappa * sin3, (g.c2 + kappa * cos3)[:, None])
    return t1, t2, t3 - arc_tangent(g.a2, g.c3)


def _root(square: FloatArray, *, scale: float) -> FloatArray:
    """Square root; zero for round-off below zero, NaN (out of reach) further down."""
    return np.sqrt(np.where(square < -REACH_SLACK * scale, np.nan, np.maximum(square, 0.0)))


def _solve_wrist(R: FloatArray, t1: FloatArray, t23: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Angles 4, 5, 6 of ``Rz(θ4) Ry(θ5) Rz(θ6) = (Rz(θ1) Ry(θ2 + θ3))ᵀ R``, each of shape (2, 2, N)."""
    s1, c1 = sine_cosine(t1)
    s23, c23 = sine_cosine(t23)
    u = c1 * R[0][:, None, None] + s1 * R[1][:, None, None]  # row 0 of Rz(-θ1) R for each column
    M0 = c23 * u - s23 * R[2][:, None, None]
    M1 = c1 * R[1][:, None, None] - s1 * R[0][:, None, None]
    m22 = s23 * u[2] + c23 * R[2][2]
    t4 = arc_tangent(M1[2], M0[2])
    s4, c4 = sine_cosine(t4)
    t5 = arc_tangent(c4 * M0[2] + s4 * M1[2], m22)
    t6 = arc_tangent(c4 * M1[0] - s4 * M0[0], c4 * M1[1] - s4 * M0[1])
    return t4, t5, t6
