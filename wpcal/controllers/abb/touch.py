r"""ABB RAPID: a program that touches the part, and a module with its results.

``NAME_touch.mod`` is the program: a procedure per search, one that runs them all, and `wptTouch`, which searches.
``NAME_touch_res.mod`` holds the results as ``PERS`` data; the program saves it with ``Save``. With `with_package` the
search is ``Search_1D`` of SmarTac. It searches over twice the distance from its start to its search point, which is
therefore half of the stroke.

References: ABB, Technical reference manual: RAPID Instructions, Functions and Data types (SearchL, Save, TRYNEXT,
ERRNO). ABB, Application manual SmarTac (Search_1D).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from wpcal.controllers.abb.read import read_rapid
from wpcal.controllers.abb.statements import declarations, statements_of
from wpcal.controllers.abb.write import (
    JOINT_SPEED,
    LONGEST_COMMENT,
    NAMES,
    NO_EXTERNAL_AXES,
    OFF,
    ON,
    jointtargets,
    rapid_frame,
    robtargets,
    speed_data,
)
from wpcal.controllers.language.naming import comment_lines, own_name, safe_name
from wpcal.controllers.language.touch import ResultNames, TouchWriter
from wpcal.controllers.program.touch_program import TouchSteps
from wpcal.core.errors import FormatError, InputError
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults
from wpcal.touch.searches.setup import TouchSetup

SIGNAL = "diTouch"  #: The input, if the touch setup names none.
HOME = "wptHome"
WAY = ("wptOver", "wptSafe")  #: From the last search to the weld program.
FOLDER = re.compile(r"[\w:/.-]+")  #: A folder of the controller, as ``HOME:`` or ``HOME:/touch``.
HELD_MM = 0.01  #: Where a search of SmarTac ended without contact, it may leave the place as it was.


class _RapidTouches(TouchWriter):
    format, names, longest_comment, has_package = "rapid", NAMES, LONGEST_COMMENT, True
    air, first = "wptAir", JOINT_SPEED
    way_points = WAY
    frame_as_written = staticmethod(lambda T: rapid_frame(T)[1])

    def points_of(self, steps: TouchSteps, first: int) -> list[str]:
        return [f"wpt{steps.name}_{mark}" for mark in steps.marks]

    @property
    def signal(self) -> str:
        return own_name(self.setup.signal or SIGNAL, NAMES, what="signal of the touch setup")

    def files(self) -> dict[str, str]:
        tool = own_name(self.controller.tool_name, NAMES, what="tool")
        folder = self.setup.rapid.results_folder.rstrip("/")
        if not FOLDER.fullmatch(self.setup.rapid.results_folder):
            what = f"results_folder {self.setup.rapid.results_folder!r} of the touch setup"
            raise InputError(f"{what}: expected a folder of the controller, as HOME:")
        results = f"{self.name}_res"
        off, on = ([], []) if self.program.arm is not None else (list(OFF), list(ON))
        names: dict[str, Any] = {
            "tool": tool,
            "folder": folder,
            "results": results,
            "wobj": f'[FALSE,TRUE,"",[{rapid_frame(self.plan.T_base_part)[0]}],[[0,0,0],[1,0,0,0]]];',
            "signal": self.signal,
        }
        names |= self.sensing(self.signal, self.enable)
        home = self.home(HOME, JOINT_SPEED)
        more = {"off": off, "on": on, "home": home, "data": self._data(), "held_mm": f"{HELD_MM:g}"}
        about = comment_lines(
            [f"results of {self.name}; the program writes them, and saves this module"], mark="  ! ", longest=72
        )
        header = self.header(self.signal, self._about(tool, folder, results))
        texts = {
            self.name: self.lines("touch", header=header, **names, **more),
            results: self.lines("touch_results", about=about, no_axes=NO_EXTERNAL_AXES, **names),
        }
        if self.program.welds is not None:
            module = f"{self.name}_weld"
            main = safe_name(f"run_{safe_name(self.controller.program_name, NAMES)}", NAMES)
            about = comment_lines([f"run_{module} searches, corrects wpPart and welds"], mark="  ! ", longest=72)
            texts[module] = self.lines("touch_weld", about=about, module=module, weld=main)
        return {f"{name}.mod": "\r\n".join([*lines, ""]) for name, lines in texts.items()}

    def _about(self, tool: str, folder: str, results: str) -> list[str]:
        about = [
            f"results: module {results}, which must be loaded too; saved as {folder}/{results}.mod",
            "targets and results are relative to wpPart, the part as planned; mm; q1..q4 = w,x,y,z",
            "confdata is not known: ConfJ, ConfL \\Off let the controller choose, and are On again at the end"
            if self.program.arm is None
            else "confdata is computed from the joints",
            f"run the procedure run_{self.name}; tool {tool} must be declared on the controller",
        ]
        if self.setup.with_package:
            about.append("searches with SmarTac, at its own speed (SMARTAC_SPEEDS); if it asks, answer RAISE")
        return about

    def _data(self) -> list[str]:
        setup, home = self.setup, self.plan.home_joints
        return [
            *(speed_data("wptAir", setup.air_speed_mm_s), speed_data("wptSearch", setup.search_speed_mm_s)),
            *([] if setup.with_package else [speed_data("wptNear", setup.approach_speed_mm_s)]),
            *([] if home is None else jointtargets([HOME], home[None])),
            *([] if self.way is None else robtargets(WAY, *self.way, None)),
            *(
                line
                for each in self.searches
                for line in robtargets([*each.at.values()], each.steps.p, each.steps.R, each.steps.postures)
            ),
        ]


STORED = ResultNames("wptplan", "wpttool", "wptcount", "wpto_", "wptp_", "wptpart")


def read_rapid_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the saved module of results; see `TouchResultsReader`."""
    file = next((each for each in files if _values(each.text, "string")), files[0])
    values = _values(file.text, "string", "num")
    stored = STORED.stored(values, read_rapid(file.text, file.path), file.path)
    if stored.outcomes and stored.T_base_part is None:
        raise FormatError("lacks the work object wptPart of the places", path=file.path)
    return stored.results("rapid", file.path)


def _values(text: str, *kinds: str) -> dict[str, str]:
    """Return what a program of touches stores, without quotes."""
    found = declarations(statements_of(text), *kinds)
    return {
        each.name: "".join(each.tokens).strip('"')
        for each in found
        if each.storage == "PERS" and each.name.lower().startswith("wpt")
    }
