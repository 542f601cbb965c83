"""What is taken for a weld and what is not, on parts whose answer anybody can tell; no solid has a telling name."""

import math
from typing import Any

import pytest

from tests.saved_graphs import saved_seams
from wpcal.core.errors import InputError
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.limits import Level
from wpcal.seam.options import Judging


def seams_of(name: str, **options: Any) -> tuple[Seam, ...]:
    return saved_seams(name, SeamOptions(**options))


def accepted(seams: tuple[Seam, ...]) -> set[tuple[str, ...]]:
    return {tuple(sorted(seam.solids)) for seam in seams if seam.accepted}


GENEROUS = Judging(level=Level.GENEROUS)


def test_bolted_plates_are_not_welded_by_default_and_their_bolts_never() -> None:
    seams = seams_of("bolted-plates")
    assert accepted(seams) == set()
    whys = {why for seam in seams for why in seam.against}
    assert {"S2 is a bolt or screw", "S3 is a nut or washer", "2 bolts hold the two members together here"} <= whys
    generous = seams_of("bolted-plates", judging=GENEROUS)
    assert accepted(generous) == {("S0", "S1")}
    assert sum(seam.length_mm for seam in generous if seam.accepted) == pytest.approx(440.0, rel=0, abs=0.01)


def test_a_bar_through_plates_is_a_rod_only_with_nuts() -> None:
    assert ("S0", "S2") in accepted(seams_of("bar-through-plates"))
    assert accepted(seams_of("bar-with-nut")) == set()
    assert accepted(seams_of("bar-with-nut", judging=GENEROUS)) == {("S0", "S1")}


def test_a_collar_on_a_tube_is_a_weld() -> None:
    seams = seams_of("collar-on-tube")
    assert [seam.accepted for seam in seams] == [True, True]
    assert [seam.against for seam in seams] == [(), ()]  # a tube is no pin


def test_corners_of_a_window_are_no_welds_and_those_of_a_fused_tee_are() -> None:
    seams = seams_of("window")
    assert [(seam.accepted, round(seam.length_mm, 6)) for seam in seams] == [(False, 10.0)] * 4
    assert all(any("a corner inside one plate" in why for why in seam.against) for seam in seams)
    assert [seam.accepted for seam in seams_of("thick-tee-in-one")] == [False, True, True, False]  # ends


def test_the_inside_of_a_closed_box_is_out_of_reach() -> None:
    """Six sheets of 6 mm, 180 mm wide inside: that is enough room for a wire, but not for a torch."""
    a = 180.0
    seams = seams_of("closed-box")
    inside = [bool(((seam.frames.p > -1e-6) & (seam.frames.p < a + 1e-6)).all()) for seam in seams]
    assert sum(inside) >= 8
    assert not any(seam.reachable for seam, is_in in zip(seams, inside, strict=True) if is_in)
    assert sum(seam.accepted for seam in seams) >= 12  # the edges of the box, from outside


def test_a_seam_is_found_once_where_an_edge_lies_near_two_faces() -> None:
    """One half of a wall is on a plate, the other 0.2 mm above its lower half: along each side there is one run."""
    seams = seams_of("wall-on-step")
    assert [round(seam.length_mm, 6) for seam in seams if seam.length_mm > 50] == [120.0, 120.0]
    assert max(seam.gap_mm[2] for seam in seams) == pytest.approx(0.2, rel=0, abs=1e-9)


def test_the_least_length_of_a_seam_is_an_option() -> None:
    """The T-joint has two seams of 150 mm and two of 8 mm."""

    def accepted_lengths(least_mm: float) -> list[float]:
        return sorted(round(seam.length_mm, 6) for seam in seams_of("tee", min_length_mm=least_mm) if seam.accepted)

    assert accepted_lengths(5.0) == [150.0, 150.0]  # the two of 8 mm are the ends of the web
    assert accepted_lengths(150.0) == [150.0, 150.0]
    assert accepted_lengths(151.0) == []
    (short, *_) = [seam for seam in seams_of("tee", min_length_mm=8.5) if not seam.accepted]
    assert "8.0 mm is shorter than the least length of a seam, 8.5 mm" in short.against


def test_a_larger_least_length_keeps_long_seams_of_short_edges() -> None:
    """The rim of the disc is 80 arcs of 2 mm."""
    (rim,) = seams_of("disc-of-arcs", min_length_mm=100.0)
    assert rim.accepted
    assert rim.length_mm == pytest.approx(2 * math.pi * 25, rel=0, abs=1e-6)


@pytest.mark.parametrize("least_mm", [-1.0, math.nan, math.inf])
def test_a_least_length_without_meaning_is_refused(least_mm: float) -> None:
    with pytest.raises(InputError, match="min_length_mm must be 0 or more"):
        SeamOptions(min_length_mm=least_mm)
