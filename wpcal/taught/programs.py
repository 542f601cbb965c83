"""What the programs of all controllers have in common: stored points, in the frames that a file names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_number
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform

if TYPE_CHECKING:
    from wpcal.taught.features.reference import ReferenceFeature
    from wpcal.taught.table import TaughtPoints

LEAST_JOINTS = 4  #: Welding arms have six joints, palletising arms four. With fewer numbers, the line was cut.
BASE = "base"  #: Name of the user frame that is the robot's base itself.


@dataclass(frozen=True, slots=True, eq=False)
class JointValues:
    """A position stored as joint values."""

    values: FloatArray  #: shape (n,). Angles as shown on the pendant, deg, or encoder pulses.
    in_pulses: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class ProgramPoint:
    """One stored position."""

    name: str
    line: int  #: In the file, counted from 1.
    #: shape (3,). The tool centre point in `frame`, mm; NaN if the file does not have it. With a `fault` it cannot be
    #: used.
    p_mm: FloatArray
    R: FloatArray  #: shape (3, 3). The axes of the tool, as columns, in `frame`.
    frame: str | None = None  #: Name or number of the user frame, or `BASE`; None if the file does not say.
    at_flange: bool = False  #: Recorded without a tool: the position is that of the flange.
    #: Why the position cannot be used as it is, for example because it is stored as joint angles.
    fault: str | None = None
    joints: JointValues | None = None  #: Joint values, if the file holds these instead of coordinates.

    @property
    def T_frame_tool(self) -> RigidTransform:
        """The position as a pose of the tool in `frame`; NaN if the file does not have it."""
        return RigidTransform(self.R, self.p_mm, "frame", "tool")


@dataclass(frozen=True, slots=True, eq=False)
class ProgramPoints:
    """The positions in a file, and the user frames whose values it contains."""

    points: tuple[ProgramPoint, ...]
    frames: dict[str, RigidTransform] = field(default_factory=dict)  #: ``T_base_frame`` by name or number.


@dataclass(frozen=True, slots=True)
class ProgramReader:
    """How taught points are read from the files of one controller."""

    #: From a file's text and its path (for messages) to `ProgramPoints`. It raises `FormatError`.
    read: Callable[[str, str], ProgramPoints]
    #: From the numbers of a user frame, in the pendant's order, to ``T_base_frame``. It raises `InputError`.
    frame_of_pendant: Callable[[Sequence[float]], RigidTransform]
    pendant_order: str  #: That order for messages, for example ``X,Y,Z,A,B,C``.


@dataclass(frozen=True, slots=True, eq=False)
class TaughtProgram:
    """A program as read, in the frames that it names."""

    path: str  #: The file, for messages.
    reader: ProgramReader  #: Of the controller that wrote the file.
    found: ProgramPoints


def unusable_point(name: str, line: int, fault: str, joints: JointValues | None = None) -> ProgramPoint:
    """Return a point that the file stores without usable coordinates, with the reason."""
    return ProgramPoint(name, line, np.full(3, np.nan), np.eye(3), fault=fault, joints=joints)


def joint_values(values: Sequence[object], *, in_pulses: bool = False) -> JointValues | None:
    """Return joint values; None unless all are numbers (a file can hold asterisks or lack a joint)."""
    try:
        found = np.array([parse_number(str(value)) for value in values])
    except InputError:
        return None
    return JointValues(found, in_pulses) if len(found) >= LEAST_JOINTS else None


def stored_pose(
    cells: Sequence[tuple[str, str]],
    name: str,
    path: str,
    line: int,
    rotation: Callable[..., FloatArray] = rotation_from_zyx,
) -> RigidTransform:
    """Return the pose of six coordinates that a file stores as text, as `frame_from_angles` does; keys for messages.

    `rotation`: Gives axes of shape (3, 3).

    Raises `FormatError` when one of them is not a finite number of at most `wpcal.core.arrays.LARGEST_MM`.
    """
    found = list[float]()
    for key, text in cells:
        try:
            found.append(parse_number(text))
        except InputError as error:
            raise FormatError(f"{name}: {key}: {error}", path=path, line=line) from None
    return frame_from_angles(found, rotation)


def frame_from_angles(
    values: Sequence[float], rotation: Callable[..., FloatArray] = rotation_from_zyx
) -> RigidTransform:
    """Return ``T_base_frame`` of x, y, z in mm and three angles in degrees.

    `rotation`: From the angles, rad, to axes of shape (3, 3); by default they are about x, y, z, ``R = Rz Ry Rx``.

    Raises `InputError` when these are not six numbers.
    """
    if len(values) != 6:
        raise InputError(f"expected 6 numbers, got {len(values)}")
    return RigidTransform(rotation(*np.radians(values[3:])), np.asarray(values[:3]), "base", "frame")


def names_as_features(taught: TaughtPoints, features: Sequence[ReferenceFeature]) -> TaughtPoints:
    """Keep the names of a program's points as features where the part has such a feature, and clear the others.

    Controllers number their points (``P1``, ``C00003``), and only some controllers let a person name them. A name says
    nothing if the part does not have it, or has it for a plane or an axis. Points of a table are returned as they are.
    """
    if not taught.is_from_program:
        return taught
    known = {feature.name.lower() for feature in features if feature.kind.is_point}
    return replace(taught, features=tuple(name if name.lower() in known else "" for name in taught.features))
