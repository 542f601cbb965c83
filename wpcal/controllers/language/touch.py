"""A touch program in one language: what all languages share. The rest is in whole templates beside the writer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from wpcal.controllers.language.jobs import ConfigurationRule
from wpcal.controllers.language.naming import NameRules, comment_lines, own_name
from wpcal.controllers.language.post import ENDING, TOUCH_BLOCKS, AirMoves, Blocks, whole_template
from wpcal.controllers.program.describe import NOT_CHECKED
from wpcal.controllers.program.in_run import SETTLED_MM, STEPS
from wpcal.controllers.program.touch_program import TouchProgram, TouchSteps
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.core.version import __version__
from wpcal.taught.programs import ProgramPoint, ProgramPoints
from wpcal.touch.searches import STORED_NUMBERS, Outcome, Search
from wpcal.touch.searches.results import StoredValues, parsed_number

FOUND, MISSED, ACTIVE, NOT_RUN = (
    STORED_NUMBERS[each] for each in (Outcome.FOUND, Outcome.MISSED, Outcome.ACTIVE_AT_START, Outcome.NOT_RUN)
)
REFUSED_TEXT = " off: not welded; calibrate"
"""After the name of a search, where the frame cannot be corrected in the program."""
ENDED_TEXT = " misses: program ends"  #: Behind their number.
MISSED_TEXT, ACTIVE_TEXT = "missed: look at the part", "signal on at start"
"""After the name of a search, in the message at which a program stops: a pendant may show 24 characters after it."""


@dataclass(frozen=True, slots=True)
class Numbers:
    """The numbers of inputs or outputs that a controller has."""

    default: int
    most: int
    least: int = 1


@dataclass(frozen=True, slots=True)
class SearchText:
    """One search in words of a language, for templates."""

    name: str
    number: int  #: From 0 on.
    at: Mapping[str, str]  #: The points as moves name them, by their marks (`TouchSteps.marks`).
    way: Sequence[str]  #: The points from the first on that the robot goes to without sensing.
    is_first: bool  #: Whether the arm comes from anywhere.
    steps: TouchSteps


class TouchWriter(AirMoves):
    """Writes one touch program: a language says how points, speeds and signals are written, and has templates."""

    format: ClassVar[str]  #: The name of the format.
    names: ClassVar[NameRules]
    longest_comment: ClassVar[int]
    inputs: ClassVar[Numbers | None] = None  #: None if signals have names.
    outputs: ClassVar[Numbers | None] = None
    has_package: ClassVar[bool] = False  #: Whether searches of a touch-sensing package are written.
    is_upper: ClassVar[bool] = False  #: Whether names of programs are upper case.
    #: Returns the frame of the part with the digits that the program states.
    frame_as_written: ClassVar[staticmethod[[RigidTransform], RigidTransform]]
    post: TouchPost
    way_points: ClassVar[Sequence[str]] = ()
    """As moves name the poses from the last search to a weld program; a language with them corrects its frame."""

    def __init__(self, program: TouchProgram) -> None:
        self.program, self.plan, self.setup, self.controller = program, program.plan, program.setup, program.controller
        self.language, self.air_mm_s = self.names.language, self.setup.air_speed_mm_s
        self._require_language()
        self.check()
        name = program.name(self.names)
        self.name = name.upper() if self.is_upper else name
        self.frame = self.frame_as_written(self.plan.T_base_part)
        self.steps = program.steps(self.frame)
        self.post = TouchPost(self.format, program)
        self.searches = self._texts()

    def _require_language(self) -> None:
        with_package, welds = self.setup.with_package, self.program.welds
        if with_package and not self.has_package:
            what = f"{self.language}: wpcal writes no searches of a touch-sensing package"
            raise InputError(f"{what}: with_package = false in the touch setup")
        if welds is not None and not self.way_points:
            raise InputError(f"{self.language}: touch and weld in one run is not written in this language")
        if welds is not None and welds.stage and with_package:
            raise InputError(f"{self.language}: two stages in one run are not written with a touch-sensing package")

    def _texts(self) -> list[SearchText]:
        first, found = self.first_point, list[SearchText]()
        for number, steps in enumerate(self.steps):
            names = self.points_of(steps, first)
            at = dict(zip(steps.marks, names, strict=True))
            is_first = number == 0 and self.plan.home_joints is None
            felt = 2 if self.setup.with_package else 3  # a package senses from the start on
            found.append(SearchText(steps.name, number, at, names[:-felt], is_first, steps))
            first += len(names)
        return found

    @property
    def first_point(self) -> int:
        """The number of the first point of a search."""
        return 0

    def check(self) -> None:
        """Refuse what the controller does not have."""

    def points_of(self, steps: TouchSteps, first: int) -> list[str]:
        """Return how moves name the points of a search; `first` is the number of the first of them."""
        raise NotImplementedError

    def configurations(self, rule: ConfigurationRule, steps: TouchSteps) -> list[str]:
        """Return how a language writes the configuration of the arm at the points of a search."""
        where, has_arm = f"search {steps.name}", self.program.arm is not None
        return rule.texts_of(self.controller, steps.postures, len(steps.p), where=where, has_arm=has_arm)

    def require_room(self, section: object, needed: Mapping[str, int], *, least: int = 0) -> None:
        """Refuse a plan with more searches than fit into the registers or variables of the touch setup."""
        for what, count in needed.items():
            key = what.replace(" ", "_")
            first, last = getattr(section, f"first_{key}"), getattr(section, f"last_{key}")
            if first < least or first + count - 1 > last:
                raise InputError(
                    f"{self.language}: {_count(len(self.plan.searches))} need {count} {what}s from {first} on; the "
                    f"controller has {least} to {last}: change first_{key} or last_{key} in the touch setup"
                )

    def require_frame(self, most: int) -> None:
        """Refuse a user frame that a controller does not have."""
        number = self.setup.frame_number
        if not 1 <= number <= most:
            what = f"frame_number = {number} of the touch setup"
            raise InputError(f"{what}: {self.language} has the user frames 1 to {most}")

    @property
    def signal(self) -> str:
        """The touch input: its name or its number."""
        if self.inputs is None:
            return own_name(self.setup.signal, self.names, what="signal of the touch setup")
        return self._number(self.setup.signal, self.inputs, "signal")

    @property
    def enable(self) -> str:
        """The output that switches the sensing voltage on; empty if there is none."""
        if not self.setup.enable or self.outputs is None:
            return self.setup.enable and own_name(self.setup.enable, self.names, what="enable of the touch setup")
        return self._number(self.setup.enable, self.outputs, "enable")

    def _number(self, text: str, numbers: Numbers, what: str) -> str:
        if not text.strip():
            return str(numbers.default)
        if not text.strip().isascii() or not text.strip().isdigit() or not numbers.least <= int(text) <= numbers.most:
            expected = f"{self.language} numbers it: expected {numbers.least} to {numbers.most}"
            raise InputError(f"{what} = {text!r} of the touch setup: {expected}")
        return str(int(text))

    def header(self, signal: str, results: Sequence[str], *, clean: str = "") -> list[str]:
        """Return the header; `results` say where the results are, and characters of `clean` become commas."""
        about = describe_touches(self.program, signal=signal, results=results)
        about = [line.replace(clean, ",") if clean else line for line in about]
        return self.post.header(comment_lines(about, mark="", longest=self.longest_comment))

    def approach(self, search: SearchText) -> list[str]:
        """Return the moves to where a search is sensed from: its approach, or with a package its start."""
        lines = list[str]()
        for row, point in enumerate(search.way):
            is_joint = row == 0 and search.is_first
            lines += self.post.air_move(point, speed=self.first if is_joint else self.air, joint=is_joint)
        return lines

    def leave(self, search: SearchText) -> list[str]:
        """Return the moves from where a search ended."""
        return self.air_moves([search.at[mark] for mark in "SR"])

    def back(self, search: SearchText) -> list[str]:
        """Return the move from a contact on the way to the start."""
        return self.air_moves([search.at["A"]])

    @property
    def way(self) -> tuple[FloatArray, FloatArray] | None:
        """The poses from the last search to the weld program in the frame; None without one, or from a home."""
        welds = self.program.welds
        return None if welds is None or welds.way is None else welds.way.poses_in(self.frame)

    def home(self, point: str, speed: str) -> list[str]:
        """Return the move to the home of the plan, if it has one."""
        return [] if self.plan.home_joints is None else self.post.joint_move(point, speed=speed)

    def sensing(self, signal: str, enable: str) -> dict[str, list[str]]:
        """Return what switches the sensing on before a search, and off after it, as names for templates."""
        ways = (("sensing_on", True), ("sensing_off", False))
        return {name: self.post.sensing(on=on, signal=signal, enable=enable) for name, on in ways}

    def lines(self, template: str, **names: Any) -> list[str]:
        """Return the lines of a whole template of this language; a list among the names becomes as many lines."""
        known = {
            "FOUND": FOUND,
            "MISSED": MISSED,
            "ACTIVE": ACTIVE,
            "NOT_RUN": NOT_RUN,
            "MISSED_TEXT": MISSED_TEXT,
            "ACTIVE_TEXT": ACTIVE_TEXT,
            "name": self.name,
            "plan": self.plan,
            "setup": self.setup,
            "tool_number": self.controller.tool_number,
            "searches": self.searches,
            "approach": self.approach,
            "leave": self.leave,
            "back": self.back,
            "welds": self.program.welds,
            "stage": 0 if self.program.welds is None else self.program.welds.stage,
            "way": [] if self.way is None else self.air_moves(self.way_points),
            "vec": lambda v: ",".join(f"{x + 0.0:.9f}" for x in v),
            "STEPS": STEPS,
            "SETTLED_MM": SETTLED_MM,
            "REFUSED_TEXT": REFUSED_TEXT,
            "ENDED_TEXT": ENDED_TEXT,
            "footer": self.post.footer(),
        }
        return whole_template(self.format, template, {**known, **names})


@dataclass(frozen=True, slots=True)
class TouchPost(Blocks):
    """The templates of one language for a touch program.

    Raises `InputError` when a folder of the user has one of the two templates of sensing: what switches it on may then
    not be off.
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
        """Return what switches the sensing on before a search, and waits until the signal is true, or off after it."""
        hold_s = self.program.setup.hold_s
        return self.lines("touch_on" if on else "touch_off", signal=signal, enable=enable, hold_s=hold_s)


IN_RUN = (
    "after the searches the program corrects the frame of the welds, and welds. It ends before the first weld where a "
    "search missed, or the places that were found do not fit the part: then copy the results, and calibrate with them "
    "(wpcal calibrate --touches)"
)
IN_STAGES = (
    "searches F1 … correct the frame in which the searches after them run, and these once more, then it welds. It ends "
    "before the first weld where a search missed, or the places that were found do not fit the part. Its results are "
    "no touches for wpcal calibrate: for these run the two stages as two programs"
)


def describe_touches(program: TouchProgram, *, signal: str, results: Sequence[str]) -> list[str]:
    """Return the lines of the header that every language shares."""
    plan, setup = program.plan, program.setup
    longest = max(search.stroke_mm for search in plan.searches)
    level = "on" if setup.is_on_high else "off"
    enable = f"from output {setup.enable} " if setup.enable else ""
    first = "the way from where the arm is to home" if plan.home_joints is not None else "the way to the first point"
    return [
        f"written by wpcal {__version__} from the plan in touches.json, fingerprint {plan.fingerprint}",
        f"part {plan.part}: {_count(len(plan.searches))}, wire {plan.wire_mm:g} mm, stick-out {plan.stick_out_mm:g} mm",
        *(
            [f"the tool centre point is {plan.standoff_mm:g} mm back from the tip of the wire, also in results"]
            if plan.standoff_mm
            else ["the tool centre point is the tip of the wire"]
        ),
        *plan.notes,
        f"SAFETY: contact turns {signal} {level}. Before the first run hold the wire against the part by hand and see "
        f"it turn {level}: without it the torch drives {longest:.0f} mm on, into the part",
        f"SAFETY: during searches the sensing voltage {enable}is on the wire: keep away from wire and torch",
        "SAFETY: after a missed search the part may be elsewhere. The program stops and names the search: look at the "
        "part before you start it again. It then goes on with the next search; after "
        f"{setup.most_misses} misses it ends",
        "the way to the start of a search is not sensed: the package senses from the start on. It is free of the part "
        "wherever the plan allows it to stand"
        if setup.with_package
        else f"the way to the start of a search is sensed as well, at {setup.approach_speed_mm_s:g} mm/s",
        *([] if program.welds is None else [IN_STAGES if program.welds.stage else IN_RUN]),
        NOT_CHECKED.replace("the way to the first point", first),
        "run it dry: without the part, every search is missed (most_misses). Searches "
        f"{setup.search_speed_mm_s:g} mm/s, air {setup.air_speed_mm_s:g} mm/s",
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


@dataclass(frozen=True, slots=True)
class ResultNames:
    """How a program names what it stores, lower case."""

    plan: str  #: The fingerprint.
    tool: str
    count: str
    outcome: str  #: Before the name of a search.
    place: str  #: The same.
    frame: str  #: The place of the part.

    def stored(self, values: Mapping[str, str], read: ProgramPoints, path: str) -> StoredValues:
        """Return what a file stores: its values by their names as written, and its points and frames."""
        texts = {name.lower(): text for name, text in values.items()}
        stored = StoredValues(fingerprint=texts.get(self.plan, ""), tool=texts.get(self.tool, ""))
        for name, text in values.items():
            own = name.lower()
            if own.startswith(self.outcome):
                stored.outcomes[own.removeprefix(self.outcome).upper()] = parsed_number(text, name, path)
            elif own == self.count:
                stored.count = parsed_number(text, name, path)
        for point in read.points:
            own = point.name.lower()
            if own == self.frame:
                stored.T_base_part = point.T_frame_tool.relabelled(target="base", source="frame")
            elif own.startswith(self.place):
                self._take(stored, own.removeprefix(self.place).upper(), point)
        for name, T in read.frames.items():
            if name.lower() == self.frame:
                stored.T_base_part = T
        return stored

    @staticmethod
    def _take(stored: StoredValues, search: str, point: ProgramPoint) -> None:
        if point.fault is None:
            stored.places[search] = point.T_frame_tool
        else:
            stored.faults[search] = point.fault
