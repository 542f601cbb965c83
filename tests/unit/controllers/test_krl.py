"""KRL: what the language asks for, and taught points; `test_program_text` reads its programs back."""

import re

import numpy as np
import pytest

from wpcal.controllers.kuka.write import write_krl
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.taught_program import read_taught_program
from wpcal.core.errors import FormatError, InputError
from wpcal.taught.user_frames import ProgramReading

ATOL_MM = 1e-5
"""Five decimals in three coordinates: 0.9e-5. The frame's own rounding does not count: points are relative to it."""


def test_the_file_says_that_c_was_fixed_where_b_is_a_quarter_turn(make_program):
    files = write_krl(make_program(n=9))
    assert "C was fixed at 0" in re.sub(r"\r\n; +", " ", files["WPCAL.src"])
    assert re.search(r"B -?90\.000000,C 0\.000000", files["WPCAL.dat"])


def test_status_and_turn_are_not_guessed(make_program):
    data = write_krl(make_program())["WPCAL.dat"]
    assert not re.search(r"[,{][ST] ", data)
    assert "S and T are not known" in data


def test_names_are_at_most_24_characters_and_no_keywords(make_program):
    program = make_program(names=("y" * 40, "lin"), controller=ControllerSettings(program_name="for", tool_number=7))
    files = write_krl(program)
    assert sorted(files) == ["for_2.dat", "for_2.src"]
    names = re.findall(r"E6POS (\w+)=", files["for_2.dat"])
    assert max(map(len, names)) <= 24
    assert "$TOOL=TOOL_DATA[7]" in files["for_2.src"]


TAUGHT = """&ACCESS RVP
DEFDAT TEACH
;DECL E6POS XGHOST={X 1,Y 1,Z 1,A 0,B 0,C 0}
EXT BAS (BAS_COMMAND :IN,REAL :IN )
DECL E6POS XP1={X 10.0,Y 20.0,Z -30.5,A 0.0,B 90.0,C 0.0,S 2,T 34,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}
DECL FDAT FP1={TOOL_NO 1,BASE_NO 3,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}
DECL E6POS XP2={X 1,Y 2,Z 3.0E1,A 0.0,B 0.0,C 0.0,S 2,T 34}
DECL FDAT FP2={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}
DECL LDAT LCPDAT1={VEL 2.00000,ACC 100.000,APO_DIST 100.000,APO_FAC 50.0000,ORI_TYP #VAR,CIRC_TYP #BASE}
ENDDAT
"""


def taught(tmp_path, text, **options):
    path = tmp_path / "teach.dat"
    path.write_bytes(text.encode("latin-1"))
    return read_taught_program(path, ProgramReading(**options))


def test_taught_points_are_in_the_base_that_fdat_names(tmp_path):
    points = taught(tmp_path, TAUGHT, uframes={"3": [100, 0, 0, 90, 0, 0]})
    assert points.names == ("P1", "P2")
    assert points.lines == (5, 7)
    np.testing.assert_allclose(points.p_base, [[80, 10, -30.5], [1, 2, 30]], rtol=0, atol=1e-9)


def test_a_base_whose_values_are_not_there_is_asked_for(tmp_path):
    with pytest.raises(
        FormatError, match=r"line 5: point P1: is in user frame 3.*give the user frame as 3=X,Y,Z,A,B,C"
    ):
        taught(tmp_path, TAUGHT)
    carried = TAUGHT.replace("ENDDAT", "BASE_DATA[3]={X 100,Y 0,Z 0,A 90,B 0,C 0}\nENDDAT")
    np.testing.assert_allclose(taught(tmp_path, carried).p_base[0], [80, 10, -30.5], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Z -30.5,", "", "XP1 lacks Z"),
        ("X 10.0", "X 1.0.0", "expected a number"),
        ("BASE_NO 3,IPO_FRAME #BASE", "BASE_NO 3,IPO_FRAME #TCP", "fixed tool"),
        ("TOOL_NO 1,BASE_NO 3", "TOOL_NO 0,BASE_NO 0", "recorded without a tool"),
        ("DECL FDAT FP1", "DECL FDAT FP9", "does not say its user frame"),
        ("DECL E6POS XP2={X 1,Y 2,Z 3.0E1,A 0.0,B 0.0,C 0.0", "DECL E6AXIS XP2={A1 0,A2 0,A3 0,A4 0", "joint angles"),
        ("XP2", "XP1", "appears twice, first in line 5"),
    ],
)
def test_bad_data_lists_are_refused_with_the_line(tmp_path, old, new, message):
    with pytest.raises(FormatError, match=rf"teach\.dat, line \d+: .*{message}"):
        taught(tmp_path, TAUGHT.replace(old, new), uframes={"3": "base"})


def test_our_own_data_list_is_read_in_the_frame_it_carries(tmp_path, make_program):
    program = make_program(3)
    points = taught(tmp_path, write_krl(program)["WPCAL.dat"], uframes={"": "WP_PART"})
    np.testing.assert_allclose(points.p_base, program.paths[0].p_base, rtol=0, atol=ATOL_MM)


def test_a_file_without_points_and_an_unknown_kind_are_refused(tmp_path):
    with pytest.raises(FormatError, match="holds no stored positions"):
        taught(tmp_path, "DEFDAT X\nENDDAT\n")
    known = re.escape(".as, .dat, .dg, .jbi, .ls, .mod, .pdl, .prg, .sys, .va")
    with pytest.raises(InputError, match=rf"unknown kind of program '\.src'; known: {known}"):
        read_taught_program(tmp_path / "x.src")
    with pytest.raises(InputError, match="no such file"):
        read_taught_program(tmp_path / "x.dat")
