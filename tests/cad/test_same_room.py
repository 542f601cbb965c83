"""Two bodies in the same room: one of them counts, and it is said which one does not."""

from typing import Any

import pytest
from build123d import Align, Box, Pos, chamfer

from cad.kernel.to_brep import to_brep
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam import detect_seams
from wpcal.seam.find.covered import covered_by, covered_issues

LOW = (Align.CENTER, Align.CENTER, Align.MIN)
PLATE = Pos(0, 0, -10) * Box(200, 120, 10, align=LOW)
POST = Box(60, 40, 100, align=LOW)


def found(**shapes: Any) -> tuple[list[tuple[tuple[str, ...], float]], list[str]]:
    """Return the solids and lengths of the accepted seams, and what is said about the solids."""
    graph = to_brep([(name, shape.solid().wrapped) for name, shape in shapes.items()])
    seams = [(seam.solids, round(seam.length_mm, 6)) for seam in detect_seams(graph) if seam.accepted]
    return sorted(seams), [issue.message for issue in covered_issues(graph, TrimmedFaces.of(graph))]


def test_a_body_that_is_twice_in_the_file_gives_its_seams_once() -> None:
    alone, said = found(plate=PLATE, post=POST)
    assert (len(alone), said) == (4, [])
    twice, said = found(plate=PLATE, Pad001=POST, post=POST)
    assert twice == alone  # the name that a person gave stays
    assert said == ["1 solid fills room that another solid fills, so one of the two gives no seams: Pad001 in post"]


def test_earlier_states_of_a_body_and_what_a_union_was_made_of_do_not_count() -> None:
    alone, _ = found(plate=PLATE, post=POST)
    state = chamfer(Box(60, 40, 100, align=LOW).edges().group_by()[-1], 3)
    seams, said = found(plate=PLATE, post=POST, Chamfer=state, kernel=Pos(0, 0, 30) * Box(20, 20, 40, align=LOW))
    assert seams == alone
    assert said[0].startswith("2 solids fill room")
    union, _ = found(union=PLATE + POST)
    assert found(plate=PLATE, post=POST, union=PLATE + POST)[0] == union


@pytest.mark.parametrize("height", [0.0, 90.0])
def test_members_that_touch_or_run_a_little_into_each_other_count(height: float) -> None:
    pin = Pos(0, 0, height) * Box(20, 20, 100.0 - 80.0 * (height > 0), align=LOW)  # in the bore, or 90 % out of it
    sleeve = POST - Pos(0, 0, -1) * Box(20, 20, 102, align=LOW)
    graph = to_brep([("sleeve", sleeve.solid().wrapped), ("pin", pin.solid().wrapped)])
    assert (covered_by(graph, TrimmedFaces.of(graph)) < 0).all()
