"""Points of programs in special files: stored as joint angles or pulses, numbers that are none, registers by hand."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.running import run_here
from wpcal.controllers.registry import controller_named
from wpcal.controllers.taught_program import PointsAsked, read_taught_program
from wpcal.controllers.user_frames import ProgramReading, parse_uframes
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.robot_space import RobotSpace
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.taught.table import taught_csv

SAME_MM = 1e-9  #: The same products of rotations in another order.
TOOL = [20.0, 0.0, 350.0]
ANGLES = "10,20,-30,40,50,60"
PULSES_PER_DEG = 1000.0
FILES = {
    "t.mod": f"MODULE t\nCONST jointtarget V1:=[[{ANGLES}],[9E9,9E9,9E9,9E9,9E9,9E9]];\nENDMODULE\n",
    "t.dat": "DEFDAT T\nDECL E6AXIS V1={A1 10,A2 20,A3 -30,A4 40,A5 50,A6 60,E1 0}\nENDDAT\n",
    "t.ls": '/PROG T\n/POS\nP[1:"V1"]{\n   GP1:\n\tUF : 1, UT : 1,\n'
    "\tJ1=  10.000 deg,\tJ2=  20.000 deg,\tJ3= -30.000 deg,\n"
    "\tJ4=  40.000 deg,\tJ5=  50.000 deg,\tJ6=  60.000 deg\n};\n/END\n",
    "t.jbi": "/JOB\n//NAME T\n//POS\n///NPOS 1,0,0,0,0,0\n///TOOL 1\n///POSTYPE PULSE\n///PULSE\n"
    "C00000=10000,20000,-30000,40000,50000,60000\n//INST\n",
}


@pytest.fixture
def arm():
    found = find_arm("mh6")
    return replace(found, joints=tuple(replace(joint, pulses_per_deg=PULSES_PER_DEG) for joint in found.joints))


def read(folder, name, text=None, **options):
    path = folder / name
    path.write_text(text or FILES[name])
    return read_taught_program(path, ProgramReading(**options))


@pytest.mark.parametrize("name", FILES)
def test_the_tip_is_where_the_arm_puts_it(tmp_path, arm, name):
    T = arm.forward(np.radians([[10, 20, -30, 40, 50, 60]]))[0]
    points = read(tmp_path, name, arm=arm, tool=TOOL)
    np.testing.assert_allclose(points.p_base, [T[:3, :3] @ TOOL + T[:3, 3]], rtol=0, atol=SAME_MM)
    assert points.space is RobotSpace.NOMINAL


@pytest.mark.parametrize("name", FILES)
def test_without_an_arm_the_message_asks_for_it(tmp_path, name):
    with pytest.raises(FormatError, match=r"or give the arm and the tool") as refused:
        read(tmp_path, name)
    assert refused.value.code == ErrorCode.ARM_MISSING


def test_what_does_not_fit_the_arm_is_refused(tmp_path, arm):
    with pytest.raises(FormatError, match="give the tool"):
        read(tmp_path, "t.mod", arm=arm)
    with pytest.raises(FormatError, match="beyond the limits of YASKAWA MOTOMAN MH6"):
        read(tmp_path, "t.mod", FILES["t.mod"].replace("[10,", "[300,"), arm=arm, tool=TOOL)
    with pytest.raises(FormatError, match="has 6 joints"):
        read(tmp_path, "t.mod", FILES["t.mod"].replace(",60]", "]"), arm=arm, tool=TOOL)
    with pytest.raises(FormatError, match="pulses per degree are not stated"):
        read(tmp_path, "t.jbi", arm=find_arm("mh6"), tool=TOOL)


def test_an_identified_arm_takes_no_coordinates_and_marks_its_points(tmp_path, arm):
    identified = arm.as_identified(arm.chain)
    points = read(tmp_path, "t.dat", arm=identified, tool=TOOL)
    assert points.space is RobotSpace.IDENTIFIED
    assert taught_csv(points).splitlines()[0].endswith("feature,rx_deg,ry_deg,rz_deg,robot_space")
    assert taught_csv(points).splitlines()[1].endswith(",identified")
    text = "DEFDAT T\nDECL E6POS V1={X 1,Y 2,Z 3,A 0,B 0,C 0}\nENDDAT\n"
    with pytest.raises(FormatError, match="computed with its nominal model"):
        read(tmp_path, "t.dat", text, arm=identified, tool=TOOL, uframes={"": "base"})


RAPID = "MODULE T\nCONST robtarget V1:=[[{x},2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nENDMODULE\n"
FANUC = (
    '/PROG T\n/POS\nP[1:"V1"]{{\nGP1:\n UF : 0, UT : 1,\n X = {x} mm, Y = 2 mm, Z = 3 mm,\n'
    " W = 0 deg, P = 0 deg, R = 0 deg\n}};\n"
)
KRL = "DEFDAT T\nDECL E6POS XV1={{X {x},Y 2,Z 3,A 0,B 0,C 0}}\nENDDAT\n"
INFORM = "/JOB\n//POS\n///POSTYPE ROBOT\n///RECTAN\nC00001={x},2,3,0,0,0\n//INST\n"
AS = ".TRANS\nv1 {x} 2 3 0 0 0\n.END\n"
LANGUAGES = {"rapid": (RAPID, 2), "fanuc": (FANUC, 3), "krl": (KRL, 2), "inform": (INFORM, 5), "as": (AS, 2)}
READ = {name: controller_named(name).load_reader().read for name in LANGUAGES}
NO_NUMBERS = ["nan", "inf", "-Infinity", "1e400", "2e9", "81_2", "１２", "true", "1.2.3", "0x10"]


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("text", NO_NUMBERS)
def test_what_is_no_number_is_refused_with_its_line(language: str, text: str) -> None:
    program, line = LANGUAGES[language]
    with pytest.raises(FormatError, match=rf"T, line {line}: .*(expected|number)"):
        READ[language](program.format(x=text), "T")


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_number_is_read(language: str) -> None:
    assert READ[language](LANGUAGES[language][0].format(x="-8.125"), "T").points[0].p_mm[0] == -8.125


def test_a_cut_module_is_refused_and_a_missing_semicolon_loses_no_point() -> None:
    joined = RAPID.replace(";\nENDMODULE", "\nVAR robtarget V2:=[[1,2,3],[1,0,0,0]];")
    assert len(READ["rapid"](joined.format(x="1"), "T").points) == 2
    with pytest.raises(FormatError, match="line 2: V1: expected"):
        READ["rapid"](RAPID[:60].format(x="1"), "T")


@pytest.mark.parametrize("value", ["1.5", "#TCP", "9" * 400, "nan"])
def test_a_base_of_krl_is_a_whole_number(value: str) -> None:
    text = KRL.format(x="1").replace("ENDDAT", f"DECL FDAT FV1={{TOOL_NO 1,BASE_NO {value},IPO_FRAME #BASE}}\nENDDAT")
    with pytest.raises(FormatError, match="V1: BASE_NO: expected a whole number"):
        READ["krl"](text, "T")


@pytest.mark.parametrize("text", ["1,2,nan,0,0,0", "2=1e400,0,0,0,0,0", "81_2,0,0,0,0,0"])
def test_a_user_frame_is_made_of_numbers(text: str) -> None:
    with pytest.raises(InputError, match=r"user frame .*expected a"):
        parse_uframes([text])


POSREG = """\
[*POSREG*]$POSREG  Storage: CMOS  Access: RW  : ARRAY[1,100] OF Position Reg
    [1,1] =   'corner'
  Group: 1   Config: N U T, 0, 0, 0
  X:   812.290   Y:  -240.620   Z:   -.800
  W:   180.000   P:      .000   R:    30.000
    [1,2] =   '' Uninitialized
    [1,3] =   ''
  Group: 1
  J1 =     1.000 deg   J2 =     2.000 deg   J3 =     3.000 deg
[*SYSTEM*]
"""
CURPOS = """\
Group #: 1
Frame #: 2   Tool #: 1
Joint  1:   1.00
CURRENT WORLD POSITION:
Frame #: 0
X:   812.290
Y:  -240.620
Z:   165.800
W:   180.000
P:     0.000
R:    30.000
"""
VAR = """\
//VAR
///B
0,0,1
///P
0.000,0.000,0.000,0.0000,0.0000,0.0000
///POSTYPE USER
///USER 3
1.500,2.000,3.000,0,0,90
"""
CONFIG = """\
DEFDAT $CONFIG
BASE_DATA[1]={X 10.0,Y 20.0,Z 30.0,A 0.0,B 0.0,C 0.0}
BASE_DATA[2]={X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}
ENDDAT
"""


@pytest.mark.parametrize(
    ("name", "text", "frames", "point", "place"),
    [
        ("posreg.va", POSREG, {"": "base"}, "corner", (812.29, -240.62, -0.8)),
        ("curpos.dg", CURPOS, {}, "curpos", (812.29, -240.62, 165.8)),
        ("VAR.DAT", VAR, {"3": [100.0, 0.0, 0.0, 0.0, 0.0, 0.0]}, "P001", (101.5, 2.0, 3.0)),
        ("$config.dat", CONFIG, {}, "BASE_DATA[1]", (10.0, 20.0, 30.0)),
        (
            "any.mod",
            "MODULE M\n  TASK PERS robtarget p1:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nENDMODULE\n",
            {"": "base"},
            "p1",
            (1.0, 2.0, 3.0),
        ),
    ],
)
def test_a_register_is_a_taught_point(
    tmp_path: Path, name: str, text: str, frames: dict[str, object], point: str, place: tuple[float, ...], golden: Any
) -> None:
    path = tmp_path / name
    path.write_text(text)
    taught = read_taught_program(path, ProgramReading(uframes=frames, points=[point]))  # type: ignore[arg-type]
    assert (taught.names, taught.p_base[0].tolist()) == ((point,), pytest.approx(place))
    golden(taught)


def test_a_register_without_a_frame_asks_for_it(tmp_path: Path) -> None:
    path = tmp_path / "posreg.va"
    path.write_text(POSREG)
    with pytest.raises(InputError, match="user frame"):
        PointsAsked(points="corner").read_taught(path)
    done = run_here("taught", path, "--uframe", "base")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "PR3" in done.stderr
