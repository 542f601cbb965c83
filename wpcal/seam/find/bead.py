"""Modelled beads and rounds inside one solid: the seam is where the two faces beside the strip would meet.

The strip fills the corner between two faces. The curve in which their surfaces
meet is a line for two planes, and a circle for a plane across a cylinder. Otherwise it is computed point by point, in
planes across the side of the strip (`brep.meeting`). A cubic spline through the points is the curve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from wpcal.brep.concavity import LEAST_TURN_SIN
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.extend import FreeEdge, add_edges, arc, interpolated, line
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.meeting import meet_surfaces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.find.strips import WIDEST_MM, Strip, find_strips
from wpcal.seam.options import ConcaveEdges, SeamOptions
from wpcal.seam.seam import JointType, SeamPieces, WeldType

CURVE_POINTS = 513
"""Points of the spline. On an ellipse round a pipe of 60 mm it is then within 1e-7 mm of the curve, and its slope at an
end within 1e-6."""
ACROSS_SIN = 1e-6  #: A plane is across a cylinder if the sine between its normal and the axis is below this.


def add_beads(
    graph: BrepGraph, trimmed: TrimmedFaces, options: SeamOptions, may: Callable[[IntArray, IntArray], BoolArray]
) -> tuple[BrepGraph, JoinedPieces]:
    """Add the curves in which the faces beside beads and rounds meet, as edges without faces of their own.

    `may`: Tells between which pairs of faces, shape (n,) each, members may meet; with `ConcaveEdges.AUTO`, only beads
    between such faces are taken.
    Returns `pieces`: JoinedPieces. Wall and base are the faces beside the strips.
    """
    strips: list[Strip] = []
    if options.concave is not ConcaveEdges.NEVER:
        strips = find_strips(graph, trimmed, min_length_mm=options.min_edge_mm)
    if options.concave is ConcaveEdges.AUTO:
        sides = np.array([strip.sides for strip in strips], dtype=np.int64).reshape(-1, 2)
        strips = [strips[row] for row in np.flatnonzero(may(sides[:, 0], sides[:, 1])).tolist()]
    found = [(strip, edge) for strip in strips for edge in _meeting_edges(graph, strip)]
    wider, edges = add_edges(graph, [edge for _, edge in found])
    n = len(found)
    wall, base = (np.array([strip.sides[k] for strip, _ in found], dtype=np.int64) for k in (0, 1))
    t0, t1 = wider.edge_range[edges].T
    pieces = SeamPieces(edges, t0, t1, wall, base, np.zeros((n, 3)))
    return wider, JoinedPieces(pieces, (JointType.UNKNOWN,) * n, (WeldType.FILLET,) * n)


def _meeting_edges(graph: BrepGraph, strip: Strip) -> Iterator[FreeEdge]:
    """Yield, for each edge along the first side, the piece of the curve in which the two sides meet."""
    for edge in strip.edges[0]:
        t = np.linspace(graph.edge_range[edge, 0], graph.edge_range[edge, 1], CURVE_POINTS)
        p0, slope = evaluate_edges(graph, np.full(CURVE_POINTS, edge), t)
        p = _meet(graph, strip.sides, p0, slope)
        if p is None:
            continue
        kinds, axes = {int(graph.face_kind[side]) for side in strip.sides}, graph.face_frame[[*strip.sides], 3]
        if kinds == {SurfaceKind.PLANE}:
            yield line(p[0], p[-1])
        elif kinds == {SurfaceKind.PLANE, SurfaceKind.CYLINDER} and np.linalg.norm(np.cross(*axes)) <= ACROSS_SIN:
            yield _circle(graph, strip.sides, p)
        else:
            yield interpolated(p)


def _meet(graph: BrepGraph, sides: tuple[int, int], p0: FloatArray, slope: FloatArray) -> FloatArray | None:
    """Return where two surfaces meet across the points p0 (n, 3) of an edge, or None where they do not."""
    x = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    first, second = (np.full(len(p0), side) for side in sides)
    p = meet_surfaces(graph, np.stack([first, second]), p0, x, least_sin=LEAST_TURN_SIN)
    return p if np.linalg.norm(p - p0, axis=1).max() <= 2.0 * WIDEST_MM else None


def _circle(graph: BrepGraph, sides: tuple[int, int], p: FloatArray) -> FreeEdge:
    """Return the arc in which a plane cuts a cylinder across, from the first of the points p to the last."""
    plane, cylinder = sorted(sides, key=lambda side: int(graph.face_kind[side]))
    o, z = graph.face_frame[cylinder, 0], graph.face_frame[cylinder, 3]
    n = graph.face_frame[plane, 3]
    centre = o + float((graph.face_frame[plane, 0] - o) @ n) / float(z @ n) * z
    return arc(centre, z, p, float(graph.face_param[cylinder, 0]))
