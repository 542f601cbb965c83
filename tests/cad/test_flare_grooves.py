"""Flare grooves beside the radii of tubes and bars: path, frame, ends and depth against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from build123d import Solid
from scipy.optimize import brentq

from cad.kernel.geometry import to_location
from cad.kernel.primitives import ring
from cad.kernel.to_brep import to_brep
from tests.few import few
from tests.samples.flares import (
    SIDE_MM,
    Solids,
    bar_on_plate,
    flush_tubes,
    half_ring_on_plate,
    plate_along_pipe,
    rack_of_bars,
    ring_round_a_pipe,
    rising_bar,
    roller_bearing,
    round_tubes,
    tubes_side_by_side,
    u_bar_on_plate,
    wheel_on_rail,
)
from tests.samples.graphs import nothing_crosses
from wpcal.brep import BrepGraph, CurveKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam, SeamOptions, SeamSource, WeldType, detect_seams
from wpcal.seam.find.flare_grooves import add_grooves
from wpcal.seam.search import find_part_candidates

EXACT = 1e-6  #: mm, or rad: lines and circles through points that Newton's method finds to round-off.
POSES = [[700, -300, 40, 0.4, -1.1, 2.0], [0, 0, 0, 0, 0, 0]]  #: Turned about all axes, and as drawn, mm and rad.
WIRE, NOZZLE, FREE_WIRE = 0.6, 11.0, 20.0
"""Radii of the wire's ball and of the nozzle, and how far the wire is out of the nozzle, mm."""


def grooves_of(solids: Solids, pose: list[float]) -> tuple[BrepGraph, list[Seam]]:
    """Return the seams in flare grooves of a part that was moved, their frames moved back."""
    T = RigidTransform.from_six_tuple(pose, target="base", source="part")
    graph, options = to_brep([(name, shape.Moved(to_location(T))) for name, shape in solids]), SeamOptions()
    trimmed = TrimmedFaces.of(graph)
    wider, flares = add_grooves(graph, trimmed, options)
    found = detect_seams(wider, options, trimmed=replace(trimmed, graph=wider), flares=flares)
    seams = [replace(seam, frames=seam.frames.moved(T.inverse())) for seam in found if seam.source is SeamSource.FLARE]
    return wider, seams


def check(seam: Seam, ends: list[list[float]], z: FloatArray) -> None:
    """Compare a straight seam with its ends, in either direction, and its z with a vector."""
    p = seam.frames.p
    ends_found = p[[0, -1]] if np.linalg.norm(p[0] - ends[0]) < np.linalg.norm(p[0] - ends[1]) else p[[-1, 0]]
    np.testing.assert_allclose(ends_found, ends, rtol=0, atol=EXACT)
    x = (p[-1] - p[0]) / np.linalg.norm(p[-1] - p[0])
    np.testing.assert_allclose(seam.frames.R[:, :, 0], np.broadcast_to(x, p.shape), rtol=0, atol=EXACT)
    unit = np.asarray(z) / np.linalg.norm(z)
    np.testing.assert_allclose(seam.frames.R[:, :, 2], np.broadcast_to(unit, p.shape), rtol=0, atol=EXACT)
    assert seam.length_mm == pytest.approx(math.dist(*ends), rel=0, abs=EXACT)


@pytest.mark.parametrize("pose", few(POSES, 1))
@pytest.mark.parametrize(("radius", "wall", "ball"), few([(2.0, 1.0, 0.495), (6.1, 3.05, 0.6), (10.0, 5.0, 1.0)], 1))
def test_flush_tubes_have_a_flare_bevel_on_both_sides(
    radius: float, wall: float, ball: float, pose: list[float]
) -> None:
    """On 2 mm the wire stays in the mouth; on 10 mm the wall ends so far from the root that it would fall in."""
    _, seams = grooves_of(flush_tubes(radius, wall), pose)
    out = 2.0 * math.sqrt(radius * ball)
    inset = radius - math.sqrt(radius**2 - out**2)
    assert [(seam.weld, seam.joint.value, seam.accepted) for seam in seams] == 2 * [
        (WeldType.FLARE_BEVEL, "corner", True)
    ]
    seams.sort(key=lambda seam: float(seam.frames.p[0, 1]))
    for seam, y, side in zip(seams, (radius - out, SIDE_MM - radius + out), (-1.0, 1.0), strict=True):
        ends = [[SIDE_MM - ball, y, 100.0 + inset], [SIDE_MM - ball, y, 100.0 + SIDE_MM - inset]]
        mouth = [SIDE_MM - radius / 4, 0.0 if side < 0 else SIDE_MM, ends[0][2]]
        check(seam, ends, np.array(mouth) - ends[0])
        assert seam.groove.depth_mm == pytest.approx(radius, rel=0, abs=EXACT)
        assert seam.groove.opening_mm == pytest.approx(radius, rel=0, abs=1e-3)
        assert seam.groove.root_mm == pytest.approx(out, rel=0, abs=EXACT)


def test_flush_tubes_that_are_one_body_have_the_same_grooves() -> None:
    solids = flush_tubes(10.0, 5.0)
    graph = to_brep([("body", Solid(solids[0][1]).fuse(Solid(solids[1][1])).clean().solid().wrapped)])
    found = find_part_candidates(graph, TrimmedFaces.of(graph), SeamOptions(), cross=nothing_crosses)
    seams = [seam for seam in found.judged(SeamOptions()) if seam.source is SeamSource.FLARE and seam.accepted]
    for one, other in zip(seams, grooves_of(solids, POSES[1])[1], strict=True):
        np.testing.assert_allclose(one.frames.p[[0, -1]], other.frames.p[[0, -1]], rtol=0, atol=EXACT)


@pytest.mark.parametrize("pose", few(POSES, 1))
@pytest.mark.parametrize(("radius", "gap"), few([(6.0, 0.0), (9.0, 0.3)], 1))
def test_tubes_side_by_side_have_a_flare_v_above_and_below(radius: float, gap: float, pose: list[float]) -> None:
    _, seams = grooves_of(tubes_side_by_side(radius, gap), pose)
    assert [(seam.weld, seam.joint.value, seam.accepted) for seam in seams] == 2 * [(WeldType.FLARE_V, "butt", True)]
    seams.sort(key=lambda seam: float(seam.frames.p[0, 2]))
    out = math.sqrt((radius + WIRE) ** 2 - (radius + gap / 2) ** 2)
    for seam, z, side in zip(seams, (radius - out, SIDE_MM - radius + out), (-1.0, 1.0), strict=True):
        check(seam, [[0.0, gap / 2, z], [200.0, gap / 2, z]], np.array([0.0, 0.0, side]))
        assert seam.groove.depth_mm == pytest.approx(radius, rel=0, abs=EXACT)


@pytest.mark.parametrize("pose", few(POSES, 1))
@pytest.mark.parametrize(("radius", "gap"), few([(4.0, 0.0), (8.0, 0.2), (30.0, 0.0)], 1))
def test_a_round_bar_along_a_plate_has_a_groove_on_both_sides(radius: float, gap: float, pose: list[float]) -> None:
    _, seams = grooves_of(bar_on_plate(radius, gap), pose)
    assert [(seam.weld, seam.joint.value, seam.accepted) for seam in seams] == 2 * [(WeldType.FLARE_BEVEL, "tee", True)]
    seams.sort(key=lambda seam: float(seam.frames.p[0, 1]))

    def centre(ball: float) -> FloatArray:
        return np.array([0.0, math.sqrt((2 * radius + gap) * (2 * ball - gap)), ball])

    def too_far(ball: float) -> float:
        return math.dist(centre(ball), centre(NOZZLE)) - FREE_WIRE

    wire = centre(WIRE if too_far(WIRE) < 0 else brentq(too_far, WIRE, NOZZLE, xtol=1e-12))
    mouth = centre(brentq(lambda ball: math.dist(wire, centre(ball)) - FREE_WIRE, WIRE, 20.0, xtol=1e-12))
    for seam, side in zip(seams, (-1.0, 1.0), strict=True):
        y = np.array([1.0, side, 1.0])
        check(seam, [(wire * y).tolist(), (wire * y + [120.0, 0.0, 0.0]).tolist()], (mouth - wire) * y)
        assert seam.gap_mm == pytest.approx((gap, gap, gap), rel=0, abs=EXACT)
        assert seam.groove.depth_mm == pytest.approx(radius, rel=0, abs=EXACT)


@pytest.mark.parametrize("pose", few(POSES, 1))
def test_round_tubes_that_touch_have_a_flare_v_on_both_sides(pose: list[float]) -> None:
    _, seams = grooves_of(round_tubes(30.0, 20.0), pose)
    assert [seam.weld for seam in seams] == [WeldType.FLARE_V] * 2

    def centre(ball: float) -> tuple[float, float]:
        a, b, c = 30.0 + ball, 20.0 + ball, 50.0
        up = (a**2 + c**2 - b**2) / (2 * c)
        return math.sqrt(a**2 - up**2), up

    out, up = centre(brentq(lambda ball: math.dist(centre(ball), centre(NOZZLE)) - FREE_WIRE, 0.1, 5.0, xtol=1e-12))
    assert sorted(round(float(seam.frames.p[0, 1]), 6) for seam in seams) == [round(-out, 6), round(out, 6)]
    for seam in seams:
        np.testing.assert_allclose(seam.frames.p[:, 2], up, rtol=0, atol=EXACT)
        assert sorted(seam.frames.p[[0, -1], 0]) == pytest.approx([20.0, 150.0], rel=0, abs=EXACT)


@pytest.mark.parametrize("pose", few(POSES, 1))
def test_half_a_ring_on_a_plate_has_arcs_inside_and_outside(pose: list[float]) -> None:
    graph, seams = grooves_of(half_ring_on_plate(40.0, 6.0), pose)
    assert [(seam.weld, seam.accepted) for seam in seams] == [(WeldType.FLARE_BEVEL, True)] * 2
    assert (graph.edge_kind[[seam.pieces.edge[0] for seam in seams]] == CurveKind.CIRCLE).all()
    out = 2.0 * math.sqrt(6.0 * WIRE)
    for seam, radius in zip(sorted(seams, key=lambda seam: seam.length_mm), (40.0 - out, 40.0 + out), strict=True):
        p, x, z = seam.frames.p, seam.frames.R[:, :, 0], seam.frames.R[:, :, 2]
        np.testing.assert_allclose(np.hypot(p[:, 0], p[:, 1]), radius, rtol=0, atol=EXACT)
        np.testing.assert_allclose(p[:, 2], WIRE, rtol=0, atol=EXACT)
        assert p[:, 1].min() == pytest.approx(0.0, rel=0, abs=EXACT)
        assert seam.length_mm == pytest.approx(math.pi * radius, rel=0, abs=EXACT)
        away = p * [1.0, 1.0, 0.0] / radius * np.sign(radius - 40.0)
        mouth = brentq(lambda ball: math.hypot(2 * math.sqrt(6 * ball) - out, ball - WIRE) - FREE_WIRE, WIRE, 20.0)
        side, up = (2 * math.sqrt(6 * mouth) - out) / FREE_WIRE, (mouth - WIRE) / FREE_WIRE
        np.testing.assert_allclose(z, side * away + [0.0, 0.0, up], rtol=0, atol=EXACT)
        np.testing.assert_allclose(np.einsum("ki,ki->k", x, p), WIRE * x[:, 2], rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("solids", "words"),
    few([(wheel_on_rail(), "on a shaft"), (roller_bearing(), "rollers"), (rack_of_bars(4), "stock")], 1),
)
def test_what_rolls_or_lies_loose_is_not_welded(solids: Solids, words: str) -> None:
    _, seams = grooves_of(solids, POSES[0])
    assert seams
    assert not any(seam.accepted for seam in seams)
    assert all(any(words in text for text in seam.against) for seam in seams)


def test_two_bars_on_a_plate_are_welded() -> None:
    """Of the three grooves on either side, a torch gets to those outside and to that between the bars from above."""
    _, seams = grooves_of(rack_of_bars(2), POSES[1])
    assert [seam.accepted for seam in seams if seam.reachable] == [True] * 3


def test_a_ring_round_a_pipe_has_a_groove_above_and_below() -> None:
    graph, seams = grooves_of(ring_round_a_pipe(), POSES[0])
    assert [(seam.weld, seam.closed, seam.accepted) for seam in seams] == [(WeldType.FLARE_V, True, True)] * 2
    assert (graph.edge_kind[[seam.pieces.edge[0] for seam in seams]] == CurveKind.CIRCLE).all()
    out = 2.0 * math.sqrt(4.0 * WIRE)
    for seam, z in zip(sorted(seams, key=lambda seam: float(seam.frames.p[0, 2])), (50 - out, 50 + out), strict=True):
        np.testing.assert_allclose(np.hypot(*seam.frames.p[:, :2].T), 30.0 + WIRE, rtol=0, atol=EXACT)
        np.testing.assert_allclose(seam.frames.p[:, 2], z, rtol=0, atol=EXACT)


def test_rings_whose_faces_have_no_border_have_a_groove_inside_and_outside() -> None:
    _, seams = grooves_of([(f"ring at {z:g}", ring(50.0, 5.0, (0.0, 0.0, z))) for z in (0.0, 10.0)], POSES[0])
    assert [(seam.weld, seam.closed) for seam in seams] == [(WeldType.FLARE_V, True)] * 2


def test_a_bent_bar_has_one_seam_inside_and_one_outside() -> None:
    _, seams = grooves_of(u_bar_on_plate(), POSES[1])
    out = 2.0 * math.sqrt(6.0 * WIRE)
    assert [seam.accepted for seam in seams] == [True, True]
    assert not any("joined" in text for seam in seams for text in seam.reasons)  # pieces that meet are no bridge
    lengths = sorted(seam.length_mm for seam in seams)
    assert lengths == pytest.approx([120 + math.pi * (40 - out), 120 + math.pi * (40 + out)], rel=0, abs=EXACT)


def test_a_bar_that_leaves_a_plate_is_welded_until_the_gap_is_too_wide() -> None:
    """The gap of 0.5 mm is where the axis is so high, measured across the bar."""
    slope = 0.003
    _, seams = grooves_of(rising_bar(slope), POSES[0])
    assert len(seams) == 2
    for seam in seams:
        s = 0.5 / math.sin(slope)  # along the axis: 10 cos + s sin = 10 + gap; 10 (1 - cos) is 4.5e-5 mm
        far = seam.frames.p[np.argmax(seam.frames.p[:, 0])]
        assert far[0] == pytest.approx(s, rel=0, abs=0.1)
        assert seam.gap_mm == pytest.approx((0.0, 0.25, 0.5), rel=0, abs=1e-3)


@pytest.mark.parametrize("pose", few(POSES, 1))
def test_a_plate_along_a_pipe_has_a_fillet_at_either_rim(pose: list[float]) -> None:
    """The gap at the rims, 1 mm, is closed behind: the edge of the plate lies on the pipe in its middle."""
    radius, thickness = 24.0, 14.0
    _, seams = grooves_of(plate_along_pipe(radius, thickness), pose)
    assert [(seam.weld.value, seam.joint.value, seam.accepted) for seam in seams] == [("fillet", "tee", True)] * 2
    for seam in seams:
        y = math.copysign(thickness / 2, float(seam.frames.p[0, 1]))
        away = math.hypot(y, radius)
        z = np.array([0.0, math.copysign(1.0, y) + y / away, radius / away])
        check(seam, [[0.0, y, radius], [200.0, y, radius]], z)
        assert seam.groove.opening_mm == pytest.approx(radius - math.sqrt(radius**2 - y**2), rel=0, abs=EXACT)
