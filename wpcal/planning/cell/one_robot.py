"""`OneRobotCell`: one robot with a torch, and what carries the part: the floor, or a positioner with one or two axes.

The robot may move on a rail. All axes of a cell are one row of numbers: six joints of the arm, then the rail, then
the axes of the positioner. Angles are in rad and the rail is in mm; `world` has z against gravity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.same_bits import inverse_pose, product
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.bodies import arm_frames
from wpcal.planning.cell.robot_cell import JOINTS, Shape, joint_speeds
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.forward import Frames, start_frames
from wpcal.robot.torch.shape import TorchShape

MOST_AXES = 2
"""Axes of a positioner: one turns the part, two also tilt it."""
TOOL, WORLD, CARRIER = JOINTS + 1, JOINTS + 2, JOINTS + 3
"""Rows of these frames in the result of `OneRobotCell.frames`, after the seven of the arm. The frames of the positioner
begin at CARRIER, and the frame of the part is last."""
RAIL_MM_PER_RAD = 1000.0
"""A metre on the rail is weighed like one radian of a joint wherever axes are compared."""


@dataclass(frozen=True, slots=True, eq=False)
class Rail:
    """A straight rail under the robot.

    Raises
    ------
    InputError : When the direction is zero, or the limits or the speed are no range.
    """

    direction: FloatArray  #: shape (3,). Unit vector in `world` along which the base moves.
    #: `min_mm`, `max_mm`: Limits.
    min_mm: float
    max_mm: float
    speed_mm_s: float  #: Largest speed.

    def __post_init__(self) -> None:
        direction = frozen(self.direction)
        length = float(np.sqrt(product(direction, direction))) if direction.shape == (3,) else math.nan
        if not 0.0 < length < math.inf:
            raise InputError(f"rail: expected a direction of three numbers, got {np.asarray(direction).tolist()}")
        if not self.min_mm < self.max_mm or not 0.0 < self.speed_mm_s < math.inf:
            raise InputError(
                f"rail: expected min_mm below max_mm and a positive speed, got {self.min_mm:g}, {self.max_mm:g} mm and "
                f"{self.speed_mm_s:g} mm/s"
            )
        object.__setattr__(self, "direction", frozen(direction / length))


@dataclass(frozen=True, slots=True, eq=False)
class Positioner:
    """A positioner: its axes as an arm of one or two joints, and its bodies.

    Raises
    ------
    InputError : When there are not one or two axes, or a body is on a link that is not there.
    """

    arm: Arm  #: The part is carried by its flange.
    T_world_base: RigidTransform
    links: tuple[Shape, ...] = ()  #: Bodies; link 0 is the frame, 1 and 2 are moved by the axes.

    def __post_init__(self) -> None:
        if not 1 <= len(self.arm.joints) <= MOST_AXES:
            raise InputError(f"{self.arm.name}: a positioner has one or two axes, this one has {len(self.arm.joints)}")
        for shape in self.links:
            if shape.link > len(self.arm.joints):
                raise InputError(f"positioner {shape.name}: link {shape.link}, but it has {len(self.arm.joints)} axes")


@dataclass(frozen=True, slots=True, eq=False)
class OneRobotCell:
    """One robot, and the part fixed or on a positioner.

    Raises
    ------
    InputError : When the arm has not six joints, a number of axes is wrong, or the home is beyond a limit.
    """

    name: str
    arm: Arm  #: The robot with the torch.
    T_world_base: RigidTransform  #: Its base; with a rail, where the base is when the rail is at 0.
    T_flange_tool: RigidTransform  #: z of `tool` is the wire direction, its origin the tip of the wire.
    #: The part in the frame of the positioner's flange, or in `world` if there is no positioner. None: not known yet.
    T_carrier_part: RigidTransform | None
    d1_mm: float  #: Safety distance between bodies, mm.
    home: FloatArray  #: shape (k,). Where programs start and end: all axes, rad and mm.
    rail: Rail | None = None
    positioner: Positioner | None = None
    #: shape (k - 6,). External axes while the part was touched, rad and mm.
    touched_at: FloatArray = field(default_factory=lambda: np.zeros(0))
    #: `links`, `torch`, `bench`: Bodies of the arm, in `tool` and in `world`.
    links: tuple[Shape, ...] = ()
    torch: tuple[Shape, ...] = ()
    bench: tuple[Shape, ...] = ()
    floor_z_mm: float = 0.0  #: Height of the floor in `world`, mm.
    mount_z_mm: float | None = None  #: Height in `world` at which the arm is mounted, mm; None: on the floor.
    source: str = ""  #: Origin of the numbers.
    #: The torch whose bodies `torch` holds, to be compared with that of the seams; None: not stated.
    torch_shape: TorchShape | None = None

    def __post_init__(self) -> None:
        if len(self.arm.joints) != JOINTS:
            raise InputError(f"{self.arm.name}: a planned arm has {JOINTS} joints, this one has {len(self.arm.joints)}")
        if not self.d1_mm >= 0:
            raise InputError(f"the safety distance must be 0 or more, got {self.d1_mm:g} mm")
        k = len(self.axis_names)
        home, touched = frozen(self.home), frozen(self.touched_at)
        if home.shape != (k,) or touched.shape != (k - JOINTS,):
            raise InputError(
                f"home and touched_at: expected {k} and {k - JOINTS} numbers, got {home.size} and {touched.size}"
            )
        low, high = self.limits
        for name, value, least, most in zip(self.axis_names, home, low, high, strict=True):
            if not least <= value <= most:
                raise InputError(f"home: {name} is beyond its limits")
        object.__setattr__(self, "home", home)
        object.__setattr__(self, "touched_at", touched)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of all axes, each once: joints of the arm, the rail, the axes of the positioner."""
        rail = () if self.rail is None else ("rail",)
        own = (*(joint.name for joint in self.arm.joints), *rail)
        turning = () if self.positioner is None else tuple(joint.name for joint in self.positioner.arm.joints)
        return (*own, *(f"positioner_{name}" if name in own else name for name in turning))

    @property
    def limits(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper limits of all axes, shape (k,) each, rad and mm."""
        low, high = self.arm.limits
        if self.rail is not None:
            low, high = np.append(low, self.rail.min_mm), np.append(high, self.rail.max_mm)
        if self.positioner is not None:
            least, most = self.positioner.arm.limits
            low, high = np.append(low, least), np.append(high, most)
        return low, high

    @property
    def speeds(self) -> FloatArray:
        """Largest speeds of all axes, shape (k,), rad/s and mm/s; infinite where they are not stated."""
        speeds = joint_speeds(self.arm)
        if self.rail is not None:
            speeds = np.append(speeds, self.rail.speed_mm_s)
        if self.positioner is not None:
            speeds = np.append(speeds, joint_speeds(self.positioner.arm))
        return speeds

    @property
    def rail_axis(self) -> int | None:
        """Column of the rail."""
        return None if self.rail is None else JOINTS

    @property
    def first_turning(self) -> int:
        """Column of the first axis of the positioner."""
        return JOINTS + (self.rail is not None)

    @property
    def as_angles(self) -> FloatArray:
        """Factors that make all axes comparable angles, shape (k,): 1, and for the rail 1/`RAIL_MM_PER_RAD`."""
        factors = np.ones(len(self.axis_names))
        if self.rail_axis is not None:
            factors[self.rail_axis] = 1.0 / RAIL_MM_PER_RAD
        return factors

    @property
    def T_part(self) -> RigidTransform:
        """The part in its carrier.

        Raises
        ------
        InputError : When it is not known.
        """
        if self.T_carrier_part is None:
            raise InputError(
                "the part's place is not known: give the folder of a finished calibration, or write "
                f"{'T_flange_part in positioner' if self.positioner else 'T_world_part'} of the cell"
            )
        return self.T_carrier_part

    def base_places(self, q: FloatArray) -> FloatArray:
        """Return ``T_world_base`` for axes of shape (n, k); shape (n, 4, 4), mm."""
        T = np.repeat(self.T_world_base.matrix[None], len(q), axis=0)
        if self.rail is not None:
            T[:, :3, 3] += q[:, JOINTS, None] * self.rail.direction
        return T

    def carrier_places(self, q: FloatArray) -> FloatArray:
        """Return ``T_world_carrier`` (the flange of the positioner) for axes of shape (n, k); shape (n, 4, 4), mm."""
        if self.positioner is None:
            return np.repeat(np.eye(4)[None], len(q), axis=0)
        turned = self.positioner.arm.forward(q[:, self.first_turning :])
        return np.asarray(product(self.positioner.T_world_base.matrix, turned))

    def part_places(self, q: FloatArray) -> FloatArray:
        """Return ``T_world_part`` for axes of shape (n, k); shape (n, 4, 4), mm."""
        return product(self.carrier_places(q), self.T_part.matrix)

    def tool_places(self, q: FloatArray) -> FloatArray:
        """Return ``T_world_tool`` for axes of shape (n, k); shape (n, 4, 4), mm."""
        flange = product(self.base_places(q), self.arm.forward(q[:, :JOINTS]))
        return product(flange, self.T_flange_tool.matrix)

    def frames(self, q: FloatArray) -> tuple[Frames, ...]:
        """Return the frames that carry bodies, in `world`, mm.

        Parameters
        ----------
        q : ndarray, shape (n, k)

        Returns
        -------
        tuple of Frames
            Seven of the arm, `tool`, `world`, those of the positioner (its base and one per axis), the part; arrays
            of shape (3, n) or (3, 1).
        """
        shift = None if self.rail is None else self.rail.direction[:, None] * q[:, JOINTS]
        arm = list(arm_frames(self.arm, self.T_world_base, q[:, :JOINTS], shift_mm=shift))
        tool = arm[-1].then(self.T_flange_tool)
        world = start_frames(RigidTransform.identity(target="world", source="world"), 1)
        carried = [world]
        if self.positioner is not None:
            place = self.positioner.T_world_base
            carried = list(arm_frames(self.positioner.arm, place, q[:, self.first_turning :]))
        part = carried[-1] if self.T_carrier_part is None else carried[-1].then(self.T_carrier_part)
        return (*arm, tool, world, *(carried if self.positioner is not None else ()), part)

    @property
    def part_row(self) -> int:
        """Row of the part's frame in `frames`."""
        return CARRIER if self.positioner is None else CARRIER + 1 + len(self.positioner.arm.joints)

    def with_touched_part(self, T_base_part: RigidTransform) -> OneRobotCell:
        """Return the cell with the part where the robot found it, its external axes at `touched_at`."""
        q = np.concatenate([self.home[:JOINTS], self.touched_at])[None]
        T_world_part = product(self.base_places(q)[0], T_base_part.matrix)
        matrix = product(inverse_pose(self.carrier_places(q)[0]), T_world_part)
        return replace(self, T_carrier_part=RigidTransform.from_matrix(matrix, target="carrier", source="part"))
