"""Nearest points on edges' whole curves, many at once: closed form on lines and circles, Newton on the others."""

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.core.arrays import FloatArray, IntArray

SEEDS = 65
"""Samples; Newton starts at the nearest one. That is more than four per half wave of any edge that is one curve."""
MOST_STEPS = 40  #: For a point nearer than the radius of the curve, each Gauss-Newton step gains one digit or more.


def project_to_edges(graph: BrepGraph, edges: IntArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Find the nearest point of each edge's curve to a point.

    `edges`: ndarray of int, shape (m,)
    `points`: shape (m, 3). In `part`, mm.

    Returns `p`: shape (m, 3). In `part`, mm. Lines and circles extend beyond the ends of the edge; other curves end
    there.
    Returns `tangent`: shape (m, 3). Unit tangents.
    """
    kind = graph.edge_kind[edges]
    origin, x, _, z = np.moveaxis(graph.edge_frame[edges], 1, 0)
    off = points - origin
    p, tangent = np.empty_like(points), np.empty_like(points)
    line, circle = kind == CurveKind.LINE, kind == CurveKind.CIRCLE
    along = np.einsum("mi,mi->m", off, x)
    p[line], tangent[line] = (origin + along[:, None] * x)[line], x[line]
    flat = off - np.einsum("mi,mi->m", off, z)[:, None] * z
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    out = np.where(length > 0, flat / np.where(length > 0, length, 1.0), x)
    p[circle] = (origin + graph.edge_param[edges, :1] * out)[circle]
    tangent[circle] = np.cross(z, out)[circle]
    other = np.flatnonzero(~line & ~circle)
    if len(other):
        p[other], tangent[other] = _by_newton(graph, edges[other], points[other])
    return p, tangent


def _by_newton(graph: BrepGraph, edges: IntArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    first, last = graph.edge_range[edges].T
    t = first[:, None] + (last - first)[:, None] * np.linspace(0.0, 1.0, SEEDS)
    samples = evaluate_edges(graph, np.repeat(edges, SEEDS), t.ravel())[0].reshape(len(edges), SEEDS, 3)
    nearest = np.argmin(np.sum((samples - points[:, None]) ** 2, axis=2), axis=1)
    at = t[np.arange(len(edges)), nearest]
    for _ in range(MOST_STEPS):
        p, slope = evaluate_edges(graph, edges, at)
        step = np.einsum("mi,mi->m", points - p, slope) / np.einsum("mi,mi->m", slope, slope)
        at = np.clip(at + step, first, last)
    p, slope = evaluate_edges(graph, edges, at)
    return p, slope / np.linalg.norm(slope, axis=1, keepdims=True)
