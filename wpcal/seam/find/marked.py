"""Edges that a person marked (by name, colour or layer in the CAD file) or picked: these are the seams.

If a marked edge runs along a contact of two solids, the seam is that contact, and the two faces of the contact give the
frames. An edge beyond the gap takes the face of another solid that it nearly touches. Otherwise the seam has the two
faces of the edge itself. If the edge has one face, z is the normal of this face.
If it has none, z points up in `part`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.concavity import are_concave
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces, distance_to_segments
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.contact import CONTACT_SAMPLES, find_edge_contacts
from wpcal.seam.find.duplicates import SHARES, without_duplicates
from wpcal.seam.find.joint import JoinedPieces, join_contacts
from wpcal.seam.limits import NEAR_GAPS
from wpcal.seam.pieces import sample_pieces
from wpcal.seam.seam import JointType, SeamPieces, SeamSource, WeldType

NEARLY_MM = (0.75, 1.0, 1.5, 2.0, 3.0)
"""Gaps at which a marked edge is looked for beside a face, one after the other: wider ones are not welded without a
backing."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkedEdges:
    """Edges of a graph to be welded."""

    edge: IntArray  #: shape (k,).
    label: tuple[str, ...]  #: length k. The mark of each edge, for people.
    #: Whether they are seams beside those that are found. Otherwise no other candidate is accepted.
    is_added: bool = False

    @property
    def source(self) -> SeamSource:
        """How the candidates on these edges were found."""
        return SeamSource.ADDED if self.is_added else SeamSource.MARKED


def take_marked(
    graph: BrepGraph, trimmed: TrimmedFaces, joined: JoinedPieces, marked: MarkedEdges, *, gap_mm: float
) -> tuple[JoinedPieces, tuple[str, ...], JoinedPieces]:
    """Separate what is marked from the other contacts.

    `gap_mm`: The gap with which the contacts were found, mm.

    Returns `pieces`: Contacts along marked edges; marked edges that nearly touch another solid, with its face; and
    those without a contact, with their own faces (-1 for a missing one).
    Returns `label`: tuple of str. The mark of each piece.
    Returns `rest`: JoinedPieces. The other contacts.
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
    near = _near_contacts(graph, trimmed, marked.edge[alone], gap_mm)
    touched = set(near.pieces.edge.tolist())
    alone = [row for row in alone if int(marked.edge[row]) not in touched]
    both = JoinedPieces.together([joined.select(taken), near, _with_own_faces(graph, marked.edge[alone])])
    mark_of = dict(zip(marked.edge.tolist(), marked.label, strict=True))
    labels = (
        *(label_of[piece] for piece in taken.tolist()),
        *(mark_of[edge] for edge in near.pieces.edge.tolist()),
        *(marked.label[row] for row in alone),
    )
    return both, labels, joined.select(rest)


def _near_contacts(graph: BrepGraph, trimmed: TrimmedFaces, edges: IntArray, gap_mm: float) -> JoinedPieces:
    """Return the contacts of edges with faces beyond the gap: each edge with the least gap that finds one."""
    found = []
    for wide_mm in (gap for gap in NEARLY_MM if gap > gap_mm):
        contacts = find_edge_contacts(graph, trimmed, gap_mm=wide_mm, edges=edges)
        near = join_contacts(graph, trimmed, contacts, gap_mm=wide_mm)
        found.append(without_duplicates(graph, near, gap_mm=gap_mm))
        edges = np.setdiff1d(edges, found[-1].pieces.edge)
    return JoinedPieces.together(found)


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


def in_words(graph: BrepGraph, pieces: SeamPieces, labels: tuple[str, ...], *, gap_mm: float) -> tuple[str, ...]:
    """Return the reasons of a marked seam: its marks, a gap beyond `gap_mm`, and how z is chosen without a face."""
    words = tuple(dict.fromkeys(f"marked: {label}" for label in labels))
    widest = float(pieces.gap_mm[:, 2].max())
    if widest > gap_mm:
        words += (f"up to {widest:.2f} mm from the other member: more than the largest gap, {gap_mm:g} mm",)
    count = ((pieces.wall >= 0).astype(int) + (pieces.base >= 0)).min()
    if count == 2:
        return words
    lacking = "only one face beside it: z is its normal" if count else "no face beside it: z is up in part coordinates"
    return (*words, lacking)
