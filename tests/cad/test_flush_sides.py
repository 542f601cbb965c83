"""Members that run a little into each other, and are flush at one side: that side is welded like the others."""

from types import SimpleNamespace
from typing import Any

import pytest
from build123d import Align, Box, Pos

from cad.kernel.to_brep import to_brep
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece
from wpcal.seam import JointType, Seam, SeamOptions, WeldType

CORNER = (Align.MIN, Align.MIN, Align.MIN)


def accepted(bar: Any) -> list[Seam]:
    """Return the accepted seams of a bar in the side of a thick bar along z, 40 mm wide from y = 0."""
    solids = [("post", Box(40, 40, 300, align=CORNER).solid().wrapped), ("bar", bar.solid().wrapped)]
    shapes = tuple(SimpleNamespace(wrapped=shape) for _, shape in solids)
    found, _ = find_seams(Workpiece(to_brep(solids), shapes=shapes), SeamOptions())
    return [seam for seam in found if seam.accepted]


@pytest.mark.parametrize("depth", [0.0, 1.5, 4.0])
def test_the_flush_side_is_one_groove_whether_the_bar_ends_at_the_post_or_inside(depth: float) -> None:
    seams = accepted(Pos(40 - depth, 0, 100) * Box(200, 30, 60, align=CORNER))
    (flush,) = (seam for seam in seams if seam.weld is WeldType.GROOVE)
    assert (flush.joint, round(flush.length_mm, 3)) == (JointType.BUTT, 60.0)
    assert abs(flush.frames.R[:, 1, 2] + 1.0).max() < 1e-9  # z is the normal of the two flush faces
    assert abs(flush.frames.p[:, 0] - 40.0).max() < 1e-3  # where the bar leaves the post
    assert sum(seam.length_mm for seam in seams) == pytest.approx(180.0, abs=0.01)


def test_a_bar_that_is_flush_nowhere_has_no_groove() -> None:
    seams = accepted(Pos(38.5, 5, 100) * Box(200, 30, 60, align=CORNER))
    assert [seam.weld for seam in seams if seam.weld is WeldType.GROOVE] == []
    assert sum(seam.length_mm for seam in seams) == pytest.approx(180.0, abs=0.01)
