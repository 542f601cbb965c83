"""Controller files that others published: every position, against a parser that shares nothing with ours.

The files lie outside the repository (`../shared/programs`, with their sources in SOURCES.md there).
"""

import re
from pathlib import Path

import numpy as np
import pytest

from wpcal.controllers.taught_program import read_taught_program
from wpcal.controllers.user_frames import ProgramReading
from wpcal.core.errors import FormatError

PROGRAMS = Path(__file__).resolve().parents[4] / "shared" / "programs"
NUMBER = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
PLACES = {
    ".ls": re.compile(rf"GP1:.*?X =\s*{NUMBER}\s+mm,\s*Y =\s*{NUMBER}\s+mm,\s*Z =\s*{NUMBER}\s+mm", re.DOTALL),
    ".jbi": re.compile(rf"^[CP]\d+={NUMBER},{NUMBER},{NUMBER},", re.MULTILINE),
    ".dat": re.compile(rf"E6POS XP(?:20|19)=\{{X {NUMBER},Y {NUMBER},Z {NUMBER},"),
    ".mod": re.compile(rf"robtarget\s+\w+\s*:=\s*\[\[{NUMBER},{NUMBER},{NUMBER}\]"),
}
"""The three coordinates of every position, in file order, and nothing else of the language."""
pytestmark = pytest.mark.skipif(
    not PROGRAMS.is_dir(), reason="published controller files are not beside the repository"
)


def robtargets(path):
    return re.findall(r"^\s*(?:CONST|PERS|VAR) robtarget (\w+)", path.read_text(encoding="latin-1"), re.MULTILINE)


@pytest.mark.parametrize(
    ("name", "count", "points"),
    [
        ("abb_cubo_MainModule.mod", 18, robtargets),
        ("abb_irb120_Module1.mod", 1, lambda path: None),
        ("fanuc_layer_2.ls", 88, lambda path: None),
        ("fanuc_up222_excerpt.ls", 2, lambda path: None),
        ("yaskawa_USER_CART_S1.jbi", 4, lambda path: None),
        ("kuka_style1app1opt1B_excerpt.dat", 2, lambda path: ["P20", "P19"]),
    ],
)
def test_every_position_is_read(name, count, points):
    path = PROGRAMS / name
    expected = np.array(PLACES[path.suffix].findall(path.read_text(encoding="latin-1")), dtype=float)
    read = read_taught_program(path, ProgramReading({"": "base"}, [0, 0, 0], points=points(path)))
    assert len(read.names) == count
    np.testing.assert_array_equal(read.p_base, expected)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("abb_cubo_MainModule.mod", "without a tool"),
        ("fanuc_layer_2.ls", "user frame 6, whose values"),
        ("yaskawa_USER_CART_S1.jbi", "user frame 2, whose values"),
        ("yaskawa_000_excerpt.jbi", "is stored as pulses"),
        ("kuka_style1app1opt1B_excerpt.dat", "user frame 3, whose values"),
    ],
)
def test_what_a_file_does_not_say_is_asked_for(name, message):
    with pytest.raises(FormatError, match=message):
        read_taught_program(PROGRAMS / name)
