"""Taught points from the programs of every language: what is read, in which frame, and what is refused by its line."""

import re

import numpy as np
import pytest

from wpcal.controllers.registry import controller_named
from wpcal.controllers.taught_program import read_taught_program
from wpcal.controllers.user_frames import ProgramReading
from wpcal.core.errors import ErrorCode, FormatError, InputError

FILES = {
    "rapid": "taught.mod",
    "krl": "teach.dat",
    "fanuc": "TEACH.LS",
    "inform": "teach.jbi",
    "as": "teach.as",
    "pdl2": "teach.pdl",
}
TAUGHT = {
    "rapid": """MODULE Taught
  ! CONST robtarget ghost:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS wobjdata fixture:=[FALSE,TRUE,"",[[100,0,0],[0.707106781,0,0,0.707106781]],[[0,0,50],[1,0,0,0]]];
  LOCAL CONST robtarget P1 := [[10,20,30],[1,0,0,0],
      [0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget P2:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  PROC MoveAlong()
    MoveL P1,v100,fine,tTorch\\WObj:=Fixture; ! turned 90 degrees about z
    MoveOn: MoveL P2,v100,fine,tTorch;
  ENDPROC
ENDMODULE
""",
    "krl": """&ACCESS RVP
DEFDAT TEACH
;DECL E6POS XGHOST={X 1,Y 1,Z 1,A 0,B 0,C 0}
EXT BAS (BAS_COMMAND :IN,REAL :IN )
DECL E6POS XP1={X 10.0,Y 20.0,Z -30.5,A 0.0,B 90.0,C 0.0,S 2,T 34,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}
DECL FDAT FP1={TOOL_NO 1,BASE_NO 3,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}
DECL E6POS XP2={X 1,Y 2,Z 3.0E1,A 0.0,B 0.0,C 0.0,S 2,T 34}
DECL FDAT FP2={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}
DECL LDAT LCPDAT1={VEL 2.00000,ACC 100.000,APO_DIST 100.000,APO_FAC 50.0000,ORI_TYP #VAR,CIRC_TYP #BASE}
ENDDAT
""",
    "fanuc": """/PROG  TEACH
/ATTR
/MN
   1:L P[1] 100mm/sec FINE    ;
/POS
P[1:"corner"]{
   GP1:
\tUF : 3, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =    10.000  mm,\tY =    20.000  mm,\tZ =   -.500  mm,
\tW =  -179.710 deg,\tP =      .002 deg,\tR =     2.111 deg
   GP2:
\tUF : 1, UT : 2,
\tJ1=     0.000 deg
};
P[2] {
    GP1:
        UF : 0, UT : 5,     CONFIG: 'N U T, 0, 0, 0',
       X = 1.0 mm, Y = 2.0 mm, Z = 3.0 mm,
       W = 0.0 deg, P = 0.0 deg, R = 90.0 deg
 };
/END
""",
    "inform": """/JOB
//NAME TEACH
//POS
///NPOS 3,0,0,0,0,0
///TOOL 1
///POSTYPE ROBOT
///RECTAN
///RCONF 1,0,0,0,0,0,0,0
C00000=1.000,2.000,3.000,180.0000,0.0000,0.0000
///USER 3
///POSTYPE USER
C00001=10.000,20.000,-0.500,0.0000,0.0000,0.0000
C00002=0.000,0.000,0.000,0.0000,0.0000,0.0000
//INST
///DATE 2020/02/02 20:20
NOP
MOVL C00000 V=10.0
P00001=not a position here
END
""",
    "as": """.NETCONF 192.168.0.2
.PROGRAM teach() #12
; LMOVE not_a_move
  BASE fix
  TOOL torch
  LMOVE v1
  JMOVE V2 ;to the corner
  BASE NULL
  LMOVE v3
  LMOVE v1x[1,2]
  LMOVE shift.a + v5
  JMOVE #home1
.END
.TRANS
fix 100.000000 0.000000 0.000000 90.000000 0.000000 0.000000
torch 0 0 300 0 0 0
v1 10 20 -0.5 0 180 0
v2 0 0 0 0.0 90.0 0.0
v3 1 2 3 0 180 0 0 180
v1x[1,2] 7 8 9 0 180 0
v5 5 5 5 0 180 0
.END
.JOINTS
#home1 0.0 10.0 -20.0 0.0 90.0 0.0
.END
""",
    "pdl2": """PROGRAM teach HOLD
VAR
  fixture, corner, edge : POSITION
BEGIN
  fixture := POS(100, 0, 0, 90, 0, 0, '')
  $UFRAME := fixture
  corner := POS(1, 2, 3, 0, 90, 0, 'S')
  Edge := pos (10, 20.5, -0.5, 0, 0, 0, '')
END teach
""",
}


TURNED = [100, 0, 0, 0, 0, 90]


def taught(tmp_path, language, text, **options):
    path = tmp_path / FILES[language]
    path.write_bytes((text.replace("\n", "\r\n") if language == "as" else text).encode("latin-1"))
    return read_taught_program(path, ProgramReading(**options))


@pytest.mark.parametrize(
    ("language", "frame", "names", "lines", "p_base"),
    [
        ("rapid", None, "P1 P2", (4, 6), [[80, 10, 80], [1, 2, 3]]),
        ("krl", [100, 0, 0, 90, 0, 0], "P1 P2", (5, 7), [[80, 10, -30.5], [1, 2, 30]]),
        ("fanuc", TURNED, "corner P2", (6, 15), [[80, 10, -0.5], [1, 2, 3]]),
        ("inform", TURNED, "C00000 C00001 C00002", (9, 12, 13), [[1, 2, 3], [80, 10, -0.5], [100, 0, 0]]),
        ("as", None, "v1 v2 v3 v1x[1,2]", (17, 18, 19, 20), [[80, 10, -0.5], [100, 0, 0], [1, 2, 3], [7, 8, 9]]),
        ("pdl2", None, "corner Edge", (7, 8), [[98, 1, 3], [79.5, 10, -0.5]]),
    ],
)
def test_taught_points_are_read_in_their_frames(tmp_path, language, frame, names, lines, p_base, golden):
    """In the frame of their moves, of their data, or of the pendant."""
    chosen = names.split() if language == "as" else None
    points = taught(tmp_path, language, TAUGHT[language], uframes={"3": frame} if frame else {}, points=chosen)
    assert (points.names, points.lines) == (tuple(names.split()), lines)
    np.testing.assert_allclose(points.p_base, p_base, rtol=0, atol=1e-6)
    golden(points)


@pytest.mark.parametrize(
    ("language", "old", "new", "message"),
    [
        ("rapid", "[1,0,0,0],[0,0,0,0]", "[1,1,0,0],[0,0,0,0]", r"line \d+: .*length 1.414"),
        ("rapid", "[1,0,0,0],[0,0,0,0]", "[0,0,0,0],[0,0,0,0]", r"line \d+: .*was never taught"),
        ("rapid", "[[1,2,3]", "[[1,2]", r"line \d+: .*expected .x,y,z."),
        ("rapid", "[[1,2,3]", "[[1,2,x]", r"line \d+: .*expected a number, got 'x'"),
        ("rapid", "[FALSE,", "[TRUE,", r"line \d+: .*which the robot or another unit carries"),
        ("rapid", "P2,v100,fine,tTorch;", "P1,v100,fine,tTorch;", r"line \d+: .*several work objects: fixture, wobj0"),
        ("rapid", "robtarget P2", "jointtarget P2", r"line \d+: .*jointtarget"),
        ("krl", "Z -30.5,", "", r"line \d+: .*XP1 lacks Z"),
        ("krl", "X 10.0", "X 1.0.0", r"line \d+: .*expected a number"),
        ("krl", "BASE_NO 3,IPO_FRAME #BASE", "BASE_NO 3,IPO_FRAME #TCP", r"line \d+: .*fixed tool"),
        ("krl", "TOOL_NO 1,BASE_NO 3", "TOOL_NO 0,BASE_NO 0", r"line \d+: .*recorded without a tool"),
        ("krl", "DECL FDAT FP1", "DECL FDAT FP9", r"line \d+: .*does not say its user frame"),
        (
            "krl",
            "DECL E6POS XP2={X 1,Y 2,Z 3.0E1,A 0.0,B 0.0,C 0.0",
            "DECL E6AXIS XP2={A1 0,A2 0,A3 0,A4 0",
            r"line \d+: .*joint angles",
        ),
        ("krl", "XP2", "XP1", r"line \d+: .*appears twice, first in line 5"),
        ("krl", "T 34,E1", "T 34;E1", r"line 5: XP1 lacks X"),
        ("fanuc", "UF : 3", "UF : 4", r"line 6: .*is in user frame 4, .*give the user frame as 4=X,Y,Z,W,P,R"),
        ("fanuc", "UF : 3", "UF : F", r"line 6: .*does not say its user frame"),
        ("fanuc", "UT : 2,\t\tC", "UT : 0,\t\tC", r"line 6: .*recorded without a tool"),
        ("fanuc", "X =    10.000  mm,\t", "", r"line 6: .*lacks X"),
        ("fanuc", "10.000", "1O.000", r"line 6: .*expected a number"),
        ("fanuc", "10.000", "********", r"line 6: .*was never taught"),
        (
            "fanuc",
            "X =    10.000  mm,\tY =    20.000  mm,\tZ",
            "RX =   10.000  mm,\tRY =   20.000  mm,\tRZ",
            r"line 6: .*remote tool",
        ),
        ("fanuc", "\tX =    10.000", "\tJ1=    10.000", r"line 6: .*joint angles"),
        ("inform", "///USER 3", "///USER 4", "line 12: .*user frame 4, .*give the user frame as 4=X,Y,Z,Rx,Ry,Rz"),
        ("inform", "POSTYPE ROBOT\n///RECTAN", "POSTYPE PULSE\n///PULSE", "line 9: .*is stored as pulses"),
        ("inform", "POSTYPE ROBOT", "POSTYPE MTOOL", "line 9: .*POSTYPE MTOOL"),
        ("inform", "3,0,0,0,0,0\n///TOOL 1\n///POSTYPE ROBOT", "3,3,0,0,0,0\n///POSTYPE BASE", "a base axis moves"),
        ("inform", "1.000,2.000,3.000,180.0000,0.0000", "1.000,2.000,3.000,180.0000", "line 9: .*expected six numbers"),
        ("inform", "//POS", "//NOPOS", "has no section //POS"),
        ("as", "v3 1 2 3 0 180 0 0 180", "v3 1 2 3 0 180", "line 19: v3: expected six numbers"),
        ("as", "fix 100.0", "fox 100.0", "the user frame as fix=X,Y,Z,O,A,T"),
        ("as", TAUGHT["as"], "class A {}\n", r"has no \.PROGRAM"),
        ("as", "  LMOVE v3\n", "  LMOVE v3\n  LMOVE v1\n", "is used in the bases fix, null"),
        ("as", "  BASE fix\n  TOOL torch\n  LMOVE v1\n", "  LMOVE v1\n  BASE fix\n", "does not say the base"),
        ("pdl2", "PROGRAM teach", "teach", "has no line PROGRAM"),
        ("pdl2", "POS(1, 2, 3, 0, 90, 0, 'S')", "POS(1, 2, 3)", r"line 7: corner: expected six numbers"),
        ("pdl2", "POS(1, 2", "POS(1, x", r"line 7: corner: Y: "),
        ("pdl2", "  corner", "  $UFRAME := corner\n  corner", r"sets \$UFRAME to corner, fixture"),
    ],
)
def test_what_cannot_be_used_is_refused_by_its_line(tmp_path, language, old, new, message):
    text, uframes = TAUGHT[language], {"3": "base"} if language in ("krl", "fanuc", "inform") else {}
    assert old in text
    count = 1 if language in ("fanuc", "inform") else -1
    with pytest.raises(FormatError, match=message) as refused:
        taught(
            tmp_path,
            language,
            text.replace(old, new, count),
            uframes=uframes,
            points=("v1", "v3") if language == "as" else None,
        )
    assert refused.value.path.endswith(FILES[language])


@pytest.mark.parametrize(
    ("language", "file", "atol_mm"),
    [
        ("rapid", 0, 1e-5),
        ("krl", 1, 1e-5),
        ("fanuc", 1, 0.9e-3),
        ("inform", 1, 0.9e-3),
        ("as", 0, 1e-5),
        ("pdl2", 0, 1e-5),
    ],
)
def test_our_own_program_is_read_as_taught_points(tmp_path, make_program, language, file, atol_mm):
    """In the frame that it carries, or that its remarks ask the operator to set."""
    program = make_program(3)
    texts = list(controller_named(language).write(program).values())
    frame = [float(v) for v in re.findall(r"[!'] ?(?:[XYZWPR]|R[xyz]) (-?\d+\.\d+)\b", texts[0])]
    uframes = {"fanuc": {"1": frame}, "inform": {"1": frame}, "krl": {"": "WP_PART"}}.get(language, {})
    points = taught(tmp_path, language, texts[file].replace("\r\n", "\n"), uframes=uframes)
    np.testing.assert_allclose(points.p_base, program.paths[0].p_base, rtol=0, atol=atol_mm)


def test_the_object_frame_is_relative_to_the_user_frame(tmp_path):
    """A quarter turn about x in the object, then one about z in the user frame: [10,20,30] goes to [110,10,70]."""
    turned = TAUGHT["rapid"].replace("[[0,0,50],[1,0,0,0]]", "[[0,20,50],[0.707106781,0.707106781,0,0]]")
    np.testing.assert_allclose(taught(tmp_path, "rapid", turned).p_base[0], [110, 10, 70], rtol=0, atol=1e-6)


def test_without_moves_the_file_does_not_say_the_frame(tmp_path):
    data = "\n".join(TAUGHT["rapid"].splitlines()[:6]) + "\nENDMODULE"
    with pytest.raises(FormatError, match=r"point P1: .*give it as X,Y,Z,Q1,Q2,Q3,Q4 or as base, .*fixture") as refused:
        taught(tmp_path, "rapid", data)
    assert refused.value.code == ErrorCode.USER_FRAME_MISSING
    np.testing.assert_array_equal(taught(tmp_path, "rapid", data, uframes={"": "base"}).p_base[0], [10, 20, 30])
    turned = taught(tmp_path, "rapid", data, uframes={"": "fixture"}).p_base[0]
    np.testing.assert_allclose(turned, [80, 10, 80], rtol=0, atol=1e-6)


def test_a_work_object_that_is_not_in_the_file_is_asked_for(tmp_path):
    text = TAUGHT["rapid"].replace("PERS wobjdata", "! PERS wobjdata")
    with pytest.raises(FormatError, match="user frame fixture, whose values the file does not contain"):
        taught(tmp_path, "rapid", text)
    given_one = taught(tmp_path, "rapid", text, uframes={"fixture": [100, 0, 50, 0.5**0.5, 0, 0, 0.5**0.5]})
    np.testing.assert_allclose(given_one.p_base[0], [80, 10, 80], rtol=0, atol=1e-6)
    with pytest.raises(InputError, match="expected 7 numbers, got 6"):
        taught(tmp_path, "rapid", text, uframes={"fixture": [100, 0, 50, 0, 0, 90]})


def test_points_taught_with_tool0_need_the_tool(tmp_path):
    text = TAUGHT["rapid"].replace("tTorch;", "tool0;")
    with pytest.raises(FormatError, match="line 6: point P2: was recorded without a tool") as refused:
        taught(tmp_path, "rapid", text)
    assert refused.value.code == ErrorCode.TOOL_MISSING
    np.testing.assert_array_equal(taught(tmp_path, "rapid", text, tool=[0, 0, 100]).p_base[1], [1, 2, 103])
    assert taught(tmp_path, "rapid", text, points=["P1"]).names == ("P1",)


def test_what_is_not_asked_for_does_no_harm(tmp_path):
    """A local variable of a name that appears twice, a target that was never taught, and an array of work objects."""
    unset = "VAR robtarget r:=[[0,0,0],[0,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    stands = 'PERS wobjdata stand{2}:=[[FALSE,TRUE,"",[[1,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]],'
    stands += '[FALSE,TRUE,"",[[2,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]]];'
    text = TAUGHT["rapid"].replace("ENDMODULE", f"{unset}\n{unset}\n{stands}\nENDMODULE")
    expected = taught(tmp_path, "rapid", TAUGHT["rapid"])
    np.testing.assert_array_equal(taught(tmp_path, "rapid", text, points=["P1", "P2"]).p_base, expected.p_base)
    with pytest.raises(FormatError, match="the point 'r' appears twice"):
        taught(tmp_path, "rapid", text)


def test_a_base_whose_values_are_not_there_is_asked_for(tmp_path):
    with pytest.raises(
        FormatError, match=r"line 5: point P1: is in user frame 3.*give the user frame as 3=X,Y,Z,A,B,C"
    ):
        taught(tmp_path, "krl", TAUGHT["krl"])
    carried = TAUGHT["krl"].replace("ENDDAT", "BASE_DATA[3]={X 100,Y 0,Z 0,A 90,B 0,C 0}\nENDDAT")
    np.testing.assert_allclose(taught(tmp_path, "krl", carried).p_base[0], [80, 10, -30.5], rtol=0, atol=1e-9)


def test_a_file_without_points_and_an_unknown_kind_are_refused(tmp_path):
    with pytest.raises(FormatError, match="holds no stored positions"):
        taught(tmp_path, "krl", "DEFDAT X\nENDDAT\n")
    known = re.escape(".as, .dat, .dg, .jbi, .ls, .mod, .pdl, .prg, .sys, .va")
    with pytest.raises(InputError, match=rf"unknown kind of program '\.src'; known: {known}"):
        read_taught_program(tmp_path / "x.src")
    with pytest.raises(InputError, match="no such file"):
        read_taught_program(tmp_path / "x.dat")


def test_a_comment_that_appears_twice_names_no_point(tmp_path):
    text = TAUGHT["fanuc"].replace("P[2] {", 'P[2:"corner"]{')
    assert taught(tmp_path, "fanuc", text, uframes={"3": "base"}).names == ("P1", "P2")


@pytest.mark.parametrize(
    ("name", "message"),
    [("v5", "line 21: .*is added to another transformation"), ("home1", "line 24: .*stored as joint angles")],
)
def test_a_point_that_is_no_place_is_named(tmp_path, name, message):
    with pytest.raises(FormatError, match=message):
        taught(tmp_path, "as", TAUGHT["as"], points=(name,))


def test_values_without_a_program_are_in_the_robots_base(tmp_path):
    text = ".TRANS\np1 1 2 3 0 180 0\n.END\n.PROGRAM a()\n  POINT p2 = TRANS(4, 5.5, 6, 0, 180, 0)\n.END\n"
    points = taught(tmp_path, "as", text)
    np.testing.assert_allclose(points.p_base, [[1, 2, 3], [4, 5.5, 6]], rtol=0, atol=1e-9)


def test_without_a_frame_points_are_in_the_base(tmp_path):
    points = taught(tmp_path, "pdl2", TAUGHT["pdl2"].replace("  $UFRAME := fixture\n", ""))
    np.testing.assert_allclose(points.p_base, [[100, 0, 0], [1, 2, 3], [10, 20.5, -0.5]], rtol=0, atol=1e-9)
