"""PDL2: what the language asks for, and taught points; `test_program_text` reads its programs back."""

import numpy as np
import pytest

from wpcal.controllers.comau.write import write_pdl2
from wpcal.controllers.program.arc import ArcSettings
from wpcal.controllers.taught_program import read_taught_program
from wpcal.core.errors import FormatError
from wpcal.taught.user_frames import ProgramReading

TAUGHT = """PROGRAM teach HOLD
VAR
  fixture, corner, edge : POSITION
BEGIN
  fixture := POS(100, 0, 0, 90, 0, 0, '')
  $UFRAME := fixture
  corner := POS(1, 2, 3, 0, 90, 0, 'S')
  Edge := pos (10, 20.5, -0.5, 0, 0, 0, '')
END teach
"""


def taught(tmp_path, text, **options):
    path = tmp_path / "teach.pdl"
    path.write_bytes(text.encode("latin-1"))
    return read_taught_program(path, ProgramReading(**options))


def test_taught_points_are_in_the_frame_that_the_program_sets(tmp_path):
    points = taught(tmp_path, TAUGHT)
    assert points.names == ("corner", "Edge")
    assert points.lines == (7, 8)
    np.testing.assert_allclose(points.p_base, [[98, 1, 3], [79.5, 10, -0.5]], rtol=0, atol=1e-9)


def test_without_a_frame_points_are_in_the_base(tmp_path):
    points = taught(tmp_path, TAUGHT.replace("  $UFRAME := fixture\n", ""))
    np.testing.assert_allclose(points.p_base, [[100, 0, 0], [1, 2, 3], [10, 20.5, -0.5]], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("PROGRAM teach", "teach", "has no line PROGRAM"),
        ("POS(1, 2, 3, 0, 90, 0, 'S')", "POS(1, 2, 3)", r"line 7: corner: expected six numbers"),
        ("POS(1, 2", "POS(1, x", r"line 7: corner: Y: "),
        ("  corner", "  $UFRAME := corner\n  corner", r"sets \$UFRAME to corner, fixture"),
    ],
)
def test_bad_programs_are_refused_with_the_line(tmp_path, old, new, message):
    with pytest.raises(FormatError, match=message):
        taught(tmp_path, TAUGHT.replace(old, new))


def test_an_output_switches_the_arc_or_routines_of_the_user(make_program):
    (text,) = write_pdl2(make_program(n=5, arc=ArcSettings(output=4))).values()
    assert "$DOUT[4] switches the arc" in text
    assert text.index("  $DOUT[4] := TRUE") < text.index("TO W1_0002") < text.index("  $DOUT[4] := FALSE")
    assert "EXPORTED FROM" not in text
    (text,) = write_pdl2(make_program(n=5, arc=ArcSettings())).values()
    assert "ROUTINE arc_start(job : INTEGER) EXPORTED FROM wp_arc" in text


def test_our_own_program_is_read_as_taught_points(tmp_path, make_program):
    program = make_program()
    points = taught(tmp_path, *write_pdl2(program).values())
    np.testing.assert_allclose(points.p_base, program.paths[0].p_base, rtol=0, atol=1e-5)
