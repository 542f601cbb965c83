"""The boundaries of faces as polylines, with the parameters of their points on the faces (sag `curves.CHORD_MM`)."""

import numpy as np

from wpcal.brep.curves import edge_polylines
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray, blocks, numbered_rows

AXIS_MM = 1e-6  #: A boundary point this near to the axis is the apex: kernels place vertices within 1e-7 mm.
SAME_VERTEX_MM = 1e-6  #: Ends this near to each other are one vertex: ten times the accuracy of vertices in kernels.
MOST_POINTS = 50_000  #: Points projected in one array: about 20 MB.


def sample_boundaries(
    graph: BrepGraph,
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray, IntArray, FloatArray, FloatArray]:
    """Sample the boundaries of all faces of `graph`; the arrays of `trim.TrimmedFaces`, in their order."""
    used = ~graph.is_seam_edge[graph.coedge_edge] & (graph.edge_kind[graph.coedge_edge] != CurveKind.DEGENERATE)
    order = np.flatnonzero(used)[np.argsort(graph.coedge_face[used], kind="stable")]
    face, edge, forward = graph.coedge_face[order], graph.coedge_edge[order], graph.coedge_forward[order]
    start, t, points = edge_polylines(graph)
    counts = np.diff(start)[edge] - 1
    coedge, step = numbered_rows(counts)
    low = start[edge[coedge]] + step
    flip = ~forward[coedge]
    first, second = np.where(flip, low + 1, low), np.where(flip, low, low + 1)
    of_face = face[coedge]
    p0, p1 = points[first], points[second]
    closed = _closed_ends(graph, start, points)  # so pieces with a common vertex have exactly equal (u, v) there
    uv0, uv1 = _parameters(graph, of_face, closed[first]), _parameters(graph, of_face, closed[second])
    for here, there, p in ((uv0, uv1, p0), (uv1, uv0, p1)):
        apex = is_on_axis(graph, of_face, p)  # it has no angle of its own: take that of the other end
        here[apex, 0] = there[apex, 0]
    swap = graph.face_outward[of_face] < 0  # left seen from outside is right seen along the surface's own normal
    uv0[swap], uv1[swap] = uv1[swap], uv0[swap].copy()
    face_start = np.searchsorted(of_face, np.arange(graph.face_count + 1))
    return face_start, uv0, uv1, p0, p1, edge[coedge], t[first], t[second]


def _parameters(graph: BrepGraph, faces: IntArray, points: FloatArray) -> FloatArray:
    """Return the parameters (m, 2) of points on surfaces."""
    uv = np.empty((len(faces), 2))
    for own in blocks(len(faces), MOST_POINTS):
        uv[own] = project_to_faces(graph, faces[own], points[own]).uv
    return uv


def _closed_ends(graph: BrepGraph, start: IntArray, points: FloatArray) -> FloatArray:
    """Return the samples of edges with equal ends at a common vertex: the end of the first edge there."""
    points = points.copy()
    real = np.flatnonzero(np.diff(start) > 0)
    samples = np.stack([start[real], start[real + 1] - 1], axis=1).ravel()
    vertices = graph.edge_vertices[real].ravel()
    samples, vertices = samples[vertices >= 0], vertices[vertices >= 0]
    _, first, inverse = np.unique(vertices, return_index=True, return_inverse=True)
    near = np.linalg.norm(points[samples] - points[samples[first[inverse]]], axis=1) <= SAME_VERTEX_MM
    points[samples[near]] = points[samples[first[inverse]]][near]
    return points


def is_on_axis(graph: BrepGraph, faces: IntArray, points: FloatArray) -> BoolArray:
    """Tell which points are on the axis of their cone or sphere: at its apex or pole, shape (m,).

    `faces`: ndarray of int, shape (m,).
    `points`: shape (m, 3). In `part`, mm.
    """
    on_axis = np.zeros(len(faces), dtype=bool)
    pointed = np.flatnonzero(np.isin(graph.face_kind[faces], (SurfaceKind.CONE, SurfaceKind.SPHERE)))
    frame = graph.face_frame[faces[pointed]]
    arm = points[pointed] - frame[:, 0]
    height = np.einsum("mi,mi->m", arm, frame[:, 3])
    on_axis[pointed] = np.linalg.norm(arm - height[:, None] * frame[:, 3], axis=1) < AXIS_MM
    return on_axis
