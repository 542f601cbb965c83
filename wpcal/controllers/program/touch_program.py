"""A plan of touches before it is written in a language: the poses of every search, and what the program says of itself.

What the programs store, and where, is in docs/reference/touch-results.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from wpcal import __version__
from wpcal.controllers.language.naming import NameRules, safe_name
from wpcal.controllers.language.post import ENDING, TOUCH_BLOCKS, Blocks
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.program.describe import NOT_CHECKED
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.posture import Posture, posture
from wpcal.touch.searches import STORED_NUMBERS, Outcome, Search, TouchPlan, TouchSetup

NAME_ENDING = "_touch"
"""Of the name of a touch program, which thus never replaces the weld program of the same part."""
FOUND, MISSED, ACTIVE, NOT_RUN = (
    STORED_NUMBERS[each] for each in (Outcome.FOUND, Outcome.MISSED, Outcome.ACTIVE_AT_START, Outcome.NOT_RUN)
)
MISSED_TEXT, ACTIVE_TEXT = "missed: look at the part", "signal on at start"
"""After the name of a search, in the message at which a program stops: FANUC shows 24 characters after a name."""


LONGEST_STROKE_MM = 300.0
"""A part that is displaced by more is not where the plan says at all."""
OFF_STROKE_MM = 1.0
"""The planned contact is on the line of the search; a file that is typed may be this far off."""


@dataclass(frozen=True, slots=True, eq=False)
class TouchSteps:
    """The poses of one search, in the frame that the program makes its work object."""

    search: Search
    #: `p`, `R`: shapes (k + 4, 3) and (k + 4, 3, 3). The k points on the way, approach, start, end, retract; mm.
    p: FloatArray
    R: FloatArray
    postures: Posture | None  #: Of the arm there; None if it is not known.

    @property
    def name(self) -> str:
        """The name of the search as programs write it."""
        return self.search.name.upper()

    @property
    def way_count(self) -> int:
        """k, the number of points on the way to the approach."""
        return len(self.p) - 4

    @property
    def marks(self) -> list[str]:
        """A mark for each pose: ``V1`` on the way, ``A`` approach, ``S`` start, ``E`` end, ``R`` retract."""
        return [*(f"V{number}" for number in range(1, self.way_count + 1)), *"ASER"]


@dataclass(frozen=True, slots=True, eq=False)
class TouchProgram:
    """What a writer of touch programs gets.

    Raises
    ------
    InputError : When the plan has no searches, or a search would not move onto its own face: files are edited by hand.
    """

    plan: TouchPlan
    setup: TouchSetup = field(default_factory=TouchSetup)
    #: Its `frame_number` is not used: touch programs use that of `setup`.
    controller: ControllerSettings = field(default_factory=ControllerSettings)
    arm: Arm | None = None  #: The arm that the joints of the plan belong to; the configuration is computed with it.

    def __post_init__(self) -> None:
        if not self.plan.searches:
            raise InputError("the plan of touches has no searches")
        for search in self.plan.searches:
            _refuse_unsafe(search)

    @property
    def arc(self) -> None:
        """A touch program has no arc."""
        return

    def name(self, rules: NameRules) -> str:
        """Return the name of the program on the controller."""
        longest = NameRules(rules.language, rules.longest - len(NAME_ENDING), rules.keywords)
        return f"{safe_name(self.controller.program_name, longest)}{NAME_ENDING}"

    def steps(self, T_base_frame: RigidTransform) -> tuple[TouchSteps, ...]:
        """Return the poses of the searches.

        Parameters
        ----------
        T_base_frame : RigidTransform
            `TouchPlan.T_base_part` with the digits that the program states. Its rounding then does not move the robot.
        """
        T_frame_part = T_base_frame.inverse() @ self.plan.T_base_part
        return tuple(_steps(search, T_frame_part, self.arm) for search in self.plan.searches)


def _refuse_unsafe(search: Search) -> None:
    """Refuse a search that is too long, runs away from its face, or does not pass where the contact is planned."""
    if search.stroke_mm > LONGEST_STROKE_MM:
        raise InputError(
            f"search {search.name}: a stroke of {search.stroke_mm:.0f} mm; at most {LONGEST_STROKE_MM:g} mm"
        )
    if not search.direction @ search.normal_part < 0.0:
        raise InputError(f"search {search.name}: it runs away from the face that it should touch")
    along = float((search.planned - search.start) @ search.direction)
    off = float(np.linalg.norm(search.planned - search.start - along * search.direction))
    if not (0.0 < along < search.stroke_mm and off <= OFF_STROKE_MM):
        raise InputError(
            f"search {search.name}: its planned contact is not between its start and its end, to {OFF_STROKE_MM:g} mm"
        )


def _steps(search: Search, T_frame_part: RigidTransform, arm: Arm | None) -> TouchSteps:
    ends = [search.approach, search.start, search.end, search.retract]
    p = np.concatenate([search.via.reshape(-1, 3), ends])
    R = np.broadcast_to(T_frame_part.R @ search.R_part_tool, (len(p), 3, 3))
    return TouchSteps(search, p @ T_frame_part.R.T + T_frame_part.t_mm, R, _postures(search, arm))


def _postures(search: Search, arm: Arm | None) -> Posture | None:
    """Return the postures of all poses; at the retract, which is near the start, that of the start."""
    if arm is None or search.joints is None or (len(search.via) and search.via_joints is None):
        return None
    way = np.empty((0, search.joints.shape[1])) if search.via_joints is None else search.via_joints
    return posture(arm, np.concatenate([way, search.joints, search.joints[1:2]]))


@dataclass(frozen=True, slots=True)
class TouchPost(Blocks):
    """The templates of one language for a touch program.

    Raises
    ------
    InputError
        When a folder of the user has one of the two templates of sensing: what switches it on may then not be off.
    """

    program: TouchProgram

    def __post_init__(self) -> None:
        folder = self.program.controller.templates
        own = [] if folder is None else [(folder / self.language / f"{block}{ENDING}") for block in TOUCH_BLOCKS]
        if sum(path.is_file() for path in own) == 1:
            missing = next(path for path in own if not path.is_file())
            raise InputError(
                f"{missing}: no such file; templates that switch sensing on and off come together, or it may stay on"
            )

    def sensing(self, *, on: bool, signal: str, enable: str) -> list[str]:
        """Return what switches the sensing on before a search, and waits until the signal is true, or off after it.

        Parameters
        ----------
        signal, enable : The input and the output as the language writes them; no output: empty.
        """
        hold_s = self.program.setup.hold_s
        return self.lines("touch_on" if on else "touch_off", signal=signal, enable=enable, hold_s=hold_s)


def describe_touches(program: TouchProgram, *, signal: str, results: Sequence[str]) -> list[str]:
    """Return the lines of the header that every language shares.

    Parameters
    ----------
    signal : The touch input as the language writes it.
    results : Where the results are.
    """
    plan, setup = program.plan, program.setup
    longest = max(search.stroke_mm for search in plan.searches)
    level = "on" if setup.is_on_high else "off"
    enable = f"from output {setup.enable} " if setup.enable else ""
    first = "the way from where the arm is to home" if plan.home_joints is not None else "the way to the first point"
    return [
        f"written by wpcal {__version__} from the plan in touches.json, fingerprint {plan.fingerprint}",
        f"part {plan.part}: {_count(len(plan.searches))}, wire {plan.wire_mm:g} mm, stick-out {plan.stick_out_mm:g} mm",
        *plan.notes,
        f"SAFETY: contact turns {signal} {level}. Before the first run hold the wire against the part by hand and see "
        f"it turn {level}: without it the torch drives {longest:.0f} mm on, into the part",
        f"SAFETY: during searches the sensing voltage {enable}is on the wire: keep away from wire and torch",
        "SAFETY: after a missed search the part may be elsewhere. The program stops and names the search: look at the "
        "part before you start it again. It then goes on with the next search",
        NOT_CHECKED.replace("the way to the first point", first),
        f"run it dry: without the part, every search is missed. Searches {setup.search_speed_mm_s:g} mm/s, "
        f"air {setup.air_speed_mm_s:g} mm/s",
        *results,
        "search: what it touches, stroke and direction in the part",
        *(f"  {search.name.upper()}: {_in_words(search)}" for search in plan.searches),
    ]


def _count(number: int) -> str:
    return f"{number} search{'es' if number > 1 else ''}"


def _in_words(search: Search) -> str:
    towards = " ".join(f"{value + 0.0:.2f}" for value in np.round(search.direction, 2))
    of = f" {search.feature}" if search.feature else ""
    return f"{search.target}{of}, {search.contact.value} of the wire, {search.stroke_mm:.1f} mm along ({towards})"


def refuse_package(program: TouchProgram, language: str) -> None:
    """Refuse a package in a language without one.

    Raises
    ------
    InputError : For `with_package`.
    """
    if program.setup.with_package:
        what = f"{language}: wpcal writes no searches of a touch-sensing package"
        raise InputError(f"{what}: with_package = false in the touch setup")


@dataclass(frozen=True, slots=True)
class Room:
    """Registers or variables of a controller."""

    what: str  #: One of them; the keys ``first_…`` and ``last_…`` of the touch setup have its name.
    #: `first`, `last`: As in the touch setup.
    first: int
    last: int
    needed: int  #: How many the searches need.
    least: int = 0  #: The first one that the controller has.


def require_room(program: TouchProgram, room: Room, *, language: str) -> None:
    """Refuse a plan with more searches than fit.

    Raises
    ------
    InputError : If it is so.
    """
    if room.first < room.least or room.first + room.needed - 1 > room.last:
        key = room.what.replace(" ", "_")
        raise InputError(
            f"{language}: {_count(len(program.plan.searches))} need {room.needed} {room.what}s from {room.first} on; "
            f"the controller has {room.least} to {room.last}: change first_{key} or last_{key} in the touch setup"
        )


def require_frame(program: TouchProgram, *, language: str, most: int) -> None:
    """Refuse a user frame that a controller does not have.

    Raises
    ------
    InputError : If it is so.
    """
    number = program.setup.frame_number
    if not 1 <= number <= most:
        raise InputError(f"frame_number = {number} of the touch setup: {language} has the user frames 1 to {most}")


def number_of(text: str, *, default: int, what: str, language: str, most: int, least: int = 1) -> int:
    """Return the number of an input or output of a language that numbers them.

    Parameters
    ----------
    text : As in the touch setup.
    default : For an empty text.
    what : The key, for the message.
    most, least : The largest and the smallest number.

    Raises
    ------
    InputError : When it is not a number of this language.
    """
    if not text.strip():
        return default
    if not text.strip().isascii() or not text.strip().isdigit() or not least <= int(text) <= most:
        raise InputError(f"{what} = {text!r} of the touch setup: {language} numbers it: expected {least} to {most}")
    return int(text)
