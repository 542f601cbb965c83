"""A fused body is taken apart into members: roots of rolled profiles are inside one, what stands on them is welded."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from build123d import (
    Align,
    Axis,
    Box,
    Circle,
    Cylinder,
    Plane,
    PolarLocations,
    Polyline,
    Pos,
    RegularPolygon,
    Sphere,
    Spline,
    extrude,
    fillet,
    make_face,
    sweep,
)

from cad.kernel.to_brep import to_brep
from tests.few import few
from tests.samples.graphs import nothing_crosses
from wpcal.brep import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.judge.way_out import find_closed_in
from wpcal.seam.member.member import Decomposition, Member, MemberKind
from wpcal.seam.member.members import members_of
from wpcal.seam.member.one_piece import why_one_piece
from wpcal.seam.seam import SeamSource
from wpcal.seam.search import find_part_candidates

ALONG = (Align.CENTER, Align.CENTER, Align.MIN)
LOW = (Align.MIN, Align.MIN, Align.MIN)


def i_beam(height: float, width: float, web: float, flange: float, *, length: float, root: float) -> Any:
    """Return an I section along z with rounds of a radius in its roots; sharp if it is 0."""
    beam = Box(width, height, length, align=ALONG)
    side = Pos((web + width) / 4, 0, 0) * Box((width - web) / 2, height - 2 * flange, length, align=ALONG)
    beam = beam - side - side.mirror(Plane.YZ)
    if root:
        inner = [e for e in beam.edges().filter_by(Axis.Z) if abs(abs(e.center().X) - web / 2) < 1e-6]
        beam = beam.fillet(root, inner)
    return beam


def graph_of(shape: Any) -> tuple[BrepGraph, TrimmedFaces]:
    graph = to_brep([("body", shape.solid().wrapped)])
    return graph, TrimmedFaces.of(graph)


def fused_seams(shape: Any) -> tuple[Seam, ...]:
    graph, trimmed = graph_of(shape)
    return find_part_candidates(graph, trimmed, SeamOptions(), cross=nothing_crosses).judged(SeamOptions())


@pytest.mark.parametrize("root", few([12.0, 0.0], 1))
def test_a_column_fused_with_its_foot_is_welded_at_the_foot_only(root: float) -> None:
    column = Box(160, 160, 12, align=ALONG) + Pos(0, 0, 12) * i_beam(100, 100, 6, 10, length=500, root=root)
    seams = fused_seams(column)
    accepted = [seam for seam in seams if seam.accepted]
    assert {round(float(seam.frames.p[0, 2]), 6) for seam in accepted} == {12.0}
    assert sum(seam.length_mm for seam in accepted) > 350
    rolled = [seam for seam in seams if any(finding.rule == "rolled" for finding in seam.findings)]
    assert [round(seam.length_mm) for seam in rolled] == [500] * 4


@pytest.mark.parametrize("root", few([0.0, 8.0], 1))
def test_angles_with_battens_across_them_are_welded_at_the_battens_only(root: float) -> None:
    angle = Box(60, 60, 500, align=LOW) - Pos(8, 8, 0) * Box(60, 60, 500, align=LOW)
    inner = [edge for edge in angle.edges() if math.dist(tuple(edge.center()), (8, 8, 250)) < 1e-6]
    angle = angle.fillet(root, inner) if root else angle
    battens = [Pos(24, -8, z) * Box(252, 8, 70, align=LOW) for z in (0, 215, 430)]
    body = sum(battens, angle + Pos(300, 0, 0) * angle.mirror(Plane.YZ))
    lengths = [seam.length_mm for seam in fused_seams(body) if seam.accepted]
    assert sum(lengths) > 1000 > 10 * max(lengths)


def test_a_mitred_frame_of_angles_is_welded_at_its_corners_only() -> None:
    frame = Box(600, 400, 40, align=ALONG) - Pos(0, 0, 4) * Box(592, 392, 40, align=ALONG) - Box(520, 320, 40)
    mitres = [seam for seam in fused_seams(frame) if seam.accepted]
    assert sum(seam.length_mm for seam in mitres if seam.source is SeamSource.MITRE) == pytest.approx(160.0)
    assert max(seam.length_mm for seam in mitres) == pytest.approx(40.0)


def test_members_of_a_column_are_a_profile_and_a_plate() -> None:
    column = Box(160, 160, 12, align=ALONG) + Pos(0, 0, 12) * i_beam(100, 100, 6, 10, length=500, root=12.0)
    found = members_of(*graph_of(column), 0)
    profile = next(one for one in found.members if one.kind is MemberKind.PROFILE)
    assert len(found.members) == 2
    assert found.share == 1.0
    assert (profile.length_mm, *profile.section) == pytest.approx((500.0, 100.0, 100.0))


def test_a_channel_through_a_plate_keeps_its_roots_and_is_welded_round() -> None:
    outline = Polyline((0, 0), (50, 0), (50, 6), (6, 6), (6, 94), (50, 94), (50, 100), (0, 100), (0, 0))
    channel = extrude(make_face(outline), 400)
    plate = Pos(25, 50, 200) * Box(200, 200, 10)
    accepted = [seam for seam in fused_seams(channel + plate) if seam.accepted]
    assert accepted
    assert all(abs(seam.frames.R[:, 2, 0]).max() < 0.1 for seam in accepted)


def test_ribs_on_a_plate_are_welded_though_nothing_explains_the_dome_below() -> None:
    dome = Sphere(90) & Pos(0, 0, -50) * Box(200, 200, 100)
    ribs = [Pos(0, y, 40) * Box(250, 8, 60) for y in (-60, 60)]
    bracket = Pos(0, 0, 5) * Box(300, 200, 10) + dome + ribs
    assert why_one_piece(*graph_of(bracket), 0) is not None
    accepted = [seam for seam in fused_seams(bracket) if seam.accepted]
    assert sum(seam.length_mm for seam in accepted) == pytest.approx(4 * 250.0)
    moulded = bracket.scale(0.25)  # the same with walls of 2 and 2.5 mm
    assert not [seam for seam in fused_seams(moulded) if seam.accepted]
    milled = Box(300, 200, 60) + Pos(0, 0, -30) * dome - [Pos(x, 0, 20) * Box(120, 160, 50) for x in (-70, 70)]
    assert not [seam for seam in fused_seams(milled) if seam.accepted]


def test_a_thick_plate_and_a_lug_are_welded_to_slender_members() -> None:
    dome = Sphere(90) & Pos(0, 0, -50) * Box(200, 200, 100)
    ribs = [Pos(0, y, 40) * Box(290, 8, 60) for y in (-90, 90)]
    lug = Pos(0, 0, 55) * Box(100, 35, 90) - Pos(0, 0, 65) * Cylinder(15, 80, rotation=(90, 0, 0))
    around = {}
    fin, thick, block = (Pos(0, 0, 55) * Box(100, y, 90) for y in (2, 20, 80))
    for name, body in (("lug", lug), ("fin", fin), ("thick", thick), ("block", block)):
        seams = fused_seams(Pos(0, 0, 5) * Box(300, 200, 10) + dome + ribs + body)
        around[name] = sum(seam.length_mm for seam in seams if seam.accepted and abs(seam.frames.p[0, 1]) < 80)
    assert around == {"lug": pytest.approx(2 * 135.0), "fin": 0, "thick": pytest.approx(2 * 120.0), "block": 0}


def test_a_plate_that_lies_on_another_one_is_a_member() -> None:
    dome = Sphere(90) & Pos(0, 0, -50) * Box(200, 200, 100)  # nothing explains it
    body = Pos(0, 0, 5) * Box(300, 200, 10) + dome + Pos(60, 0, 13) * Box(260, 120, 6)
    accepted = [seam for seam in fused_seams(body) if seam.accepted]
    assert sum(seam.length_mm for seam in accepted) >= 2 * 220.0 + 120.0


def test_a_tube_is_known_by_its_bore_whatever_covers_its_outside() -> None:
    tube = Box(100, 60, 600, align=ALONG) - Box(88, 48, 600, align=ALONG)
    rails = [Pos(0, 33 * side, 200 * (side > 0)) * Box(30, 6, 400, align=ALONG) for side in (-1, 1)]
    found = members_of(*graph_of(tube + rails), 0)
    (known,) = (one for one in found.members if one.kind is MemberKind.TUBE)
    assert (known.length_mm, known.thickness_mm, *known.section) == pytest.approx((600.0, 6.0, 60.0, 100.0))
    assert found.share > 0.98
    milled = Box(100, 60, 600, align=ALONG) - Pos(5, 0, 0) * Box(60, 40, 600, align=ALONG)
    girder = tube + [Pos(0, 27 * side, 0) * Box(140, 6, 600, align=ALONG) for side in (-1, 1)]  # of four plates
    assert all(one.kind is not MemberKind.TUBE for one in members_of(*graph_of(milled + rails), 0).members)
    girder += Box(200, 120, 8)  # otherwise it is an extrusion
    assert not any(one.roots for one in members_of(*graph_of(girder), 0).members)


def test_a_sheet_that_meets_a_plate_along_an_arc_is_no_bend() -> None:
    scoop = Cylinder(100, 126) - Cylinder(97, 120) - Pos(100, 0, 0) * Box(200, 200, 200)
    accepted = [seam for seam in fused_seams(scoop) if seam.accepted]
    assert sum(seam.length_mm for seam in accepted) == pytest.approx(2 * np.pi * 97, rel=0.01)


def test_bars_on_edge_are_no_plate_that_was_cut_out() -> None:
    frame = Box(400, 300, 30, align=ALONG) - Box(390, 290, 30, align=ALONG)
    bars = [Pos(0, y, 0) * Box(390, 4, 30, align=ALONG) for y in range(-80, 81, 40)]
    accepted = [seam for seam in fused_seams(frame + bars) if seam.accepted]
    assert sum(seam.length_mm for seam in accepted) == pytest.approx(5 * 4 * 30.0)


def octagon(x: float, y: float, cut: float) -> Any:
    """Return a bar along z, 600 mm long: a box whose four edges are cut off at 45 degrees."""
    corner = [(x, y - cut), (x - cut, y)]
    turned = [(-a, b) for a, b in reversed(corner)]
    half = [*corner, *turned]
    return extrude(make_face(Polyline(*half, *[(-a, -b) for a, b in half], close=True)), 600)


def test_narrow_facets_of_a_folded_tube_are_sides_of_it() -> None:
    tube = octagon(70, 50, 12.7) - octagon(58, 38, 5.67)  # 18 mm wide outside, 8 mm inside
    rails = [Pos(0, 53 * side, 200 * (side > 0)) * Box(30, 6, 400, align=ALONG) for side in (-1, 1)]
    graph, trimmed = graph_of(tube + rails)
    (known,) = (one for one in members_of(graph, trimmed, 0).members if one.kind is MemberKind.TUBE)
    slanted = np.abs(graph.face_frame[sorted(known.faces), 3]) @ [1.0, 1.0, 0.0] > 1.4
    assert slanted.sum() == 8


def test_plates_on_a_girder_that_was_drawn_solid_are_between_plates() -> None:
    across = np.array([0.0, 0.0, 1.0])
    girder, plate, block = (
        Member(MemberKind.PLATE, frozenset([face]), across, np.array([thick, wide]), thick, wide)
        for face, (wide, thick) in enumerate(((1500.0, 200.0), (900.0, 20.0), (600.0, 140.0)))
    )
    members = (girder, plate, block)
    found = Decomposition(members, 1.0, 1.0, tuple(one.faces for one in members))
    assert found.is_between(0, 1)
    assert not found.is_between(0, 2)  # a plate of 140 mm was rather milled


@pytest.mark.parametrize(("play", "welds"), few([(0.2, 2), (0.8, 0), (0.0, 2)], 2))
def test_members_of_one_body_are_welded_over_the_play_between_them(play: float, welds: int) -> None:
    rib = Pos(6 + play, -3, 8) * Box(90 - play, 6, 70, align=Align.MIN)
    bracket = Box(200, 200, 8, align=ALONG) + Pos(0, 0, 8) * Box(12, 160, 100, align=ALONG) + rib
    upright = [seam for seam in fused_seams(bracket) if seam.accepted and abs(seam.frames.R[0, 2, 0]) > 0.99]
    assert [round(seam.length_mm) for seam in upright] == [70] * welds


@pytest.mark.parametrize("off", few([3.0, 0.0], 1), ids=["bevelled", "bent"])
def test_a_bent_or_bevelled_shell_is_a_member_beside_plates(off: float) -> None:
    shell = Cylinder(215, 500) - Pos(off, 0, 0) * Cylinder(200, 600) - Pos(-300, 0, 0) * Box(600, 600, 600)
    ends = [Pos(107.5, 0, z) * Box(215, 430, 12) for z in (-250, 250)]
    bucket = shell + ends + Pos(300, 0, 0) * Sphere(180) - Pos(off, 0, 0) * Cylinder(200, 488)
    assert why_one_piece(*graph_of(bucket), 0) is not None
    accepted = [seam for seam in fused_seams(bucket) if seam.accepted]
    assert sum(seam.length_mm for seam in accepted) == pytest.approx(2 * np.pi * (200.0 + 215.0), rel=0.01)


def test_an_upright_with_a_step_in_its_web_and_a_crossbar_keeps_its_roots() -> None:
    upright = i_beam(200, 60, 20, 30, length=900, root=0.0) + Pos(12.5, 20, 0) * Box(5, 100, 900, align=ALONG)
    frame = upright + Pos(-120, 0, 700) * Box(220, 30, 200)
    accepted = [seam for seam in fused_seams(frame) if seam.accepted]
    assert accepted
    assert all(seam.length_mm < 500 for seam in accepted)


def cut_beam(radius: float) -> Any:
    """Return an I section with sharp roots, one flange coped; with a radius in the corner of the cope."""
    cope = Pos(0, 80, 0) * Box(200, 120, 160)
    return i_beam(200, 100, 10, 12, length=1000, root=0.0) - cope.fillet(radius, cope.edges().filter_by(Axis.X))


def cut_angle(t: float) -> Any:
    leg = Box(80, t, 700, align=ALONG) + Pos(-36, 36, 0) * Box(t, 80, 700, align=ALONG)
    return leg - Pos(30, 0, 350) * Box(60, 60, 100)


def cut_tube(radius: float) -> Any:
    """Return a square tube with a slot through one wall and into two more."""
    slot = Box(60, 60, 80)
    slot = slot.fillet(radius, slot.edges().filter_by(Axis.Y)) if radius else slot
    return Box(100, 60, 800) - Box(88, 48, 800) - Pos(0, 40, 0) * slot


@pytest.mark.parametrize(
    ("cut", "size"), [(cut_beam, 1.0), (cut_beam, 10.0), (cut_angle, 8.0), (cut_tube, 0.0), (cut_tube, 8.0)],
    ids=["beam", "round beam", "angle", "tube", "round tube"],
)  # fmt: skip
def test_nobody_welds_the_corners_of_cuts_nor_the_roots_of_what_was_cut(cut: Any, size: float) -> None:
    assert not [seam for seam in fused_seams(cut(size)) if seam.accepted]


def test_the_end_of_a_rib_that_is_as_wide_as_its_plate_is_no_cut() -> None:
    seams = fused_seams(Box(200, 60, 10) + Pos(0, 0, 35) * Box(10, 60, 60))
    assert sorted(round(seam.length_mm) for seam in seams if seam.accepted) == [60, 60]


def test_nobody_welds_inside_a_case_that_an_arc_burns_through() -> None:
    case = Box(120, 80, 40, align=ALONG) - Pos(0, 0, 1) * Box(118, 78, 40, align=ALONG)
    assert not any(seam.accepted for seam in fused_seams(case + Box(120, 1, 30, align=ALONG)))


@pytest.mark.parametrize(("side", "is_welded"), [(10, False), (40, True)])
def test_nobody_welds_inside_a_box_with_many_small_ribs(side: int, is_welded: bool) -> None:
    box = Box(160, 120, 4, align=ALONG) + Pos(0, -58, 0) * Box(160, 4, 60, align=ALONG)
    box += [Pos(x, 20, 4) * Box(2.5, side, side, align=ALONG) for x in range(-65, 70, 10 if side == 10 else 30)]
    assert any(seam.accepted for seam in fused_seams(box)) == is_welded


def test_small_tabs_of_plate_leave_a_bracket_a_weldment() -> None:
    gusset = Pos(-69, 0, 6) * Box(50, 6, 50, align=(Align.MIN, Align.CENTER, Align.MIN))
    bracket = Box(150, 100, 6, align=ALONG) + Pos(-72, 0, 6) * Box(6, 100, 60, align=ALONG) + gusset
    bracket += [Pos(65 - 12 * k, (-1) ** k * 25, 6) * Box(4, 16, 16, align=ALONG) for k in range(4)]
    lengths = [round(seam.length_mm) for seam in fused_seams(bracket) if seam.accepted]
    assert len(lengths) >= 12
    assert lengths.count(50) == 4


def test_a_bent_pipe_whose_surface_is_free_form_is_welded_to_its_flange() -> None:
    path = Spline((0, 0, 0), (15, 0, 150), (110, 0, 260), tangents=[(0, 0, 1), (1, 0, 0)])
    pipe = sweep(Circle(22), path) - sweep(Circle(20), path)
    lengths = [seam.length_mm for seam in fused_seams(pipe + Pos(0, 0, -3) * (Cylinder(30, 6) - Cylinder(20, 6)))]
    np.testing.assert_allclose(lengths, [2 * np.pi * 22], rtol=1e-4)


def bent_to_a_loop() -> Any:
    """Return a P section of sheet 5 mm thick, 40 mm long: three bends, and its end against its own side."""
    outer, inner = Box(220, 200, 40), Box(210, 190, 40)
    outer = outer.fillet(25, outer.edges().filter_by(Axis.Z))
    inner = inner.fillet(20, inner.edges().filter_by(Axis.Z))
    corner = Pos(-97.5, -87.5, 0) * Box(25, 25, 40)
    loop = outer - inner - corner
    return loop + Pos(-107.5, -150, 0) * Box(5, 180, 40) + Pos(-95, -97.5, 0) * Box(25, 5, 40)


def test_a_bent_sheet_that_closes_on_itself_is_welded_there() -> None:
    lengths = [round(seam.length_mm) for seam in fused_seams(bent_to_a_loop()) if seam.accepted]
    assert lengths.count(40) == 2


def test_a_lug_across_the_end_of_a_round_bar_is_no_cut() -> None:
    lug = Pos(0, 0, 530) * (Box(20, 100, 60) & Cylinder(40, 60))
    seams = fused_seams(Cylinder(40, 500, align=ALONG) + lug)
    assert [round(seam.length_mm) for seam in seams if seam.accepted] == [77, 77]


def test_walls_of_many_pieces_of_rings_were_cast() -> None:
    outer, inner = Cylinder(100, 50, align=ALONG), Cylinder(95, 50, align=ALONG)
    for boss in PolarLocations(100, 12):
        outer, inner = outer + boss * Cylinder(12, 50, align=ALONG), inner + boss * Cylinder(7, 50, align=ALONG)
    graph, trimmed = graph_of(outer - Pos(0, 0, 5) * inner)
    assert members_of(graph, trimmed, 0).straight_share < 0.6


def test_a_coped_beam_is_welded_at_its_web_only() -> None:
    beam = i_beam(100, 60, 6, 8, length=400, root=0.0) - [Pos(0, 46 * k, 0) * Box(60, 8, 160) for k in (-1, 1)]
    wall = Pos(0, 0, -10) * Box(200, 200, 10, align=ALONG)
    accepted = [seam for seam in fused_seams(beam + wall) if seam.accepted]
    assert sum(seam.length_mm for seam in accepted) == pytest.approx(2 * 84.0)


@pytest.mark.parametrize(("wall", "welds"), [(5.0, 8), (2.5, 0)])
def test_no_sheet_is_folded_along_three_edges_that_meet(wall: float, welds: int) -> None:
    box = Box(400, 300, 100, align=ALONG) - Pos(0, 0, wall) * Box(400 - 2 * wall, 300 - 2 * wall, 100, align=ALONG)
    assert len([seam for seam in fused_seams(box) if seam.accepted]) == welds


@pytest.mark.parametrize("radius", [0.0, 5.0], ids=["sharp", "round"])
def test_a_plate_that_is_bent_by_45_degrees_is_welded_at_its_rib_only(radius: float) -> None:
    t, far = 6.3, 100.0
    lower = Polyline((-200, 0), (0, 0), (far, far))
    edge = np.tan(np.pi / 8) * t
    upper = ((far - t / np.sqrt(2), far + t / np.sqrt(2)), (-edge, t), (-200, t))
    sheet = extrude(make_face([lower, Polyline((far, far), *upper, (-200, 0))]), 150)
    if radius:
        inner, outer = (
            [e for e in sheet.edges().filter_by(Axis.Z) if abs(e.center().X) < 5 and (e.center().Y > 1) == is_inner]
            for is_inner in (True, False)
        )
        sheet = sheet.fillet(radius, inner)
        sheet = sheet.fillet(radius + 0.9 * t, outer)  # about another axis
    rib = Pos(-120, t + 30, 75) * Box(8, 60, 150)
    accepted = [seam for seam in fused_seams(sheet + rib) if seam.accepted]
    assert sum(seam.length_mm for seam in accepted) == pytest.approx(2 * 150.0)


def welded_mm(*bodies: Any) -> float:
    """Return the length of the accepted seams of bodies fused into one."""
    return sum(seam.length_mm for seam in fused_seams(bodies[0] + [*bodies[1:]]) if seam.accepted)


PLATE = Box(200, 200, 8, align=ALONG)
TUBE = Pos(0, 0, 8) * (Cylinder(40, 100, align=ALONG) - Cylinder(36, 100, align=ALONG))  # welded inside and outside
TUBE_MM = 2 * np.pi * (40 + 36)


def hexagon(flats: float, high: float) -> Any:
    return extrude(RegularPolygon(flats / np.sqrt(3), 6), high)


def pin(radius: float, head: float, high: float, *, chamfer: float = 0.0) -> Any:
    """Return a pin under the plate with a head on it."""
    cap = Pos(0, 0, 8) * Cylinder(head, high, align=ALONG)
    return (fillet(cap.edges().sort_by(Axis.Z)[-1], chamfer) if chamfer else cap) + Pos(0, 0, -20) * Cylinder(
        radius, 20, align=ALONG
    )


def test_nobody_welds_round_bolts_screws_and_nuts_that_are_one_body_with_their_plate() -> None:
    heads = [Pos(x, y, 8) * hexagon(24, 13) for x in (-75, 75) for y in (-75, 75)]
    screw = Pos(0, -75, 0) * pin(6, 9, 5, chamfer=4)
    assert welded_mm(PLATE, TUBE, *heads, screw) == pytest.approx(TUBE_MM, rel=0.01)
    assert welded_mm(hexagon(38, 10) + Pos(0, 0, 10) * Cylinder(12.7, 300, align=ALONG)) == 0.0
    bolt, holed = (
        Cylinder(7.5, 8, align=ALONG) + Pos(0, 0, 8) * hexagon(24, 13),
        PLATE - Pos(75, 0, 0) * Cylinder(8.5, 30),
    )
    assert welded_mm(holed, TUBE, Pos(75, 0, 0) * bolt) == pytest.approx(TUBE_MM, rel=0.01)


@pytest.mark.parametrize(
    ("body", "more"),
    [
        (Pos(75, 75, 8) * hexagon(60, 13), 6 * 60 / np.sqrt(3)),
        (Pos(75, 75, 8) * (hexagon(19, 10) - Cylinder(5, 30)), 6 * 19 / np.sqrt(3)),
        (Pos(75, 75, 0) * pin(6, 15, 5), 2 * np.pi * (6 + 15)),
        (Pos(75, 75, 0) * pin(15, 20, 20), 2 * np.pi * (15 + 20)),
    ],
    ids=["hexagon of 60 mm", "weld nut", "disc", "trunnion"],
)
def test_what_is_no_screw_is_welded(body: Any, more: float) -> None:
    assert welded_mm(PLATE, TUBE, body) - TUBE_MM > 0.6 * more  # a nozzle does not turn round every corner of a nut


def test_a_tube_as_thick_as_its_plate_is_no_collar() -> None:
    tube = Pos(0, 0, 5) * Cylinder(30, 80, align=ALONG)
    body = Box(200, 200, 5, align=ALONG) + tube - Cylinder(25, 300)
    assert welded_mm(body, Pos(0, 80, 5) * Box(150, 5, 60, align=ALONG)) > 2 * np.pi * 30 + 290


def test_two_plates_with_a_bead_and_a_broken_edge_are_not_bent() -> None:
    t = 10.0
    lower, edge = Polyline((-200, 0), (0, 0), (100, 100)), np.tan(np.pi / 8) * t
    upper = ((100 - t / np.sqrt(2), 100 + t / np.sqrt(2)), (-edge, t), (-200, t))
    plates = extrude(make_face([lower, Polyline((100, 100), *upper, (-200, 0))]), 150)
    fold = [e for e in plates.edges().filter_by(Axis.Z) if abs(e.center().X) < 5]
    beaded = plates.fillet(4.0, [e for e in fold if e.center().Y > 1]).fillet(
        2.0, [e for e in fold if e.center().Y < 1]
    )
    assert welded_mm(beaded, Pos(-120, t + 30, 75) * Box(8, 60, 150)) == pytest.approx(3 * 150.0, rel=0.01)


def test_a_thin_ring_inside_the_bolt_circle_of_a_flange_is_no_member() -> None:
    holes = [Pos(x, y, 0) * Cylinder(7, 40) for x, y in ((45, 0), (-45, 0), (0, 45), (0, -45))]
    flange = Cylinder(60, 16) - Cylinder(16, 40)
    for body, count in ((flange - holes, 0), (flange, 1)):
        ring = Pos(0, 0, 9.5) * (Cylinder(30, 3) - Cylinder(16, 40))
        graph = to_brep([(name, shape.solid().wrapped) for name, shape in (("flange", body), ("ring", ring))])
        assert len([seam for seam in detect_seams(graph) if seam.accepted]) == count


def test_no_seam_is_accepted_that_is_reached_from_inside_a_closed_tank_only() -> None:
    shell = Cylinder(300, 800) - Cylinder(294, 800)
    heads = [("head", Pos(0, 0, z) * Cylinder(300, 12)) for z in (-406, 406)]
    graph = to_brep([(name, shape.solid().wrapped) for name, shape in (("shell", shell), *heads)])
    accepted = [seam for seam in detect_seams(graph) if seam.accepted]
    assert [round(seam.length_mm) for seam in accepted] == [1885, 1885]
    open_graph = to_brep([(name, shape.solid().wrapped) for name, shape in (("shell", shell), heads[0])])
    assert len([seam for seam in detect_seams(open_graph) if seam.accepted]) == 2


def test_one_free_place_of_a_seam_is_a_way_out() -> None:
    graph, trimmed = graph_of(Box(300, 300, 300) - Box(280, 280, 280))
    plates = [("base", Box(200, 80, 10)), ("rib", Pos(0, 0, 30) * Box(200, 8, 50))]
    seam = next(one for one in detect_seams(to_brep([(name, body.solid().wrapped) for name, body in plates])))
    for first, is_closed in (((0.0, 0.0, 300.0), False), ((0.0, 0.0, -50.0), True)):  # outside of the box, and in it
        p = np.linspace(first, (0.0, 0.0, 0.0), len(seam.frames))
        p[1:] = 0.0
        moved = replace(seam, frames=replace(seam.frames, p=p))
        assert bool(find_closed_in(graph, trimmed, [moved], TorchShape())) == is_closed
