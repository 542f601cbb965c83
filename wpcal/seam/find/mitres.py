"""Mitres of round tubes inside one solid: two tubes of one diameter that end in the plane between them.

The weld runs all round, along an ellipse. On the inside of the corner its edge is concave, on the outside convex, and
the two faces run smoothly into each other between these. So it is found as a whole, not edge by edge. Where one of two
tubes runs on (a tee), no part of the curve is convex: it is a fillet, and its edges are found by themselves.
"""

from __future__ import annotations

from itertools import groupby

import numpy as np

from wpcal.brep.concavity import LEAST_TURN_SIN, inner_edges
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.find.tubes import find_tubes
from wpcal.seam.seam import JointType, SeamPieces, WeldType

SAMPLES = 9  #: Places along an edge at which it is compared with the plane between two tubes.
SAME_RADIUS = 1e-3  #: Relative difference of the radii of two tubes of one diameter.
OFF_PLANE = 2e-3
"""How far an edge may be from the plane between the tubes, as a share of their radius: kernels place it within 1e-4."""
BUTT_COS = float(np.cos(np.radians(45.0)))
"""Two tubes at an angle of 135 degrees or more meet in a butt joint, others in a corner joint (ISO 17659)."""


def find_mitres(graph: BrepGraph, trimmed: TrimmedFaces, solids: BoolArray) -> JoinedPieces:
    """Find the edges in which tubes of one diameter are mitred. Whole edges: butt or corner joints, grooves.

    `solids`: shape (S,). Which solids are searched.
    """
    edges = _between_cylinders(graph, solids)
    tube = np.full(graph.face_count, -1)
    for solid in np.unique(graph.edge_solid[edges]).tolist():
        tubes = find_tubes(graph, trimmed, solid)
        tube[tubes.face[tubes.outer]] = tubes.axis[tubes.outer]
    edges = edges[(tube[graph.edge_faces[edges]] >= 0).all(axis=1)]
    plane = _planes_between(graph, edges)
    edges, plane = edges[plane >= 0], plane[plane >= 0]
    pairs = np.sort(tube[graph.edge_faces[edges]], axis=1)
    keys = list(zip(graph.edge_solid[edges].tolist(), *pairs.T.tolist(), plane.tolist(), strict=True))
    x, left, right = _normals(graph, edges)
    convex = (np.einsum("ksi,ksi->ks", np.cross(left, right), x) > LEAST_TURN_SIN).any(axis=1)
    flat = (np.einsum("ksi,ksi->ks", left, right) >= BUTT_COS).all(axis=1)
    chosen: list[int] = []
    for _, rows in groupby(sorted(range(len(keys)), key=keys.__getitem__), key=keys.__getitem__):
        own = list(rows)
        if convex[own].any():
            chosen += own
    taken = np.sort(np.array(chosen, dtype=np.int64))
    edges = edges[taken]
    wall, base = graph.edge_faces[edges].T
    t0, t1 = graph.edge_range[edges].T
    pieces = SeamPieces(edges, t0, t1, wall, base, np.zeros((len(edges), 3)))
    words = tuple(JointType.BUTT if is_flat else JointType.CORNER for is_flat in flat[taken].tolist())
    return JoinedPieces(pieces, words, (WeldType.GROOVE,) * len(edges))


def _between_cylinders(graph: BrepGraph, solids: BoolArray) -> IntArray:
    """Return the edges between two outer cylinders of one radius with different axes."""
    edges = inner_edges(graph, solids)
    faces = graph.edge_faces[edges]
    round_ = (graph.face_kind[faces] == SurfaceKind.CYLINDER) & (graph.face_outward[faces] > 0)
    radius, z = graph.face_param[faces, 0], graph.face_frame[faces, 3]
    same = np.abs(radius[:, 0] - radius[:, 1]) <= SAME_RADIUS * radius[:, 0]
    turned = np.linalg.norm(np.cross(z[:, 0], z[:, 1]), axis=1) > LEAST_TURN_SIN
    return np.asarray(edges[round_.all(axis=1) & same & turned], dtype=np.int64)


def _places(graph: BrepGraph, edges: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return places on edges and the directions there, each of shape (k, SAMPLES, 3)."""
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    low, high = graph.edge_range[edges].T
    t = low[:, None] + (high - low)[:, None] * share
    p, slope = evaluate_edges(graph, np.repeat(edges, SAMPLES), t.ravel())
    return p.reshape(-1, SAMPLES, 3), slope.reshape(-1, SAMPLES, 3)


def _planes_between(graph: BrepGraph, edges: IntArray) -> IntArray:
    """Return in which of the two planes between the axes of its cylinders an edge lies: 0, 1, or -1 for neither.

    The planes are square to the sum and to the difference of the directions of the axes.
    """
    if len(edges) == 0:
        return np.zeros(0, dtype=np.int64)
    p = _places(graph, edges)[0]
    faces = graph.edge_faces[edges]
    o, z = graph.face_frame[faces, 0], graph.face_frame[faces, 3]
    across = np.cross(z[:, 0], z[:, 1])
    arm = o[:, 1] - o[:, 0]
    # the point of the first axis that is nearest to the second one
    along = np.einsum("ki,ki->k", np.cross(arm, z[:, 1]), across) / np.einsum("ki,ki->k", across, across)
    centre = o[:, 0] + along[:, None] * z[:, 0]
    most = OFF_PLANE * graph.face_param[faces[:, 0], 0]
    found = np.full(len(edges), -1)
    for number, normal in enumerate((z[:, 0] + z[:, 1], z[:, 0] - z[:, 1])):
        height = np.einsum("ksi,ki->ks", p - centre[:, None], normal) / np.linalg.norm(normal, axis=1)[:, None]
        off = np.abs(height).max(axis=1)
        found[off <= most] = number
    return found


def _normals(graph: BrepGraph, edges: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the direction of edges and the normals of their left and right faces, each of shape (k, SAMPLES, 3)."""
    p, slope = _places(graph, edges)
    faces = np.repeat(graph.edge_faces[edges], SAMPLES, axis=0)
    left, right = (project_to_faces(graph, faces[:, k], p.reshape(-1, 3)).normal.reshape(p.shape) for k in (0, 1))
    return slope / np.linalg.norm(slope, axis=2, keepdims=True), left, right
