"""Modelled beads and rounds: the seam is where the faces beside them would meet, against closed forms."""

import math
from typing import Any

import numpy as np
import pytest

from cad.kernel.to_brep import to_brep
from cad.kernel.topology import EDGE, SOLID, sub_shape_uses
from cad.samples.parts import box, cut, cylinder
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece
from wpcal.brep import CurveKind
from wpcal.brep.curves import evaluate_edges
from wpcal.core.arrays import FloatArray
from wpcal.seam import ConcaveEdges, Seam, SeamOptions, SeamSource
from wpcal.seam.find.bead import find_strips

EXACT_MM = 1e-9
"""Lines and circles are closed form; the ends are those of the bead's side, good to the kernel's 1e-12."""
EXACT_RAD = 1e-9
CURVE_MM = 1e-6
"""A spline through points that Newton's method finds; between them it is this near to the curve."""
FRAME_RAD = 1e-6


def rounded(shape: Any, radius: float, on_edge: Any) -> Any:
    """Lay a round along the edges whose middle point `on_edge` takes."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet

    fillet = BRepFilletAPI_MakeFillet(shape)
    for edge, _ in sub_shape_uses(shape, EDGE):
        curve = BRepAdaptor_Curve(edge)
        p = curve.Value((curve.FirstParameter() + curve.LastParameter()) / 2)
        if on_edge(p.X(), p.Y(), p.Z()):
            fillet.Add(radius, edge)
    ((solid, _),) = sub_shape_uses(fillet.Shape(), SOLID)
    return solid


def fused(a: Any, b: Any) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

    ((solid, _),) = sub_shape_uses(BRepAlgoAPI_Fuse(a, b).Shape(), SOLID)
    return solid


def tee(radius: float = 6.0) -> Any:
    """A web of 8 mm across the whole plate, with a bead of 6 mm on both sides."""
    shape = fused(box(200, 100, 10, (0, 0, 0)), box(200, 8, 80, (0, 46, 10)))
    return rounded(shape, radius, lambda x, y, z: abs(z - 10) < 1e-6 and abs(abs(y - 50) - 4) < 1e-6 and 1 < x < 199)


def pipe_on_plate(tilt_deg: float = 0.0) -> Any:
    """A pipe of 60 mm on a plate, with a bead of 5 mm round it; only what stands above the plate is kept."""
    tilt = math.radians(tilt_deg)
    axis = (math.sin(tilt), 0.0, math.cos(tilt))
    origin = tuple(-60 * v for v in axis)
    pipe = cut(cylinder(30, 160, origin, axis), box(400, 400, 100, (-200, -200, -100)))
    shape = fused(box(200, 200, 10, (-100, -100, -10)), pipe)

    def at_root(x: float, y: float, z: float) -> bool:
        return abs(z) < 1e-6 and math.hypot(x, y) < 60

    return cut(rounded(shape, 5.0, at_root), cylinder(27, 300, tuple(-150 * v for v in axis), axis))


def seams_of(shape: Any, concave: ConcaveEdges = ConcaveEdges.AUTO) -> tuple[Any, list[Seam]]:
    graph = to_brep([("part", shape)])
    found, wider = find_seams(Workpiece(graph, (), solids=(shape,)), SeamOptions(concave=concave))
    return wider.graph, [seam for seam in found if seam.source is SeamSource.BEAD]


def test_the_beads_of_a_tee_are_two_lines_at_the_root() -> None:
    _, seams = seams_of(tee())
    assert [seam.accepted for seam in seams] == [True, True]
    for seam, y, side in zip(seams, (46.0, 54.0), (-1.0, 1.0), strict=True):
        assert seam.length_mm == pytest.approx(200.0, rel=0, abs=EXACT_MM)
        p = seam.frames.p
        np.testing.assert_allclose(p[[0, -1]], [[0, y, 10], [200, y, 10]], rtol=0, atol=EXACT_MM)
        z = np.array([0.0, side, 1.0]) / math.sqrt(2)
        np.testing.assert_allclose(seam.frames.R[:, :, 2], np.broadcast_to(z, p.shape), rtol=0, atol=EXACT_RAD)
        np.testing.assert_allclose(seam.frames.angle_rad, math.pi / 2, rtol=0, atol=EXACT_RAD)


def test_the_bead_round_a_pipe_is_a_circle() -> None:
    graph, (seam,) = seams_of(pipe_on_plate())
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
    graph, seams = seams_of(pipe_on_plate(25.0))
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
    bent = rounded(box(100, 60, 40, (0, 0, 0)), 5.0, lambda x, y, z: abs(z - 40) < 1e-6)
    assert find_strips(to_brep([("block", bent)])) == []


def test_beads_are_asked_for_as_concave_edges_are() -> None:
    assert seams_of(tee(), ConcaveEdges.NEVER)[1] == []
    beside = to_brep([("tee", tee()), ("block", box(50, 50, 50, (0, 0, -50)))])
    workpiece = Workpiece(beside, (), solids=())
    auto, _ = find_seams(workpiece, SeamOptions())
    always, _ = find_seams(workpiece, SeamOptions(concave=ConcaveEdges.ALWAYS))
    assert not any(seam.source is SeamSource.BEAD for seam in auto)
    assert sum(seam.source is SeamSource.BEAD for seam in always) == 2
