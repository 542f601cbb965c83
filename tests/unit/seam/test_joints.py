"""Seams and joint words on parts whose welds anybody can count."""

import math
from collections import Counter

import numpy as np
import pytest

from tests.saved_graphs import saved_graph, saved_seams
from wpcal.seam import ConcaveEdges, SeamOptions, detect_seams

LENGTH_MM = 0.01  # the agreed accuracy of a seam's length
ANGLE_RAD = 1e-6  # exact surfaces; the intersection curve of the kernel is good to 1e-7 mm on a 35 mm radius

FOUR_ROUND = {("tee", "fillet"): 4}
CASES: dict[str, tuple[dict[tuple[str, str], int], float]] = {
    "joint-tee": (FOUR_ROUND, 336.0),
    "joint-tee-gap": (FOUR_ROUND, 336.0),
    "joint-tee-in-one": (FOUR_ROUND, 336.0),
    "joint-corner": ({("corner", "fillet"): 1, ("corner", "groove"): 3}, 2 * 200.0 + 2 * 8.0),
    "joint-open-corner": ({("corner", "fillet"): 2}, 400.0),
    "joint-butt": ({("butt", "groove"): 4}, 416.0),
    "joint-lap": ({("lap", "fillet"): 2, ("edge", "groove"): 2}, 200.0),
    "pin-flush": ({("corner", "fillet"): 1, ("corner", "groove"): 1}, 2 * 2 * math.pi * 5),
    "rod-through": ({("tee", "fillet"): 2}, 2 * 2 * math.pi * 30),
}
"""Saved graphs (`tests.samples.graphs`), the joints and welds on them, and the length of all seams, mm."""
WITH_ENDS = ("joint-tee", "joint-tee-gap", "joint-tee-in-one", "joint-corner", "joint-butt")
"""On these, two seams go across the ends of a plate beside long ones."""


@pytest.mark.parametrize("name", list(CASES))
def test_every_seam_is_found_and_named(name: str) -> None:
    expected, length = CASES[name]
    seams = saved_seams(name)
    assert Counter((seam.joint.value, seam.weld.value) for seam in seams) == expected
    assert sum(seam.length_mm for seam in seams) == pytest.approx(length, rel=0, abs=LENGTH_MM)
    ends = [round(seam.length_mm, 3) for seam in seams if not seam.accepted]
    assert ends == [8.0] * (2 if name in WITH_ENDS else 0)  # of the plate of 8 mm
    assert all(bool(seam.wrap_of) != seam.accepted for seam in seams)


def test_the_gap_is_reported() -> None:
    seams = saved_seams("joint-tee-gap")
    assert [seam.gap_mm for seam in seams] == [pytest.approx((0.4, 0.4, 0.4), rel=0, abs=1e-9)] * 4


def test_parts_that_do_not_touch_have_no_seam_within_the_given_gap() -> None:
    assert detect_seams(saved_graph("joint-tee-apart"), SeamOptions(gap_mm=0.5)) == ()
    assert [seam.gap_mm[0] for seam in saved_seams("joint-tee-apart")] == [pytest.approx(1.0, rel=0, abs=1e-9)] * 4


def test_the_saddle_has_an_outer_loop_and_an_inner_one_out_of_reach() -> None:
    outer, inner = saved_seams("saddle-90")
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


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("lap-in-one", {"lap": 2}),
        ("thick-tee-in-one", {"tee": 4}),  # also at the ends of the web
        ("bracket", {"lap": 2}),
    ],
)
def test_a_joint_inside_one_solid_has_the_word_of_two_solids(name: str, words: dict[str, int]) -> None:
    seams = detect_seams(saved_graph(name), SeamOptions(concave=ConcaveEdges.ALWAYS))
    assert Counter(seam.joint.value for seam in seams) == words
