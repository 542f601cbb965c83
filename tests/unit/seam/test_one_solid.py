"""Seams inside one solid: weldments have them; bends, rolled profiles, machined and turned parts do not."""

import numpy as np
import pytest

from tests.saved_graphs import saved_graph, saved_seams
from wpcal.brep import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate.observe.members import find_members
from wpcal.seam import ConcaveEdges, Seam, SeamOptions
from wpcal.seam.find.built_up import LEAST_BUILT_UP, built_up_share
from wpcal.seam.find.concave import find_concave_edges
from wpcal.seam.find.formed import are_bends
from wpcal.seam.member.members import members_of
from wpcal.seam.member.one_piece import find_whole_solids, left_out
from wpcal.seam.member.prisms import find_prisms


def trimmed(name: str) -> tuple[BrepGraph, TrimmedFaces]:
    graph = saved_graph(name)
    return graph, TrimmedFaces.of(graph)


def accepted(name: str, **options: ConcaveEdges) -> list[Seam]:
    return [seam for seam in saved_seams(name, SeamOptions(**options)) if seam.accepted]


@pytest.mark.parametrize("name", ["joint-tee-in-one", "lap-in-one", "post-base", "hollow-corner", "bead-pipe", "angle"])
def test_what_is_built_of_plates_bars_and_tubes_is_known_by_its_surface(name: str) -> None:
    assert built_up_share(*trimmed(name), 0) >= LEAST_BUILT_UP


@pytest.mark.parametrize("name", ["pockets", "comb", "bent-block"])
def test_what_was_milled_from_a_block_has_another_surface(name: str) -> None:
    assert built_up_share(*trimmed(name), 0) < LEAST_BUILT_UP
    assert accepted(name) == []


def test_a_box_is_a_prism_along_each_of_its_sides() -> None:
    found = [(prism.length_mm, *prism.sides_mm) for prism in find_prisms(*trimmed("sharp-box"), 0)]
    np.testing.assert_allclose(found, [(80, 40, 60), (60, 40, 80), (40, 60, 80)], rtol=0, atol=1e-9)


def test_a_part_without_a_seam_says_why_and_what_to_do() -> None:
    (told,) = left_out(*trimmed("pockets"), find_whole_solids(*trimmed("pockets")))
    assert told.code == "one-piece"
    assert "inner corners, none taken for a weld" in told.message
    assert "--concave always" in told.message
    (told,) = left_out(*trimmed("plain-block"), [])
    assert told.message.endswith("is one solid without an inner corner")
    assert len(accepted("pockets", concave=ConcaveEdges.ALWAYS)) > 4
    assert np.bincount(find_members(trimmed("pockets")[1])[1]).tolist() == [26, 2]  # the walls of pockets, and a boss


@pytest.mark.parametrize("name", ["angle", "channel", "zed", "i-section"])
def test_the_roots_of_a_rolled_profile_are_no_welds(name: str) -> None:
    seams = saved_seams(name)
    assert seams
    assert not any(seam.accepted for seam in seams)
    assert all(any("as if rolled" in why for why in seam.against) for seam in seams)


@pytest.mark.parametrize("name", ["joint-tee-in-one", "lap-in-one", "thick-tee-in-one", "hollow-corner"])
def test_a_tee_a_lap_and_a_corner_of_tubes_are_not_rolled(name: str) -> None:
    graph, faces = trimmed(name)
    corners = find_concave_edges(graph).pieces
    inside = set().union(*(one.roots for one in members_of(graph, faces, 0).members))
    assert not set(zip(*np.sort([corners.wall, corners.base], axis=0).tolist(), strict=True)) <= inside


def test_a_rod_under_a_bent_sheet_is_welded_and_the_bends_are_not() -> None:
    (seam,) = accepted("post-base")
    assert seam.closed
    assert seam.length_mm == pytest.approx(20.0 * np.pi, abs=1e-6)
    refused = [seam for seam in saved_seams("post-base") if not seam.accepted]
    assert [any("bent sheet" in why for why in seam.against) for seam in refused] == [True, True]


def test_the_inner_corner_of_two_tubes_is_no_bend() -> None:
    seam, outside = sorted(accepted("hollow-corner"), key=lambda own: own.source.name)  # concave, and the mitre
    assert [seam.length_mm, outside.length_mm] == pytest.approx([40.0, 40.0], abs=1e-6)
    graph, faces = trimmed("hollow-corner")
    assert not are_bends(graph, faces, seam.pieces.edge).any()
