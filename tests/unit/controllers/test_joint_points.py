"""Points stored as joint angles or pulses: forward kinematics with the arm that is given, in all four languages."""

from dataclasses import replace

import numpy as np
import pytest

from wpcal.controllers.taught_program import read_taught_program
from wpcal.controllers.user_frames import ProgramReading
from wpcal.core.errors import ErrorCode, FormatError
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
