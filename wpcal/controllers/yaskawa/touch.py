"""Yaskawa INFORM: a job ``NAME_TOUCH.jbi`` that touches the part.

A search is a ``MOVL … SRCH RIN#(n)=ON``: it ends at the end of its stroke, or where the direct input comes. ``$B002``
then says whether it came, and ``$PX002`` where, as pulses; ``CNVRT`` turns them into the user frame. INFORM cannot ask
for a direct input before a move: a signal that is on ends the search of the way to the start.

Places are in P-variables, outcomes in B-variables, fingerprint and numbers of frame and tool in D-variables. A job in a
user frame has no positions in joints: another job goes home.

References: Yaskawa, INFORM Language manuals (SRCH, GETS, CNVRT, GETE); docs/how-to/touch-sensing.md says what is
confirmed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wpcal.controllers.language.jobs import frame_in_words
from wpcal.controllers.language.rounding import rounded_frame
from wpcal.controllers.language.touch import Numbers, TouchWriter
from wpcal.controllers.program.touch_program import TouchSteps
from wpcal.controllers.yaskawa.read import AXES, Variables, variables_of
from wpcal.controllers.yaskawa.write import (
    CONFIGURATION,
    DEG_DECIMALS,
    FIRST,
    LANGUAGE,
    LONGEST_COMMENT,
    MM_DECIMALS,
    NAMES,
    inform_job,
    inform_speed,
    joint_kind,
    joint_positions,
    joint_rows,
    user_positions,
)
from wpcal.core.errors import FormatError
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import stored_pose
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

LARGEST_FRAME = 63  #: The last user frame.
HEAD = 5  #: D-variables: two of the fingerprint, user frame, tool, count. The next one counts the misses.


class _InformTouches(TouchWriter):
    format, names, longest_comment, is_upper = "inform", NAMES, LONGEST_COMMENT, True
    inputs, outputs = Numbers(default=1, most=6), Numbers(default=1, most=4096)  # RIN#(6) is not on all controllers
    first = FIRST
    frame_as_written = staticmethod(LANGUAGE.frame_as_written)

    def check(self) -> None:
        self.require_frame(LARGEST_FRAME)
        count = len(self.plan.searches)
        needed = {"position variable": count, "byte variable": count, "double variable": HEAD + 1}
        self.require_room(self.setup.inform, needed)

    def points_of(self, steps: TouchSteps, first: int) -> list[str]:
        return [f"C{number:05d}" for number in range(first, first + len(steps.p))]

    speed_of = staticmethod(inform_speed)

    def files(self) -> dict[str, str]:
        setup, name, user, tool = self.setup.inform, self.name, self.setup.frame_number, self.controller.tool_number
        signal, enable = f"RIN#({self.signal})", f"OT#({self.enable})" if self.enable else ""
        home = self.plan.home_joints
        lines = self.lines(
            "touch",
            header=self.header(signal, self._about()),
            signal=signal,
            double=setup.first_double_variable,
            byte=setup.first_byte_variable,
            position=setup.first_position_variable,
            doubles=(*halves_of(self.plan.fingerprint), user, tool, len(self.searches)),
            near_speed=lambda: inform_speed(self.setup.approach_speed_mm_s),
            search_speed=lambda: inform_speed(self.setup.search_speed_mm_s),
            home=[] if home is None else [f"CALL JOB:{name}H"],
            **self.sensing(signal, enable),
        )
        p, R = (np.concatenate([getattr(each, axis) for each in self.steps]) for axis in ("p", "R"))
        confs = [conf for each in self.steps for conf in self.configurations(CONFIGURATION, each)]
        positions = user_positions(user, tool, confs, p, R)
        files = {f"{name}.jbi": inform_job(name, positions, lines, user=user)}
        if home is not None:
            kind = joint_kind(self.program.arm)
            positions = joint_positions(tool, kind, joint_rows(home[None], self.program.arm, kind))
            files[f"{name}H.jbi"] = inform_job(f"{name}H", positions, self.home("C00000", FIRST))
        return files

    def _about(self) -> list[str]:
        setup, count = self.setup.inform, len(self.plan.searches)
        byte, place, head = setup.first_byte_variable, setup.first_position_variable, setup.first_double_variable
        return [
            *frame_in_words(LANGUAGE, self.setup.frame_number, self.frame),
            "weld jobs must use another user frame",
            CONFIGURATION.origin(self.controller, has_arm=self.program.arm is not None),
            f"results: B{byte:03d} to B{byte + count - 1:03d} outcomes, P{place:03d} to P{place + count - 1:03d} "
            "places, in the order of the searches: copy VAR.DAT",
            f"D{head:03d} to D{head + HEAD - 1:03d}: fingerprint, user frame, tool, count",
        ]


def read_inform_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the file of variables; see `TouchResultsReader`."""
    # ///B, ///D and ///P hold the variables in the order of their numbers, from 0. The user frame is not in the
    # file: the job asks in remarks to type it in, with the digits of the language
    file, inform = files[0], setup.inform
    rows = [*variables_of(file.text)]
    if not {"B", "D", "P"} <= {row.kind for row in rows}:
        raise FormatError("has no sections ///B, ///D and ///P of variables", path=file.path)
    byte, double = (_numbers(rows, kind, file.path) for kind in "BD")
    places = {row.first: row.cells for row in rows if row.kind == "P"}
    first = inform.first_double_variable
    stored = StoredValues(
        fingerprint=fingerprint_of_stored(double.get(first), double.get(first + 1)),
        tool=text_number(number_at(double, first + 3, f"D{first + 3:03d}", file.path)),
        count=number_at(double, first + 4, f"D{first + 4:03d}", file.path),
        T_base_part=rounded_frame(plan.T_base_part, mm_decimals=MM_DECIMALS, deg_decimals=DEG_DECIMALS),
    )
    for k, search in enumerate(plan.searches):
        name, number = search.name.upper(), inform.first_position_variable + k
        outcome = inform.first_byte_variable + k
        stored.outcomes[name] = number_at(byte, outcome, f"B{outcome:03d}", file.path)
        pose = _pose(places.get(number, []), f"P{number:03d}", file.path)
        if isinstance(pose, str):
            stored.faults[name] = pose
        else:
            stored.places[name] = pose
    return stored.results("inform", file.path)


def _numbers(rows: Sequence[Variables], kind: str, path: str) -> dict[int, float]:
    cells = {row.first + k: cell for row in rows if row.kind == kind for k, cell in enumerate(row.cells)}
    return {index: parsed_number(cell, f"{kind}{index:03d}", path) for index, cell in cells.items()}


def _pose(cells: Sequence[str], name: str, path: str) -> RigidTransform | str:
    if len(cells) < len(AXES):
        return f"{name} is not a Cartesian position"
    return stored_pose(list(zip(AXES, cells, strict=False)), name, path, 0)
