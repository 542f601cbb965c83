"""Tubes laid on each other are bolted if a hole goes through all their walls, with or without the bolt in the file."""

from typing import Any

import pytest
from build123d import Align, Box, Cylinder, Pos, Rot

from cad.kernel.to_brep import to_brep
from tests.few import few
from wpcal.seam import Seam, detect_seams
from wpcal.seam.rules import Rule

LOW = (Align.CENTER, Align.CENTER, Align.MIN)
SIDE_MM, WALL_MM, LONG_MM, HOLE_MM = 40.0, 2.5, 300.0, 8.0


def tube(*drilled: float) -> Any:
    """Return a square tube along x on z = 0, with a hole in the middle of its walls below given heights."""
    inside = SIDE_MM - 2 * WALL_MM
    body = Box(LONG_MM, SIDE_MM, SIDE_MM, align=LOW) - Pos(0, 0, WALL_MM) * Box(LONG_MM, inside, inside, align=LOW)
    for low in drilled:
        body -= Pos(0, 0, low) * Cylinder(HOLE_MM / 2, WALL_MM, align=LOW)
    return body


NEAR, FAR = SIDE_MM - WALL_MM, 0.0
CROSSED = Pos(0, 0, SIDE_MM) * Rot(0, 0, 90)


def seams_of(lower: Any, upper: Any) -> tuple[Seam, ...]:
    upper = CROSSED * upper
    return detect_seams(to_brep([("lower", lower.solid().wrapped), ("upper", upper.solid().wrapped)]))


def welded_mm(lower: Any, upper: Any) -> float:
    return sum(seam.length_mm for seam in seams_of(lower, upper) if seam.accepted)


@pytest.mark.parametrize(
    "lower", few([((NEAR, FAR),), ((NEAR,),), ((),)], 1), ids=["both walls", "near wall", "no hole"]
)
def test_crossed_tubes_are_welded_unless_a_hole_goes_on_through_a_far_wall(lower: tuple[float, ...]) -> None:
    upper = tube(0.0) if lower else tube()  # a hole in the wall that touches
    expected = 0.0 if FAR in lower else 4 * SIDE_MM
    assert welded_mm(tube(*lower), upper) == pytest.approx(expected, rel=0, abs=0.5)


def test_bolted_tubes_say_why() -> None:
    both = tube(NEAR, FAR)
    found = seams_of(both, both)
    assert not any(seam.accepted for seam in found)
    round_it = [seam for seam in found if seam.length_mm > HOLE_MM * 4 and len(seam.solids) == 2]
    assert len(round_it) == 4
    for seam in round_it:
        assert Rule.LINED_UP.key in {one.rule for one in seam.findings}
