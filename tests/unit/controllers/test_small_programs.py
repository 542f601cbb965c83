"""Small programs with loops, branches, parts of places and displacements lead where their languages say.

The places are worked out by hand from the manuals; the texts are in `fixtures/small_programs`.
"""

from pathlib import Path

import numpy as np
import pytest

from wpcal.controllers.judge.execute import execute

FOLDER = Path(__file__).parents[3] / "fixtures" / "small_programs"
PLACES = {
    "m.mod": "110,19,30 130,17,31 150,15,32 8,0,0 8,2.5,0 6,3.5,3 11,9.5,10 C8,2.5,0",
    "m.src": "110,20,30 130,20,30 150,20,30 150,2.5,30 150,2.5,0 98,21,33 103,21,33 1,2,3 1,2,3 C150,2.5,0",
    "m.as": "110,19,30.5 130,17,31.5 150,15,32.5 100,28,30 7,14,-7",
    "M.LS": "110,20,30 120,20,30 130,20,30 130,3,30 130,-3,30",
    "m.script": "110,20,30 140,2.5,30 190,2.5,5 191,4.5,3 C191,4.5,3",
    "m.pdl": "110,20,30 140,20,30 190,20,30 190,2.5,30 190,2.5,0",
    "M.JBI": "100,20,30 100,20,30 1,2,3",
}


@pytest.mark.parametrize("name", PLACES)
def test_a_small_program_leads_where_its_language_says(name: str) -> None:
    trace = execute({name: (FOLDER / name).read_text()}, tools=("", 1), T_flange_tool=np.eye(4), T_base_frame=np.eye(4))
    assert [unknown.text for unknown in trace.unknowns] == []
    goals = [(motion.kind, motion.goal[:3, 3].round(3) + 0.0) for motion in trace.motions]
    told = " ".join(kind.replace("L", "") + ",".join(f"{value:g}" for value in p) for kind, p in goals)
    assert told == PLACES[name]
