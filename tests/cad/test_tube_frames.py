"""Tube frames that were drawn as one solid: mitres all round, saddles of tubes that open into each other, any walls."""

import math
from functools import cache
from typing import Any

import pytest
from build123d import Align, Box, Cylinder, Plane, Pos, Vector
from scipy.special import ellipe

from cad.kernel.to_brep import to_brep
from tests.few import few
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam import JointType, Seam, detect_seams
from wpcal.seam.find.tubes import find_tubes
from wpcal.seam.member.one_piece import why_one_piece
from wpcal.seam.seam import SeamSource

ALONG = (Align.CENTER, Align.CENTER, Align.MIN)
CORNER, RADIUS, WALL = Vector(300, 0, 0), 15.0, 2.0


def rod(start: Vector, way: Vector, length: float, radius: float) -> Any:
    return Plane(origin=start, z_dir=way) * Cylinder(radius, length, align=ALONG)


@cache
def knee(turn_deg: float) -> Any:
    """Return two tubes that are mitred, with a third tube that opens into the first one."""
    turn = math.radians(turn_deg)
    way = Vector(math.cos(turn), math.sin(turn), 0)
    across = Vector(0, 1, 0), Vector(100, 0, 0)

    def at(radius: float) -> Any:
        first = rod(Vector(0, 0, 0), Vector(1, 0, 0), 500, radius)
        second = rod(CORNER - 200 * way, way, 500, radius)
        middle = Plane(origin=CORNER, z_dir=Vector(1, 0, 0) + way)
        cut = middle * Cylinder(400, 800, align=ALONG)
        return (first - cut) + (second & cut) + rod(across[1], across[0], 200, radius)

    return at(RADIUS) - at(RADIUS - WALL)


def seams_of(shape: Any) -> list[Seam]:
    return [seam for seam in detect_seams(to_brep([("frame", shape.solid().wrapped)])) if seam.accepted]


@pytest.mark.parametrize(("turn_deg", "word"), few([(20.0, JointType.BUTT), (90.0, JointType.CORNER)], 1))
def test_a_mitre_is_one_seam_all_round(turn_deg: float, word: JointType) -> None:
    (mitre,) = (seam for seam in seams_of(knee(turn_deg)) if seam.source is SeamSource.MITRE)
    assert (mitre.joint, mitre.closed) == (word, True)
    long = RADIUS / math.cos(math.radians(turn_deg) / 2.0)
    assert mitre.length_mm == pytest.approx(4.0 * long * ellipe(1.0 - (RADIUS / long) ** 2), rel=0, abs=1e-3)
    out = mitre.frames.p - [CORNER.X, CORNER.Y, CORNER.Z]
    assert ((out * mitre.frames.R[:, :, 2]).sum(axis=1) > 0).all()  # z points away from the axes


def test_a_tube_that_opens_into_another_one_is_no_bent_sheet() -> None:
    saddle = [seam for seam in seams_of(knee(90.0)) if seam.source is SeamSource.CONCAVE]
    assert sum(seam.length_mm for seam in saddle) == pytest.approx(4.0 * 15.0 * math.sqrt(2) * ellipe(0.5), abs=0.05)


def test_tubes_of_five_walls_are_a_weldment() -> None:
    walls = (1.0, 1.3, 1.7, 2.2, 2.9)
    frame = rod(Vector(0, 0, 0), Vector(1, 0, 0), 700, 20) - rod(Vector(-1, 0, 0), Vector(1, 0, 0), 702, 18)
    for k, wall in enumerate(walls):
        start, way = Vector(100 + 120 * k, 19, 0), Vector(0, 1, 0)
        frame += rod(start, way, 300, 12) - rod(start, way, 301, 12 - wall)
    graph = to_brep([("frame", frame.solid().wrapped)])
    assert why_one_piece(graph, TrimmedFaces.of(graph), 0) is None


def test_a_bush_is_no_tube() -> None:
    bush = rod(Vector(0, 0, 0), Vector(0, 0, 1), 100, 20) - rod(Vector(0, 0, 0), Vector(0, 0, 1), 100, 10)
    ring = rod(Vector(0, 0, 0), Vector(0, 0, 1), 30, 20) - rod(Vector(0, 0, 0), Vector(0, 0, 1), 30, 18)
    for shape in (bush, ring):
        graph = to_brep([("S", shape.solid().wrapped)])
        assert len(find_tubes(graph, TrimmedFaces.of(graph), 0).face) == 0


def inside(*shapes: tuple[str, Any]) -> list[float]:
    """Return the lengths of the accepted seams inside the first of several solids, mm."""
    graph = to_brep([(name, shape.solid().wrapped) for name, shape in shapes])
    return sorted(s.length_mm for s in detect_seams(graph) if s.accepted and s.solids == (shapes[0][0],))


@pytest.mark.deep
def test_a_frame_of_tubes_is_searched_inside_though_another_solid_touches_it() -> None:
    pad = Pos(30, 0, RADIUS) * Box(30, 40, 20, align=ALONG)
    alone = inside(("frame", knee(90.0)))
    assert inside(("frame", knee(90.0)), ("pad", pad)) == pytest.approx(alone, rel=0, abs=1e-9)


def test_a_post_with_a_foot_is_searched_inside_though_another_solid_touches_it() -> None:
    foot = Box(100, 100, 8, align=ALONG)
    post = foot + Pos(0, 0, 8) * (Box(40, 40, 300, align=ALONG) - Box(36, 36, 300, align=ALONG))
    pad = Pos(0, 0, -20) * Box(30, 40, 20, align=ALONG)
    assert inside(("post", post)) == inside(("post", post), ("pad", pad)) == pytest.approx([40.0] * 4)


def test_a_plate_with_a_step_is_not_searched_if_another_solid_touches_it() -> None:
    stepped = Box(100, 100, 8, align=ALONG) + Pos(0, 0, 8) * Box(60, 60, 6, align=ALONG)
    assert inside(("plate", stepped), ("pad", Pos(0, 0, -20) * Box(30, 40, 20, align=ALONG))) == []
