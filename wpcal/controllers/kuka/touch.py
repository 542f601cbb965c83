"""KUKA KRL: a pair ``NAME_touch.src`` and ``NAME_touch.dat`` that touches the part.

An interrupt on the touch signal stops the search (``BRAKE``), stores ``$POS_INT``, the place where the signal came, and
leaves the search (``RESUME``). ``RESUME`` ends all subprograms up to the level that declared the interrupt. The search
is therefore two levels deep: `WPFIND` declares the interrupt, `WPSEARCH` moves and is ended. ``WAIT SEC 0`` after the
move stops the advance run, so that the program does not leave `WPSEARCH` before the robot is there.

With `with_package` the searches are folds of TouchSense. A fold goes to the start, searches over the via point, which
is the middle of the stroke, and at most half of the stroke farther. It goes back to the start. TouchSense keeps the
place in ``VCD….Meas_W``, relative to ``$WORLD``; the program turns it into the part. The form follows programs of a
public post-processor (docs/how-to/touch-programs.md). No controller ran it.

Results are variables of the data list, which the controller keeps in the ``.dat``.

References: KUKA, System Software 8.x: Operating and Programming Instructions for System Integrators (INTERRUPT, BRAKE,
RESUME, $POS_INT).
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from wpcal.controllers.kuka.arc import DATA, act_lines
from wpcal.controllers.kuka.read import read_krl
from wpcal.controllers.kuka.write import (
    BLEND_MM,
    DEG_DECIMALS,
    JOINT_PERCENT,
    LONGEST_COMMENT,
    NAMES,
    aggregates,
    axes_text,
    forms_in_words,
    forms_of,
    krl_frame,
    krl_frame_text,
)
from wpcal.controllers.language.naming import safe_name
from wpcal.controllers.language.post import metres_per_second
from wpcal.controllers.language.rounding import zyx_degrees
from wpcal.controllers.language.touch import Numbers, ResultNames, SearchText, TouchWriter
from wpcal.controllers.program.in_run import Term
from wpcal.controllers.program.touch_program import TouchSteps
from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults
from wpcal.touch.searches.setup import TouchSetup

INPUTS = Numbers(default=1, most=4096)  #: Inputs and outputs of a KR C4.
LARGEST_INTERRUPT = 39  #: Numbers up to it, and from 81 on, are free for users.
HOME = "WPHOME"
WAY = ("WPOVER", "WPSAFE")  #: From the last search to the weld program.
ZERO = "{X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}"


class _KrlTouches(TouchWriter):
    format, names, longest_comment, has_package = "krl", NAMES, LONGEST_COMMENT, True
    inputs = outputs = INPUTS
    way_points = WAY
    frame_as_written = staticmethod(krl_frame)

    speed_of = staticmethod(metres_per_second)

    def points_of(self, steps: TouchSteps, first: int) -> list[str]:
        return [f"WPT_{steps.name}_{mark}" for mark in steps.marks]

    def files(self) -> dict[str, str]:
        known = forms_of([each.postures for each in self.steps])
        signal, enable = f"$IN[{self.signal}]", f"$OUT[{self.enable}]" if self.enable else ""
        header = self.header(signal, self._about(is_known=known is not None))
        names = {"header": header, "signal": signal, "air": self.air, "percent": JOINT_PERCENT, "act_lines": act_lines}
        names["weld"] = safe_name(self.controller.program_name, NAMES)
        names |= {"seen": self._seen, "gains": _gains, "frame": krl_frame_text(self.frame)}
        names["near"] = metres_per_second(self.setup.approach_speed_mm_s)
        names |= {"interrupt": self._interrupt, "sensor": self.setup.krl.sensor, "home": self.home(HOME, "")}
        data = self.lines("touch_data", header=header, frame=krl_frame_text(self.frame), data=self._data(known))
        source = self.lines("touch", **names, **self.sensing(signal, enable))
        return {f"{self.name}.src": "\r\n".join([*source, ""]), f"{self.name}.dat": "\r\n".join([*data, ""])}

    def _seen(self, term: Term) -> list[str]:
        """Return the call that measures the deviation of a search: with its normal, or the axis and the radius."""
        flat = (*term.normal, term.normal @ term.planned)
        values = flat if term.axis is None else (*term.axis.ravel(), term.radius_mm)
        stated = ",".join(f"{value + 0.0:.9f}" for value in values)
        ahead = RigidTransform(np.eye(3), term.ahead, "part", "tool")
        return [
            *([f"WPAHEAD={krl_frame_text(ahead)}"] if self.plan.standoff_mm else []),
            f"{'WPOFF' if term.axis is None else 'WPROUND'}(WPR_{term.name},{stated})",
        ]

    @property
    def _interrupt(self) -> int:
        number = self.setup.krl.interrupt
        if not 1 <= number <= LARGEST_INTERRUPT:
            raise InputError(f"interrupt = {number} of the touch setup: KRL: expected 1 to {LARGEST_INTERRUPT}")
        return number

    def _about(self, *, is_known: bool) -> list[str]:
        about = [
            f"results: variables WPO_ and WPR_ of {self.name}.dat, which the controller keeps: copy this file",
            "points and results are relative to WPPART, the part as planned; mm; R = Rz(A) Ry(B) Rx(C), deg",
            f"BASE_DATA[{self.setup.frame_number}] becomes WPPART: weld programs must use another base",
            forms_in_words(is_known=is_known),
            f"tool {self.controller.tool_number}, interrupt {self._interrupt}",
            f"PTP moves run with {JOINT_PERCENT} % of the axes' speed",
        ]
        if self.setup.with_package:
            about.append(f"searches with TouchSense, sensor {self.setup.krl.sensor}, at its slow speed")
        return about

    def _data(self, known: list[list[str]] | None) -> list[str]:
        home = self.plan.home_joints
        lines = [] if home is None else [f"DECL E6AXIS {HOME}={axes_text(home)}"]
        for each in self.searches:
            values = aggregates(each.steps.p, each.steps.R, None if known is None else known[each.number])
            lines += [f"DECL E6POS {label}={value}" for label, value in zip(each.at.values(), values, strict=True)]
        if self.way is not None:
            lines += [f"DECL E6POS {name}={value}" for name, value in zip(WAY, aggregates(*self.way), strict=True)]
        if self.setup.with_package:
            lines += [line for each in self.searches for line in self._sensed(each)]
        return lines

    def _sensed(self, search: SearchText) -> list[str]:
        """Return the declarations of a search with TouchSense."""
        start, mark, R = search.at["S"], f"WPT_{search.name}_M", search.steps.R[:1]
        first, last = search.steps.p[search.steps.way_count + 1 : search.steps.way_count + 3]
        values = aggregates(np.stack([first, (first + last) / 2.0]), np.repeat(R, 2, axis=0))
        R_written = rotation_from_zyx(*np.radians(zyx_degrees(R[0], decimals=DEG_DECIMALS)))
        reference = krl_frame_text(self.frame @ RigidTransform(R_written, (first + last) / 2.0, "part", "tool"))
        tool, base = self.controller.tool_number, self.setup.frame_number
        half = float(np.linalg.norm(last - first)) / 2.0
        return [
            f"DECL E6POS X{start}={values[0]}",
            f"DECL E6POS X{mark}={values[1]}",
            f'DECL FDAT F{start}={{TOOL_NO {tool},BASE_NO {base},IPO_FRAME #BASE,POINT2[] " "}}',
            f"DECL LDAT LCPDAT{start}={{{DATA.format(blend=BLEND_MM)}}}",
            f"DECL TSg_PCollCD_T VCD{mark}={{CD_IPO_MODE #BASE,Mastered TRUE,SDir_W {ZERO},Ref_W {reference},"
            f"Meas_W {ZERO},Diff_W {ZERO},VecLenDiff_W 0.0,MEnum #CDEmpty,MC 1}}",
            f"DECL TSg_SearchProperty_T ZSP{mark}={{MoveType #MoveWithLin,TouchType #Single,DynamicStep #Slow,"
            f"SensorNum {self.setup.krl.sensor},SearchDepth_Tol {half:.4f},bBackToStartPos TRUE,PartThickness 0.0}}",
        ]


def _gains(term: Term) -> list[tuple[str, str]]:
    """Return what a deviation of 1 mm adds to X to Z, mm, and to C to A, which turn about x to z, deg."""
    gains = (*term.shift, *np.degrees(term.turn))
    return [(axis, f"{gain + 0.0:.9f}") for axis, gain in zip("XYZCBA", gains, strict=True)]


NUMBER = re.compile(r"^[ \t]*+(?:DECL\s++)?(?:GLOBAL\s++)?INT\s++(WP\w++)\s*+=\s*+(\S++)", re.MULTILINE | re.IGNORECASE)
PLAN = re.compile(r'^[ \t]*+(WPPLAN)\[\]\s*+=\s*+"([^"\n]*+)"', re.MULTILINE | re.IGNORECASE)
STORED = ResultNames("wpplan", "wptool", "wpcount", "wpo_", "wpr_", "wppart")


def read_krl_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the data list with the results; see `TouchResultsReader`."""
    file = next((each for each in files if PLAN.search(each.text)), files[0])
    values = {name.upper(): value for pattern in (PLAN, NUMBER) for name, value in pattern.findall(file.text)}
    return STORED.stored(values, read_krl(file.text, file.path), file.path).results("krl", file.path)
