"""The frame at every point of a seam (DESIGN §3): x along the travel, z out of the joint, y = z × x."""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import FloatArray
from wpcal.seam.discretise import Stations
from wpcal.seam.seam import SeamFrames, SeamPieces

OPPOSED_LENGTH = 1e-6
"""Normals whose sum is shorter than this are opposed: they have no bisector."""


def seam_frames(graph: BrepGraph, pieces: SeamPieces, stations: Stations) -> SeamFrames:
    """Build the frames of runs at their stations, all in one.

    Parameters
    ----------
    graph : BrepGraph
    pieces : SeamPieces
        Of all runs, in order and direction.
    stations : Stations

    Returns
    -------
    SeamFrames
        In `part`. Tangent and normals are those of the exact curve and surfaces. Where the two normals are opposed
        there is no bisector: z is then the wall's normal (`turning.face_free_space` turns it).
    """
    rows = stations.piece
    p, slope = evaluate_edges(graph, pieces.edge[rows], stations.t)
    way = np.sign(pieces.t1 - pieces.t0)[rows]
    x = slope * (way / np.linalg.norm(slope, axis=1))[:, None]
    n_wall = project_to_faces(graph, pieces.wall[rows], p).normal
    n_base = project_to_faces(graph, pieces.base[rows], p).normal
    R = frames_from_normals(x, n_wall, n_base)
    cosine = np.clip(np.einsum("ki,ki->k", n_wall, n_base), -1.0, 1.0)
    return SeamFrames(stations.s_mm, p, R, np.arccos(cosine))


def frames_from_normals(x: FloatArray, n_wall: FloatArray, n_base: FloatArray) -> FloatArray:
    """Return frames with x as given and z the bisector of two normals, made normal to x.

    Parameters
    ----------
    x, n_wall, n_base : ndarray, shape (n, 3)
        Unit vectors in one frame.

    Returns
    -------
    ndarray, shape (n, 3, 3)
        Columns x, y, z.
    """
    n1, n2 = (_across(n, x) for n in (n_wall, n_base))
    z = n1 + n2
    length = np.linalg.norm(z, axis=1, keepdims=True)
    z = np.where(length > OPPOSED_LENGTH, z, n1)
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)


def _across(n: FloatArray, x: FloatArray) -> FloatArray:
    return np.asarray(n - np.einsum("ki,ki->k", n, x)[:, None] * x, dtype=np.float64)
