"""Judge programs of two robots that move by joints: each text has to lead through the states that were checked."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import zip_longest
from pathlib import Path

import numpy as np

from wpcal.controllers.judge.asked import SAME_DEG
from wpcal.controllers.judge.execute import execute, text_at
from wpcal.controllers.judge.written import WrittenWrongError
from wpcal.controllers.program.coordinated_program import SyncProgram
from wpcal.controllers.registry import grammar_of_file
from wpcal.controllers.run.recorder import Recorder, pulses_of

ROBOT = re.compile(r".*_R([12])")  #: The stem of a program of robot 1 or 2; all others only start both.


def require_in_step(files: Mapping[str, str], program: SyncProgram) -> None:
    """Execute every program: each robot has to go through its joints in their order, and nowhere else.

    Between two of them both robots move by the joints, as the run was checked.

    Raises `WrittenWrongError` with the first line that does something else.
    """
    for name, text in files.items():
        found, grammar = ROBOT.fullmatch(Path(name).stem), grammar_of_file(Path(name))
        if found is None or grammar is None:
            continue
        robot = int(found[1]) - 1
        trace = execute({name: text}, recorder=Recorder(pulses_of(program.arms[robot])))
        for unknown in trace.unknowns:
            if re.search(grammar.in_step, text_at(unknown.place, files)) is None:
                raise WrittenWrongError(f"{name}, line {unknown.place.line}: {unknown.text}; nothing is written")
        for motion, q in zip_longest(trace.motions, np.degrees(program.joints[robot])):
            goal = None if motion is None else motion.joints
            if goal is None or q is None or motion.kind != "J" or np.abs(goal - q).max() > SAME_DEG:
                where = "its end" if motion is None else f"line {motion.place.line}"
                raise WrittenWrongError(f"{name}, {where}: not the next joints of the plan; nothing is written")
