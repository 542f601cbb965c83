"""Seams and joint words on parts whose welds anybody can count."""

import math
from collections import Counter
from typing import Any

import numpy as np
import pytest

from cad.kernel.to_brep import to_brep
from cad.samples.parts import box, cut, cylinder
from wpcal.seam import Seam, detect_seams

LENGTH_MM = 0.01  # the agreed accuracy of a seam's length
ANGLE_RAD = 1e-6  # exact surfaces; the intersection curve of the kernel is good to 1e-7 mm on a 35 mm radius

FOUR_ROUND = {("tee", "fillet"): 4}


def fused(a: Any, b: Any) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

    union = ShapeUpgrade_UnifySameDomain(BRepAlgoAPI_Fuse(a, b).Shape(), True, True, False)
    union.Build()
    return union.Shape()


def base() -> Any:
    return box(200, 100, 8, (0, 0, 0))


def cases() -> dict[str, tuple[list[Any], dict[tuple[str, str], int], float]]:
    web = box(160, 8, 80, (20, 46, 8))
    return {
        "tee": ([base(), web], FOUR_ROUND, 336.0),
        "tee with a gap of 0.4": ([base(), box(160, 8, 80, (20, 46, 8.4))], FOUR_ROUND, 336.0),
        "tee in one piece": ([fused(base(), web)], {("unknown", "fillet"): 4}, 336.0),
        "corner": (
            [base(), box(200, 8, 80, (0, 0, 8))],
            {("corner", "fillet"): 1, ("corner", "groove"): 3},
            2 * 200.0 + 2 * 8.0,
        ),
        "open corner": ([base(), box(200, 8, 80, (0, -8, 8))], {("corner", "fillet"): 1}, 200.0),
        "butt": ([base(), box(200, 100, 8, (0, 100, 0))], {("butt", "groove"): 4}, 416.0),
        "lap": (
            [box(120, 50, 6, (0, 0, 0)), box(120, 50, 6, (70, 0, 6))],
            {("lap", "fillet"): 2, ("edge", "groove"): 2},
            200.0,
        ),
        "pin flush with its plate": (
            [cut(box(80, 80, 10, (-40, -40, -10)), pin()), pin()],
            {("corner", "fillet"): 1, ("butt", "groove"): 1},
            2 * 2 * math.pi * 5,
        ),
        "rod through a plate": (
            [cut(box(200, 200, 10, (-100, -100, -10)), rod()), rod()],
            {("tee", "fillet"): 2},
            2 * 2 * math.pi * 30,
        ),
    }


def pin() -> Any:
    return cylinder(5, 40, (0, 0, -40), (0, 0, 1))


def rod() -> Any:
    return cylinder(30, 100, (0, 0, -50), (0, 0, 1))


def seams_of(shapes: list[Any]) -> tuple[Seam, ...]:
    return detect_seams(to_brep((f"S{i}", shape) for i, shape in enumerate(shapes)))


@pytest.mark.parametrize("name", list(cases()))
def test_every_seam_is_found_and_named(name: str) -> None:
    shapes, expected, length = cases()[name]
    seams = seams_of(shapes)
    assert Counter((seam.joint.value, seam.weld.value) for seam in seams) == expected
    assert sum(seam.length_mm for seam in seams) == pytest.approx(length, rel=0, abs=LENGTH_MM)
    assert all(seam.accepted for seam in seams)


def test_the_gap_is_reported() -> None:
    seams = seams_of([base(), box(160, 8, 80, (20, 46, 8.4))])
    assert [seam.gap_mm for seam in seams] == [pytest.approx((0.4, 0.4, 0.4), rel=0, abs=1e-9)] * 4


def test_parts_that_do_not_touch_have_no_seam() -> None:
    assert seams_of([base(), box(160, 8, 80, (20, 46, 9.0))]) == ()


def saddle(tilt_deg: float) -> list[Any]:
    tilt = math.radians(tilt_deg)
    axis = (math.sin(tilt), 0.0, math.cos(tilt))
    run = cylinder(60, 300, (-150, 0, 0), (1, 0, 0))
    return [run, cut(cylinder(35, 160, (0, 0, 0), axis), cylinder(31, 170, (0, 0, 0), axis), run)]


def test_the_saddle_has_an_outer_loop_and_an_inner_one_out_of_reach() -> None:
    outer, inner = seams_of(saddle(0.0))
    assert (outer.closed, outer.accepted, inner.closed, inner.accepted) == (True, True, True, False)
    # outer radius 35 on radius 60: square at the crown, acos(35/60) between the normals at the flank
    angle = outer.frames.angle_rad
    assert angle.max() == pytest.approx(math.pi / 2, rel=0, abs=ANGLE_RAD)
    crown = outer.frames.p[int(np.argmax(angle))]
    assert abs(crown[1]) <= LENGTH_MM
    x, y = outer.frames.p[:, 0], outer.frames.p[:, 1]
    between = np.arccos(np.clip(y / 35 * y / 60, -1, 1))  # normals (x, y, 0)/35 and (0, y, z)/60
    np.testing.assert_allclose(angle, between, rtol=0, atol=ANGLE_RAD)
    np.testing.assert_allclose(np.hypot(x, y), 35.0, rtol=0, atol=1e-6)


def test_the_saddle_of_60_degrees_has_both_loops() -> None:
    assert [(seam.closed, seam.accepted) for seam in seams_of(saddle(30.0))] == [(True, True), (True, False)]


@pytest.mark.parametrize("tilt_deg", [0.0, 30.0])
def test_an_untrimmed_branch_has_the_seams_of_the_trimmed_one(tilt_deg: float) -> None:
    from cad.workpiece.seams import find_seams
    from cad.workpiece.workpiece import Workpiece
    from wpcal.seam import SeamOptions

    tilt = math.radians(tilt_deg)
    axis = (math.sin(tilt), 0.0, math.cos(tilt))
    run, trimmed_branch = saddle(tilt_deg)
    branch = cut(cylinder(35, 160, (0, 0, 0), axis), cylinder(31, 170, (0, 0, 0), axis))
    graph = to_brep([("run", run), ("branch", branch)])
    found, _ = find_seams(Workpiece(graph, (), solids=(run, branch)), SeamOptions())
    expected = seams_of([run, trimmed_branch])
    assert [seam.accepted for seam in found] == [True, False]
    for mine, other in zip(found, expected, strict=True):
        assert mine.closed
        assert mine.length_mm == pytest.approx(other.length_mm, rel=0, abs=LENGTH_MM)
