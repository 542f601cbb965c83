"""A machine that only writes down where it is sent, and what it writes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.machine import Matrix, Place, ProgramError, about, rigid
from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import inverse_pose
from wpcal.robot.kinematics.arm import Arm

NOWHERE = rigid(about("ZYX", (-63.0, 51.0, 23.0)), (77_777.0, -88_888.0, 99_999.0))
"""Where a robot stands of which nobody knows."""


def pulses_of(arm: Arm | None) -> Callable[[FloatArray], FloatArray] | None:
    """Return what turns pulses of an arm, shape (6,), into its joints, deg."""
    return None if arm is None else lambda pulses: np.degrees(arm.angles_from_pulses(pulses))


class Recorder:
    """Writes a `Trace`.

    `from_pulses`: From pulses of an arm, shape (6,), to its joints, deg. Without it they are not known.
    `arc_output`: Number of the digital output that switches the arc.
    `feel`: From the end of a search to where it finds the part, both T_base_tool, or None for a search that misses.
    """

    def __init__(
        self,
        from_pulses: Callable[[FloatArray], FloatArray] | None = None,
        *,
        arc_output: int | None = None,
        feel: Callable[[Matrix], Matrix | None] = lambda T_base_tool: T_base_tool,
    ) -> None:
        self.trace, self.from_pulses, self.arc_output, self.feel = Trace(), from_pulses, arc_output, feel
        self._at, self._seams = Place("", 0), 0
        self.begin()

    def begin(self) -> None:
        """Let another routine begin: nothing is known of what ran before."""
        self.T_base_flange: FloatArray | None = None
        self._arc_on, self._in_seam, self._is_dry, self._touches = False, False, False, False

    @property
    def at(self) -> Place:
        """Where the program is."""
        return self._at

    @at.setter
    def at(self, place: Place) -> None:
        self._at = place
        self.trace.steps.append(place)

    def T_base_tool(self, T_flange_tool: Matrix) -> Matrix:
        """Return where the tool is."""
        if self.T_base_flange is None:
            raise ProgramError("the place of the robot is asked for before its first move to a point")
        return self.T_base_flange @ T_flange_tool

    def reading(self, T_flange_tool: Matrix) -> Matrix:
        """Return where the tool is; before the first move to a point a place that is like none of the program."""
        return NOWHERE if self.T_base_flange is None else self.T_base_flange @ T_flange_tool

    def is_on(self) -> bool:
        """Tell whether the last motion was a search that found the part."""
        return self._touches

    def move(self, T_base_tool: Matrix, T_flange_tool: Matrix, *, is_line: bool = True) -> None:
        """Write a line, or a move by the joints."""
        self._write("L" if is_line else "J", T_base_tool, T_flange_tool)

    def arc(self, via: Matrix, goal: Matrix, T_flange_tool: Matrix) -> None:
        """Write an arc."""
        self._write("C", goal, T_flange_tool, via=via)

    def joint_move(
        self,
        joints: FloatArray | None = None,
        *,
        kind: str = "J",
        via: FloatArray | None = None,
        in_pulses: bool = False,
    ) -> None:
        """Write a move to joints, shape (6,), deg, or pulses of the arm."""
        if in_pulses and joints is not None:
            known = self.from_pulses
            joints = None if known is None else known(joints)
            via = None if known is None or via is None else known(via)
        self._write(kind, None, np.eye(4), joints=joints, via_joints=via)

    def stand(self) -> None:
        """Write that the last motion stops."""
        for last in self.trace.motions[-1:]:
            self.trace.motions[-1] = replace(last, place=replace(last.place, blends=False))

    def search(
        self, T_base_tool: Matrix, T_flange_tool: Matrix, speed_mm_s: float, *, is_edge: bool = True
    ) -> Matrix | None:
        """Write a search, which finds the part where `feel` says."""
        self._write("S", T_base_tool, T_flange_tool)
        found = self.feel(T_base_tool)
        self._touches = found is not None
        if found is not None:
            self.T_base_flange = found @ inverse_pose(T_flange_tool)
        return found

    def switch(self, does: Does) -> None:
        """Write down a switch of the arc, or a mark of a seam."""
        self.trace.events.append(Switch(self.at, does))
        if does in (Does.ON, Does.OFF):
            self._arc_on = does is Does.ON
        elif does in (Does.START, Does.END, Does.STOP, Does.DRY):
            self._in_seam = does is Does.START or (does is Does.DRY and not self._in_seam)
            self._is_dry, self._seams = does is Does.DRY, self._seams + self._in_seam

    def output(self, number: Any, value: Any) -> None:
        """Switch the arc, if this output does."""
        if self.arc_output is not None and number == self.arc_output:
            self.switch(Does.ON if value else Does.OFF)

    def refuse(self, error: ProgramError) -> None:
        """Write down what is not followed; nobody knows where it leads."""
        self.T_base_flange = None
        self.trace.unknowns.append(Unknown(self.at, error.what, len(self.trace.steps)))

    def _write(
        self,
        kind: str,
        goal: Matrix | None,
        T_flange_tool: Matrix,
        *,
        via: Matrix | None = None,
        joints: FloatArray | None = None,
        via_joints: FloatArray | None = None,
    ) -> None:
        if goal is not None and not np.isfinite(goal).all():
            raise ProgramError("a move to a position that is no number")
        self._touches = False
        start = None if self.T_base_flange is None else self.T_base_flange @ T_flange_tool
        is_welding = self._in_seam and (self._is_dry or self._arc_on)  # a move that leads to the arc welds nothing
        seam, step = self._seams if is_welding else 0, len(self.trace.steps)
        self.trace.events.append(Switch(self.at, Does.MOVE))
        self.trace.motions.append(
            Motion(self.at, kind, start, goal, T_flange_tool, via, joints, via_joints, self._arc_on, seam, step)
        )
        self.T_base_flange = None if goal is None else goal @ inverse_pose(T_flange_tool)


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """One motion of the tool in `base`."""

    place: Place
    kind: str  #: ``J`` by joints, ``L`` line, ``C`` arc, ``S`` search on a line.
    start: FloatArray | None  #: T_base_tool, shape (4, 4), of the tool of this motion; None where nobody knows.
    goal: FloatArray | None  #: The same at the end.
    T_flange_tool: FloatArray  #: Shape (4, 4).
    via: FloatArray | None = None  #: T_base_tool in the middle of an arc.
    joints: FloatArray | None = None  #: Of the goal, shape (6,), deg, where the program says them.
    via_joints: FloatArray | None = None  #: The same in the middle of an arc.
    arc_on: bool = False
    seam: int = 0  #: From 1 on in the order of the program; 0 between seams, and to where the arc is struck.
    step: int = 0  #: Steps of the program before its end.


@dataclass(frozen=True, slots=True)
class Switch:
    """A switch of the arc, a mark of a seam, or a motion, in the order of the program."""

    place: Place
    does: Does


@dataclass(frozen=True, slots=True)
class Unknown:
    """An instruction that was not followed, and why."""

    place: Place
    text: str
    step: int = 0  #: Steps of the program before it was refused.


@dataclass
class Trace:
    """What a program did, in its order."""

    motions: list[Motion] = field(default_factory=list)
    events: list[Switch] = field(default_factory=list)
    unknowns: list[Unknown] = field(default_factory=list)
    steps: list[Place] = field(default_factory=list)  #: The lines in the order in which they ran.
    idle: list[Place] = field(default_factory=list)  #: The lines of routines that never ran.
