"""`Cell`: a robot with a torch, what carries the part, and the bodies around them.

The part is fixed in `world`, or its carrier is a positioner with one or two axes, or a second robot. All axes of a cell
are one row of numbers: six joints of the robot with the torch, then its rail, then the axes of the carrier. Angles are
in rad and the rail is in mm; `world` has z against gravity. In a cell of two robots, robot 1 carries the torch and
robot 2 holds the part.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.same_bits import arc_tangent, inverse_pose, length, product
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.shape import JOINTS, Shape
from wpcal.robot.kinematics.arm import Arm, arm_frames
from wpcal.robot.kinematics.forward import Frames, start_frames
from wpcal.robot.torch.shape import TorchShape

IN_WORLD = start_frames(RigidTransform.identity(target="world", source="world"), 1)  #: The frame of what stands still.
MOST_AXES = 2  #: Axes of a positioner: one turns the part, two also tilt it.
TOOL, WORLD, CARRIER = JOINTS + 1, JOINTS + 2, JOINTS + 3
"""Rows of these frames in the result of `Cell.frames`, after the seven of the robot. The frames of the carrier begin at
CARRIER, and the frame of the part is last."""


@dataclass(frozen=True, slots=True, eq=False)
class Rail:
    """A straight rail under the robot.

    Raises `InputError` when the direction is zero, or the limits or the speed are no range.
    """

    direction: FloatArray  #: shape (3,). Unit vector in `world` along which the base moves.
    min_mm: float
    max_mm: float
    speed_mm_s: float  #: Largest speed.

    def __post_init__(self) -> None:
        direction = frozen(self.direction)
        size = length(direction) if direction.shape == (3,) else math.nan
        if not 0.0 < size < math.inf:
            raise InputError(f"rail: expected a direction of three numbers, got {np.asarray(direction).tolist()}")
        if not self.min_mm < self.max_mm or not 0.0 < self.speed_mm_s < math.inf:
            raise InputError(
                f"rail: expected min_mm below max_mm and a positive speed, got {self.min_mm:g}, {self.max_mm:g} mm and "
                f"{self.speed_mm_s:g} mm/s"
            )
        object.__setattr__(self, "direction", frozen(direction / size))


@dataclass(frozen=True, slots=True, eq=False)
class Carrier:
    """What moves the part: a positioner with one or two axes, or a second robot.

    Raises `InputError` when the number of axes is wrong, or a body is on a link that is not there.
    """

    arm: Arm  #: The part is carried by its flange.
    T_world_base: RigidTransform
    links: tuple[Shape, ...] = ()  #: Bodies; link 0 is the frame, the others are moved by the axes.
    mount_z_mm: float | None = None  #: As in `Cell`.

    def __post_init__(self) -> None:
        count = len(self.arm.joints)
        if not (1 <= count <= MOST_AXES or count == JOINTS):
            what = f"{self.arm.name}: a positioner has one or two axes, and a second robot {JOINTS}"
            raise InputError(f"{what}, this one has {count}")
        for shape in self.links:
            if shape.link > count:
                raise InputError(f"positioner {shape.name}: link {shape.link}, but it has {count} axes")

    @property
    def is_robot(self) -> bool:
        """Whether it is a second robot."""
        return len(self.arm.joints) == JOINTS


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """One robot with a torch, or two robots; k axes in all.

    Raises `InputError` when the arm does not have six joints, a number of axes is wrong, home is beyond a limit, the
    safety distance is negative, or a weight is not positive.
    """

    name: str
    arm: Arm  #: The robot with the torch.
    T_world_base: RigidTransform  #: Its base; with a rail, where the base is when the rail is at 0.
    T_flange_tool: RigidTransform  #: z of `tool` is the wire direction, its origin the tip of the wire.
    #: The part in the frame of the carrier's flange, or in `world` if there is no carrier. None: not known yet.
    T_carrier_part: RigidTransform | None
    #: Safety distance, mm: a state is clear if the least distance between bodies is larger (Hou 2018, eq. 6).
    d1_mm: float
    #: shape (k,). Where programs start and end: all axes, rad and mm. Of two robots zero, or the limit nearest to zero,
    #: if it is not stated.
    home: FloatArray = field(default_factory=lambda: np.zeros(0))
    rail: Rail | None = None
    carrier: Carrier | None = None
    #: shape (k - 6,). External axes while the part was touched, rad and mm; without it those of home.
    touched_at: FloatArray = field(default_factory=lambda: np.zeros(0))
    #: `links`, `torch`, `part`, `bench`: bodies of the robot, in `tool`, in `part` and in `world`.
    links: tuple[Shape, ...] = ()
    torch: tuple[Shape, ...] = ()
    part: tuple[Shape, ...] = ()
    bench: tuple[Shape, ...] = ()
    floor_z_mm: float = 0.0  #: Height of the floor in `world`, mm.
    mount_z_mm: float | None = None  #: Height in `world` at which the arm is mounted, mm; None: on the floor.
    source: str = ""  #: Origin of the numbers, above all of the bodies.
    #: The torch whose bodies `torch` holds, to be compared with that of the seams; None: not stated.
    torch_shape: TorchShape | None = None
    #: shape (k,). K_j of Hou 2018, eq. 4: the weight of each axis in the motion of two robots; empty for one robot.
    joint_weights: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if len(self.arm.joints) != JOINTS:
            raise InputError(f"{self.arm.name}: a planned arm has {JOINTS} joints, this one has {len(self.arm.joints)}")
        if not self.d1_mm >= 0:
            raise InputError(f"the safety distance must be 0 or more, got {self.d1_mm:g} mm")
        low, high = self.limits
        k, usual = len(low), np.clip(np.zeros(len(low)), low, high)
        is_stated = self.home.any() if self.has_two_robots else len(self.home)
        home = frozen(self.home if is_stated else usual)
        touched = frozen(self.touched_at if len(self.touched_at) else home[JOINTS:])
        weights = frozen(self.joint_weights)
        if home.shape != (k,) or touched.shape != (k - JOINTS,):
            raise InputError(
                f"home and touched_at: expected {k} and {k - JOINTS} numbers, got {home.size} and {touched.size}"
            )
        for name, value, least, most in zip(self.axis_names, home, low, high, strict=True):
            if not least <= value <= most:
                raise InputError(f"home: {name} is beyond its limits")
        if len(weights) and (weights.shape != (k,) or not (weights > 0).all()):
            raise InputError(f"joint weights: expected {k} positive numbers, got {weights.tolist()}")
        for field_name, values in (("home", home), ("touched_at", touched), ("joint_weights", weights)):
            object.__setattr__(self, field_name, values)

    @property
    def has_two_robots(self) -> bool:
        """Whether a second robot holds the part."""
        return self.carrier is not None and self.carrier.is_robot

    @property
    def goes_from_home(self) -> bool:
        """Whether two robots have a home that is stated: their programs go from there straight to the first point."""
        return self.has_two_robots and bool((self.home != np.clip(0.0, *self.limits)).any())

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of all axes, each once: joints of the arm, the rail, the axes of the carrier."""
        rail = () if self.rail is None else ("rail",)
        own = (*(joint.name for joint in self.arm.joints), *rail)
        turning = () if self.carrier is None else tuple(joint.name for joint in self.carrier.arm.joints)
        return (*own, *(f"positioner_{name}" if name in own else name for name in turning))

    @property
    def limits(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper limits of all axes, shape (k,) each, rad and mm."""
        rail = [] if self.rail is None else [[[self.rail.min_mm], [self.rail.max_mm]]]
        turning = [] if self.carrier is None else [self.carrier.arm.limits]
        low, high = np.concatenate([self.arm.limits, *rail, *turning], axis=1)
        return low, high

    @property
    def speeds(self) -> FloatArray:
        """Largest speeds of all axes, shape (k,), rad/s and mm/s; infinite where they are not stated."""
        rail = [] if self.rail is None else [[self.rail.speed_mm_s]]
        turning = [] if self.carrier is None else [joint_speeds(self.carrier.arm)]
        return np.concatenate([joint_speeds(self.arm), *rail, *turning])

    @property
    def rail_axis(self) -> int | None:
        """Column of the rail."""
        return None if self.rail is None else JOINTS

    @property
    def first_turning(self) -> int:
        """Column of the first axis of the carrier."""
        return JOINTS + (self.rail is not None)

    @property
    def T_part(self) -> RigidTransform:
        """The part in its carrier. Raises `InputError` when it is not known."""
        if self.T_carrier_part is None:
            raise InputError(
                "the part's place is not known: give the folder of a finished calibration, or write "
                f"{'T_flange_part in positioner' if self.carrier else 'T_world_part'} of the cell"
            )
        return self.T_carrier_part

    def joint_of(self, column: int) -> tuple[int, str]:
        """Return the number of the robot, 1 or 2, and the name of the joint of a column of two robots."""
        robot, joint = divmod(column, JOINTS)
        return robot + 1, (self.arm, self.arm2)[robot].joints[joint].name

    @property
    def arm2(self) -> Arm:
        """Robot 2."""
        return self._robot2.arm

    @property
    def T_world_base2(self) -> RigidTransform:
        """The base of robot 2."""
        return self._robot2.T_world_base

    @property
    def _robot2(self) -> Carrier:
        if self.carrier is None:
            raise InputError(f"{self.name}: this cell has one robot; expected two")
        return self.carrier

    @property
    def T_base1_base2(self) -> RigidTransform:
        """The pose of base 2 in base 1."""
        return self.T_world_base.inverse() @ self.T_world_base2

    @property
    def T_world_middle(self) -> RigidTransform:
        """The frame between two robots: origin midway between the bases, x horizontal from base 1 to base 2, z up."""
        one, two = self.T_world_base.t_mm, self.T_world_base2.t_mm
        x, y, _ = two - one
        R = rotation_from_zyx(0.0, 0.0, arc_tangent(y, x))
        return RigidTransform(R, (one + two) / 2, target="world", source="middle")

    def base_places(self, q: FloatArray) -> FloatArray:
        """Return ``T_world_base`` for axes of shape (n, k); shape (n, 4, 4), mm."""
        T = np.repeat(self.T_world_base.matrix[None], len(q), axis=0)
        if self.rail is not None:
            T[:, :3, 3] += q[:, JOINTS, None] * self.rail.direction
        return T

    def carrier_places(self, q: FloatArray) -> FloatArray:
        """Return ``T_world_carrier`` (the flange of the carrier) for axes of shape (n, k); shape (n, 4, 4), mm."""
        if self.carrier is None:
            return np.repeat(np.eye(4)[None], len(q), axis=0)
        return product(self.carrier.T_world_base.matrix, self.carrier.arm.forward(q[:, self.first_turning :]))

    def part_places(self, q: FloatArray) -> FloatArray:
        """Return ``T_world_part`` for axes of shape (n, k); shape (n, 4, 4), mm."""
        return product(self.carrier_places(q), self.T_part.matrix)

    def held_places(self, joints2: FloatArray) -> FloatArray:
        """Return ``T_world_part`` for joints of robot 2 of shape (n, 6), rad; shape (n, 4, 4), mm."""
        return self.part_places(np.pad(joints2, ((0, 0), (self.first_turning, 0))))

    def tool_places(self, q: FloatArray) -> FloatArray:
        """Return ``T_world_tool`` for axes of shape (n, k); shape (n, 4, 4), mm."""
        return product(product(self.base_places(q), self.arm.forward(q[:, :JOINTS])), self.T_flange_tool.matrix)

    def tool_in_part(self, q: FloatArray) -> FloatArray:
        """Return ``T_part_tool`` for axes of shape (n, k); shape (n, 4, 4), mm."""
        return product(inverse_pose(self.part_places(q)), self.tool_places(q))

    def allowed_mm_s(self, q: FloatArray, s_mm: FloatArray) -> FloatArray:
        """Return the largest speed that each axis allows on each step along a seam, shape (n - 1, k), mm/s.

        `q`: shape (n, k). All axes at the arc lengths `s_mm`, shape (n,).
        """
        moves = np.abs(np.diff(q, axis=0))
        allowed = self.speeds * np.diff(s_mm)[:, None]
        found: FloatArray = np.divide(allowed, moves, out=np.full(moves.shape, math.inf), where=moves > 0)
        return found

    def frames(self, q: FloatArray) -> tuple[Frames, ...]:
        """Return the frames that carry bodies for axes of shape (n, k), in `world`, mm.

        Returns tuple of Frames. Seven of the arm, `tool`, `world`, those of the carrier (its base and one per axis),
        the part; arrays of shape (3, n) or (3, 1).
        """
        shift = None if self.rail is None else self.rail.direction[:, None] * q[:, JOINTS]
        arm = list(arm_frames(self.arm, self.T_world_base, q[:, :JOINTS], shift_mm=shift))
        carrier, turning = self.carrier, q[:, self.first_turning :]
        carried = [] if carrier is None else list(arm_frames(carrier.arm, carrier.T_world_base, turning))
        last = [IN_WORLD, *carried][-1]
        part = last if self.T_carrier_part is None else last.then(self.T_carrier_part)
        return (*arm, arm[-1].then(self.T_flange_tool), IN_WORLD, *carried, part)

    @property
    def part_row(self) -> int:
        """Row of the part's frame in `frames`."""
        return CARRIER if self.carrier is None else CARRIER + 1 + len(self.carrier.arm.joints)

    def with_joint_margin(self, margin_rad: float) -> Cell:
        """Return the cell whose joints of the robot with the torch stay away from their limits, as far as home lets."""
        joints = tuple(
            replace(
                joint,
                min_rad=min(joint.min_rad + margin_rad, max(home, joint.min_rad)),
                max_rad=max(joint.max_rad - margin_rad, min(home, joint.max_rad)),
            )
            for joint, home in zip(self.arm.joints, self.home[:JOINTS].tolist(), strict=True)
        )
        return replace(self, arm=replace(self.arm, joints=joints))

    def with_touched_part(self, T_base_part: RigidTransform) -> Cell:
        """Return the cell with the part where the robot found it, its external axes at `touched_at`."""
        q = np.concatenate([self.home[:JOINTS], self.touched_at])[None]
        T_world_part = product(self.base_places(q)[0], T_base_part.matrix)
        matrix = product(inverse_pose(self.carrier_places(q)[0]), T_world_part)
        return replace(self, T_carrier_part=RigidTransform.from_matrix(matrix, target="carrier", source="part"))


def joint_speeds(arm: Arm) -> FloatArray:
    """Return the largest speed of every joint, shape (n,), rad/s; infinite where the arm's file does not state it."""
    return np.array([math.inf if joint.speed_rad_s is None else joint.speed_rad_s for joint in arm.joints])
