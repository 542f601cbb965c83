"""What several steps ask about the pieces of seams: points along them, and the solids that they join."""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.seam import SeamPieces


def sample_pieces(graph: BrepGraph, pieces: SeamPieces, share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points at the same shares of every piece.

    `share`: shape (n,). From 0 (start of a piece) to 1 (end), by the edge's parameter.
    Returns `t`: ndarray, shape (k, n). Edge parameters.
    Returns `p`: ndarray, shape (k, n, 3). Points in `part`, mm.
    """
    t = pieces.t0[:, None] + (pieces.t1 - pieces.t0)[:, None] * share
    return t, evaluate_edges(graph, np.repeat(pieces.edge, len(share)), t.ravel())[0].reshape(*t.shape, 3)


def solids_of(graph: BrepGraph, pieces: SeamPieces) -> IntArray:
    """Return the numbers of the two solids of each piece, the smaller first, -1 for a missing face; shape (k, 2)."""
    solids = [np.where(face >= 0, graph.face_solid[face], -1) for face in (pieces.wall, pieces.base)]
    return np.sort(np.stack(solids, axis=1), axis=1)
