"""Edges that a person marked (by name, colour or layer in the CAD file) or picked: these are the seams.

If a marked edge runs along a contact of two solids, the seam is that contact, and the two faces of the contact give the
frames. Otherwise the seam has the two faces of the edge itself. If the edge has one face, z is the normal of this face.
If it has none, z points up in `part`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.concavity import are_concave
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import distance_to_segments
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.contact import CONTACT_SAMPLES
from wpcal.seam.find.duplicates import SHARES
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.limits import NEAR_GAPS
from wpcal.seam.pieces import sample_pieces
from wpcal.seam.seam import JointType, SeamPieces, WeldType


@dataclass(frozen=True, slots=True, eq=False)
class MarkedEdges:
    """Edges of a graph to be welded.

    Parameters
    ----------
    edge : ndarray of int, shape (k,)
    label : tuple of str, length k
        The mark of each edge, for people.
    """

    edge: IntArray
    label: tuple[str, ...]


def take_marked(
    graph: BrepGraph, joined: JoinedPieces, marked: MarkedEdges, *, gap_mm: float
) -> tuple[JoinedPieces, tuple[str, ...], JoinedPieces]:
    """Separate what is marked from the other contacts.

    Parameters
    ----------
    graph : BrepGraph
    joined : JoinedPieces
        The contacts.
    marked : MarkedEdges
    gap_mm : float
        The gap with which the contacts were found, mm.

    Returns
    -------
    pieces : JoinedPieces
        Contacts along marked edges, and marked edges without a contact, with their own faces (-1 for a missing one).
    label : tuple of str
        The mark of each piece.
    rest : JoinedPieces
        The other contacts.
    """
    label_of: dict[int, str] = {}
    alone = []
    curves = sample_pieces(graph, joined.pieces, SHARES)[1]
    for row, edge in enumerate(marked.edge.tolist()):
        beside = np.flatnonzero(_run_along(graph, curves, edge, NEAR_GAPS * gap_mm) | (joined.pieces.edge == edge))
        for piece in beside.tolist():
            label_of.setdefault(piece, marked.label[row])
        if len(beside) == 0:
            alone.append(row)
    taken = np.array(sorted(label_of), dtype=np.int64)
    rest = np.setdiff1d(np.arange(len(joined.pieces)), taken)
    own = _with_own_faces(graph, marked.edge[alone])
    here = joined.select(taken)
    both = JoinedPieces(
        SeamPieces.joined([here.pieces, own.pieces]), (*here.joint, *own.joint), (*here.weld, *own.weld)
    )
    labels = (*(label_of[piece] for piece in taken.tolist()), *(marked.label[row] for row in alone))
    return both, labels, joined.select(rest)


def _run_along(graph: BrepGraph, curves: FloatArray, edge: int, near: float) -> BoolArray:
    """Tell which curves, as points (k, n, 3), run along an edge: all their points are nearer to it than `near`."""
    first, last = graph.edge_range[edge]
    path = evaluate_edges(graph, np.full(CONTACT_SAMPLES, edge), np.linspace(first, last, CONTACT_SAMPLES))[0]
    along = ((curves >= path.min(axis=0) - near) & (curves <= path.max(axis=0) + near)).all(axis=(1, 2))
    for row in np.flatnonzero(along).tolist():
        p = np.repeat(curves[row], CONTACT_SAMPLES - 1, axis=0)
        off = distance_to_segments(p, np.tile(path[:-1], (CONTACT_SAMPLES, 1)), np.tile(path[1:], (CONTACT_SAMPLES, 1)))
        along[row] = off.reshape(CONTACT_SAMPLES, -1).min(axis=1).max() <= near
    return np.asarray(along, dtype=bool)


def _with_own_faces(graph: BrepGraph, edges: IntArray) -> JoinedPieces:
    wall, base = graph.edge_faces[edges].T
    t0, t1 = graph.edge_range[edges].T
    weld = [WeldType.UNKNOWN] * len(edges)
    two = np.flatnonzero((wall >= 0) & (base >= 0))
    for row, concave in zip(two.tolist(), are_concave(graph, edges[two]).tolist(), strict=True):
        weld[row] = WeldType.FILLET if concave else WeldType.GROOVE
    pieces = SeamPieces(edges, t0, t1, wall, base, np.zeros((len(edges), 3)))
    return JoinedPieces(pieces, (JointType.UNKNOWN,) * len(edges), tuple(weld))


def in_words(graph: BrepGraph, pieces: SeamPieces, labels: tuple[str, ...]) -> tuple[str, ...]:
    """Return the reasons of a marked seam: its marks, and how z is chosen if a face is missing."""
    words = tuple(dict.fromkeys(f"marked: {label}" for label in labels))
    count = ((pieces.wall >= 0).astype(int) + (pieces.base >= 0)).min()
    if count == 2:
        return words
    lacking = "only one face beside it: z is its normal" if count else "no face beside it: z is up in part coordinates"
    return (*words, lacking)
