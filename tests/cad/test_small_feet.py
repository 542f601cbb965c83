"""Round the foot of a small bar there is one weld, not one per side."""

from typing import Any

from build123d import Align, Box, Pos

from cad.kernel.to_brep import to_brep
from wpcal.seam import Seam, SeamOptions, detect_seams

LOW = (Align.CENTER, Align.CENTER, Align.MIN)


def accepted(bar: Any, **options: Any) -> list[Seam]:
    """Return the accepted seams of a bar on a plate."""
    plate = Box(120, 80, 8, align=(Align.CENTER, Align.CENTER, Align.MAX))
    graph = to_brep([(name, shape.solid().wrapped) for name, shape in (("plate", plate), ("bar", bar))])
    return [seam for seam in detect_seams(graph, SeamOptions(**options)) if seam.accepted]


def test_a_weld_round_a_small_foot_is_one_closed_seam_with_and_without_wrap() -> None:
    foot = Box(10, 5, 60, align=LOW)
    for wrap in (False, True):
        (seam,) = accepted(foot, wrap=wrap)
        assert (seam.closed, round(seam.length_mm, 6)) == (True, 30.0)


def test_the_sides_that_a_torch_reaches_are_one_run() -> None:
    """Under a low arch the inner side of each foot stays open."""
    arch = Pos(0, 0, 10) * Box(50, 10, 5, align=LOW)
    arch += Pos(-22.5, 0, 0) * Box(5, 10, 10, align=LOW) + Pos(22.5, 0, 0) * Box(5, 10, 10, align=LOW)
    seams = accepted(arch)
    assert [(seam.closed, round(seam.length_mm, 6)) for seam in seams] == [(False, 20.0), (False, 20.0)]


def test_a_long_side_is_a_seam_of_its_own() -> None:
    assert sorted(round(seam.length_mm, 6) for seam in accepted(Box(30, 10, 60, align=LOW))) == [30.0, 30.0]
