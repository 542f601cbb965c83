"""Inverse kinematics of an `Arm`: closed form, Newton steps where the arm is an identified one, limits, whole turns.

Also here: joint angles along a path in one branch of the inverse kinematics: continuous, and within the limits.

A linear move cannot change the branch: the arm would have to pass a singularity. Whole turns of an axis with more than
one turn are counted on along the path.

Which of its eight postures an arm is in, from its joint angles: what controllers call its configuration.

Two of the three choices are places of the wrist centre, as drawings of the makers show them: in front of axis 1 or
behind it, and in front of the line through axes 2 and 3 or behind it. *In front* is the side of the base's x axis when
joint 1 is at 0. The third choice is the sign of joint 5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.same_bits import product, solve
from wpcal.core.tangent import log_rotation
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.forward import MDHChain, forward_kinematics, geometric_jacobian
from wpcal.robot.kinematics.offset_wrist import OffsetWrist
from wpcal.robot.kinematics.opw import OPWGeometry, solve_opw

TURN = 2.0 * np.pi
AXES = 6  #: Of an arm whose inverse kinematics are solved.
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

    #: shape (N, b, 6); b is 8, or 16 where roots are searched. Shown joint angles, rad, each in the turn around zero;
    #: NaN where a branch does not reach.
    joints: FloatArray
    reached: BoolArray  #: shape (N, b). Whether the branch meets the pose; limits are not looked at.


@lru_cache(maxsize=64)
def family_of(chain: MDHChain) -> OPWGeometry | OffsetWrist:
    """Return how the inverse kinematics of a chain are found.

    Raises `GeometryError` when it is of no family, with what is not as it should be.
    """
    try:
        return OPWGeometry.of_chain(chain)
    except GeometryError as first:
        if len(chain) != AXES:
            raise
        try:
            return OffsetWrist.of_chain(chain)
        except GeometryError as error:
            raise GeometryError(f"{first}; {error}") from None


def has_searched_roots(arm: Arm) -> bool:
    """Tell whether the solutions of an arm are roots that are searched: their numbers name no branch along a path."""
    family = family_of(arm.as_nominal().chain)
    return isinstance(family, OffsetWrist) and not family.is_parallel


def solve_inverse(arm: Arm, T_base_flange: ArrayLike) -> JointSolutions:
    """Return the joint angles of all eight branches for flange poses.

    An arm of the OPW family or of that of `offset_wrist` has a closed form, or a search for all roots. An identified
    arm is no longer exactly of its family: the solutions of its nominal chain are followed by Newton steps with its own
    Jacobian.

    `T_base_flange`: shape (N, 4, 4). Flange poses in the base, mm.
    Raises `GeometryError` when the nominal chain is of no family.
    """
    T = _as_poses(T_base_flange)
    nominal = arm.as_nominal().chain
    family = family_of(nominal)
    if isinstance(family, OPWGeometry):
        theta = solve_opw(family, T, least_bend=0.0 if arm.chain is nominal else START_BEND)
    else:
        theta = family.solve(T)
    if arm.chain is not nominal or has_searched_roots(arm):
        theta = _newton(arm.chain, np.repeat(T, theta.shape[1], axis=0), theta.reshape(-1, 6)).reshape(theta.shape)
    joints = arm.shown_angles(theta)
    joints -= TURN * np.ceil(joints / TURN - 0.5)
    return JointSolutions(joints, np.asarray(np.isfinite(joints).all(axis=-1)))


def own_branch(arm: Arm, T_base_flange: ArrayLike, branch: int, near: FloatArray) -> FloatArray:
    """Return the angles of one branch at N poses, shape (N, 6); of searched roots those that are nearest.

    `near`: shape (6,) or (N, 6). Angles at the first pose, from where on each pose is the next one; or at every pose.
    """
    if not has_searched_roots(arm):
        return np.asarray(solve_inverse(arm, T_base_flange).joints[:, branch])
    if near.ndim > 1:  # no search is needed
        found = arm.shown_angles(_newton(arm.chain, _as_poses(T_base_flange), arm.model_angles(near)))
        return np.where((np.abs(found - near).max(axis=1) < LARGEST_STEP_RAD)[:, None], found, np.nan)
    joints = solve_inverse(arm, T_base_flange).joints
    found, last = np.full(joints[:, 0].shape, np.nan), near
    for row, every in enumerate(joints):
        step = every - last
        move = np.nan_to_num(np.abs(step - TURN * np.rint(step / TURN)).max(axis=1), nan=np.inf)
        if np.isfinite(move.min()):
            last = found[row] = every[int(np.argmin(move))]
    return found


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
        now = forward_kinematics(chain, angles[open_rows])
        turn = log_rotation(product(T[open_rows, :3, :3], np.swapaxes(now[:, :3, :3], 1, 2)))
        error = np.concatenate([turn, T[open_rows, :3, 3] - now[:, :3, 3]], axis=1)  # rad and mm, in the base
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


def with_whole_turns(joints: FloatArray, low: FloatArray, high: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return every state once for each choice of whole turns within the limits: its row, and its joints.

    `joints`: shape (m, n). Within half a turn, rad.
    `low`, `high`: shape (n,). rad.
    """
    state, turned = np.arange(len(joints)), joints
    for joint in range(joints.shape[1]):
        choices = np.arange(np.ceil((low[joint] - np.pi) / TURN), np.floor((high[joint] + np.pi) / TURN) + 1)
        angle = turned[:, joint, None] + TURN * choices
        row, choice = np.nonzero((angle >= low[joint]) & (angle <= high[joint]))
        state, turned = state[row], turned[row].copy()
        turned[:, joint] = angle[row, choice]
    return state, turned


def nearest_joints(arm: Arm, T_base_flange: ArrayLike, near: ArrayLike) -> FloatArray:
    """Return, for each pose on its own, the solution within limits whose largest joint move from `near` is smallest.

    Returns ndarray, shape (N, n). Shown angles, rad.

    `T_base_flange`: shape (N, 4, 4).
    `near`: shape (n,) or (N, n). Shown angles, rad.

    Raises `GeometryError` when a pose is out of reach or all its solutions break a limit: which pose, and which of the
    two.
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

    `T_base_flange`: shape (N, 4, 4). Flange poses in the order of travel.
    `start`: shape (n,). Shown angles before the first pose, rad.
    Returns ndarray, shape (N, n). Shown angles, rad; a last axis with several turns goes on turning as long as its
    limits allow.
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


LARGEST_STEP_RAD = math.radians(45.0)
"""Between two poses some millimetres and degrees apart, a joint that turns by more swings through a singularity. Arms
stop there, or leave the path."""


@dataclass(frozen=True, slots=True, eq=False)
class Broken:
    """Where a path cannot go on."""

    row: int  #: The first pose that the arm does not get to.
    why: str


def continue_branch(arm: Arm, joints: ArrayLike, near: ArrayLike) -> FloatArray | Broken:
    """Count whole turns along a path, shape (N, n). Shown angles, rad; or where the path breaks, and why.

    `joints`: shape (N, n). Shown angles of one branch, each in the turn around zero, rad; NaN where the branch does not
    reach.
    `near`: shape (n,). The first angles are as near as possible to these.
    """
    q = np.asarray(joints, dtype=np.float64)
    out = ~np.isfinite(q).all(axis=1)
    if out.any():
        return Broken(int(np.argmax(out)), "is out of reach")
    steps = np.diff(q, axis=0)
    steps -= TURN * np.rint(steps / TURN)
    path = np.concatenate([q[:1], q[:1] + np.cumsum(steps, axis=0)])
    broken = [_limit(arm, path, joint, np.asarray(near)) for joint in range(q.shape[1])]
    jumps = np.abs(steps) > LARGEST_STEP_RAD
    if jumps.any():
        row, joint = (int(index[0]) for index in np.nonzero(jumps))
        degrees = math.degrees(steps[row, joint])
        broken.append(Broken(row + 1, f"joint {arm.joints[joint].name} would swing by {degrees:.0f} deg to get there"))
    found = [each for each in broken if each is not None]
    return min(found, key=lambda each: each.row) if found else path


def _limit(arm: Arm, path: FloatArray, joint: int, near: FloatArray) -> Broken | None:
    """Move one column of `path` by whole turns into the limits, in place; where it breaks them, if it does."""
    low, high = arm.limits[:, joint]
    column = path[:, joint]
    nearest = int(np.rint((near[joint] - column[0]) / TURN))
    turns = sorted(range(nearest - 3, nearest + 4), key=lambda turn: abs(turn - nearest))
    outside = [(column + TURN * turn < low) | (column + TURN * turn > high) for turn in turns]
    held = [int(np.argmax(rows)) if rows.any() else len(column) for rows in outside]
    best = held.index(max(held))
    path[:, joint] = column + TURN * turns[best]
    if held[best] == len(column):
        return None
    name, degrees = arm.joints[joint].name, math.degrees(path[held[best], joint])
    limits = f"{math.degrees(low):g} and {math.degrees(high):g} deg"
    return Broken(held[best], f"joint {name} would be at {degrees:.0f} deg, its limits are {limits}")


FRONT_COS = 0.9
"""With joint 1 at 0 the arm reaches along the base's x axis on every controller; an arm file that is off by more than
about 25° has another zero or another base."""


@dataclass(frozen=True, slots=True, eq=False)
class Posture:
    """Postures for N joint angles."""

    joints: FloatArray  #: shape (N, 6). Shown angles, rad.
    is_behind: BoolArray  #: shape (N,). Whether the wrist centre is behind axis 1.
    is_behind_lower_arm: BoolArray  #: shape (N,). Whether the wrist centre is behind the line through axes 2 and 3.

    def __len__(self) -> int:
        return len(self.joints)

    @property
    def degrees(self) -> FloatArray:
        """Shown angles, deg, shape (N, 6)."""
        return np.asarray(np.rad2deg(self.joints), dtype=np.float64)


def posture(arm: Arm, joints: ArrayLike) -> Posture:
    """Return the postures of an arm.

    `joints`: shape (N, 6). Shown angles, rad.

    Raises `GeometryError` when the arm has no spherical wrist, or does not reach along the base's x axis at joint 1 =
    0: which side is its front is then not known.
    """
    q = np.asarray(joints, dtype=np.float64)
    nominal = arm.as_nominal()
    g = OPWGeometry.of_chain(nominal.chain)
    t = nominal.model_angles(q) * g.signs + g.offsets
    zero = float((nominal.model_angles(np.zeros(6)) * g.signs + g.offsets)[0])
    reach = g.T_base_opw[:3, :3] @ np.array([np.cos(zero), np.sin(zero), 0.0])
    if abs(reach[0]) < FRONT_COS:
        raise GeometryError(
            f"{arm.name}: with joint 1 at 0 it does not reach along the x axis of its base; which side is its front is "
            "not known"
        )
    front = float(np.sign(reach[0]))
    up = float(np.sign(g.T_base_opw[2, 2])) or 1.0
    bend = t[:, 2] + np.arctan2(g.a2, g.c3)
    r = g.a1 + g.c2 * np.sin(t[:, 1]) + np.hypot(g.a2, g.c3) * np.sin(t[:, 1] + bend)
    return Posture(
        q, np.asarray(front * r < 0.0, dtype=np.bool_), np.asarray(front * up * np.sin(bend) < 0.0, dtype=np.bool_)
    )
