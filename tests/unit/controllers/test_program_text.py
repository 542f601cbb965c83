"""Programs of every language, read by parsers that know nothing of the writer (`tests.program_text`)."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.program_text import READERS
from wpcal.controllers.registry import controller_named

DIGITS = {
    "rapid": (1e-5, 2e-7),  # five decimals in three coordinates; nine of two quaternions turn by at most 2e-9 rad each
    "krl": (1e-5, 1e-6),  # six decimals: √3/2 units
    "fanuc": (0.9e-3, 0.9e-3),
    "inform": (0.9e-3, 0.9e-4),
    "urscript": (1e-6, 1e-7),  # nine decimals of a metre and of a rad
    "val3": (1e-5, 1e-6),
    "as": (0.9e-5, 0.9e-6),
    "pdl2": (1e-5, 1e-6),
}
"""Largest rounding, mm and deg. That of the frame does not count: points are relative to it."""


@pytest.mark.parametrize("name", READERS)
@settings(max_examples=25)  # each has the poses of two seams
@given(seed=st.integers(0, 2**32))
@example(seed=1181448)  # scaling the frame's rounded quaternion to one once moved its last digit
def test_what_is_written_is_read_back_relative_to_the_part(
    make_program, assert_same_poses, assert_is_the_part, name, seed
):
    program = make_program(seed, names=("W1", "Rib 7/ä"))
    found, (mm, deg) = READERS[name](controller_named(name).write(program)), DIGITS[name]
    assert_same_poses(*found.in_base(), program, atol_mm=mm, atol_deg=deg)
    assert_is_the_part(*found.frame, program, atol_mm=mm, atol_deg=deg)


@pytest.mark.parametrize("name", READERS)
def test_moves_come_in_order_with_the_arc_along_the_seam(make_program, name):
    found = READERS[name](controller_named(name).write(make_program(n=5)))
    assert found.order() == [0, 1, "ARC ON", 2, 3, "ARC OFF", 4]
    assert [event.kind for event in found.routines[0] if event.names] == ["J", "L", "L", "L", "L"]
    if name in ("rapid", "krl", "as", "pdl2"):
        assert [*found.poses] == ["W1_appr", "W1_0001", "W1_0002", "W1_0003", "W1_retr"]
