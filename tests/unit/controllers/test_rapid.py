"""RAPID: what the language asks for, and taught points; `test_program_text` reads its programs back."""

import re

import numpy as np
import pytest

from wpcal.controllers.abb.write import write_rapid
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.taught_program import read_taught_program
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.taught.user_frames import ProgramReading

ATOL_MM = 1e-5
"""Five decimals in three coordinates: 0.9e-5. The frame's own rounding does not count: targets are relative to it."""


def test_the_file_says_what_each_name_was_and_what_it_does_not_know(make_program):
    (text,) = write_rapid(make_program(names=("naht\nMoveL home;", "W1"))).values()
    assert "ConfL\\Off" in text[text.index("PROC weld_W1") :]
    assert "naht\\x0aMoveL home; -> naht_MoveL_home" in text
    assert not re.search(r"^\s*MoveL home", text, re.MULTILINE)
    assert "confdata is not known" in text
    assert text.isascii()
    assert text.count("\r\n") == text.count("\n")


def test_long_names_are_cut_and_stay_apart(make_program):
    program = make_program(names=("x" * 40 + "1", "x" * 40 + "2"), controller=ControllerSettings(program_name="1 a"))
    ((name, text),) = write_rapid(program).items()
    assert name == "W_1_a.mod"
    identifiers = re.findall(r"(?:robtarget|PROC) (\w+)", text)
    assert max(map(len, identifiers)) <= 32
    assert len(set(map(str.lower, identifiers))) == len(identifiers)


def taught(tmp_path, text, **options):
    path = tmp_path / "taught.mod"
    path.write_bytes(text.encode("latin-1"))
    return read_taught_program(path, ProgramReading(**options))


TAUGHT = """MODULE Taught
  ! CONST robtarget ghost:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS wobjdata fixture:=[FALSE,TRUE,"",[[100,0,0],[0.707106781,0,0,0.707106781]],[[0,0,50],[1,0,0,0]]];
  LOCAL CONST robtarget P1 := [[10,20,30],[1,0,0,0],
      [0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget P2:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  PROC teach()
    MoveL P1,v100,fine,tTorch\\WObj:=Fixture; ! turned 90 degrees about z
    MoveL P2,v100,fine,tTorch;
  ENDPROC
ENDMODULE
"""


def test_taught_points_are_in_the_work_object_of_their_moves(tmp_path):
    points = taught(tmp_path, TAUGHT)
    assert points.names == ("P1", "P2")
    assert points.lines == (4, 6)
    np.testing.assert_allclose(points.p_base, [[80, 10, 80], [1, 2, 3]], rtol=0, atol=1e-6)


def test_the_object_frame_is_relative_to_the_user_frame(tmp_path):
    """A quarter turn about x in the object, then one about z in the user frame: [10,20,30] goes to [110,10,70]."""
    turned = TAUGHT.replace("[[0,0,50],[1,0,0,0]]", "[[0,20,50],[0.707106781,0.707106781,0,0]]")
    np.testing.assert_allclose(taught(tmp_path, turned).p_base[0], [110, 10, 70], rtol=0, atol=1e-6)


def test_without_moves_the_file_does_not_say_the_frame(tmp_path):
    data = "\n".join(TAUGHT.splitlines()[:6]) + "\nENDMODULE"
    with pytest.raises(FormatError, match=r"point P1: .*give it as X,Y,Z,Q1,Q2,Q3,Q4 or as base, .*fixture") as refused:
        taught(tmp_path, data)
    assert refused.value.code == ErrorCode.USER_FRAME_MISSING
    np.testing.assert_array_equal(taught(tmp_path, data, uframes={"": "base"}).p_base[0], [10, 20, 30])
    turned = taught(tmp_path, data, uframes={"": "fixture"}).p_base[0]
    np.testing.assert_allclose(turned, [80, 10, 80], rtol=0, atol=1e-6)


def test_a_work_object_that_is_not_in_the_file_is_asked_for(tmp_path):
    text = TAUGHT.replace("PERS wobjdata", "! PERS wobjdata")
    with pytest.raises(FormatError, match="user frame fixture, whose values the file does not contain"):
        taught(tmp_path, text)
    given_one = taught(tmp_path, text, uframes={"fixture": [100, 0, 50, 0.5**0.5, 0, 0, 0.5**0.5]})
    np.testing.assert_allclose(given_one.p_base[0], [80, 10, 80], rtol=0, atol=1e-6)
    with pytest.raises(InputError, match="expected 7 numbers, got 6"):
        taught(tmp_path, text, uframes={"fixture": [100, 0, 50, 0, 0, 90]})


def test_points_taught_with_tool0_need_the_tool(tmp_path):
    text = TAUGHT.replace("tTorch;", "tool0;")
    with pytest.raises(FormatError, match="line 6: point P2: was recorded without a tool") as refused:
        taught(tmp_path, text)
    assert refused.value.code == ErrorCode.TOOL_MISSING
    np.testing.assert_array_equal(taught(tmp_path, text, tool=[0, 0, 100]).p_base[1], [1, 2, 103])
    assert taught(tmp_path, text, points=["P1"]).names == ("P1",)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[1,0,0,0],[0,0,0,0]", "[1,1,0,0],[0,0,0,0]", "length 1.414"),
        ("[1,0,0,0],[0,0,0,0]", "[0,0,0,0],[0,0,0,0]", "was never taught"),
        ("[[1,2,3]", "[[1,2]", "expected .x,y,z."),
        ("[[1,2,3]", "[[1,2,x]", "expected a number, got 'x'"),
        ("[FALSE,", "[TRUE,", "which the robot or another unit carries"),
        ("P2,v100,fine,tTorch;", "P1,v100,fine,tTorch;", "several work objects: fixture, wobj0"),
        ("robtarget P2", "jointtarget P2", "jointtarget"),
    ],
)
def test_bad_modules_are_refused_with_the_line(tmp_path, old, new, message):
    with pytest.raises(FormatError, match=rf"taught\.mod, line \d+: .*{message}"):
        taught(tmp_path, TAUGHT.replace(old, new))


def test_what_is_not_asked_for_does_no_harm(tmp_path):
    """A local variable of a name that appears twice, a target that was never taught, and an array of work objects."""
    unset = "VAR robtarget r:=[[0,0,0],[0,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    stands = 'PERS wobjdata stand{2}:=[[FALSE,TRUE,"",[[1,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]],'
    stands += '[FALSE,TRUE,"",[[2,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]]];'
    text = TAUGHT.replace("ENDMODULE", f"{unset}\n{unset}\n{stands}\nENDMODULE")
    expected = taught(tmp_path, TAUGHT)
    np.testing.assert_array_equal(taught(tmp_path, text, points=["P1", "P2"]).p_base, expected.p_base)
    with pytest.raises(FormatError, match="the point 'r' appears twice"):
        taught(tmp_path, text)


def test_our_own_module_is_read_as_taught_points(tmp_path, make_program):
    program = make_program(3)
    (text,) = write_rapid(program).values()
    points = taught(tmp_path, text)
    np.testing.assert_allclose(points.p_base, program.paths[0].p_base, rtol=0, atol=ATOL_MM)
