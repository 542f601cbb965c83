"""Registers that were taught by hand are read as taught points."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.running import run_here
from wpcal.controllers.taught_program import PointsAsked, read_taught_program
from wpcal.controllers.user_frames import ProgramReading
from wpcal.core.errors import InputError

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
    tmp_path: Path, name: str, text: str, frames: dict[str, object], point: str, place: tuple[float, ...]
) -> None:
    path = tmp_path / name
    path.write_text(text)
    taught = read_taught_program(path, ProgramReading(uframes=frames, points=[point]))  # type: ignore[arg-type]
    assert (taught.names, taught.p_base[0].tolist()) == ((point,), pytest.approx(place))


def test_a_register_without_a_frame_asks_for_it(tmp_path: Path) -> None:
    path = tmp_path / "posreg.va"
    path.write_text(POSREG)
    with pytest.raises(InputError, match="user frame"):
        PointsAsked(points="corner").read_taught(path)
    done = run_here("taught", path, "--uframe", "base")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "PR3" in done.stderr
