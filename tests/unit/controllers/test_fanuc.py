"""FANUC TP: what the language asks for, and taught points; `test_program_text` reads its programs back."""

import re

import numpy as np
import pytest

from wpcal.controllers.fanuc.write import write_fanuc
from wpcal.controllers.judge.asked import asked_of, compare
from wpcal.controllers.judge.execute import execute
from wpcal.controllers.program import ControllerSettings, MotionSettings
from wpcal.controllers.taught_program import read_taught_program
from wpcal.core.errors import FormatError, InputError
from wpcal.taught.user_frames import ProgramReading

ATOL_MM = 0.9e-3  #: Three decimals in three coordinates: √3/2 units.


def test_the_configuration_is_the_users(make_program):
    with pytest.raises(InputError, match=r'fanuc: every position needs .*--config fanuc="N U T, 0, 0, 0"'):
        write_fanuc(make_program(controller=ControllerSettings()))
    given_one = write_fanuc(make_program(controller=ControllerSettings(configurations={"": "N U T, 0, 0, -1"})))
    assert given_one["W1.ls"].count("CONFIG : 'N U T, 0, 0, -1'") == 16
    with pytest.raises(InputError, match="expected it as the pendant shows it"):
        write_fanuc(make_program(controller=ControllerSettings(configurations={"fanuc": "0,0,0"})))


def test_remarks_fit_the_pendant_and_cannot_end_an_instruction(make_program):
    files = write_fanuc(make_program(names=("a ; JMP LBL[1] ;", "wpcal")))
    for text in files.values():
        remarks = re.findall(r"!(.*) ;\r\n", text)
        assert max(map(len, remarks)) <= 32
        assert not any(";" in remark for remark in remarks)
    assert set(files) == {"WPCAL.ls", "A_JMP_LBL_1.ls", "WPCAL_2.ls"}


@pytest.mark.parametrize(("speed", "written"), [(8.0, "8mm/sec"), (7.5, "45cm/min"), (0.5, "3cm/min")])
def test_speeds_are_written_exactly(make_program, speed, written):
    files = write_fanuc(make_program(motion=MotionSettings(speed_mm_s=speed)))
    assert f"L P[3] {written} CNT100" in files["W1.ls"]


def test_the_program_sets_the_user_frame_to_the_part(make_program):
    program = make_program(controller=ControllerSettings(frame_number=4, configurations={"fanuc": "N U T, 0, 0, 0"}))
    remark = re.compile(r"(?m)^ *\d+: *!.*\n")
    files = {name: remark.sub("", text.replace("\r", "")) for name, text in write_fanuc(program).items()}
    main = next(iter(files.values()))
    assert main.index("UFRAME[4]=PR[51]") < main.index("UFRAME_NUM=4") < main.index("CALL ")
    found = compare(execute(files, tools=(program.controller.tool_number,)), asked_of(program))
    assert (found.missing, found.others) == ((), ())
    moved = {name: text.replace("PR[51,1]=", "PR[51,1]=1+") for name, text in files.items()}
    assert compare(execute(moved, tools=(program.controller.tool_number,)), asked_of(program)).others


def test_what_tp_cannot_hold_is_refused(make_program):
    with pytest.raises(InputError, match=r"nearest is 7\.333 mm/s"):
        write_fanuc(make_program(motion=MotionSettings(speed_mm_s=7.3)))
    with pytest.raises(InputError, match="at most 9999"):
        write_fanuc(make_program(n=10_000))


TAUGHT = """/PROG  TEACH
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
"""


def taught(tmp_path, text, **options):
    path = tmp_path / "TEACH.LS"
    path.write_bytes(text.encode("latin-1"))
    return read_taught_program(path, ProgramReading(**options))


def test_taught_points_are_read_with_their_frame(tmp_path):
    points = taught(tmp_path, TAUGHT, uframes={"3": [100, 0, 0, 0, 0, 90]})
    assert points.names == ("corner", "P2")
    assert points.lines == (6, 15)
    np.testing.assert_allclose(points.p_base, [[80, 10, -0.5], [1, 2, 3]], rtol=0, atol=1e-9)


def test_a_comment_that_appears_twice_names_no_point(tmp_path):
    text = TAUGHT.replace("P[2] {", 'P[2:"corner"]{')
    assert taught(tmp_path, text, uframes={"3": "base"}).names == ("P1", "P2")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("UF : 3", "UF : 4", "is in user frame 4, .*give the user frame as 4=X,Y,Z,W,P,R"),
        ("UF : 3", "UF : F", "does not say its user frame"),
        ("UT : 2,\t\tC", "UT : 0,\t\tC", "recorded without a tool"),
        ("X =    10.000  mm,\t", "", "lacks X"),
        ("10.000", "1O.000", "expected a number"),
        ("10.000", "********", "was never taught"),
        ("X =    10.000  mm,\tY =    20.000  mm,\tZ", "RX =   10.000  mm,\tRY =   20.000  mm,\tRZ", "remote tool"),
        ("\tX =    10.000", "\tJ1=    10.000", "joint angles"),
    ],
)
def test_bad_positions_are_refused_with_the_line(tmp_path, old, new, message):
    with pytest.raises(FormatError, match=rf"TEACH\.LS, line 6: .*{message}"):
        taught(tmp_path, TAUGHT.replace(old, new, 1), uframes={"3": "base"})


def test_our_own_program_is_read_as_taught_points(tmp_path, make_program):
    program = make_program(3)
    files = write_fanuc(program)
    frame = re.findall(r"! ?([XYZWPR]) (\S+) ;", files["WPCAL.ls"])
    points = taught(tmp_path, files["W1.ls"], uframes={"1": [float(v) for _, v in frame]})
    np.testing.assert_allclose(points.p_base, program.paths[0].p_base, rtol=0, atol=ATOL_MM)
