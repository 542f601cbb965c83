"""Members of a weldment are cut from plate, bar and tube, or turned; what was made in one piece is doubted."""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from build123d import Align, Axis, Box, Cylinder, Pos, Rot, Spline, chamfer, extrude, fillet, make_face, offset

from cad.kernel.to_brep import to_brep
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.limits import Level
from wpcal.seam.member.members import members_of
from wpcal.seam.member.note import take_members
from wpcal.seam.member.one_piece import LEAST_EXPLAINED, OnePieces, find_whole_solids
from wpcal.seam.options import Judging
from wpcal.seam.rules import Rule

LOW = (Align.CENTER, Align.CENTER, Align.MIN)


def clevis() -> Any:
    """Return a fork milled from a block, with a round foot."""
    fork = Pos(0, 0, 30) * Box(60, 60, 70, align=LOW) - Pos(0, 0, 55) * Box(24, 60, 50, align=LOW)
    return fork + Cylinder(40, 30, align=LOW) - Pos(0, 0, 78) * Rot(0, 90, 0) * Cylinder(10, 100)


def casting() -> Any:
    """Return a bearing block: a foot, a round body, a boss on it."""
    body = Box(120, 60, 24, align=LOW) + Pos(0, 0, 50) * Rot(90, 0, 0) * Cylinder(40, 60)
    body += Pos(0, 0, 70) * Cylinder(15, 35, align=LOW)
    return body - Pos(0, 0, 50) * Rot(90, 0, 0) * Cylinder(24, 70)


def pad() -> Any:
    """Return a block with chamfers on all edges, and tapped holes in two directions."""
    block = chamfer(Box(60, 40, 30, align=LOW).edges(), 2)
    return block - Pos(15, 0, 15) * Cylinder(4, 40) - Pos(0, 0, 15) * Rot(90, 0, 0) * Cylinder(3, 60)


def rounded_plate() -> Any:
    return fillet(Box(120, 80, 10, align=LOW).edges(), 3)


def flange() -> Any:
    """Return a welding neck flange with bolt holes."""
    ring = Cylinder(60, 16, align=LOW) + Pos(0, 0, 16) * Cylinder(34, 20, align=LOW) - Cylinder(28, 100)
    for k in range(4):
        ring -= Rot(0, 0, 90 * k) * Pos(46, 0, 0) * Cylinder(7, 40)
    return ring


def hub() -> Any:
    """Return a hub with a keyway."""
    return Cylinder(30, 40, align=LOW) - Cylinder(15, 100) - Pos(15, 0, 0) * Box(8, 8, 100)


def mitred_angle() -> Any:
    angle = Box(120, 40, 40, align=LOW) - Pos(0, 4, 4) * Box(140, 40, 40, align=LOW)
    for side in (-1, 1):
        angle -= Pos(60 * side, -20, 0) * Rot(0, 0, 45 * side) * Box(57, 200, 100)
    return angle


def stub() -> Any:
    """Return a short square bar with a hole across."""
    return Box(30, 30, 40, align=LOW) - Pos(0, 0, 20) * Rot(0, 90, 0) * Cylinder(6, 60)


def pressed_cup() -> Any:
    """Return a bowl of sheet with a wavy wall that meets its floor at a sharp corner."""
    turn = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    radius = 80.0 + 12.0 * np.cos(2.0 * turn) + 6.0 * np.sin(3.0 * turn)
    corners = np.column_stack([1.2 * radius * np.cos(turn), radius * np.sin(turn)]).tolist()
    outside = make_face(Spline([tuple(corner) for corner in corners], periodic=True))
    return extrude(outside, 110) - Pos(0, 0, 4) * extrude(offset(outside, -4), 110)


def looks_whole(shape: Any) -> str | None:
    graph = to_brep([("S", shape.solid().wrapped)])
    return OnePieces(graph, TrimmedFaces.of(graph)).why(0)


def on_plate(shape: Any, **judging: Any) -> tuple[list[Seam], tuple[Seam, ...], Any]:
    """Return the accepted seams of a solid on a plate, all of them, and what the solids are taken for."""
    plate = Box(240, 200, 10, align=(Align.CENTER, Align.CENTER, Align.MAX))
    graph = to_brep([("plate", plate.solid().wrapped), ("body", shape.solid().wrapped)])
    options = SeamOptions(judging=Judging(**judging))
    seams = detect_seams(graph, options)
    notes = take_members(graph, TrimmedFaces.of(graph), options.judging).notes.with_shapes(seams)
    return [seam for seam in seams if seam.accepted], seams, notes.members[1]


def test_a_piece_of_a_ring_on_a_thin_plate_is_a_member_and_one_on_a_thick_plate_was_cast_with_it() -> None:
    ring = Pos(0, 0, 160) * Rot(90, 0, 0) * (Cylinder(40, 60) - Cylinder(24, 60))
    for plate_mm, is_member in ((12, True), (30, False)):
        lug = Box(300, plate_mm, 160, align=LOW) - Pos(0, 0, 160) * Rot(90, 0, 0) * Cylinder(24, 60) + ring
        graph = to_brep([("S", lug.solid().wrapped)])
        assert (members_of(graph, TrimmedFaces.of(graph), 0).straight_share >= LEAST_EXPLAINED) == is_member


def test_a_clip_of_thin_sheet_is_a_member_and_a_case_that_an_arc_burns_through_is_none() -> None:
    clip = Box(30, 26, 20, align=LOW) - Pos(2.5, 0, 2.5) * Box(30, 21, 20, align=LOW)
    assert looks_whole(clip) is None
    assert "it looks cast, moulded or milled" in str(looks_whole(clip.scale(0.4)))


def tray() -> Any:
    """Return a plate with a wavy rim as thick all round."""
    return pressed_cup() - Pos(0, 0, 30) * Box(400, 400, 200, align=LOW)


def tongue() -> Any:
    """Return a plate that is thinner at one end, as heads of milled holders are."""
    return Box(80, 60, 6, align=LOW) + Pos(47, 0, 0) * Box(20, 12, 3, align=LOW)


def padded() -> Any:
    """Return a plate with pads for screws."""
    plate = Box(260, 200, 4, align=LOW)
    for x, y in itertools.product((-100, 0, 100), (-70, 70)):
        plate += Pos(x, y, 4) * Box(14, 14, 8, align=LOW)
    return plate


def pocketed(pocket_mm: float) -> Any:
    """Return a plate with a round bar on it and, if it is deep enough, a pocket with round corners and a hole."""
    pocket = fillet(Box(80, 60, pocket_mm, align=LOW).edges().filter_by(Axis.Z), 8)
    plate = Box(240, 120, 25, align=LOW) + Pos(80, 0, 25) * Cylinder(20, 30, align=LOW)
    return plate - Pos(-50, 0, 25 - pocket_mm) * pocket - Pos(-50, 0, 0) * Cylinder(6, 60)


def islands(corner_mm: float = 0.1) -> Any:
    """Return a block with a pocket that round corners show to be milled, and what the cutter left in it."""
    pocket = fillet(Box(106, 66, 30, align=LOW).edges().filter_by(Axis.Z), 8)
    block = fillet(Box(130, 90, 35, align=LOW).edges().filter_by(Axis.Z), corner_mm)
    block = block - Pos(0, 0, 12) * pocket + Pos(26, 11, 0) * Cylinder(12, 28, align=LOW)
    return block + Pos(-26, 0, 0) * fillet(Box(24, 30, 28, align=LOW).edges().filter_by(Axis.Z), 6)


def stepped() -> Any:
    """Return a block with a slot along it and a step along one end."""
    step, slot = Box(61, 240, 20, align=LOW), Box(300, 48, 18.6)
    return Box(300, 240, 31, align=LOW) - Pos(120, 0, 18.6) * step - Pos(0, 0, 31) * slot


def crate() -> Any:
    """Return a box with round corners and ribs, of one wall."""
    outer, inner = (
        fillet(Box(x, x - 60, 100, align=LOW).edges().filter_by(Axis.Z), r) for x, r in ((240, 9), (235, 6.5))
    )
    return outer - Pos(0, 0, 2.5) * inner + [Pos(x, 92, 0) * Box(2.5, 12, 80, align=LOW) for x in range(-90, 91, 30)]


def extrusion() -> Any:
    """Return a square bar with a T slot in each of its sides."""
    slot = Pos(0, 16, 0) * Box(8, 8, 300) + Pos(0, 13, 0) * Box(16, 6, 300)
    return Box(40, 40, 300) - [Rot(0, 0, 90 * k) * slot for k in range(4)]


def keyed_shaft() -> Any:
    """Return a shaft with a collar and a keyway that ends in the shaft."""
    return Cylinder(20, 150) + Cylinder(28, 10) - Pos(17, 0, 40) * Box(10, 10, 40)


def compact(mm: int, known: int, corners: int, filled: int) -> str:
    words = (
        f"members explain {known}% of its surface and {corners}% of its inner corners, it fills {filled}% of its hull"
    )
    return f"{words}, and it is {mm} mm from corner to corner: it was rather cast, printed or milled"


def small_tee(scale: float) -> Any:
    return (Box(260, 200, 4, align=LOW) + Pos(0, 0, 4) * Box(100, 4, 60, align=LOW)).scale(scale)


def corner(t: float) -> Any:
    return Box(180, 120, t, align=LOW) + Pos(-30, 0, 0) * Box(t, 120, 150, align=LOW)


def bossed(scale: float) -> Any:
    """Return a corner of three plates with four bored bosses."""
    made = Box(120, 80, 10, align=LOW) + Box(120, 8, 60, align=LOW) + Box(8, 80, 50, align=LOW)
    at = [Pos(x, y, 0) for x in (-40, 40) for y in (-25, 25)]
    made = made + [one * Cylinder(12, 30, align=LOW) for one in at]
    return (made - [one * Pos(0, 0, 10) * Cylinder(5, 30, align=LOW) for one in at]).scale(scale)


@pytest.mark.parametrize(
    ("made", "why"),
    [
        (pressed_cup, "it is mostly free-form sheet: it looks pressed or moulded"),  # its edges are offset curves
        (tray, "it is of one thickness, with free-form sheet: it looks pressed or moulded"),
        (tongue, "it is one plate with steps or pads: it looks milled or printed"),
        (padded, compact(328, 96, 0, 40)),
        (lambda: pocketed(10), compact(274, 100, 91, 65)),
        (islands, compact(162, 97, 88, 66)),
        (stepped, compact(385, 100, 100, 91)),
        (lambda: small_tee(0.34), compact(114, 100, 100, 16)),
        (lambda: small_tee(0.36), None),
        (lambda: corner(25), compact(263, 100, 100, 44)),
        (lambda: corner(9), None),
        (lambda: bossed(1), compact(156, 94, 94, 40)),
        (lambda: bossed(3), None),
        (lambda: Pos(0, 25, 0) * Box(40, 10, 60) + extrusion(), "its section has 16 inner corners: it is an extrusion"),
        (crate, "its 8 walls are 2.5 mm thick: it looks moulded"),
        (keyed_shaft, "all its faces are round about one axis: it looks turned"),
    ],
)
def test_what_looks_pressed_milled_or_printed_has_no_seam(made: Callable[[], Any], why: str | None) -> None:
    graph = to_brep([("S", made().solid().wrapped)])
    assert any(seam.accepted for seam in detect_seams(graph)) == (why is None)
    assert [one[2] for one in find_whole_solids(graph, TrimmedFaces.of(graph))] == ([why] if why else [])


def test_an_extrusion_with_slots_is_clamped() -> None:
    assert looks_whole(extrusion()) == "its section has 16 inner corners: it is an extrusion"


CAST, CUT = (clevis, casting), (pad, rounded_plate, flange, hub, mitred_angle, stub)


@pytest.mark.parametrize("made", [*CAST, *CUT])
def test_castings_and_milled_forks_are_one_piece_and_what_is_cut_or_turned_is_a_member(made: Any) -> None:
    assert str(looks_whole(made())).endswith("it looks cast, moulded or milled" if made in CAST else "None")


def test_a_casting_on_a_plate_is_a_candidate_that_generous_and_your_word_take() -> None:
    accepted, seams, member = on_plate(casting())
    assert accepted == []
    doubted = [seam for seam in seams if Rule.ONE_PIECE.key in {one.rule for one in seam.findings}]
    assert sum(seam.length_mm for seam in doubted) == pytest.approx(360.0, abs=1e-3)
    assert member.taken_as == "made in one piece"
    assert "it looks cast" in member.why[0]
    for said in ({"level": Level.GENEROUS}, {"weld": ("body",)}):
        accepted, _, _ = on_plate(casting(), **said)
        assert sum(seam.length_mm for seam in accepted) == pytest.approx(360.0, abs=1e-3)


def test_a_short_bar_and_a_flange_on_a_plate_are_welded() -> None:
    for shape in (stub(), flange()):
        accepted, _, member = on_plate(shape)
        assert accepted
        assert member.taken_as == "a member"
