"""Joints with a constant gap above the usual one are found where they are without a gap; nothing else changes."""

import numpy as np
import pytest
from build123d import Box, Plane, Polyline, Pos, extrude, make_face, mirror

from cad.kernel.primitives import box, cut, cylinder, prism
from cad.kernel.to_brep import to_brep
from tests.few import few
from tests.samples.graphs import UP, graph_of
from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.find.facing import find_facing
from wpcal.seam.find.root_gaps import _at_gap
from wpcal.seam.limits import usual_gap_mm

GAPS_MM = [0.3, 0.9, 1.8]
EXACT_MM = 1e-9


def tee(gap: float) -> BrepGraph:
    return graph_of(box(200, 100, 8, (0, 0, 0)), box(160, 8, 80, (20, 46, 8 + gap)))


def pipe_on_plate(gap: float) -> BrepGraph:
    pipe = cut(cylinder(44.45, 200, (0, 0, 8 + gap), UP), cylinder(40.45, 200, (0, 0, 8 + gap), UP))
    return graph_of(box(200, 200, 8, (-100, -100, 0)), pipe)


def butt(gap: float) -> BrepGraph:
    return graph_of(box(200, 100, 8, (0, 0, 0)), box(200, 100, 8, (0, 100 + gap, 0)))


PARTS = {"tee": tee, "butt": butt, "pipe-on-plate": pipe_on_plate}


def accepted(graph: BrepGraph, options: SeamOptions | None = None) -> list[Seam]:
    return [seam for seam in detect_seams(graph, options) if seam.accepted]


def without_gap(name: str) -> list[Seam]:
    return accepted(PARTS[name](0.0))


@pytest.mark.parametrize("gap", few(GAPS_MM, 2))
@pytest.mark.parametrize("name", few(PARTS, 2))
def test_a_constant_gap_changes_neither_the_seams_nor_their_places(name: str, gap: float) -> None:
    without, found = without_gap(name), accepted(PARTS[name](gap))
    assert len(found) == len(without) > 0
    for seam in found:
        assert seam.gap_mm == pytest.approx((gap, gap, gap), rel=0, abs=1e-6)
        assert any(f"a gap of {gap:.2f} mm on average" in finding for finding in seam.against)
        off = [np.linalg.norm(one.frames.p.mean(axis=0) - seam.frames.p.mean(axis=0)) for one in without]
        same = without[int(np.argmin(off))]
        assert min(off) <= gap + EXACT_MM
        assert (seam.joint, seam.weld, seam.closed) == (same.joint, same.weld, same.closed)
        assert seam.length_mm == pytest.approx(same.length_mm, rel=0, abs=EXACT_MM)


@pytest.mark.parametrize("name", list(PARTS))
def test_a_gap_that_is_too_wide_is_none(name: str) -> None:
    assert detect_seams(PARTS[name](3.1 if name == "butt" else 2.1)) == ()  # a butt joint may have a root gap


def test_the_gap_that_a_person_gives_is_the_widest_one() -> None:
    assert detect_seams(tee(0.9), SeamOptions(gap_mm=0.5)) == ()
    assert len(accepted(tee(0.9), SeamOptions(gap_mm=1.0))) == 2


def test_on_a_small_part_a_wide_gap_is_small() -> None:
    def small(gap: float) -> BrepGraph:
        return graph_of(box(70, 40, 3, (0, 0, 0)), box(60, 3, 30, (5, 18, 3 + gap)))

    assert usual_gap_mm(small(0.0).size_mm) < 0.22
    assert len(detect_seams(small(0.7))) == 4
    assert detect_seams(small(0.9)) == ()


def test_a_gap_that_opens_is_not_a_joint_beyond_the_usual_gap() -> None:
    outline = [(20.0, 46.0, 8.6), (180.0, 46.0, 9.0), (180.0, 46.0, 80.0), (20.0, 46.0, 80.0)]
    assert detect_seams(graph_of(box(200, 100, 8, (0, 0, 0)), prism(outline, (0.0, 8.0, 0.0)))) == ()


def test_what_a_shim_keeps_apart_is_not_joined() -> None:
    plates = [box(200, 100, 8, (0, 0, 0)), box(160, 60, 8, (20, 20, 8.8))]
    pairs = {seam.solids for seam in detect_seams(graph_of(*plates, box(158, 58, 0.8, (21, 21, 8))))}
    assert ("S0", "S1") not in pairs
    assert {seam.solids for seam in accepted(graph_of(*plates))} == {("S0", "S1")}


@pytest.mark.parametrize("half", [False, True], ids=["V", "half V"])
@pytest.mark.parametrize(("gap", "welds"), [(1.0, 2), (3.0, 2), (3.6, 0)])  # at the root, and in the groove
def test_the_root_of_a_prepared_groove_may_be_as_wide_apart_as_its_faces(gap: float, welds: int, half: bool) -> None:
    outline = Polyline((0, 0), (0, 2), (5.8, 12), (100, 12), (100, 0), (0, 0))
    plate = Pos(gap / 2, 0, 0) * extrude(make_face(outline), 200)
    other = Pos(-50 - gap / 2, 6, 100) * Box(100, 12, 200) if half else mirror(plate, Plane.YZ)
    plates = [(name, shape.solid().wrapped) for name, shape in (("a", plate), ("b", other))]
    assert len([seam for seam in detect_seams(to_brep(plates)) if seam.accepted]) == welds


def test_ends_out_of_reach_of_each_other_are_no_joint() -> None:
    graph = butt(1.8)
    trimmed = TrimmedFaces.of(graph)
    assert len(_at_gap(graph, trimmed, find_facing(graph, trimmed, most_mm=3.0), 0.1).pieces) == 0


@pytest.mark.parametrize("play", few([0.7, 0.3], 1))
def test_a_bar_with_play_in_a_hole_is_not_welded(play: float) -> None:
    plate = cut(box(200, 200, 20, (-100, -100, 0)), cylinder(30 + play, 20, (0, 0, 0), UP))
    seams = detect_seams(graph_of(plate, cylinder(30, 200, (0, 0, -90), UP)))
    assert len(seams) == 2
    assert all("round member in a hole" in str(seam.against) for seam in seams)
    assert not any(seam.accepted for seam in seams if seam.gap_mm[1] > 0.5)


@pytest.mark.parametrize("name", few(["tee-under-bar", "frame"], 1))
def test_what_is_found_with_the_usual_gap_stays_as_it_is(name: str) -> None:
    graph = saved_graph(name)
    found = detect_seams(graph)
    for seam in detect_seams(graph, SeamOptions(gap_mm=usual_gap_mm(graph.size_mm))):
        assert any(_is_same(seam, other) for other in found), seam.name


def test_a_wide_gap_beside_a_usual_one_leaves_that_as_it_is() -> None:
    solids = [box(200, 100, 8, (0, 0, 0)), box(160, 8, 80, (20, 46, 8.0)), box(30, 30, 6, (60, 54.8, 8.0))]
    graph = graph_of(*solids)
    found, usual = detect_seams(graph), detect_seams(graph, SeamOptions(gap_mm=0.5))
    assert all(any(_is_same(seam, other) for other in found) for seam in usual)
    new = [seam for seam in found if not any(_is_same(seam, other) for other in usual)]
    assert {seam.solids for seam in new} == {("S1", "S2")}
    assert all(seam.gap_mm == pytest.approx((0.8, 0.8, 0.8), rel=0, abs=1e-9) for seam in new)


def _is_same(one: Seam, other: Seam) -> bool:
    return (
        one.frames.p.shape == other.frames.p.shape
        and one.accepted == other.accepted
        and np.allclose(one.frames.p, other.frames.p, rtol=0, atol=EXACT_MM)
        and np.allclose(one.frames.R, other.frames.R, rtol=0, atol=EXACT_MM)
    )
