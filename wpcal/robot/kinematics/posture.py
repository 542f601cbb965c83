"""Which of its eight postures an arm is in, from its joint angles: what controllers call its configuration.

Two of the three choices are places of the wrist centre, as drawings of the makers show them: in front of axis 1 or
behind it, and in front of the line through axes 2 and 3 or behind it. *In front* is the side of the base's x axis when
joint 1 is at 0. The third choice is the sign of joint 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import GeometryError
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.opw import OPWGeometry

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

    Parameters
    ----------
    joints : shape (N, 6). Shown angles, rad.

    Raises
    ------
    GeometryError
        When the arm has no spherical wrist, or does not reach along the base's x axis at joint 1 = 0: which side is its
        front is then not known.
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
        q,
        np.asarray(front * r < 0.0, dtype=np.bool_),
        np.asarray(front * up * np.sin(bend) < 0.0, dtype=np.bool_),
    )
