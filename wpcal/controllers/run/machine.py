"""What an interpreter moves, unaware of languages: poses in `base`, mm."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import Any, Protocol, TypeAlias

import numpy as np

from wpcal.controllers.language.grammar import Does
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.rotations import zyx_angles, zyz_angles
from wpcal.core.wording import shown

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


def real(value: Any) -> float:
    """Return a value of a program as a number; `ProgramError` if it is none, or not finite."""
    if not isinstance(value, Real) or not math.isfinite(value):
        raise ProgramError(f"expected a finite number, got {shown(value)}")
    return float(value)


def about(axes: str, degrees: Sequence[float]) -> FloatArray:
    """Return turns about the named axes, each of which the turns before it carry along, shape (3, 3)."""
    R = np.eye(3)
    for axis, angle in zip(axes, map(math.radians, map(real, degrees)), strict=True):
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


MOST_STEPS = 100_000  #: Instructions of one run: 30 seams have some 5000.
MOST_CALLS = 30  #: Calls in one another.
MOST_ELEMENTS = 100_000  #: Of an array.


def entries_of(calls: Mapping[str, Collection[str]]) -> list[str]:
    """Return the routines that no other one calls, then the first of those that only call each other, or themselves.

    `calls`: The names that each routine calls.
    """
    called = {one for name, others in calls.items() for one in others if one != name}
    found, reached = list[str](), set[str]()
    for name in sorted(calls, key=called.__contains__):
        if name not in reached:
            found.append(name)
            front = [name]
            while front:
                one = front.pop()
                front += [other for other in calls.get(one, ()) if other not in reached]
                reached.add(one)
    return found


class ProgramError(FormatError):
    """The program says what its controller would refuse, or what its interpreter does not know."""

    def at(self, file: str, line: int) -> ProgramError:
        """Return the error with its place, unless it has one."""
        return self if self.line is not None else ProgramError(self.what, path=file, line=line)


class EndlessError(InputError):
    """The program does not come to an end."""


class StoppedError(Exception):
    """The program ended itself, or was ended by its operator."""


@dataclass
class Run:
    """What a run of a program left: messages, stops, files, and whether it came to its end."""

    messages: list[str] = field(default_factory=list)
    stops: list[str] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)
    is_finished: bool = False
    outputs: dict[str, bool] = field(default_factory=dict)
    steps: int = 0

    def stop(self, message: str, on_stop: Callable[[str], bool]) -> None:
        """Stand with a message; the operator lets the program go on, or ends it."""
        self.stops.append(message)
        if not on_stop(message):
            raise StoppedError(message)

    def step(self, calls: int, file: str, line: int) -> None:
        """Count an instruction in this many calls; `EndlessError` when there are too many."""
        self.steps += 1
        if self.steps > MOST_STEPS or calls > MOST_CALLS:
            what = f"{MOST_STEPS} instructions" if self.steps > MOST_STEPS else f"{MOST_CALLS} calls in one another"
            raise EndlessError(f"{file}, line {line}: the program does not end within {what}")
