"""Inverse kinematics of an `Arm`: closed form, Newton steps where the arm is an identified one, limits, whole turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.same_bits import product, solve
from wpcal.core.tangent import log_rotation
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.chain import MDHChain
from wpcal.robot.kinematics.forward import forward_kinematics, geometric_jacobian
from wpcal.robot.kinematics.opw import OPWGeometry, solve_opw

TURN = 2.0 * np.pi

NEWTON_STEPS = 12
"""An identified arm is off its nominal one by millimetres: three steps reach round-off, next to a straight wrist a few
more; beyond twelve a pose is at a singularity and does not get there."""

NEWTON_MM = 1e-9  #: A pose is met when its origin is this close (three orders above the round-off of a metre) ...

NEWTON_RAD = 1e-12  #: ... and its axes are: at arm's length the same distance.

START_BEND = 0.2
"""Sine of the elbow angle below which Newton steps start from this bend: an arm of a metre that is really some
millimetres longer than nominal reaches poses which the nominal one does not, and a stretched start leads nowhere."""

DAMPING = 1e-9
"""Added to the squared, length-scaled Jacobian. It bounds the step at an exact singularity and has no visible effect
elsewhere."""


@dataclass(frozen=True, slots=True, eq=False)
class JointSolutions:
    """All branches for many poses."""

    #: shape (N, 8, 6). Shown joint angles, rad, each in the turn around zero; NaN where a branch does not reach.
    joints: FloatArray
    reached: BoolArray  #: shape (N, 8). Whether the branch meets the pose; limits are not looked at.


def solve_inverse(arm: Arm, T_base_flange: ArrayLike) -> JointSolutions:
    """Return the joint angles of all eight branches for flange poses.

    An arm of the OPW family has a closed form. An identified arm is no longer exactly of the family: the closed form
    of its nominal chain is followed by Newton steps with its own Jacobian.

    `T_base_flange`: shape (N, 4, 4). Flange poses in the base, mm.
    Raises `GeometryError` when the nominal chain is not of the family.
    """
    T = _as_poses(T_base_flange)
    nominal = arm.as_nominal().chain
    geometry = OPWGeometry.of_chain(nominal)
    if arm.chain is nominal:
        theta = solve_opw(geometry, T)
    else:
        theta = solve_opw(geometry, T, least_bend=START_BEND)
        theta = _newton(arm.chain, np.repeat(T, theta.shape[1], axis=0), theta.reshape(-1, 6)).reshape(theta.shape)
    joints = arm.shown_angles(theta)
    joints -= TURN * np.ceil(joints / TURN - 0.5)
    return JointSolutions(joints, np.asarray(np.isfinite(joints).all(axis=-1)))


def _as_poses(T: ArrayLike) -> FloatArray:
    poses = np.asarray(T, dtype=np.float64)
    if poses.ndim != 3 or poses.shape[1:] != (4, 4):
        raise InputError(f"expected poses of shape (N, 4, 4), got {poses.shape}")
    if not np.isfinite(poses).all():
        raise InputError(f"pose {int(np.argmin(np.isfinite(poses).all(axis=(1, 2)))) + 1} holds a value not finite")
    return poses


def _newton(chain: MDHChain, T: FloatArray, theta: FloatArray) -> FloatArray:
    """Improve model angles (M, 6) until they meet the poses (M, 4, 4); NaN where they do not.

    This is not the least-squares solver of `wpcal.optim`: thousands of square systems are solved at once, to round-off.
    """
    angles = theta.copy()
    open_rows = np.flatnonzero(np.isfinite(angles).all(axis=1))
    reach = max(float(np.abs(chain.a).sum() + np.abs(chain.d).sum()), 1.0)
    scale = np.array([1.0, 1.0, 1.0, *(1.0 / reach,) * 3])  # rows of the Jacobian alike, whatever the arm's size
    for _ in range(NEWTON_STEPS):
        error = _pose_error(chain, T[open_rows], angles[open_rows])
        met = (np.abs(error[:, :3]).max(axis=1) < NEWTON_RAD) & (np.abs(error[:, 3:]).max(axis=1) < NEWTON_MM)
        open_rows, error = open_rows[~met], error[~met]
        if open_rows.size == 0:
            return angles
        J = geometric_jacobian(chain, angles[open_rows]) * scale[:, None]
        Jt = np.swapaxes(J, 1, 2)
        step, _ = solve(product(Jt, J) + DAMPING * np.eye(6), product(Jt, (error * scale)[:, :, None]))
        angles[open_rows] += step[:, :, 0]
    angles[open_rows] = np.nan
    return angles


def _pose_error(chain: MDHChain, T: FloatArray, theta: FloatArray) -> FloatArray:
    """Error that remains, shape (M, 6): rotation vector (rad) and distance (mm), in the base."""
    now = forward_kinematics(chain, theta)
    turn = log_rotation(product(T[:, :3, :3], np.swapaxes(now[:, :3, :3], 1, 2)))
    return np.concatenate([turn, T[:, :3, 3] - now[:, :3, 3]], axis=1)


def turn_into_limits(arm: Arm, joints: ArrayLike, near: ArrayLike) -> FloatArray:
    """Add whole turns so that every angle is within its limits and as near as possible to another.

    `joints`: shape (..., n). Shown angles, rad.
    `near`: shape broadcasting with `joints`. The angles before: a last axis with several turns then does not jump back.
    Returns ndarray, shape (..., n). NaN for an angle that no number of turns brings within the limits.
    """
    q = np.asarray(joints, dtype=np.float64)
    low, high = arm.limits
    fewest, most = np.ceil((low - q) / TURN), np.floor((high - q) / TURN)
    turns = np.clip(np.rint((np.asarray(near) - q) / TURN), fewest, most)
    return np.where(fewest <= most, q + TURN * turns, np.nan)


def nearest_joints(arm: Arm, T_base_flange: ArrayLike, near: ArrayLike) -> FloatArray:
    """Return, for each pose on its own, the solution within limits whose largest joint move from `near` is smallest.

    Returns ndarray, shape (N, n). Shown angles, rad.

    Parameters
    ----------
    T_base_flange : array_like, shape (N, 4, 4)
    near : shape (n,) or (N, n). Shown angles, rad.

    Raises
    ------
    GeometryError : When a pose is out of reach or all its solutions break a limit: which pose, and which of the two.
    """
    solutions = solve_inverse(arm, T_base_flange)
    target = np.broadcast_to(np.asarray(near, dtype=np.float64), (len(solutions.joints), len(arm.joints)))[:, None]
    q = turn_into_limits(arm, solutions.joints, target)
    move = np.abs(q - target).max(axis=2)  # NaN where a branch has no solution
    usable = np.isfinite(move)
    if not usable.any(axis=1).all():
        row = int(np.argmin(usable.any(axis=1)))
        why = "every solution breaks a joint limit" if solutions.reached[row].any() else "is out of reach"
        raise GeometryError(f"{arm.name}: pose {row + 1} of {len(usable)}: {why}")
    best = np.argmin(np.where(usable, move, np.inf), axis=1)
    return np.asarray(q[np.arange(len(q)), best], dtype=np.float64)


def follow_path(arm: Arm, T_base_flange: ArrayLike, start: ArrayLike) -> FloatArray:
    """Return joint angles along a path of poses, each chosen nearest to the one before.

    Raises `GeometryError` as in `nearest_joints`.

    Parameters
    ----------
    T_base_flange : shape (N, 4, 4). Flange poses in the order of travel.
    start : shape (n,). Shown angles before the first pose, rad.

    Returns
    -------
    ndarray, shape (N, n)
        Shown angles, rad; a last axis with several turns goes on turning as long as its limits allow.
    """
    solutions = solve_inverse(arm, T_base_flange)
    path = np.empty((len(solutions.joints), len(arm.joints)))
    before = np.asarray(start, dtype=np.float64)
    for row, candidates in enumerate(solutions.joints):
        q = turn_into_limits(arm, candidates, before)
        move = np.abs(q - before).max(axis=1)
        if np.isnan(move).all():
            why = "every solution breaks a joint limit" if solutions.reached[row].any() else "is out of reach"
            raise GeometryError(f"{arm.name}: pose {row + 1} of {len(path)}: {why}")
        before = path[row] = q[np.nanargmin(move)]
    return path
