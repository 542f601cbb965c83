"""Clearances are one fact per assembly: they are estimated from its joints, said, and are no doubt about a weld."""

from collections.abc import Sequence

import numpy as np
import pytest

from cad.kernel.primitives import box, cut, cylinder, prism
from tests.samples.graphs import UP, graph_of
from wpcal.brep import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.find.play import measure_play
from wpcal.seam.rules import Rule

SLOTS_MM = (60.0, 135.0, 210.0)  # where the tabs of the web begin


def tabs(play: float) -> BrepGraph:
    """Return a web on a sheet of 5 mm with three tabs of 30 mm through slots, flush below."""
    sheet = box(300, 100, 5, (0, 0, -5))
    slots = [box(30 + 2 * play, 5 + 2 * play, 7, (x - play, 47.5 - play, -6)) for x in SLOTS_MM]
    below = [
        (x, 47.5, z) for start in SLOTS_MM for x, z in ((start, 0), (start, -5), (start + 30, -5), (start + 30, 0))
    ]
    outline = [(50.0, 47.5, 0.0), *below, (250.0, 47.5, 0.0), (250.0, 47.5, 60.0), (50.0, 47.5, 60.0)]
    return graph_of(cut(sheet, *slots), prism(outline, (0.0, 5.0, 0.0)))


def ribs(gap: float) -> BrepGraph:
    return graph_of(box(400, 200, 8, (0, 0, -8)), *(box(6, 160, 70, (30 + 60 * k, 20, gap)) for k in range(4)))


def tube_in_plate(radius: float, length: float, play: float) -> BrepGraph:
    side = 6.0 * radius
    plate = cut(box(side, side, 6, (-side / 2, -side / 2, -3)), cylinder(radius + play, 20, (0, 0, -10), UP))
    start = (0.0, 0.0, -length / 2)
    return graph_of(plate, cut(cylinder(radius, length, start, UP), cylinder(radius - 2, length, start, UP)))


def butt(gap: float, thickness: float) -> BrepGraph:
    return graph_of(box(150, 100, thickness, (0, 0, 0)), box(150, 100, thickness, (150 + gap, 0, 0)))


def accepted(seams: Sequence[Seam]) -> list[float]:
    return sorted(round(seam.length_mm, 1) for seam in seams if seam.accepted)


def play_of(graph: BrepGraph) -> list[tuple[float, int]]:
    return [(round(one.gap_mm, 6), one.joints) for one in measure_play(graph, TrimmedFaces.of(graph))]


def test_the_play_of_an_assembly_is_what_its_joints_have_in_common() -> None:
    assert play_of(tabs(0.2)) == [(0.2, 3)]
    assert play_of(ribs(0.8)) == [(0.8, 4)]
    assert play_of(tube_in_plate(20.0, 120.0, 0.5)) == []  # one joint says nothing about the others


@pytest.mark.parametrize("play", [0.1, 0.3])
def test_tabs_in_slots_are_welded_along_the_web_and_on_the_far_side(play: float) -> None:
    seams = detect_seams(tabs(play))
    around = 2 * (30.0 + 5.0 + 2 * play)  # two sides of the tab, two of the slot
    assert accepted(seams)[:3] == pytest.approx([around] * 3, rel=0, abs=8 * play)
    assert accepted(seams)[3:] == pytest.approx([200.0] * 2, rel=0, abs=20 * play)  # straight bridges beside the tabs
    welded = [seam for seam in seams if seam.accepted]
    far = [seam for seam in welded if seam.closed]
    assert len(far) == 3
    assert all((seam.frames.R[:, 2, 2] < -0.99).all() for seam in far)  # the torch comes from below
    assert all(abs(seam.frames.p[:, 2]).max() < 1e-6 for seam in welded if seam not in far)  # none is inside a slot
    assert not any(finding.rule == Rule.GAP.key for seam in welded for finding in seam.findings)


def test_a_gap_that_all_ribs_have_is_no_doubt_and_one_that_a_person_says_is() -> None:
    graph = ribs(0.8)
    welds = [seam for seam in detect_seams(graph) if seam.accepted]
    assert [round(seam.confidence, 2) for seam in welds] == [0.95] * 8
    said = [seam for seam in detect_seams(graph, SeamOptions(gap_mm=1.0)) if seam.accepted]
    assert [round(seam.confidence, 2) for seam in said] == [0.85] * 8


@pytest.mark.parametrize(("radius", "length", "play"), [(20.0, 120.0, 0.5), (10.0, 60.0, 0.5), (10.0, 60.0, 0.25)])
def test_a_tube_with_play_in_a_hole_is_welded_on_both_sides(radius: float, length: float, play: float) -> None:
    welds = [seam for seam in detect_seams(tube_in_plate(radius, length, play)) if seam.accepted]
    assert [seam.closed for seam in welds] == [True, True]
    np.testing.assert_allclose([seam.gap_mm for seam in welds], play, rtol=0, atol=1e-6)


@pytest.mark.parametrize(("gap", "thickness"), [(1.5, 5.0), (2.0, 8.0), (3.0, 10.0)])
def test_a_butt_joint_with_a_root_gap_is_found_on_both_sides(gap: float, thickness: float) -> None:
    seams = detect_seams(butt(gap, thickness))
    assert accepted(seams) == [100.0, 100.0]
    assert {(seam.joint.value, seam.weld.value) for seam in seams if seam.accepted} == {("butt", "groove")}
    assert {round(seam.gap_mm[1], 6) for seam in seams if seam.accepted} == {gap}


def test_what_is_only_near_is_no_butt_joint() -> None:
    stacked = graph_of(box(150, 100, 8, (0, 0, 0)), box(150, 100, 8, (0, 0, 10)))
    shim = graph_of(box(150, 100, 8, (0, 0, 0)), box(150, 100, 8, (152, 0, 0)), box(2, 100, 8, (150, 0, 0)))
    assert detect_seams(stacked) == ()
    assert not any(seam.solids == ("S0", "S1") for seam in detect_seams(shim))
    assert detect_seams(butt(3.0, 4.0)) == ()  # wider than half of the plate
