"""Kawasaki AS: one file ``NAME_touch.as`` that touches the part.

A search is an ``XMOVE … TILL`` the touch signal. If the signal is on when the robot has stopped, ``HERE`` stores where
it stands. This is behind the contact by the way of the stop; it counts as latency. Results are variables; the
controller writes them with ``SAVE``.

References: Kawasaki, AS Language Reference Manual (XMOVE, HERE, SIG); docs/how-to/touch-sensing.md says what is
confirmed.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from wpcal.controllers.kawasaki.read import read_as
from wpcal.controllers.kawasaki.write import (
    ACCURACY_MM,
    JOINT_PERCENT,
    LONGEST_COMMENT,
    MM_DECIMALS,
    NAMES,
    as_frame,
    as_frame_text,
    as_speed,
    transformations,
    without_repeats,
)
from wpcal.controllers.language.naming import own_name
from wpcal.controllers.language.rounding import texts
from wpcal.controllers.language.touch import Numbers, ResultNames, TouchWriter
from wpcal.controllers.program.touch_program import TouchSteps
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults
from wpcal.touch.searches.setup import TouchSetup


class _AsTouches(TouchWriter):
    format, names, longest_comment = "as", NAMES, LONGEST_COMMENT
    inputs, outputs = Numbers(default=1001, most=2256, least=1001), Numbers(default=1, most=960)
    first = f"{JOINT_PERCENT}"
    frame_as_written = staticmethod(as_frame)

    def points_of(self, steps: TouchSteps, first: int) -> list[str]:
        return [f"wpt_{steps.name.lower()}{mark.lower()}" for mark in steps.marks]

    speed_of = staticmethod(as_speed)

    def files(self) -> dict[str, str]:
        tool = own_name(self.controller.tool_name, NAMES, what="tool")
        signal = self.signal if self.setup.is_on_high else f"-{self.signal}"
        body = self.lines(
            "touch_body",
            tool=tool,
            accuracy_mm=ACCURACY_MM,
            signal=signal,
            near_speed=as_speed(self.setup.approach_speed_mm_s),
            search_speed=as_speed(self.setup.search_speed_mm_s),
            home=self.home("#wpt_home", str(JOINT_PERCENT)),
            **self.sensing(signal, self.enable),
        )
        points = [
            f"{label} {value}"
            for each in self.searches
            for label, value in zip(each.at.values(), transformations(each.steps.p, each.steps.R), strict=True)
        ]
        joints = self.plan.home_joints
        text = self.lines(
            "touch",
            header=self.header(f"signal {self.signal}", self._about(tool)),
            body=without_repeats(body),
            frame=as_frame_text(self.frame),
            points=points,
            joints="" if joints is None else " ".join(texts(np.degrees(joints)[None], MM_DECIMALS)[0]),
        )
        return {f"{self.name}.as": "\r\n".join([*text, ""])}

    def _about(self, tool: str) -> list[str]:
        return [
            "results: variables wpto_, wptp_ and $wpt_plan: SAVE them into a file on the controller and copy it",
            "points and results are relative to wpt_part, the part as planned; mm; R = Rz(O) Ry(A) Rz(T), deg",
            "the configuration is not known: the arm keeps the one it comes with"
            if self.plan.home_joints is None
            else "the configuration is that of the home: the arm keeps it",
            f"the transformation {tool} (the torch) must be on the controller",
        ]


SECTION = re.compile(r"^\.(?P<name>[A-Za-z]++)\b")
VALUE = re.compile(r'^\s*+(?P<name>\$?+\w++)\s*+=\s*+(?:"(?P<text>[^"\n]*+)"|(?P<number>\S++))')
STORED = ResultNames("$wpt_plan", "$wpt_tool", "wpt_count", "wpto_", "wptp_", "wpt_part")


def read_as_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the saved variables; see `TouchResultsReader`."""
    file = next((each for each in files if STORED.outcome in each.text.lower()), files[0])
    values, places, section = dict[str, str](), [".TRANS"], ""
    for line in file.text.splitlines():
        head = SECTION.match(line)
        section = head["name"].upper() if head else section
        # programs of the same file say nothing about these values
        places.append(line if not head and section == "TRANS" else "")
        if section in ("REALS", "STRINGS") and (match := VALUE.match(line)):
            values[match["name"].lower()] = match["number"] if match["text"] is None else match["text"]
    return STORED.stored(values, read_as("\n".join(places), file.path), file.path).results("as", file.path)
