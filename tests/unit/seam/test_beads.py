"""Modelled beads and rounds: the seam is where the faces beside them would meet, against closed forms."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph, CurveKind
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.seam import ConcaveEdges, Seam, SeamOptions, SeamSource, detect_seams
from wpcal.seam.find.bead import add_beads
from wpcal.seam.find.strips import find_strips
from wpcal.seam.member.one_piece import are_welded_corners

EXACT_MM = 1e-9
"""Lines and circles are closed form; the ends are those of the bead's side, good to the kernel's 1e-12."""
EXACT_RAD = 1e-9
CURVE_MM = 1e-6  #: A spline through points that Newton's method finds; between them it is this near to the curve.
FRAME_RAD = 1e-6


def seams_of(name: str, concave: ConcaveEdges = ConcaveEdges.AUTO) -> tuple[BrepGraph, list[Seam]]:
    graph, options = saved_graph(name), SeamOptions(concave=concave)
    trimmed = TrimmedFaces.of(graph)
    wider, beads = add_beads(
        graph, trimmed, options, partial(are_welded_corners, graph, trimmed, gap_mm=options.gap_for(graph))
    )
    found = detect_seams(wider, options, trimmed=replace(trimmed, graph=wider), beads=beads)
    return wider, [seam for seam in found if seam.source is SeamSource.BEAD]


def test_the_beads_of_a_tee_are_two_lines_at_the_root() -> None:
    _, seams = seams_of("bead-tee")
    assert [seam.accepted for seam in seams] == [True, True]
    for seam, y, side in zip(seams, (46.0, 54.0), (-1.0, 1.0), strict=True):
        assert seam.length_mm == pytest.approx(200.0, rel=0, abs=EXACT_MM)
        p = seam.frames.p
        np.testing.assert_allclose(p[[0, -1]], [[0, y, 10], [200, y, 10]], rtol=0, atol=EXACT_MM)
        z = np.array([0.0, side, 1.0]) / math.sqrt(2)
        np.testing.assert_allclose(seam.frames.R[:, :, 2], np.broadcast_to(z, p.shape), rtol=0, atol=EXACT_RAD)
        np.testing.assert_allclose(seam.frames.angle_rad, math.pi / 2, rtol=0, atol=EXACT_RAD)


def test_the_bead_round_a_pipe_is_a_circle() -> None:
    graph, (seam,) = seams_of("bead-pipe")
    assert (seam.closed, seam.accepted) == (True, True)
    assert (graph.edge_kind[seam.pieces.edge] == CurveKind.CIRCLE).all()
    assert seam.length_mm == pytest.approx(2 * math.pi * 30, rel=0, abs=EXACT_MM)
    p = seam.frames.p
    np.testing.assert_allclose(np.hypot(p[:, 0], p[:, 1]), 30.0, rtol=0, atol=EXACT_MM)
    np.testing.assert_allclose(p[:, 2], 0.0, rtol=0, atol=EXACT_MM)
    z = np.column_stack([p[:, :2] / 30, np.ones(len(p))]) / math.sqrt(2)
    np.testing.assert_allclose(seam.frames.R[:, :, 2], z, rtol=0, atol=EXACT_RAD)


def test_the_bead_round_a_leaning_pipe_is_an_ellipse() -> None:
    tilt = math.radians(25.0)
    graph, seams = seams_of("bead-leaning-pipe")
    (seam,) = seams
    assert seam.closed
    pieces = seam.pieces
    for edge, t0, t1 in zip(pieces.edge, pieces.t0, pieces.t1, strict=True):
        p = evaluate_edges(graph, np.full(999, edge), np.linspace(t0, t1, 999))[0]
        np.testing.assert_allclose(p[:, 2], 0.0, rtol=0, atol=CURVE_MM)
        np.testing.assert_allclose(np.hypot(p[:, 0] * math.cos(tilt), p[:, 1]), 30.0, rtol=0, atol=CURVE_MM)
    z = bisector_on_leaning_pipe(seam.frames.p, tilt)
    np.testing.assert_allclose(seam.frames.R[:, :, 2], z, rtol=0, atol=FRAME_RAD)


def bisector_on_leaning_pipe(p: FloatArray, tilt: float) -> FloatArray:
    axis = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    n = p - (p @ axis)[:, None] * axis
    z = n / np.linalg.norm(n, axis=1, keepdims=True) + np.array([0.0, 0.0, 1.0])
    return np.asarray(z / np.linalg.norm(z, axis=1, keepdims=True))


def test_rounds_on_outer_edges_and_bends_are_no_beads() -> None:
    graph = saved_graph("bent-block")
    assert find_strips(graph, TrimmedFaces.of(graph)) == []


def test_beads_are_asked_for_as_concave_edges_are() -> None:
    assert seams_of("bead-tee", ConcaveEdges.NEVER)[1] == []
    for concave in (ConcaveEdges.AUTO, ConcaveEdges.ALWAYS):
        assert len(seams_of("bead-tee-beside-block", concave)[1]) == 2
