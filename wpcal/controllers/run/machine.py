"""What an interpreter moves, unaware of languages: poses in `base`, mm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np

from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.program import ProgramError
from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import zyx_angles, zyz_angles

Matrix: TypeAlias = FloatArray
"""A pose, shape (4, 4)."""


WHOLE_ZONE = 0.5  #: No controller leaves a motion before its half, and each is back on the next by then.


@dataclass(frozen=True, slots=True)
class Place:
    """Where a program is, and what it moves with."""

    file: str
    line: int  #: From 1 on.
    tool: str = ""  #: Name or number.
    frame: str = ""  #: Name or number.
    speed_mm_s: float | None = None
    blends: bool = False  #: Whether the tool does not stop at the end.
    #: How far from the end the next motion may begin: the tool centre point, mm, and the share of this motion.
    zone: tuple[float, float] = (math.inf, WHOLE_ZONE)
    external: tuple[float, ...] = ()  #: External axes at the end, in their order, mm and deg, as the text states them.
    via_external: tuple[float, ...] = ()  #: The same in the middle of an arc, where it is stated.
    mark: str = ""  #: What a move has in common with that of another robot, which begins and ends with it.


class Machine(Protocol):
    """A robot, or what writes down where a robot would go. `at`: Set by the interpreter before each call."""

    at: Place

    def T_base_tool(self, T_flange_tool: Matrix) -> Matrix:
        """Return where the tool is; `ProgramError` when nobody knows."""

    def reading(self, T_flange_tool: Matrix) -> Matrix:
        """Return where the controller says that the standing tool is."""

    def is_on(self) -> bool:
        """Tell whether the touch signal is on."""

    def move(self, T_base_tool: Matrix, T_flange_tool: Matrix, *, is_line: bool = True) -> None:
        """Go to a pose, on a line or by the joints."""

    def arc(self, via: Matrix, goal: Matrix, T_flange_tool: Matrix) -> None:
        """Go to a pose on the circle through the place of `via`."""

    def joint_move(
        self,
        joints: FloatArray | None = None,
        *,
        kind: str = "J",
        via: FloatArray | None = None,
        in_pulses: bool = False,
    ) -> None:
        """Go to joint angles, shape (6,), deg or pulses; None where the program does not say them.

        `kind`: ``J`` by the joints, ``L`` on a line, ``C`` on an arc through the joint angles `via`.
        """

    def stand(self) -> None:
        """Wait until the last motion has ended: it does not blend into the next."""

    def search(
        self, T_base_tool: Matrix, T_flange_tool: Matrix, speed_mm_s: float, *, is_edge: bool = True
    ) -> Matrix | None:
        """Go to a pose on a line until the signal comes; return the stored pose of the tool, or None without one.

        `is_edge`: only a signal that comes on the way counts, not one that is on at the start.
        """

    def switch(self, does: Does) -> None:
        """Switch the arc, or pass a mark of a seam."""

    def output(self, number: Any, value: Any) -> None:
        """Set a digital output."""

    def refuse(self, error: ProgramError) -> None:
        """Take an instruction that is unknown or that the controller would refuse; raise it, or write it down."""


def rigid(R: FloatArray, translation: Any) -> Matrix:
    """Return a rotation, shape (3, 3), and a translation as one matrix."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, translation
    return T


def moved(T: Matrix, d: Any, in_tool: bool) -> Matrix:
    """Return a pose, displaced along the axes of the base or its own."""
    T = T.copy()
    T[:3, 3] += T[:3, :3] @ d if in_tool else d
    return T


def about(axes: str, degrees: Sequence[float]) -> FloatArray:
    """Return turns about the named axes, each of which the turns before it carry along, shape (3, 3)."""
    R = np.eye(3)
    for axis, angle in zip(axes, map(math.radians, degrees), strict=True):
        rows = {"X": [1, 2], "Y": [2, 0], "Z": [0, 1]}[axis]
        turn = np.eye(3)
        turn[np.ix_(rows, rows)] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
        R = R @ turn
    return R


def turns_of(axes: str, T: Matrix) -> list[float]:
    """Return the degrees with which `about` gives the axes of a matrix."""
    R = T[:3, :3]
    angles = {"ZYX": zyx_angles(R)[::-1], "ZYZ": zyz_angles(R), "XYZ": -zyx_angles(R.T)}[axes]
    return [math.degrees(angle) for angle in angles]
