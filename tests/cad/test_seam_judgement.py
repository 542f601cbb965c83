"""What is taken for a weld and what is not, on parts whose answer anybody can tell; no solid has a telling name."""

from typing import Any

import pytest

from cad.kernel.to_brep import to_brep
from cad.samples.parts import box, cut, cylinder
from wpcal.seam import ConcaveEdges, Seam, SeamOptions, detect_seams

UP = (0.0, 0.0, 1.0)


def fuse(a: Any, b: Any) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

    union = ShapeUpgrade_UnifySameDomain(BRepAlgoAPI_Fuse(a, b).Shape(), True, True, False)
    union.Build()
    return union.Shape()


def bolt(x: float) -> Any:
    """A shank of 10 mm below z 20 with a head above."""
    return fuse(cylinder(5, 45, (x, 0, -25), UP), cylinder(9, 7, (x, 0, 20), UP))


def nut(x: float) -> Any:
    return cut(box(17, 17, 8, (x - 8.5, -8.5, -8)), cylinder(5, 8, (x, 0, -8), UP))


def plates(*holes_x: float) -> list[Any]:
    """Two plates of 10 mm on each other, the upper one smaller, with holes of 11 mm."""
    holes = [cylinder(5.5, 20, (x, 0, 0), UP) for x in holes_x]
    return [cut(box(200, 100, 10, (-100, -50, 0)), *holes), cut(box(160, 60, 10, (-80, -30, 10)), *holes)]


def seams_of(*shapes: Any, concave: ConcaveEdges = ConcaveEdges.AUTO) -> tuple[Seam, ...]:
    return detect_seams(to_brep((f"S{i}", shape) for i, shape in enumerate(shapes)), SeamOptions(concave=concave))


def accepted(seams: tuple[Seam, ...]) -> set[tuple[str, ...]]:
    return {tuple(sorted(seam.solids)) for seam in seams if seam.accepted}


def test_bolted_plates_may_be_welded_and_their_bolts_are_not() -> None:
    seams = seams_of(*plates(-40, 40), bolt(-40), nut(-40), bolt(40), nut(40))
    assert accepted(seams) == {("S0", "S1")}
    assert sum(seam.length_mm for seam in seams if seam.accepted) == pytest.approx(440.0, rel=0, abs=0.01)
    whys = {why for seam in seams for why in seam.against}
    assert {"S2 is a bolt or screw", "S3 is a nut or washer", "the members are also held by 4 fasteners"} <= whys


def test_a_bar_through_plates_is_a_rod_only_with_nuts() -> None:
    bar = cylinder(5, 60, (0, 0, -20), UP)
    hole = cylinder(5, 20, (0, 0, 0), UP)
    lower, upper = (cut(plate, hole) for plate in plates())
    assert ("S0", "S2") in accepted(seams_of(lower, upper, bar))
    assert accepted(seams_of(lower, upper, bar, nut(0))) == {("S0", "S1")}


def test_a_collar_on_a_tube_is_a_weld() -> None:
    tube = cut(cylinder(15, 200, (0, 0, 0), UP), cylinder(12, 200, (0, 0, 0), UP))
    collar = cut(cylinder(25, 8, (0, 0, 90), UP), cylinder(15, 8, (0, 0, 90), UP))
    seams = seams_of(tube, collar)
    assert [seam.accepted for seam in seams] == [True, True]
    assert all("a round member in a hole" in seam.against[0] for seam in seams)


def test_corners_of_a_window_are_no_welds_and_those_of_a_fused_tee_are() -> None:
    window = cut(box(200, 150, 10, (0, 0, 0)), box(80, 60, 10, (50, 40, 0)))
    seams = seams_of(window)
    assert [(seam.accepted, round(seam.length_mm, 6)) for seam in seams] == [(False, 10.0)] * 4
    assert all(any("the corner of an opening" in why for why in seam.against) for seam in seams)
    asked = seams_of(window, concave=ConcaveEdges.ALWAYS)
    assert not any("opening" in why for seam in asked for why in seam.against)
    tee = fuse(box(200, 100, 15, (0, 0, 0)), box(160, 8, 80, (20, 46, 15)))
    assert [seam.accepted for seam in seams_of(tee)] == [True] * 4


def test_the_inside_of_a_closed_box_is_out_of_reach() -> None:
    """Six sheets of 6 mm, 180 mm wide inside: a wire gets that far before it meets a wall, a torch not."""
    a, b, t = 180.0, 192.0, 6.0
    sheets = [box(b, b, t, (-t, -t, -t)), box(b, b, t, (-t, -t, a))]
    sheets += [box(t, b, a, (-t, -t, 0)), box(t, b, a, (a, -t, 0)), box(a, t, a, (0, -t, 0)), box(a, t, a, (0, a, 0))]
    seams = seams_of(*sheets)
    inside = [bool(((seam.frames.p > -1e-6) & (seam.frames.p < a + 1e-6)).all()) for seam in seams]
    assert sum(inside) >= 8
    assert not any(seam.reachable for seam, is_in in zip(seams, inside, strict=True) if is_in)
    assert sum(seam.accepted for seam in seams) >= 12  # the edges of the box, from outside


def test_a_seam_is_found_once_where_an_edge_lies_near_two_faces() -> None:
    """A wall stands half on a plate and half 0.2 mm above its lower half: along each side there is one run."""
    floor = fuse(box(100, 100, 10, (0, 0, 0)), box(100, 100, 10.2, (100, 0, 0)))
    seams = seams_of(floor, box(120, 8, 60, (40, 46, 10.2)))
    assert [round(seam.length_mm, 6) for seam in seams if seam.length_mm > 10] == [120.0, 120.0]
    assert max(seam.gap_mm[2] for seam in seams) == pytest.approx(0.2, rel=0, abs=1e-9)
