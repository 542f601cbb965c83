"""INFORM: what the language asks for, and taught points; `test_program_text` reads its programs back."""

import re

import numpy as np
import pytest

from wpcal.controllers.program import ControllerSettings, MotionSettings
from wpcal.controllers.taught_program import read_taught_program
from wpcal.controllers.yaskawa.write import write_inform
from wpcal.core.errors import FormatError, InputError
from wpcal.taught.user_frames import ProgramReading

ATOL_MM = 0.9e-3  #: Three decimals in three coordinates: √3/2 units.


def test_the_configuration_is_the_users(make_program):
    with pytest.raises(InputError, match=r'inform: every position needs .*--config inform="1,0,0,0,0,0,0,0"'):
        write_inform(make_program(controller=ControllerSettings()))
    given_one = write_inform(make_program(controller=ControllerSettings(configurations={"": "0,1,0,0,0,0,0,0"})))
    assert "///RCONF 0,1,0,0,0,0,0,0\r\n" in given_one["W1.jbi"]


def test_cartesian_positions_make_a_relative_job(make_program):
    lines = write_inform(make_program(controller=ControllerSettings(frame_number=5, configurations={"": "1,0"})))[
        "W1.jbi"
    ].splitlines()
    assert lines[lines.index("///ATTR SC,RW,RJ") + 1] == "////FRAME USER 5"
    with pytest.raises(InputError, match="as RCONF of a job has them"):
        write_inform(make_program(controller=ControllerSettings(configurations={"inform": "N U T"})))


def test_a_job_holds_at_most_9999_lines(make_program):
    with pytest.raises(InputError, match="at most 9999"):
        write_inform(make_program(n=10_000))


def test_a_speed_finer_than_the_format_is_refused(make_program):
    with pytest.raises(InputError, match=r"multiple of 0\.1 mm/s"):
        write_inform(make_program(motion=MotionSettings(speed_mm_s=7.25)))


def test_comments_fit_the_pendant(make_program):
    files = write_inform(make_program(names=("y" * 60,)))
    assert all(len(line) <= 33 for text in files.values() for line in text.split("\r\n") if line.startswith("'"))


TAUGHT = """/JOB
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
"""


def taught(tmp_path, text, **options):
    path = tmp_path / "teach.jbi"
    path.write_bytes(text.encode("latin-1"))
    return read_taught_program(path, ProgramReading(**options))


def test_taught_points_are_read_with_their_frame(tmp_path):
    points = taught(tmp_path, TAUGHT, uframes={"3": [100, 0, 0, 0, 0, 90]})
    assert points.names == ("C00000", "C00001", "C00002")
    assert points.lines == (9, 12, 13)
    np.testing.assert_allclose(points.p_base, [[1, 2, 3], [80, 10, -0.5], [100, 0, 0]], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("///USER 3", "///USER 4", "line 12: .*user frame 4, .*give the user frame as 4=X,Y,Z,Rx,Ry,Rz"),
        ("POSTYPE ROBOT\n///RECTAN", "POSTYPE PULSE\n///PULSE", "line 9: .*is stored as pulses"),
        ("POSTYPE ROBOT", "POSTYPE MTOOL", "line 9: .*POSTYPE MTOOL"),
        ("NPOS 3,0,0,0,0,0\n///TOOL 1\n///POSTYPE ROBOT", "NPOS 3,3,0,0,0,0\n///POSTYPE BASE", "a base axis moves"),
        ("1.000,2.000,3.000,180.0000,0.0000", "1.000,2.000,3.000,180.0000", "line 9: .*expected six numbers"),
        ("//POS", "//NOPOS", "has no section //POS"),
    ],
)
def test_bad_jobs_are_refused(tmp_path, old, new, message):
    with pytest.raises(FormatError, match=message):
        taught(tmp_path, TAUGHT.replace(old, new, 1), uframes={"3": "base"})


def test_our_own_job_is_read_as_taught_points(tmp_path, make_program):
    program = make_program(3)
    files = write_inform(program)
    frame = re.findall(r"' ([XYZ]|R[xyz]) (\S+)", files["WPCAL.jbi"])
    points = taught(tmp_path, files["W1.jbi"], uframes={"1": [float(v) for _, v in frame]})
    np.testing.assert_allclose(points.p_base, program.paths[0].p_base, rtol=0, atol=ATOL_MM)
