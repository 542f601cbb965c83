"""`RobotCell`: arms, bases, tools and bodies; `CellState`: the joints of both robots at the points of a path.

Robot 1 carries the torch, robot 2 holds the part. `world` has z against gravity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.same_bits import arc_tangent, product
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm

JOINTS = 6
"""The closed-form inverse kinematics that both arms need has six joints."""


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A rigid body for collision checks: some capsules, and the hull around it.

    Parameters
    ----------
    hull : array_like, shape (m, 3), optional
        Corners of the convex body in the same frame, mm; empty if the body has capsules only.

    Raises
    ------
    InputError : When shapes of arrays differ, a value is not finite or a radius is not positive.
    """

    name: str
    #: `p`, `q`: shape (k, 3). Ends of the capsules' axes in the frame of the body, mm; equal ends make a ball.
    p: FloatArray
    q: FloatArray
    radius_mm: FloatArray  #: shape (k,).
    #: For a body of an arm: the frame it moves with. 0 is the base, i the frame after link i of the chain, and 6 (the
    #: last) the flange. Bodies of the torch, the part and the bench are given in `tool`, `part` and `world`.
    link: int = 0
    hull: FloatArray = ()  # type: ignore[assignment]  # frozen in __post_init__
    #: For a body of the torch that works close to the part (the nozzle): its own safety distance to the part.
    to_part_mm: float | None = None

    def __post_init__(self) -> None:
        p, q, radius = frozen(self.p).reshape(-1, 3), frozen(self.q).reshape(-1, 3), frozen(self.radius_mm).reshape(-1)
        hull = frozen(self.hull).reshape(-1, 3)
        if not len(p) == len(q) == len(radius) >= 1:
            raise InputError(f"shape {self.name}: {len(p)} and {len(q)} ends of axes, {len(radius)} radii; one each")
        if not all(np.isfinite(values).all() for values in (p, q, radius, hull)):
            raise InputError(f"shape {self.name}: a value is not finite")
        if not (radius > 0).all():
            raise InputError(f"shape {self.name}: a radius must be positive, got {radius.min():g} mm")
        if not 0 <= self.link <= JOINTS:
            raise InputError(f"shape {self.name}: link is 0 (base) to {JOINTS} (flange), got {self.link}")
        for name, values in (("p", p), ("q", q), ("radius_mm", radius), ("hull", hull)):
            values.setflags(write=False)
            object.__setattr__(self, name, values)


@dataclass(frozen=True, slots=True, eq=False)
class RobotCell:
    """Two arms, the torch and the part that they carry, and the fixed bodies around them.

    Raises
    ------
    InputError
        When an arm does not have six joints, a frame name is wrong, the safety distance is negative or a weight is
        not positive.
    """

    name: str
    #: `arm1`, `arm2`: Robot 1 with the torch, robot 2 with the part.
    arm1: Arm
    arm2: Arm
    T_world_base1: RigidTransform
    T_world_base2: RigidTransform
    T_flange1_tool: RigidTransform  #: The torch: z of `tool` is the wire direction, its origin the tip of the wire.
    T_flange2_part: RigidTransform  #: The grasp: `part` has the coordinates of the STEP file.
    #: Safety distance, mm: a state is clear if the least distance between bodies is larger (Hou 2018, eq. 6).
    d1_mm: float
    #: `weights1`, `weights2`: shape (6,). K_j of Hou 2018, eq. 4: the weight of each joint in the motion.
    weights1: FloatArray
    weights2: FloatArray
    #: `links1`, `links2`: Bodies of the arms (with grippers and cables), each with the link that carries it.
    links1: tuple[Shape, ...] = ()
    links2: tuple[Shape, ...] = ()
    #: `torch`, `part`, `bench`: Bodies in the frames `tool`, `part` and `world`.
    torch: tuple[Shape, ...] = ()
    part: tuple[Shape, ...] = ()
    bench: tuple[Shape, ...] = ()
    source: str = ""  #: Origin of the numbers, above all of the bodies.
    floor_z_mm: float = 0.0  #: Height of the floor in `world`, mm.
    #: Height in `world` at which each arm is mounted, mm; None: on the floor. `check_cell` compares it with the bases.
    mount_z_mm: tuple[float | None, float | None] = (None, None)

    def __post_init__(self) -> None:
        for arm in (self.arm1, self.arm2):
            if len(arm.joints) != JOINTS:
                raise InputError(f"{arm.name}: a planned arm has {JOINTS} joints, this one has {len(arm.joints)}")
        for name in ("T_world_base1", "T_world_base2", "T_flange1_tool", "T_flange2_part"):
            transform, frames = getattr(self, name), tuple(name.split("_")[1:])
            if (transform.target, transform.source) != frames:
                raise InputError(f"{name} joins the frames {transform.target!r} and {transform.source!r}")
        if not self.d1_mm >= 0:
            raise InputError(f"the safety distance must be 0 or more, got {self.d1_mm:g} mm")
        for name in ("weights1", "weights2"):
            weights = frozen(getattr(self, name))
            if weights.shape != (JOINTS,) or not (weights > 0).all():
                raise InputError(f"{name}: expected {JOINTS} positive numbers, got {weights.tolist()}")
            object.__setattr__(self, name, weights)

    @property
    def T_base1_base2(self) -> RigidTransform:
        """The pose of base 2 in base 1."""
        return self.T_world_base1.inverse() @ self.T_world_base2

    @property
    def joint_limits(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper limits of all twelve joints, robot 1 first, shape (12,) each, rad."""
        (low1, high1), (low2, high2) = self.arm1.limits, self.arm2.limits
        return np.concatenate([low1, low2]), np.concatenate([high1, high2])

    @property
    def joint_weights(self) -> FloatArray:
        """K_j of all twelve joints (Hou 2018, eq. 4), robot 1 first, shape (12,)."""
        return np.concatenate([self.weights1, self.weights2])

    @property
    def joint_speeds(self) -> FloatArray:
        """Largest speeds of all twelve joints, robot 1 first, shape (12,), rad/s; infinite where an arm states none."""
        return np.concatenate([joint_speeds(self.arm1), joint_speeds(self.arm2)])

    @property
    def T_world_middle(self) -> RigidTransform:
        """The frame between the robots: origin midway between the bases, x horizontal from base 1 to base 2, z up."""
        one, two = self.T_world_base1.t_mm, self.T_world_base2.t_mm
        x, y, _ = two - one
        R = rotation_from_zyx(0.0, 0.0, arc_tangent(y, x))
        return RigidTransform(R, (one + two) / 2, target="world", source="middle")


@dataclass(frozen=True, slots=True, eq=False)
class CellState:
    """Joints of both robots at n points of a path.

    Raises
    ------
    InputError : When a shape is wrong.
    """

    #: `joints1`, `joints2`: shape (n, 6). Shown angles, rad, unwrapped: the difference of neighbours is the actual
    #: move.
    joints1: FloatArray
    joints2: FloatArray

    def __post_init__(self) -> None:
        joints1, joints2 = frozen(self.joints1), frozen(self.joints2)
        if joints1.shape != joints2.shape or joints1.ndim != 2 or joints1.shape[1] != JOINTS:
            raise InputError(f"expected joints of shape (n, {JOINTS}) twice, got {joints1.shape} and {joints2.shape}")
        object.__setattr__(self, "joints1", joints1)
        object.__setattr__(self, "joints2", joints2)

    def __len__(self) -> int:
        return len(self.joints1)

    @property
    def both(self) -> FloatArray:
        """Joints of robot 1, then of robot 2, shape (n, 12), rad."""
        return np.concatenate([self.joints1, self.joints2], axis=1)


def joint_speeds(arm: Arm) -> FloatArray:
    """Return the largest speed of every joint, shape (6,), rad/s; infinite where the arm's file does not state it."""
    return np.array([math.inf if joint.speed_rad_s is None else joint.speed_rad_s for joint in arm.joints])


def tool_in_world(cell: RobotCell, joints1: FloatArray) -> FloatArray:
    """Return ``T_world_tool`` for joints of robot 1 of shape (n, 6), rad; shape (n, 4, 4), mm."""
    return product(product(cell.T_world_base1.matrix, cell.arm1.forward(joints1)), cell.T_flange1_tool.matrix)


def part_in_world(cell: RobotCell, joints2: FloatArray) -> FloatArray:
    """Return ``T_world_part`` for joints of robot 2 of shape (n, 6), rad; shape (n, 4, 4), mm."""
    return product(product(cell.T_world_base2.matrix, cell.arm2.forward(joints2)), cell.T_flange2_part.matrix)
