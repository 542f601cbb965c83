"""What a controller's file says of taught points, before it is known where its frames stand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform

LEAST_JOINTS = 4
"""Arms that weld have six joints, palletising arms four; fewer numbers are a line that was cut."""
BASE = "base"
"""Label of the frame that is the robot's base itself."""


@dataclass(frozen=True, slots=True, eq=False)
class JointValues:
    """A position stored as joint values.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Shown angles, deg, or encoder pulses.
    in_pulses : bool
    """

    values: FloatArray
    in_pulses: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class ProgramPoint:
    """One stored position.

    Parameters
    ----------
    name : str
    line : int
        In the file, counted from 1.
    p_mm : ndarray, shape (3,)
        Of the tool centre point in `frame`, mm; NaN where `fault` says why there is none.
    R : ndarray, shape (3, 3)
        Axes of the tool in `frame`.
    frame : str or None
        Name or number of the user frame, `BASE`, or None where the file does not say.
    at_flange : bool
        Recorded without a tool: the position is the flange's.
    fault : str or None
        Why the position cannot be used as it is: joint angles, pulses.
    joints : JointValues or None
        The shown angles or pulses, where the file holds these instead of coordinates.
    """

    name: str
    line: int
    p_mm: FloatArray
    R: FloatArray
    frame: str | None = None
    at_flange: bool = False
    fault: str | None = None
    joints: JointValues | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ProgramPoints:
    """The positions of a file and the values of user frames that it carries.

    Parameters
    ----------
    points : tuple of ProgramPoint
    frames : dict of str to RigidTransform
        ``T_base_frame`` by name or number.
    """

    points: tuple[ProgramPoint, ...]
    frames: dict[str, RigidTransform] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ProgramLanguage:
    """A language whose files hold taught points.

    Parameters
    ----------
    title : str
    read : callable
        From text and path to `ProgramPoints`; raises `FormatError`.
    pose : callable
        From numbers in the order of the pendant to ``T_base_frame``; raises `InputError`.
    pose_words : str
        That order, for messages.
    """

    title: str
    read: Callable[[str, str], ProgramPoints]
    pose: Callable[[Sequence[float]], RigidTransform]
    pose_words: str


def unusable_point(name: str, line: int, fault: str, joints: JointValues | None = None) -> ProgramPoint:
    """Return a point that the file holds in a form without coordinates."""
    return ProgramPoint(name, line, np.full(3, np.nan), np.eye(3), fault=fault, joints=joints)


def joint_values(values: Sequence[object], *, in_pulses: bool = False) -> JointValues | None:
    """Return joint values; None where something else than finite numbers stands there (asterisks, a joint missing)."""
    try:
        found = np.array([float(str(value)) for value in values])
    except ValueError:
        return None
    return JointValues(found, in_pulses) if len(found) >= LEAST_JOINTS and np.isfinite(found).all() else None


def frame_from_xyz_angles(values: Sequence[float]) -> RigidTransform:
    """Return ``T_base_frame`` of x, y, z in mm and angles about x, y, z in degrees, ``R = Rz Ry Rx``.

    Raises
    ------
    InputError
        When these are not six numbers.
    """
    if len(values) != 6:
        raise InputError(f"expected 6 numbers, got {len(values)}")
    alpha, beta, gamma = np.radians(values[3:])
    return RigidTransform(rotation_from_zyx(alpha, beta, gamma), np.asarray(values[:3]), "base", "frame")
