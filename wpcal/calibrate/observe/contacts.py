"""Where bodies of a part lie on each other: plane faces that touch, face to face.

A tacked plate stays on the face below it. With `KeptContacts` the fit keeps each such face within the gap of the joint:
the tilt of an upright and its height then follow the base, also where no touch sees them.
"""

from __future__ import annotations

import math

import numpy as np

from wpcal.brep.graph import SurfaceKind
from wpcal.brep.strips import items_of
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate.observe.bodies import KeptContacts
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.linked import near_tree

PARALLEL_RAD = 0.01  #: Faces that lie on each other are parallel to half a degree; a welded-on wedge is not.
PIECES = 8
"""Points along each line of a border that are tried: overlaps shorter than an eighth of both faces are not found."""
LEAST_SPREAD_MM = 1.0  #: Contact points nearer to each other say the same.
FLUSH_MM = 0.1  #: A corner this near to the border of the other face lies on it: sides of plates that are flush.
HELD = 3  #: A plane contact holds one height and two tilts. More points share the weight of three.


def find_kept_contacts(trimmed: TrimmedFaces, face_body: IntArray, *, gap_mm: float, sigma_mm: float) -> KeptContacts:
    """Find where plane faces of two bodies lie on each other.

    `face_body`: shape (F,). The body of every face; -1: it does not move.
    Returns: Three or four points for each pair of faces, at the ends of the overlap.
    """
    face, at, normal = _plane_faces(trimmed)
    i, j = _facing(trimmed, face, at, normal, gap_mm)
    apart = face_body[face[i]] != face_body[face[j]]
    i, j = i[apart], j[apart]
    points, pair = _overlaps(trimmed, face[i], face[j], gap_mm)
    # faces of one body in one plane, such as those between slots, hold it together
    plane = np.round(np.column_stack([normal[i] / PARALLEL_RAD, np.einsum("ni,ni->n", at[i], normal[i]) / gap_mm]))
    of_pair = np.column_stack([face_body[face[i]], face_body[face[j]], plane])
    patches, patch = np.unique(of_pair, axis=0, return_inverse=True)
    found = [KeptContacts.none()]
    for number in range(len(patches)):
        own = int(np.flatnonzero(patch == number)[0])
        p = _corners(points[patch[pair] == number], normal[i[own]])
        ones = np.ones(len(p), dtype=np.int64)
        sigma = np.full(len(p), sigma_mm * math.sqrt(max(len(p), HELD) / HELD))
        normals = np.tile(normal[i[own]], (len(p), 1))
        found.append(KeptContacts(p, normals, ones * face_body[face[i[own]]], ones * face_body[face[j[own]]], sigma))
    return KeptContacts.joined(found)


def _plane_faces(trimmed: TrimmedFaces) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the plane faces with a border, a point of each, and their outward normals; (k,), (k, 3), (k, 3)."""
    graph = trimmed.graph
    has_border = np.diff(trimmed.start) > 0
    face = np.flatnonzero((graph.face_kind == SurfaceKind.PLANE) & has_border)
    at = trimmed.p0[trimmed.start[face]]
    return face, at, project_to_faces(graph, face, at).normal


def _facing(
    trimmed: TrimmedFaces, face: IntArray, at: FloatArray, normal: FloatArray, gap_mm: float
) -> tuple[IntArray, IntArray]:
    """Return pairs of plane faces in one plane that look at each other, and whose boxes meet: rows, shapes (m,)."""
    if len(face) < 2:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    offset = np.einsum("ni,ni->n", at, normal) * (PARALLEL_RAD / gap_mm)
    here = np.column_stack([normal, offset])
    near = near_tree(here).query_ball_point(-here, PARALLEL_RAD * math.sqrt(2.0), return_sorted=True)
    i = np.repeat(np.arange(len(face)), [len(others) for others in near])
    j = np.concatenate([np.array(others, dtype=np.int64) for others in near])
    low, high = (corner[face] for corner in trimmed.face_box)
    meet = (low[i] <= high[j] + gap_mm).all(axis=1) & (low[j] <= high[i] + gap_mm).all(axis=1) & (i < j)
    return i[meet], j[meet]


def _overlaps(trimmed: TrimmedFaces, a: IntArray, b: IntArray, gap_mm: float) -> tuple[FloatArray, IntArray]:
    """Return points of the border of either face of each pair that lie on the other, and their pairs: (k, 3), (k,)."""
    of, within = np.concatenate([a, b]), np.concatenate([b, a])
    row, piece = items_of(trimmed.start, of)
    share = (np.arange(PIECES) / PIECES)[None, :, None]
    points = ((1.0 - share) * trimmed.p0[piece][:, None] + share * trimmed.p1[piece][:, None]).reshape(-1, 3)
    row = np.repeat(row, PIECES)
    low, high = trimmed.face_box
    near = ((points >= low[within[row]] - gap_mm) & (points <= high[within[row]] + gap_mm)).all(axis=1)
    points, row = points[near], row[near]
    foot = project_to_faces(trimmed.graph, within[row], points)
    inside = trimmed.contains(within[row], foot.uv)
    rest = np.flatnonzero(~inside)
    inside[rest] = trimmed.boundary_distance(within[row[rest]], foot.p[rest], within_mm=FLUSH_MM) <= FLUSH_MM
    return points[inside], row[inside] % max(len(a), 1)


def _corners(points: FloatArray, normal: FloatArray) -> FloatArray:
    """Return three or four points at the ends of an area in a plane, shape (k, 3); none if it is a line or a point."""
    if len(points) < HELD:
        return np.zeros((0, 3))
    flat = points - points.mean(axis=0)
    flat = flat - np.outer(flat @ normal, normal)
    u, v = np.linalg.svd(flat, full_matrices=False)[2][:2]
    x, y = flat @ u, flat @ v
    if min(np.ptp(x), np.ptp(y)) < LEAST_SPREAD_MM:
        return np.zeros((0, 3))
    rows = [int(np.argmax(s * x / np.ptp(x) + t * y / np.ptp(y))) for s in (-1, 1) for t in (-1, 1)]
    kept: list[int] = []
    for row in rows:
        if all(np.linalg.norm(points[row] - points[other]) >= LEAST_SPREAD_MM for other in kept):
            kept.append(row)
    return np.asarray(points[kept] if len(kept) >= HELD else np.zeros((0, 3)))
