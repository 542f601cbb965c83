"""Refuse a part that is nowhere: a damaged file can place faces, curves and points at infinity."""

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.core.arrays import LARGEST_MM, BoolArray, FloatArray, IntArray
from wpcal.core.errors import GeometryError
from wpcal.core.wording import listed


def require_finite(graph: BrepGraph) -> None:
    """Refuse a part with a face, an edge or a vertex that is not at a finite place within `LARGEST_MM`.

    Raises `GeometryError` with the names of the solids.
    """
    wrong = np.zeros(len(graph.solid_names) + 1, dtype=bool)  # the last is for what belongs to no solid
    wrong[graph.face_solid[~_are_near(graph.face_frame, graph.face_param)]] = True
    for face in np.flatnonzero(graph.face_nurbs >= 0).tolist():
        surface = graph.nurbs_surfaces[graph.face_nurbs[face]]
        wrong[graph.face_solid[face]] |= not _are_numbers(
            surface.poles, surface.weights, surface.knots_u, surface.knots_v
        )
    wrong[graph.edge_solid[~_edges_are_near(graph)]] = True
    wrong[graph.vertex_solid[~_are_near(graph.vertex_p)]] = True
    if wrong.any():
        names = listed(graph.solid_names[number] for number in np.flatnonzero(wrong[:-1]))
        where = f" in {names}" if names else ""
        what = f"geometry{where} is infinite or farther away than {LARGEST_MM:g} mm"
        raise GeometryError(f"{what}; the file is damaged there: export the part again")


def _edges_are_near(graph: BrepGraph) -> BoolArray:
    """Tell which edges are at finite places, at both ends and in the middle; shape (E,)."""
    near = np.asarray(np.isfinite(graph.edge_range).all(axis=1), dtype=bool)
    for edge in np.flatnonzero(graph.edge_nurbs >= 0).tolist():
        curve = graph.nurbs_curves[graph.edge_nurbs[edge]]
        near[edge] &= _are_numbers(curve.poles, curve.weights, curve.knots)
    near &= _are_near(graph.edge_frame, graph.edge_param)
    rows: IntArray = np.flatnonzero(near & (graph.edge_kind != CurveKind.DEGENERATE))
    first, last = graph.edge_range[rows].T
    for t in (first, first / 2 + last / 2, last):
        near[rows] &= _are_near(evaluate_edges(graph, rows, t)[0])
    return near


def _are_near(*arrays: FloatArray) -> BoolArray:
    """Tell in which rows of all arrays every number is finite and at most `LARGEST_MM`; shape (n,)."""
    rows = [np.abs(array).max(axis=tuple(range(1, array.ndim)), initial=0.0) <= LARGEST_MM for array in arrays]
    return np.asarray(np.logical_and.reduce(rows), dtype=bool)  # NaN is not <=


def _are_numbers(*arrays: FloatArray) -> bool:
    return all(bool((np.abs(array) <= LARGEST_MM).all()) for array in arrays)
