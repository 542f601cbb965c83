"""Where a program moved a robot."""

from __future__ import annotations

from dataclasses import dataclass, field

from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.machine import Place
from wpcal.core.arrays import FloatArray


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
    seam: int = 0  #: From 1 on in the order of the program; 0 between seams.
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
