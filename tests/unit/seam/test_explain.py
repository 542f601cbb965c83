"""What `wpcal seams --explain` says of a seam: the numbers lead to its confidence, and the picture holds the seam."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from tests.saved_graphs import saved_graph, saved_seams
from wpcal.brep.extend import add_edges, line
from wpcal.brep.trim import TrimmedFaces
from wpcal.pages.draw.seam import SEAM, explained_svg
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.explain import explain_seam
from wpcal.seam.find.marked import MarkedEdges
from wpcal.seam.limits import Level
from wpcal.seam.member.note import take_members
from wpcal.seam.options import Judging
from wpcal.seam.rules import Rule

ROUNDED = 2e-3  #: Factors and confidences are written with three digits.


@pytest.fixture(scope="module")
def seams() -> tuple[Seam, ...]:
    return saved_seams("gusset-with-holes")


def test_the_factors_lead_from_the_start_to_the_score_and_this_to_the_confidence(seams: tuple[Seam, ...]) -> None:
    graph = saved_graph("gusset-with-holes")
    notes = take_members(graph, TrimmedFaces.of(graph), Judging()).notes
    for seam in seams:
        record = explain_seam(graph, seam, notes)
        factors = [one["factor"] for one in record["findings"]]
        product = record["start_score"] * float(np.prod(factors))
        assert product == pytest.approx(record["score"], rel=0, abs=ROUNDED)
        after = [record["start_confidence"], *(one["confidence_after"] for one in record["findings"])]
        assert after == sorted(after, reverse=True)
        assert after[-1] == pytest.approx(record["confidence"], rel=0, abs=ROUNDED)
        assert record["accepted"] == seam.accepted
        assert {one["solid"] for one in record["members"]} == set(seam.solids)
        assert all(one["why"] and one["found_by"] for one in record["findings"])


def test_a_bolted_seam_says_so_and_a_welded_one_says_what_it_joins(seams: tuple[Seam, ...]) -> None:
    graph = saved_graph("gusset-with-holes")
    notes = take_members(graph, TrimmedFaces.of(graph), Judging()).notes
    bolted = max((seam for seam in seams if "strap" in seam.solids), key=lambda seam: seam.confidence)
    assert explain_seam(graph, bolted, notes)["findings"][0]["rule"] == Rule.LINED_UP.key
    welded = next(seam for seam in seams if seam.accepted)
    chain = explain_seam(graph, welded, notes)["chain"]
    assert "fillet weld between plane of gusset and plane of plate, which open by 90 degrees" in chain[1]
    assert chain[-1] == "confidence 95%: at least the 80% that are asked (usual)"


def test_the_verdict_names_the_level_that_was_asked() -> None:
    graph = saved_graph("gusset-with-holes")
    judging = Judging(level=Level.GENEROUS)
    seams = detect_seams(graph, SeamOptions(judging=judging))
    notes = take_members(graph, TrimmedFaces.of(graph), judging).notes
    bolted = next(seam for seam in seams if "strap" in seam.solids and seam.accepted)
    assert "5% that are asked (generous)" in explain_seam(graph, bolted, notes)["chain"][-1]


def test_the_picture_holds_the_seam_inside_its_frame(seams: tuple[Seam, ...]) -> None:
    graph = saved_graph("gusset-with-holes")
    seam = next(seam for seam in seams if seam.accepted)
    trimmed = TrimmedFaces.of(graph)
    notes = take_members(graph, trimmed, Judging()).notes
    section = explain_seam(graph, seam, notes)["section"]
    root = ET.fromstring(explained_svg(graph, trimmed, seam, "a < b", USUAL_TORCH, section))
    lines = [line for line in root.iter("{http://www.w3.org/2000/svg}polyline") if line.get("stroke") == SEAM]
    assert len(lines) == 1
    points = np.array([pair.split(",") for pair in (lines[0].get("points") or "").split()], dtype=float)
    assert len(points) == len(seam.frames)
    assert (points >= 0).all()
    assert (points <= [900, 640]).all()


def test_a_wire_without_a_face_says_so() -> None:
    wires = [
        line(np.array([0.0, 0, 50]), np.array([30.0, 0, 50])),
        line(np.array([80.0, 0, 0]), np.array([80.0, 0, 9])),
    ]
    wider, edges = add_edges(saved_graph("plain-block"), wires)
    seams = detect_seams(wider, marked=MarkedEdges(edges, ("a", "b")))
    assert [seam.solids for seam in seams] == [(), ()]
    assert all("no face beside it: z is up in part coordinates" in seam.reasons for seam in seams)
    for seam, z in zip(seams, ([0, 0, 1], [1, 0, 0]), strict=True):
        np.testing.assert_allclose(
            seam.frames.R[:, :, 2], np.broadcast_to(z, (len(seam.frames), 3)), rtol=0, atol=1e-12
        )
