"""Small programs with loops, branches, parts of places and displacements lead where their languages say.

The places are worked out by hand from the manuals; the texts are in `fixtures/small_programs`.
"""

from pathlib import Path

import numpy as np
import pytest

from wpcal.controllers.judge.execute import execute

FOLDER = Path(__file__).parents[3] / "fixtures" / "small_programs"
PLACES = dict(row.split(": ") for row in (FOLDER / "places.txt").read_text().splitlines())


@pytest.mark.parametrize("name", PLACES)
def test_a_small_program_leads_where_its_language_says(name: str) -> None:
    trace = execute({name: (FOLDER / name).read_text()}, tools=("", 1), T_flange_tool=np.eye(4), T_base_frame=np.eye(4))
    assert [unknown.text for unknown in trace.unknowns] == []
    goals = [(motion.kind, motion.goal[:3, 3].round(3) + 0.0) for motion in trace.motions]
    told = " ".join(kind.replace("L", "") + ",".join(f"{value:g}" for value in p) for kind, p in goals)
    assert told == PLACES[name]
