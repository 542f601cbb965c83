"""Seams that a person cut, joined or turned: computed and judged anew, never taken over."""

import numpy as np
import pytest

from tests.saved_graphs import saved_graph, saved_seams
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import InputError
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.edit import PlacedEdit, apply_edits
from wpcal.seam.path.corners import CORNER_MM, CORNER_STEP_RAD
from wpcal.seam.path.turning import rotation_angles
from wpcal.seam.seam_edit import Candidate, JoinedStretch, SeamEdit

ROUND_OFF_MM = 1e-9


def candidate(name: str, part: str = "tee") -> Candidate:
    (own,) = (seam.candidate for seam in saved_seams(part) if seam.name == name)
    assert own is not None
    return own


def joined(name: str, range_mm: tuple[float, float] | None = None) -> JoinedStretch:
    return JoinedStretch(candidate(name), range_mm)


def after(*edits: tuple[str, SeamEdit], part: str = "tee") -> dict[str, Seam]:
    graph = saved_graph(part)
    placed = [PlacedEdit(candidate(name, part), edit, "edits.json") for name, edit in edits]
    return {
        seam.name: seam for seam in apply_edits(graph, TrimmedFaces.of(graph), saved_seams(part), placed, SeamOptions())
    }


def ends(seam: Seam) -> tuple[list[float], list[float]]:
    first, last = np.round(seam.frames.p[[0, -1]], 9).tolist()
    return first, last


def test_cut_pieces_joined_again_are_the_seam() -> None:
    whole = saved_seams("tee")[1]
    seams = after(("W2", SeamEdit(range_mm=(0.0, 60.0), join=(joined("W2", (60.0, 150.0)),))))
    assert seams["W2"].length_mm == pytest.approx(whole.length_mm, rel=0, abs=ROUND_OFF_MM)
    assert ends(seams["W2"]) == ends(whole)


def test_seams_are_joined_in_any_order_and_keep_the_direction_of_the_first() -> None:
    for order in (("W1", "W3", "W4"), ("W4", "W3", "W1")):
        seams = after(("W2", SeamEdit(join=tuple(joined(name) for name in order))))
        assert list(seams) == ["W2"]
        loop = seams["W2"]
        assert (loop.closed, round(loop.length_mm, 9), loop.accepted) == (True, 316.0, True)
        assert (np.diff(loop.frames.s_mm) > 0).all()
        along = loop.frames.R[np.isclose(loop.frames.p[:, 1], 56.0), 0, 0]
        assert np.median(along) == pytest.approx(1.0)  # W2 runs along x
    backwards = after(("W2", SeamEdit(reverse=True, join=(joined("W1"),))))["W2"]
    assert ends(backwards) == ([175.0, 56.0, 10.0], [25.0, 64.0, 10.0])


def test_at_a_corner_the_torch_turns_by_small_steps() -> None:
    """With one step of 10 mm the wire would cut the corner of the web, and no program would be written."""
    for edit in (SeamEdit(join=(joined("W1"),)), SeamEdit(reverse=True, join=(joined("W1"),))):
        frames = after(("W2", edit))["W2"].frames
        turns = rotation_angles(frames.R[:-1], frames.R[1:])
        steps = np.flatnonzero(turns > 1e-9)
        assert turns.max() <= CORNER_STEP_RAD + 1e-9
        assert turns.sum() == pytest.approx(np.pi / 2)
        assert np.diff(frames.s_mm)[steps].sum() == pytest.approx(CORNER_MM + 8.0 / 2)  # half of the short side


def test_an_end_that_is_joined_is_no_short_end_any_more() -> None:
    seam = after(("W1", SeamEdit(join=(joined("W2"),))))["W1"]
    assert (seam.accepted, seam.wrap_of, seam.against) == (True, None, ())


def test_an_end_of_a_seam_is_joined_and_the_rest_is_a_seam_of_its_own() -> None:
    rest = SeamEdit(name="rest", range_mm=(50.0, 150.0))
    seams = after(("W1", SeamEdit(join=(joined("W2", (0.0, 50.0)),))), ("W2", rest))
    assert {name: round(seam.length_mm, 9) for name, seam in seams.items()} == {
        "W1": 58.0,
        "rest": 100.0,
        "W3": 150.0,
        "W4": 8.0,
    }


def test_what_cannot_be_joined_is_said() -> None:
    for said, *edits in (
        ("W3 does not meet W2: their nearest ends are 8.0 mm apart", ("W2", SeamEdit(join=(joined("W3"),)))),
        ("range_mm ends at 9, but the seam at 8.000 mm", ("W2", SeamEdit(join=(joined("W1", (0.0, 9.0)),)))),
        ("W1 is joined to W2 and cannot", ("W2", SeamEdit(join=(joined("W1"),))), ("W1", SeamEdit(accept=False))),
        ("is joined to W2 and to W3", *((name, SeamEdit(join=(joined("W1"),))) for name in ("W2", "W3"))),
    ):
        with pytest.raises(InputError) as caught:
            after(*edits)
        assert said in str(caught.value)
        assert str(caught.value).startswith("edits.json: ")


def test_the_other_side_is_turned_about_the_direction_of_travel_and_stays_refused_inside_material() -> None:
    plain = saved_seams("tee")[1].frames
    turned = after(("W2", SeamEdit(other_side=True, accept=True)))["W2"]
    np.testing.assert_allclose(turned.frames.R, plain.R * [1.0, -1.0, -1.0], rtol=0, atol=1e-12)
    assert not turned.accepted
    assert turned.inside
    assert any("no torch welds inside material" in text for text in turned.reasons)


def test_reach_is_felt_on_the_stretch_and_not_taken_from_the_whole() -> None:
    """A refused seam of the frame stays refused in parts, and what a person accepts says so."""
    name, length_mm = next((seam.name, seam.length_mm) for seam in saved_seams("frame") if not seam.reachable)
    kept = after((name, SeamEdit(range_mm=(0.0, length_mm / 2))), part="frame")[name]
    assert (kept.accepted, kept.reachable) == (False, False)
    assert kept.blocked_by
    assert kept.against[0].startswith("the torch does not get there")
    taken = after((name, SeamEdit(accept=True, range_mm=(0.0, length_mm / 2))), part="frame")[name]
    assert (taken.accepted, taken.reasons[-1]) == (True, "accepted by hand")
