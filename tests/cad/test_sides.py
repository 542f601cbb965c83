"""Side and joint of a weld, station by station: turned parts, borders that touch, and frames with equal corners."""

import math
from collections import Counter
from typing import Any

import numpy as np
import pytest

from cad.kernel.primitives import box, cut, cylinder, prism, square_tube
from cad.kernel.to_brep import to_brep
from tests.few import few
from wpcal.core.arrays import FloatArray
from wpcal.seam import Seam, SeamOptions, detect_seams

LENGTH_MM = 1e-3
COS = 1e-9  # planes and cylinders: exact normals
UP, OUT = (0.0, 0.0, 1.0), math.sqrt(0.5)


def accepted(*solids: tuple[str, Any]) -> list[Seam]:
    return [seam for seam in detect_seams(to_brep(list(solids))) if seam.accepted]


def plate_beside(distance: float, turn_deg: float) -> Any:
    """Return a plate under z = 0 whose border is at a distance from the z axis, in a direction."""
    turn = math.radians(turn_deg)
    x, y = np.array([math.cos(turn), math.sin(turn)]), np.array([-math.sin(turn), math.cos(turn)])
    corners = [-distance * x - 100 * y, 170 * x - 100 * y, 170 * x + 100 * y, -distance * x + 100 * y]
    return prism([(float(p[0]), float(p[1]), -10.0) for p in corners], (0.0, 0.0, 10.0))


def assert_fillet_round_a_post(seam: Seam, radius: float) -> None:
    assert (seam.joint.value, seam.weld.value, seam.closed) == ("tee", "fillet", True)
    assert seam.length_mm == pytest.approx(2 * math.pi * radius, abs=LENGTH_MM)
    out = seam.frames.p[:, :2] / radius
    np.testing.assert_allclose(seam.frames.R[:, :, 2], np.column_stack([OUT * out, np.full(len(out), OUT)]), atol=1e-6)


@pytest.mark.parametrize("turn_deg", few([0.0, 133.0, 7.5, 30.0, 90.0, 180.0, 270.0], 2))
def test_a_post_that_touches_the_border_of_its_plate_has_one_fillet_however_the_plate_is_turned(
    turn_deg: float,
) -> None:
    (seam,) = accepted(("plate", plate_beside(30.0, turn_deg)), ("post", cylinder(30, 100, (0, 0, 0), UP)))
    assert_fillet_round_a_post(seam, 30.0)


@pytest.mark.parametrize("distance", few([44.5, 46.0, 44.0, 44.4, 44.8], 2))
def test_a_post_a_little_over_or_beside_the_border_has_one_fillet(distance: float) -> None:
    (seam,) = accepted(("plate", plate_beside(distance, 20.0)), ("post", cylinder(44.45, 150, (0, 0, 0), UP)))
    assert_fillet_round_a_post(seam, 44.45)


@pytest.mark.parametrize("ends", [(0.0, 100.0), (30.0, 60.0)])
def test_where_the_plate_ends_at_a_wall_the_fillet_ends_and_a_flush_groove_goes_on(ends: tuple[float, float]) -> None:
    """The base has a notch up to the wall: no fillet there. A notch of 2 mm is bridged."""
    first, last = ends
    base = cut(box(100, 60, 10, (0, 0, -10)), box(last - first, 30, 30, (first, 0, -20)))
    seams = detect_seams(to_brep([("base", base), ("wall", box(100, 8, 50, (0, 30, 0)))]))
    seams = tuple(seam for seam in seams if seam.frames.R[0, 1, 2] < -0.5)  # those in front of the wall
    groove = [s for s in seams if s.weld.value == "groove"]
    fillet = [s for s in seams if s.weld.value == "fillet"]
    assert sum(s.length_mm for s in groove) == pytest.approx(last - first, abs=LENGTH_MM)
    assert sum(s.length_mm for s in fillet) == pytest.approx(100 - (last - first), abs=LENGTH_MM)
    for seam in groove:
        np.testing.assert_allclose(seam.frames.R[:, 1, 2], -1.0, atol=COS)


def test_a_tab_beside_slits_is_one_weld_whose_points_are_on_its_edges_or_on_the_bridges() -> None:
    """The plate is slit by 2 mm beside a tab 20 mm wide, and the tab stands back by 0.1 mm."""
    base = box(120, 80, 10, (0, 0, -10))
    web = cut(
        box(100, 8, 60, (10, 40, 0)),
        *(box(2, 20, 5, (x, 35, -1)) for x in (48.0, 70.0)),
        box(20, 5, 61, (50, 35.1, -0.5)),
    )
    solids = [("base", base), ("web", web)]
    seams = [s for s in detect_seams(to_brep(solids)) if abs(s.frames.p[0, 1] - 40) < 0.2 and s.length_mm > 50]
    (seam,) = seams
    assert (seam.weld.value, seam.accepted) == ("fillet", True)
    s, p = seam.frames.s_mm, seam.frames.p
    assert seam.length_mm == s[-1] == pytest.approx(96 + 2 * math.hypot(2.0, 0.1), abs=LENGTH_MM)
    np.testing.assert_allclose(np.diff(s), np.linalg.norm(np.diff(p, axis=0), axis=1), atol=1e-9)
    assert set(np.round(p[:, 1], 6)) == {40.0, 40.1}
    np.testing.assert_allclose(seam.frames.R[:, :, 0], np.tile([1.0, 0, 0], (len(p), 1)), atol=1e-9)
    assert any("2 interruptions of up to 2.0 mm" in text for text in seam.reasons)
    apart = detect_seams(to_brep(solids), SeamOptions(join_mm=0.0))
    assert sum(abs(s.frames.p[0, 1] - 40) < 0.2 and s.length_mm > 15 for s in apart) == 3


def test_a_rib_in_an_interruption_keeps_the_seams_apart() -> None:
    base, web = box(120, 80, 10, (0, 0, -10)), box(100, 8, 60, (10, 40, 0))
    rib = box(4, 30, 60, (60, 10, 0))
    seams = accepted(("base", base), ("web", web), ("rib", rib))
    in_front = [s for s in seams if set(s.solids) == {"base", "web"} and abs(s.frames.p[0, 1] - 40) < 0.01]
    assert all(s.frames.p[:, 0].max() <= 60.01 or s.frames.p[:, 0].min() >= 63.99 for s in in_front if s.length_mm > 20)


def tube(length: float, corner: tuple[float, float, float], axis: str, radius: float) -> Any:
    if radius:
        return square_tube(50, length, corner, axis, wall=3, corner_radius=radius)
    way = "xyz".index(axis)
    outer = [length if k == way else 50.0 for k in range(3)]
    inner = [length if k == way else 44.0 for k in range(3)]
    at = tuple(c if k == way else c + 3.0 for k, c in enumerate(corner))
    return cut(box(outer[0], outer[1], outer[2], corner), box(inner[0], inner[1], inner[2], at))  # type: ignore[arg-type]


def box_frame(radius: float, width: float, depth: float, height: float) -> list[tuple[str, Any]]:
    """Return four posts and two rings of rails between them; tubes of 50 mm."""
    solids = [
        (f"post {x:g} {y:g}", tube(height, (x, y, 0.0), "z", radius))
        for x in (0.0, width - 50)
        for y in (0.0, depth - 50)
    ]
    for z in (0.0, height - 50):
        solids += [(f"rail x {y:g} {z:g}", tube(width - 100, (50.0, y, z), "x", radius)) for y in (0.0, depth - 50)]
        solids += [(f"rail y {x:g} {z:g}", tube(depth - 100, (x, 50.0, z), "y", radius)) for x in (0.0, width - 50)]
    return solids


def classes(seams: list[Seam]) -> Counter[tuple[Any, ...]]:
    """Count seams by what a person sees: joint, weld, length and kinds of members."""
    return Counter(
        (s.joint.value, s.weld.value, round(s.length_mm, 3), tuple(sorted(n.split()[0] for n in s.solids)))
        for s in seams
    )


@pytest.mark.parametrize(("is_reversed", "radius"), few([(True, 0.0), (False, 0.0), (False, 6.0), (True, 6.0)], 0))
def test_equal_corners_of_a_box_frame_have_equal_seams(radius: float, is_reversed: bool) -> None:
    """Each ring of rails has four equal corners: every class of seams comes eight times, or a multiple of that."""
    members = box_frame(radius, 400.0, 350.0, 350.0)
    seams = accepted(*(members[::-1] if is_reversed else members))
    counted = classes(seams)
    assert all(count % 8 == 0 for count in counted.values()), counted
    inner = [s for s in seams if all(name.startswith("rail") for name in s.solids)]
    assert [(s.joint.value, s.weld.value) for s in inner] == [("corner", "fillet")] * 8
    for seam in inner:  # towards the middle of the frame; at both ends the rounds of the tubes begin
        frame = len(seam.frames) // 2
        middle: FloatArray = np.array([200.0, 175.0]) - seam.frames.p[frame, :2]
        np.testing.assert_allclose(seam.frames.R[frame, :2, 2], OUT * np.sign(middle), atol=1e-6)
