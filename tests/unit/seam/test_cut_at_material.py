"""Seams that go through a third solid are cut there, on parts whose free stretches follow from their dimensions."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.few import few
from tests.saved_graphs import moved, saved_graph, saved_seams
from wpcal.brep.material import ExactMaterial
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.records import to_json
from wpcal.core.transform import RigidTransform
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam import Seam, SeamOptions, StepOptions, detect_seams
from wpcal.seam.edit import apply_edits, read_edits
from wpcal.seam.find.marked import MarkedEdges
from wpcal.seam.judge.material import TorchPart, find_poses_in_material
from wpcal.seam.judge.stations import Stretch, find_stretches
from wpcal.seam.judge.stretches import Cut, cut_at
from wpcal.seam.path.build import with_frames
from wpcal.seam.record import seams_record
from wpcal.seam.seam import SeamPieces, SeamSource

EXACT_MM = 1e-6  #: Planes and cylinders allow this; the cut itself is found to round-off.
WIRE_MM = 1e-3  #: Where the wire touches a solid beside the seam is found by bisection.
PARTS = ("crossed-tee", "tee-beside-bolt", "gusseted-bracket", "boss-with-ribs", "pipe-through-plates")


def seams_between(seams: tuple[Seam, ...], *solids: str) -> list[Seam]:
    return [seam for seam in seams if set(seam.solids) == set(solids)]


def along(seams: list[Seam], y: float) -> list[tuple[float, float, bool]]:
    """Return the seams along x at a y: x of both ends and whether accepted."""
    on = [seam for seam in seams if seam.frames.p[0, 1] == seam.frames.p[-1, 1] == y]
    return [(float(seam.frames.p[0, 0]), float(seam.frames.p[-1, 0]), seam.accepted) for seam in on]


def test_a_block_on_a_joint_leaves_the_two_stretches_beside_it() -> None:
    seams = seams_between(saved_seams("crossed-tee"), "base", "web")
    found = along(seams, 46.0)
    np.testing.assert_allclose([row[:2] for row in found], [(10, 80), (80, 120), (120, 190)], rtol=0, atol=EXACT_MM)
    assert [row[2] for row in found] == [True, False, True]
    (blocked,) = [seam for seam in seams if seam.inside == ("block",)]
    assert "inside block, from (80.0, 46.0, 10.0) to (120.0, 46.0, 10.0)" in blocked.against[0]
    assert along(seams, 54.0) == [(10.0, 190.0, True)]


def test_gussets_cut_the_joint_behind_them_also_where_they_lean() -> None:
    seams = seams_between(saved_seams("gusseted-bracket"), "base", "upright")
    found = along(seams, 92.0)
    # the wire, 20 mm long and at 45°, meets the gusset that leans over the joint farther along it
    over = 98 + USUAL_TORCH.wire_mm * math.sqrt(0.5)
    ends = [(0, 30), (30, 38), (38, 90), (90, over)]
    np.testing.assert_allclose([row[:2] for row in found[:4]], ends, rtol=0, atol=WIRE_MM)
    (beside, free) = found[4:]  # the nozzle is wider than the wire
    np.testing.assert_allclose([*beside[:2], free[1]], [over, free[0], 160], rtol=0, atol=WIRE_MM)
    assert (beside[2], free[2]) == (False, True)
    assert beside[1] - beside[0] < 2 * USUAL_TORCH.nozzle_radius_mm
    assert {seam.inside: seam.accepted for seam in seams if seam.inside} == {("gusset",): False, ("leaning",): False}


def test_ribs_cut_a_loop_whose_start_is_inside_one_of_them() -> None:
    seams = seams_between(saved_seams("boss-with-ribs"), "boss", "plate")
    assert not any(seam.closed for seam in seams)
    half = math.asin(3 / 30)
    lengths = sorted(seam.length_mm for seam in seams if not seam.inside)
    assert lengths == pytest.approx([15 * math.pi - 60 * half, 45 * math.pi - 60 * half], rel=0, abs=EXACT_MM)
    blocked = {seam.inside: seam.length_mm for seam in seams if seam.inside}
    assert blocked == pytest.approx({("west",): 60 * half, ("north",): 60 * half}, rel=0, abs=EXACT_MM)
    for seam in seams:  # an open seam starts at its end with the smaller (x, y, z)
        assert seam.frames.p[0].round(6).tolist() <= seam.frames.p[-1].round(6).tolist()


def test_a_bolt_in_the_way_of_the_wire_cuts_the_joint_beside_it() -> None:
    seams = seams_between(saved_seams("tee-beside-bolt"), "plate", "web")
    found = along(seams, 46.0)  # the wire passes the axis of the bolt 18.4 mm out of the joint
    np.testing.assert_allclose([row[:2] for row in found], [(20, 96), (96, 104), (104, 180)], rtol=0, atol=WIRE_MM)
    assert [row[2] for row in found] == [True, False, True]
    assert along(seams, 54.0) == [(20.0, 180.0, True)]


@pytest.mark.parametrize("name", few(PARTS, 2))
def test_stretches_add_up_to_the_contacts_that_they_were_cut_from(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    graph, cut = saved_graph(name), saved_seams(name)
    monkeypatch.setattr("wpcal.seam.detect.cut_at_material", lambda graph, trimmed, seams, options: seams)
    total: dict[tuple[str, ...], list[float]] = {}
    for sign, seams in ((1.0, cut), (-1.0, detect_seams(graph))):
        for seam in seams:
            total.setdefault(seam.solids, []).append(sign * seam.length_mm)
    assert {solids: abs(sum(lengths)) < EXACT_MM for solids, lengths in total.items()} == dict.fromkeys(total, True)


@pytest.mark.parametrize("name", PARTS)
def test_no_accepted_frame_is_in_material_with_tip_or_wire(name: str) -> None:
    graph = saved_graph(name)
    material = ExactMaterial(graph, TrimmedFaces.of(graph))
    for seam in saved_seams(name):
        inner = seam.frames.select(slice(1, -1))  # the ends may lie on the faces of the solid that ends them
        found = find_poses_in_material(material, inner.p, inner.R[:, :, 2])
        parts = {part for row, part in zip(found.row.tolist(), found.part, strict=True)}
        if seam.accepted:
            assert not parts & {TorchPart.TIP, TorchPart.WIRE}
        if seam.inside:
            assert len(found) == len(inner)
            assert parts <= {TorchPart.TIP, TorchPart.WIRE}


@pytest.mark.parametrize("name", few(PARTS, 2))
def test_turning_the_part_changes_no_stretch(name: str) -> None:
    T = RigidTransform.from_six_tuple([400.0, -30.0, 77.0, 0.3, -0.5, 1.2], target="moved", source="part")
    both = detect_seams(moved(saved_graph(name), T)), saved_seams(name)
    one, other = (sorted((s.solids, s.inside, round(s.length_mm, 2), s.accepted) for s in seams) for seams in both)
    assert one == other


@pytest.mark.deep
def test_coarse_points_change_no_cut() -> None:
    coarse = SeamOptions(steps=StepOptions(chord_mm=3.0, max_step_mm=500.0))
    found = [
        [(s.solids, s.inside, round(s.length_mm, 6)) for s in saved_seams(part, options)]
        for part in ("boss-with-ribs", "saddle")
        for options in (SeamOptions(), coarse)
    ]
    assert (found[0], found[2]) == (found[1], found[3])


def test_a_marked_edge_through_a_block_is_refused_there_with_solid_and_place() -> None:
    graph = saved_graph("crossed-tee")
    (whole,) = [s for s in saved_seams("crossed-tee") if s.inside == ("block",) and set(s.solids) == {"base", "web"}]
    marked = MarkedEdges(whole.pieces.edge[:1], ("picked",))
    found = detect_seams(graph, marked=marked)
    seams = [seam for seam in seams_between(found, "base", "web") if seam.source is SeamSource.MARKED]
    assert [(round(s.length_mm, 6), s.accepted) for s in seams] == [(70.0, True), (40.0, False), (70.0, True)]
    assert "inside block, from (80.0, 46.0, 10.0)" in seams[1].against[0]


def test_a_stretch_in_material_stays_refused_when_it_is_accepted_by_hand(tmp_path: Path, golden: Any) -> None:
    graph, seams = saved_graph("crossed-tee"), saved_seams("crossed-tee")
    record = json.loads(to_json(seams_record(seams)))
    for seam in record["seams"]:
        if seam["inside"]:
            seam["edit"] = {"accept": True, "range_mm": [5, 20]}
    path = tmp_path / "seams.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    after = apply_edits(graph, TrimmedFaces.of(graph), seams, read_edits(path), SeamOptions())
    blocked = [seam for seam in after if seam.inside]
    assert [seam.accepted for seam in blocked] == [False] * 3
    assert all("stays refused" in seam.reasons[-1] for seam in blocked)
    golden(after)


def test_a_refusal_for_lack_of_reach_names_the_torch_and_what_would_change_it() -> None:
    record = seams_record(saved_seams("closed-box"))
    sizes = {"wire_mm": 20.0, "nozzle_radius_mm": 11.0, "length_mm": 300.0, "taper_mm": 0.0, "most_wire_mm": 25.0}
    assert record["torch"] == {"name": "straight", **sizes}
    against = [why for seam in record["seams"] for why in seam["against"]]
    refused = [why for why in against if why.startswith("the torch does not get there")]
    torch, change = (
        "a straight torch of 300 mm, nozzle radius 11 mm, wire 20 mm",
        "state it with --torch, or accept the",
    )
    assert {torch in why and change in why for why in refused} == {True}


def test_a_free_stretch_too_short_for_a_weld_belongs_to_the_block_beside_it() -> None:
    graph, seams = saved_graph("crossed-tee"), saved_seams("crossed-tee")
    (block,) = [seam for seam in seams_between(seams, "base", "web") if seam.inside]
    t0, t1, way = block.pieces.t0, block.pieces.t1, np.sign(block.pieces.t1 - block.pieces.t0)
    longer = replace(block, pieces=replace(block.pieces, t0=t0 - 0.6 * way, t1=t1 + 20.0 * way))
    (found,) = find_stretches(graph, TrimmedFaces.of(graph), with_frames(graph, [longer], SeamOptions()))
    lengths = [(round(stretch.high_mm - stretch.low_mm, 6), bool(stretch.solids)) for stretch in found]
    assert lengths == [(40.6, True), (20.0, False)]


def test_a_stretch_on_a_bridge_has_no_edge_and_is_left_out() -> None:
    graph, trimmed = saved_graph("tee"), TrimmedFaces.of(saved_graph("tee"))
    seam = next(seam for seam in saved_seams("tee") if seam.accepted)
    one = seam.pieces.select(np.array([0]))
    way = np.sign(one.t1 - one.t0)
    before, after = replace(one, t1=one.t0 + 3.0 * way), replace(one, t0=one.t0 + 5.0 * way)
    (bridged,) = with_frames(graph, [replace(seam, pieces=SeamPieces.joined([before, after]))], SeamOptions())
    whole, free = bridged.length_mm, frozenset[int]()
    assert whole == pytest.approx(float(abs(one.t1 - one.t0)[0]), rel=0, abs=EXACT_MM)
    stretches = [Stretch(0.0, 3.0, free), Stretch(3.0, 5.0, frozenset({1})), Stretch(5.0, whole, free)]
    (parts,) = cut_at(graph, trimmed, [Cut(bridged, stretches, "cut")], SeamOptions())
    np.testing.assert_allclose([part.length_mm for part, _ in parts], [3.0, whole - 5.0], rtol=0, atol=EXACT_MM)
    assert [stretch.solids for _, stretch in parts] == [free, free]
