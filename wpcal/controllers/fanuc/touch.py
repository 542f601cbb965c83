"""FANUC TP: a program ``NAME_TOUCH.ls`` that touches the part.

A search is a move with ``Skip,LBL[n],PR[k]=LPOS``. It ends when the skip condition is met, and the place where it was
met is in the position register. If the condition is not met, the program goes to the label. The program itself sets the
user frame to the part as planned, and writes outcomes, fingerprint and numbers of frame and tool into registers. The
register of the frame must be a position before its elements can be set.

With `with_package` the searches are those of the Touch Sensing option (``Search Start``, ``Search[…]``). They run along
one axis of the touch frame of their schedule, which must be parallel to the part. The outcome before such a search is
that of its alarm, which stops the program. The option stores the place of the contact in PR[32]; its own result, an
offset, goes to the register first.

References: FANUC, R-30iB HandlingTool Operator's Manual (skip condition, position registers); ArcTool Touch Sensing.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from wpcal.controllers.fanuc.registers import POSITIONS, registers_of, rows_behind
from wpcal.controllers.fanuc.write import (
    CONFIGURATION,
    JOINT_PERCENT,
    LANGUAGE,
    LONGEST_REMARK,
    NAMES,
    joint_bodies,
    numbered,
    pose_bodies,
    require_coupling,
    set_frame,
    tp_file,
    tp_speed,
)
from wpcal.controllers.language.touch import NOT_RUN, Numbers, SearchText, TouchWriter
from wpcal.controllers.program.touch_program import TouchSteps
from wpcal.core.errors import FormatError, InputError
from wpcal.touch.searches import halves_of
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import (
    ResultsFile,
    SearchResults,
    StoredValues,
    fingerprint_of_stored,
    number_at,
    parsed_number,
    text_number,
)
from wpcal.touch.searches.setup import TouchSetup

INPUTS = Numbers(default=1, most=4096)
LARGEST_FRAME = 9  #: The last user frame, unless the controller was set up for more.
HEAD = 5  #: Registers before the outcomes: two of the fingerprint, user frame, tool, count. Behind them: the misses.
PARALLEL = 1e-3  #: Sine of the largest angle between a search of the package and its axis: 0.06 degrees.


class _TpTouches(TouchWriter):
    format, names, longest_comment, has_package, is_upper = "fanuc", NAMES, LONGEST_REMARK, True, True
    inputs = outputs = INPUTS
    first = f"{JOINT_PERCENT}%"
    frame_as_written = staticmethod(LANGUAGE.frame_as_written)

    def check(self) -> None:
        self.require_frame(LARGEST_FRAME)
        count = len(self.plan.searches)
        self.require_room(self.setup.fanuc, {"position register": count + 1, "register": count + HEAD + 1}, least=1)
        require_coupling(self.program.arm)

    @property
    def first_point(self) -> int:
        return 1 if self.plan.home_joints is None else 2

    def points_of(self, steps: TouchSteps, first: int) -> list[str]:
        return [f"P[{number}]" for number in range(first, first + len(steps.p))]

    speed_of = staticmethod(tp_speed)

    def files(self) -> dict[str, str]:
        setup = self.setup.fanuc
        signal, enable = f"DI[{self.signal}]", f"DO[{self.enable}]" if self.enable else ""
        count, halves = len(self.plan.searches), halves_of(self.plan.fingerprint)
        tool = self.controller.tool_number
        lines = self.lines(
            "touch",
            header=self.header(signal, self._about(), clean=";"),
            signal=signal,
            first=setup.first_register,
            place=setup.first_position_register,
            schedule=setup.schedule,
            frame=set_frame(self.setup.frame_number, setup.first_position_register, self.frame),
            registers=(*halves, self.setup.frame_number, tool, count, *[NOT_RUN] * count, 0),
            near_speed=lambda: tp_speed(self.setup.approach_speed_mm_s),
            search_speed=lambda: tp_speed(self.setup.search_speed_mm_s),
            axis=self._axis,
            home=self.home("P[1]", self.first),
            **self.sensing(signal, enable),
        )
        head = f"\tUF : {self.setup.frame_number}, UT : {tool},"
        home = self.plan.home_joints
        bodies = [] if home is None else joint_bodies(head, home[None])
        for each in self.searches:
            bodies += pose_bodies(head, self.configurations(CONFIGURATION, each.steps), each.steps.p, each.steps.R)
        return {f"{self.name}.ls": tp_file(self.name, lines, numbered(bodies))}

    def _about(self) -> list[str]:
        setup, count = self.setup.fanuc, len(self.plan.searches)
        first, place = setup.first_register, setup.first_position_register
        about = [
            f"results: R[{first + HEAD}] to R[{first + HEAD + count - 1}] outcomes, PR[{place + 1}] to "
            f"PR[{place + count}] places, in the order of the searches: copy posreg.va and numreg.va",
            f"R[{first}] to R[{first + HEAD - 1}]: fingerprint, user frame, tool, count",
            f"UFRAME {self.setup.frame_number} becomes the part as planned (PR[{place}]): weld programs must use "
            "another one",
            f"points and places are relative to it, mm; {LANGUAGE.rotation}, deg",
            CONFIGURATION.origin(self.controller, has_arm=self.program.arm is not None),
        ]
        if self.setup.with_package:
            about.append(f"touch schedule {setup.schedule}: its frame must be parallel to the part, its speed is used")
        return about

    def _axis(self, search: SearchText) -> str:
        """Return the axis of the part along which a search runs, as ``-Y``."""
        direction = search.steps.search.direction
        row = int(np.argmax(np.abs(direction)))
        if np.linalg.norm(np.delete(direction, row)) > PARALLEL:
            raise InputError(
                f"FANUC: search {search.name} runs along ({' '.join(f'{v:.3f}' for v in direction)}); Touch Sensing "
                "searches along an axis of the part only: with_package = false in the touch setup"
            )
        return f"{'-' if direction[row] < 0.0 else ''}{'XYZ'[row]}"


NUMBERS = re.compile(r"^\[\*NUMREG\*\]\$NUMREG\b", re.MULTILINE)
NUMBER = re.compile(r"^\s*+\[(?P<number>\d{1,5})\]\s*+=\s*+(?P<value>[^\s']++)")


def read_fanuc_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read both files; see `TouchResultsReader`."""
    positions = next((each for each in files if POSITIONS.search(each.text)), None)
    registers = next((each for each in files if NUMBERS.search(each.text)), None)
    path = files[0].path
    if positions is None or registers is None:
        missing = "posreg.va" if positions is None else "numreg.va"
        raise FormatError(f"without {missing}: copy posreg.va and numreg.va into one folder", path=path)
    numbers = _numbers(registers)
    first, place = setup.fanuc.first_register, setup.fanuc.first_position_register
    stored = StoredValues(
        fingerprint=fingerprint_of_stored(numbers.get(first), numbers.get(first + 1)),
        tool=text_number(number_at(numbers, first + 3, f"R[{first + 3}]", registers.path)),
        count=number_at(numbers, first + 4, f"R[{first + 4}]", registers.path),
    )
    poses = {each.number: each.pose for each in registers_of(positions.text, positions.path)}
    T_base_part = poses.get(place)
    if isinstance(T_base_part, str):
        raise FormatError(f"PR[{place}], the user frame of the touches, {T_base_part}", path=positions.path)
    stored.T_base_part = T_base_part
    for k, search in enumerate(plan.searches):
        name, register, number = search.name.upper(), first + HEAD + k, place + 1 + k
        stored.outcomes[name] = number_at(numbers, register, f"R[{register}]", registers.path)
        pose = poses.get(number, "is not in the file")
        if isinstance(pose, str):
            stored.faults[name] = f"PR[{number}] {pose}"
        else:
            stored.places[name] = pose
    return stored.results("fanuc", positions.path)


def _numbers(file: ResultsFile) -> dict[int, float]:
    """Return the registers with a value: of an empty one the controller prints ``Uninitialized``."""
    values: dict[int, float] = {}
    for _, line in rows_behind(NUMBERS, file.text):
        match = NUMBER.match(line)
        if match and "*" not in match["value"] and match["value"] != "Uninitialized":
            values[int(match["number"])] = parsed_number(match["value"], f"R[{match['number']}]", file.path)
    return values
