"""A program of two robots before it is written in a language: joint targets at marks, and the times between marks.

Each robot has a target at every mark. The robots wait for each other at every mark; it has the same number in both
programs.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wpcal.controllers.program import ControllerSettings
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.robot.kinematics.arm import Arm

ROBOTS = (1, 2)
"""Robot 1 carries the torch, robot 2 carries the part."""


@dataclass(frozen=True, slots=True, eq=False)
class SyncProgram:
    """Joint targets of two robots with marks 1 to N.

    Parameters
    ----------
    seam : str
        As in the part, any text.
    arms : tuple of Arm
        Of robots 1 and 2.
    joints : tuple of ndarray, each of shape (N, 6)
        Shown angles at the marks, rad, unwrapped.
    seconds : ndarray, shape (N - 1,)
        From each mark to the next.
    arc_on, arc_off : int
        Rows (from 0) at which the arc starts and stops.
    notes : tuple of str
        For a person to read first: speed, clearance, what was checked.
    controller : ControllerSettings
        Names and numbers; the tool is that of robot 1.

    Raises
    ------
    InputError
        When shapes differ, there are fewer than two targets, or a time is not positive.
    """

    seam: str
    arms: tuple[Arm, Arm]
    joints: tuple[FloatArray, FloatArray]
    seconds: FloatArray
    arc_on: int
    arc_off: int
    notes: tuple[str, ...] = ()
    controller: ControllerSettings = field(default_factory=ControllerSettings)

    def __post_init__(self) -> None:
        n = len(self.seconds) + 1
        for robot, q, arm in zip(ROBOTS, self.joints, self.arms, strict=True):
            if q.shape != (n, len(arm.joints)) or n < 2:
                raise InputError(f"robot {robot}: {n - 1} times need joints of shape ({n}, 6), got {q.shape}")
        if not (np.isfinite(self.seconds).all() and (self.seconds > 0).all()):
            raise InputError("the time between two marks must be positive")
        if not 0 <= self.arc_on < self.arc_off < n:
            raise InputError(f"arc on at row {self.arc_on}, off at {self.arc_off}: expected rows of the {n} in order")

    def __len__(self) -> int:
        return len(self.seconds) + 1

    @property
    def marks(self) -> range:
        """Numbers of the marks, one per target."""
        return range(1, len(self) + 1)

    @property
    def label_width(self) -> int:
        """Digits of the number in a label, as in programs of `wpcal export`."""
        return max(4, len(str(len(self))))
