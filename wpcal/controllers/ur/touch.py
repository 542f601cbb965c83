"""Universal Robots: one URScript program ``NAME_touch.script`` that touches the part.

A thread moves; the program watches the input in every cycle of the controller, takes the pose when the input comes,
ends the thread and stops the robot. Results are lines of the log (``textmsg``), and are sent to a socket if the touch
setup names a computer.

References: Universal Robots, The URScript Programming Language (threads, get_actual_tcp_pose, stopl, textmsg, sockets,
popup).
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from wpcal.controllers.language.rounding import texts
from wpcal.controllers.language.touch import Numbers, TouchWriter
from wpcal.controllers.program.touch_program import TouchSteps
from wpcal.controllers.ur.grammar import MM_PER_M
from wpcal.controllers.ur.write import (
    DECIMALS,
    JOINT_LIMITS,
    LONGEST_COMMENT,
    MM,
    NAMES,
    limits,
    poses_in_part,
    poses_of,
    script_frame,
)
from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_number
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults, StoredValues
from wpcal.touch.searches.setup import TouchSetup

STOP_M_S2 = 2.0  #: Deceleration at contact: from 10 mm/s within 0.03 mm.
HOST = re.compile(r"[A-Za-z0-9.:_-]+")  #: The name or the address of a computer.


class _ScriptTouches(TouchWriter):
    format, names, longest_comment = "urscript", NAMES, LONGEST_COMMENT
    inputs = outputs = Numbers(default=0, most=7, least=0)
    first = JOINT_LIMITS
    frame_as_written = staticmethod(script_frame)

    def points_of(self, steps: TouchSteps, first: int) -> list[str]:
        return poses_in_part(steps.p, steps.R)

    speed_of = staticmethod(limits)

    def files(self) -> dict[str, str]:
        host, port = self.setup.urscript.results_host, self.setup.urscript.results_port
        if host and not HOST.fullmatch(host):
            what = f"results_host = {host!r} of the touch setup"
            raise InputError(f"{what}: expected the name or the address of a computer")
        sent = f", and sent to {host}:{port}" if host else ""
        joints = self.plan.home_joints
        at = "" if joints is None else f"[{', '.join(texts(joints[None], DECIMALS)[0])}]"
        lines = self.lines(
            "touch",
            header=self.header(f"digital input {self.signal}", self._about(sent)),
            frame=poses_of(self.frame.t_mm[None], self.frame.R[None])[0],
            signal=self.signal,
            acceleration=limits(1.0).partition(",")[0],
            near=f"{self.setup.approach_speed_mm_s * MM:g}",
            search=f"{self.setup.search_speed_mm_s * MM:g}",
            stop_m_s2=f"{STOP_M_S2:g}",
            host=host,
            port=port,
            home=self.home(at, JOINT_LIMITS),
            **self.sensing(self.signal, self.enable),
        )
        return {f"{self.name}.script": "\n".join([*lines, ""])}

    def _about(self, to: str) -> list[str]:
        fingerprint = self.plan.fingerprint
        return [
            f"results: lines of the log that begin with wpcal {fingerprint}{to}: keep them as a text file",
            "poses are relative to wp_part, the part as planned; m and rotation vectors in rad",
            "set the tool centre point before this program",
        ]


LINE = re.compile(r"\bwpcal\s++(?P<plan>[0-9a-fA-F]{8})\s++(?P<what>\w++)(?P<rest>.*)$")
POSE = re.compile(r"p?\[(?P<values>[^\[\]]*+)\]")
WORDS = {"found": 1.0, "missed": 2.0, "active": 3.0}  #: Outcomes, as numbers of other controllers.


def read_urscript_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the last run of a log; see `TouchResultsReader`."""
    file = files[0]
    stored: StoredValues | None = None
    for number, line in enumerate(file.text.splitlines(), start=1):
        match = LINE.search(line)
        if match is None:
            continue
        what, rest = match["what"], match["rest"]
        if what == "begin":
            stored = StoredValues(fingerprint=match["plan"], count=_count(rest, file.path, number))
        elif stored is not None and match["plan"].lower() == stored.fingerprint.lower():
            _note(stored, what, rest, file.path, number)
    if stored is None:
        raise FormatError('has no line "wpcal … begin" of a touch program', path=file.path)
    for search in plan.searches:  # a search without a line was not run
        stored.outcomes.setdefault(search.name.upper(), 0.0)
    return stored.results("urscript", file.path)


def _note(stored: StoredValues, what: str, rest: str, path: str, line: int) -> None:
    if what == "tool":
        stored.tool = rest.strip()
    elif what == "part":
        stored.T_base_part = _pose(rest, "part", path, line)
    elif what != "end":
        word = rest.split(maxsplit=1)[0] if rest.split() else ""
        if word not in WORDS:
            raise FormatError(f"search {what}: expected {', '.join(WORDS)}, got {word!r}", path=path, line=line)
        stored.outcomes[what.upper()] = WORDS[word]
        if word == "found":
            stored.places[what.upper()] = _pose(rest, f"search {what}", path, line)


def _count(text: str, path: str, line: int) -> float:
    try:
        return parse_number(text.strip())
    except InputError as error:
        raise FormatError(f"number of searches: {error}", path=path, line=line) from None


def _pose(text: str, what: str, path: str, line: int) -> RigidTransform:
    match = POSE.search(text)
    try:
        values = np.array([parse_number(cell) for cell in ("" if match is None else match["values"]).split(",")])
    except InputError as error:
        raise FormatError(f"{what}: {error}", path=path, line=line) from None
    if len(values) != 6:
        raise FormatError(f"{what}: expected six numbers, got {len(values)}", path=path, line=line)
    if not np.linalg.norm(values[3:]) <= 4.0 * np.pi:
        raise FormatError(f"{what}: its rotation vector is longer than two turns", path=path, line=line)
    return RigidTransform(exp_rotation(values[3:]), MM_PER_M * values[:3], "base", "frame")
