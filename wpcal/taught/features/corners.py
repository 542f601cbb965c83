"""Corners, ends and middles of edges, and virtual corners, which a round replaced."""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.taught.features.columns import NAMING_MM, FeatureColumns, first_rows, label_equal, positive_axes
from wpcal.taught.features.reference import FeatureKind
from wpcal.taught.features.slots import TANGENT_COS

LEAST_EDGE_MM = 5.0  #: With the tip of a wire, the middle of a shorter edge cannot be distinguished from its ends.
LEAST_CORNER_EDGES = 3  #: Edges that meet in a corner; only two meet where a circle closes or a curve is split.
LEAST_SPREAD = 0.1
"""Least singular value of the normals at a corner. With a smaller one (faces 8 degrees from smooth), round-off decides
the place of a virtual corner, and a tip slides along an edge."""
FARTHEST_RADII = 10.0
"""Largest distance of a virtual corner from its round, in radii: 9.5 if the faces meet at 11 degrees."""


def find_vertices(graph: BrepGraph) -> FeatureColumns:
    """Find the vertices where at least three edges meet."""
    corners = np.flatnonzero(_edges_at_vertices(graph) >= LEAST_CORNER_EDGES)
    return FeatureColumns(kind=FeatureKind.VERTEX, p=graph.vertex_p[corners], solid=graph.vertex_solid[corners])


def _edges_at_vertices(graph: BrepGraph) -> IntArray:
    real = (graph.edge_kind != CurveKind.DEGENERATE) & ~graph.is_seam_edge
    ends = graph.edge_vertices[real].ravel()
    return np.asarray(np.bincount(ends[ends >= 0], minlength=len(graph.vertex_p)), dtype=np.int64)


def _straight_edges(graph: BrepGraph) -> IntArray:
    straight = (graph.edge_kind == CurveKind.LINE) & ~graph.is_seam_edge & (graph.edge_solid >= 0)
    long_enough = np.ptp(graph.edge_range, axis=1) >= LEAST_EDGE_MM  # the parameter of a line is its length
    return np.asarray(np.flatnonzero(straight & long_enough), dtype=np.int64)


def find_midpoints(graph: BrepGraph) -> FeatureColumns:
    """Find the middles of straight edges of at least `LEAST_EDGE_MM`."""
    lines = _straight_edges(graph)
    p, slope = evaluate_edges(graph, lines, graph.edge_range[lines].mean(axis=1))
    return FeatureColumns(
        kind=FeatureKind.EDGE_MIDPOINT,
        p=p,
        solid=graph.edge_solid[lines],
        direction=positive_axes(slope),
        length_mm=np.ptp(graph.edge_range[lines], axis=1),
    )


def find_edge_ends(graph: BrepGraph) -> FeatureColumns:
    """Find the ends of straight edges of at least `LEAST_EDGE_MM` that are not corners.

    There the edge continues as an arc or a curve, or a sheet ends.
    """
    lines = _straight_edges(graph)
    vertex, row = np.unique(graph.edge_vertices[lines].ravel(), return_index=True)
    edge = np.repeat(lines, 2)[row]
    count = np.append(_edges_at_vertices(graph), LEAST_CORNER_EDGES)  # no vertex, -1, is the last
    free = count[vertex] < LEAST_CORNER_EDGES
    vertex, edge = vertex[free], edge[free]
    return FeatureColumns(
        kind=FeatureKind.EDGE_END,
        p=graph.vertex_p[vertex],
        solid=graph.vertex_solid[vertex],
        direction=positive_axes(graph.edge_frame[edge, 1]),
    )


def find_virtual_corners(graph: BrepGraph) -> FeatureColumns:
    """Find the corners that rounds replaced: where three planes around the end of a round meet.

    A round is a convex cylinder face that two plane faces continue. The third plane is the plane where the round ends.
    If the round ends at a patch or an edge, the other rounds there give the third plane. The faces of the feature are
    the three planes; its diameter is that of the smallest round.
    """
    rounds, planes = _rounds(graph)
    patch, end, plane = _planes_at_ends(graph, rounds, planes)
    rows = np.unique(np.column_stack([patch, plane]), axis=0)
    three = np.flatnonzero(np.bincount(rows[:, 0], minlength=1)[rows[:, 0]] == 3)
    of, plane3 = rows[three[::3], 0], rows[three, 1].reshape(-1, 3)
    normal = graph.face_frame[plane3, 3]
    clear = np.linalg.svd(normal, compute_uv=False).min(axis=1, initial=np.inf) > LEAST_SPREAD
    of, plane3, normal = of[clear], plane3[clear], normal[clear]
    height = np.einsum("kpi,kpi->kp", graph.face_frame[plane3, 0], normal)
    p = np.linalg.solve(normal, height[..., None])[..., 0]
    radius, is_near = _sizes(graph, rounds, end, patch, of, p)
    p, plane3, radius = p[is_near], plane3[is_near], radius[is_near]
    solid = graph.face_solid[plane3[:, 0]]
    once = first_rows(label_equal(solid, np.round(p / NAMING_MM)))
    return FeatureColumns(
        kind=FeatureKind.VIRTUAL_CORNER,
        p=p[once],
        solid=solid[once],
        diameter_mm=2.0 * radius[once],
        faces=list(plane3[once]),
    )


def _rounds(graph: BrepGraph) -> tuple[IntArray, IntArray]:
    """Return the convex cylinder faces that two plane faces continue, and these two faces, shape (n, 2)."""
    rows = np.flatnonzero((graph.edge_faces >= 0).all(axis=1) & (graph.edge_kind == CurveKind.LINE))
    pairs = np.concatenate([graph.edge_faces[rows], graph.edge_faces[rows][:, ::-1]])
    edge = np.concatenate([rows, rows])
    kept = (graph.face_kind[pairs[:, 0]] == SurfaceKind.CYLINDER) & (graph.face_outward[pairs[:, 0]] > 0)
    kept &= graph.face_kind[pairs[:, 1]] == SurfaceKind.PLANE
    pairs, edge = pairs[kept], edge[kept]
    p = evaluate_edges(graph, edge, graph.edge_range[edge].mean(axis=1))[0]
    a, b = (project_to_faces(graph, pairs[:, k], p).normal for k in (0, 1))
    pairs = np.unique(pairs[np.einsum("ki,ki->k", a, b) > TANGENT_COS], axis=0)
    two = np.flatnonzero(np.bincount(pairs[:, 0], minlength=1)[pairs[:, 0]] == 2)
    return pairs[two[::2], 0], pairs[two, 1].reshape(-1, 2)


Ends = tuple[IntArray, IntArray]  #: Row among the rounds and edge of each end of a round.


def _planes_at_ends(graph: BrepGraph, rounds: IntArray, planes: IntArray) -> tuple[IntArray, Ends, IntArray]:
    """Return which planes meet at the patches where rounds end.

    A patch is the plane where one round ends, the edge where two rounds meet, or the face between several.

    Returns `patch`: shape (m,).
    Returns `end`: pair of ndarray of int, shape (m,).
    Returns `plane`: shape (m,). Each plane at the patch.
    """
    row = np.full(graph.face_count, -1)
    row[rounds] = np.arange(len(rounds))
    pairs = np.concatenate([graph.edge_faces, graph.edge_faces[:, ::-1]])
    edge = np.tile(np.arange(graph.edge_count), 2)
    kept = (pairs >= 0).all(axis=1) & (row[pairs[:, 0]] >= 0) & (pairs[:, 0] != pairs[:, 1])
    pairs, edge = pairs[kept], edge[kept]
    round_, other = row[pairs[:, 0]], pairs[:, 1]
    at_end = (planes[round_] != other[:, None]).all(axis=1)
    round_, other, edge = round_[at_end], other[at_end], edge[at_end]
    is_plane, is_round = graph.face_kind[other] == SurfaceKind.PLANE, row[other] >= 0
    patch = label_equal(
        np.where(is_plane, 0, np.where(is_round, 1, 2)), np.where(is_round, edge, other), np.where(is_plane, round_, -1)
    )
    rows = np.concatenate([np.tile(np.arange(len(patch)), 2), np.flatnonzero(is_plane)])
    plane = np.concatenate([planes[round_].T.ravel(), other[is_plane]])
    return patch[rows], (round_[rows], edge[rows]), plane


def _sizes(
    graph: BrepGraph, rounds: IntArray, end: Ends, patch: IntArray, of: IntArray, p: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return the least radius at each corner's patch, and whether all ends there are near the corner."""
    corner = np.full(int(patch.max(initial=0)) + 1, -1)
    corner[of] = np.arange(len(of))
    at = np.flatnonzero(corner[patch] >= 0)
    k, edge, radius = corner[patch[at]], end[1][at], graph.face_param[rounds[end[0][at]], 0]
    middle = evaluate_edges(graph, edge, graph.edge_range[edge].mean(axis=1))[0]
    least, farthest = np.full(len(of), np.inf), np.zeros(len(of))
    np.minimum.at(least, k, radius)
    np.maximum.at(farthest, k, np.linalg.norm(middle - p[k], axis=1))
    return least, farthest <= FARTHEST_RADII * least
