"""The frame at every point of a seam (DESIGN §3): x along the travel, z out of the joint, y = z × x."""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.meeting import meet_surfaces
from wpcal.brep.surfaces import part_across, project_to_faces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.path.discretise import Stations
from wpcal.seam.seam import SeamFrames, SeamPieces

UPRIGHT_COS = 0.99  #: A seam without faces counts as vertical within 8 degrees; then z cannot point up.
MOUTH_STEPS = 5
"""Steps in which the ball of a wire (0.6 mm) grows to one in the mouth of a groove (20 mm): it doubles in each."""
OPPOSED_LENGTH = 1e-6  #: Two normals are opposed, and have no bisector, if their sum is shorter than this.


def seam_frames(graph: BrepGraph, pieces: SeamPieces, stations: Stations) -> SeamFrames:
    """Build the frames of runs at their stations, all in one.

    Returns: In `part`, from the exact tangents and normals. If the two normals are opposed, there is no bisector, and z
    is the normal of the wall (`turning.face_free_space` turns it). In a flare groove, z points to the centre of a ball
    in the mouth of the groove, and the normals are those where this ball touches both faces. If one face is missing
    (-1), z is the normal of the other one. If both are missing, z points up in `part`, or along its x axis on a
    vertical seam.
    """
    rows = stations.piece
    p, slope = evaluate_edges(graph, pieces.edge[rows], stations.t)
    way = np.sign(pieces.t1 - pieces.t0)[rows]
    x = slope * (way / np.linalg.norm(slope, axis=1))[:, None]
    wall, base = pieces.wall[rows], pieces.base[rows]
    mouth, is_groove = _mouths(graph, wall, base, graph.balls_mm[pieces.edge[rows]], p, x)
    n_wall, n_base = _normals(graph, wall, base, mouth, x)
    out = np.where(is_groove[:, None], mouth - p, n_wall)
    R = frames_from_normals(x, out, np.where(is_groove[:, None], out, n_base))
    cosine = np.clip(np.einsum("ki,ki->k", n_wall, n_base), -1.0, 1.0)
    return SeamFrames(stations.s_mm, p, R, np.arccos(cosine))


def _mouths(
    graph: BrepGraph, wall: IntArray, base: IntArray, ball_mm: FloatArray, p: FloatArray, x: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return the points at which normals are taken, and whether they are centres of balls in grooves; otherwise p."""
    rows = np.flatnonzero(ball_mm > 0)
    at, found = p.copy(), np.zeros(len(p), dtype=bool)
    if len(rows) == 0:
        return at, found
    first, second, c, most = wall[rows], base[rows], p[rows], ball_mm[rows]
    least = np.minimum(np.linalg.norm(project_to_faces(graph, first, c).p - c, axis=1), most)
    for share in np.linspace(0.0, 1.0, MOUTH_STEPS + 1)[1:]:  # the ball grows, so that it stays between the two faces
        height = least ** (1.0 - share) * most**share
        c = meet_surfaces(graph, np.stack([first, second]), c, x[rows], height_mm=height, least_sin=OPPOSED_LENGTH)
        c = np.where(np.isfinite(c), c, p[rows])
    found[rows] = np.linalg.norm(c - p[rows], axis=1) > OPPOSED_LENGTH
    at[found] = c[found[rows]]
    return at, found


def _normals(
    graph: BrepGraph, wall: IntArray, base: IntArray, p: FloatArray, x: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the outward normals of both faces at p; a missing one is replaced (see `seam_frames`)."""
    n_wall, n_base = (project_to_faces(graph, np.maximum(face, 0), p).normal for face in (wall, base))
    lone = np.flatnonzero((wall < 0) | (base < 0))
    for row in lone.tolist():
        upright = abs(float(x[row, 2])) > UPRIGHT_COS
        none = np.array([1.0, 0.0, 0.0] if upright else [0.0, 0.0, 1.0])
        n = n_wall[row] if wall[row] >= 0 else n_base[row] if base[row] >= 0 else none
        n_wall[row], n_base[row] = n, n.copy()
    return n_wall, n_base


def frames_from_normals(x: FloatArray, n_wall: FloatArray, n_base: FloatArray) -> FloatArray:
    """Return frames with x as given and z the bisector of two normals, made normal to x.

    `x`, `n_wall`, `n_base`: shape (n, 3). Unit vectors in one frame.
    Returns ndarray, shape (n, 3, 3). Columns x, y, z.
    """
    n1, n2 = (part_across(n, x) for n in (n_wall, n_base))
    z = n1 + n2
    length = np.linalg.norm(z, axis=1, keepdims=True)
    z = np.where(length > OPPOSED_LENGTH, z, n1)
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)
