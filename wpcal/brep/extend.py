"""Edges without a face, added to a graph: curves that were computed, not read from the file."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.nurbs import NurbsCurve
from wpcal.core.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class FreeEdge:
    """A piece of a curve."""

    kind: int
    frame: FloatArray  #: shape (4, 3). As `BrepGraph.edge_frame`.
    param: tuple[float, float]  #: As `BrepGraph.edge_param`.
    span: tuple[float, float]  #: First and last parameter.
    nurbs: NurbsCurve | None = None
    ball_mm: float = 0.0  #: As `BrepGraph.edge_ball_mm`.


def add_edges(graph: BrepGraph, edges: Sequence[FreeEdge]) -> tuple[BrepGraph, IntArray]:
    """Return the graph with more edges, and the numbers of these edges."""
    n = len(edges)
    curves = [edge.nurbs for edge in edges if edge.nurbs is not None]
    has_curve = np.array([edge.nurbs is not None for edge in edges], dtype=bool)
    index = np.where(has_curve, np.cumsum(has_curve) - 1 + len(graph.nurbs_curves), -1)
    frames = np.array([edge.frame for edge in edges], dtype=np.float64).reshape(n, 4, 3)
    params = np.array([edge.param for edge in edges], dtype=np.float64).reshape(n, 2)
    wider = graph.with_columns(
        edge_kind=np.append(graph.edge_kind, [int(edge.kind) for edge in edges]).astype(np.int64),
        edge_frame=np.concatenate([graph.edge_frame, frames]),
        edge_param=np.concatenate([graph.edge_param, params]),
        edge_nurbs=np.append(graph.edge_nurbs, index).astype(np.int64),
        edge_range=np.concatenate([graph.edge_range, np.array([e.span for e in edges]).reshape(n, 2)]),
        edge_vertices=np.concatenate([graph.edge_vertices, np.full((n, 2), -1, dtype=np.int64)]),
        edge_ball_mm=np.append(graph.balls_mm, [edge.ball_mm for edge in edges]),
        **({"nurbs_curves": (*graph.nurbs_curves, *curves)} if curves else {}),
    )
    return wider, np.arange(graph.edge_count, graph.edge_count + n)


def line(p0: FloatArray, p1: FloatArray) -> FreeEdge:
    """Return the straight edge between two points. `p0`, `p1`: shape (3,). In `part`, mm."""
    length = float(np.linalg.norm(p1 - p0))
    frame = np.stack([p0, (p1 - p0) / length, np.zeros(3), np.zeros(3)])
    return FreeEdge(CurveKind.LINE, frame, (0.0, 0.0), (0.0, length))


def arc(centre: FloatArray, z: FloatArray, points: FloatArray, radius: float) -> FreeEdge:
    """Return the arc round an axis from the first of some points of its circle, shape (n, 3), to the last."""
    arm = points - centre
    x = arm[0] / np.linalg.norm(arm[0])
    y = np.cross(z, x)
    turn = float(np.unwrap(np.arctan2(arm @ y, arm @ x))[-1])
    if turn < 0:
        z, y, turn = -z, -y, -turn
    return FreeEdge(CurveKind.CIRCLE, np.stack([centre, x, y, z]), (radius, radius), (0.0, turn))


def interpolated(points: FloatArray) -> FreeEdge:
    """Return the cubic spline through points; its parameter is the length of the chords.

    `points`: shape (n, 3). At least four points in `part`, mm.
    """
    from scipy.interpolate import make_interp_spline

    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    spline = make_interp_spline(s, points, k=3)
    curve = NurbsCurve(3, spline.t, spline.c, np.ones(len(spline.c)))
    frame = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    return FreeEdge(CurveKind.NURBS, frame, (0.0, 0.0), (0.0, float(s[-1])), curve)
