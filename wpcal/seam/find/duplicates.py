"""The same seam found twice: by an edge of either member, or by one edge on two neighbouring faces."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from wpcal.brep.curves import arc_length, evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import distance_to_segments
from wpcal.core.arrays import IntArray
from wpcal.seam.find.contact import CONTACT_SAMPLES
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.limits import LEAST_CANDIDATE_MM, NEAR_GAPS
from wpcal.seam.pieces import sample_pieces, solids_of
from wpcal.seam.seam import SeamPieces, WeldType

Interval = tuple[float, float]
SHARES = np.linspace(0.0, 1.0, CONTACT_SAMPLES)
"""Places along a piece at which curves are compared."""


def without_duplicates(graph: BrepGraph, joined: JoinedPieces, *, gap_mm: float) -> JoinedPieces:
    """Return pieces of which no two cover the same stretch of the same joint.

    Parameters
    ----------
    graph : BrepGraph
    joined : JoinedPieces
        Of contacts, each piece along its edge (t0 < t1).
    gap_mm : float
        Gap within which they were found, mm.

    Returns
    -------
    JoinedPieces
        If one edge is near two faces of the other member, the stretch belongs to the nearer face. If an edge of A on B
        and an edge of B on A coincide, a fillet is preferred to a groove, then the smaller gap.
    """
    return _without_twins(graph, _without_overlaps(graph, joined), gap_mm)


def sections_beside(graph: BrepGraph, sections: SeamPieces, joined: JoinedPieces, *, gap_mm: float) -> SeamPieces:
    """Return the section curves that do not run along a contact of the same two solids.

    In many files, members in contact overlap a little; their section curve is then the contact once more.
    """
    pairs, known = solids_of(graph, sections), solids_of(graph, joined.pieces)
    kept = np.ones(len(sections), dtype=bool)
    for row in range(len(sections)):
        same = np.flatnonzero((known == pairs[row]).all(axis=1))
        if len(same):
            points = sample_pieces(graph, sections.select(np.array([row])), SHARES)[1][0]
            curves = sample_pieces(graph, joined.pieces.select(same), SHARES)[1]
            a, b = curves[:, :-1].reshape(-1, 3), curves[:, 1:].reshape(-1, 3)
            off = [distance_to_segments(np.broadcast_to(p, a.shape), a, b).min() for p in points]
            kept[row] = max(off) > NEAR_GAPS * gap_mm
    return sections.select(kept)


def _without_overlaps(graph: BrepGraph, joined: JoinedPieces) -> JoinedPieces:
    pieces = joined.pieces
    t0, t1 = pieces.t0.copy(), pieces.t1.copy()
    key = pieces.edge * len(graph.solid_names) + graph.face_solid[pieces.base]
    _, group, counts = np.unique(key, return_inverse=True, return_counts=True)
    rows_of: dict[int, list[int]] = defaultdict(list)
    for row in np.flatnonzero(counts[group] > 1).tolist():
        rows_of[int(group[row])].append(row)
    kept = np.ones(len(pieces), dtype=bool)
    for rows in rows_of.values():
        taken: list[Interval] = []
        for row in sorted(rows, key=lambda row: (float(pieces.gap_mm[row, 1]), row)):
            whole = (float(t0[row]), float(t1[row]))
            t0[row], t1[row] = left = _longest_free(whole, taken)
            cut = left != whole
            kept[row] = not cut or arc_length(graph, int(pieces.edge[row]), *left) >= LEAST_CANDIDATE_MM
            if kept[row]:
                taken.append(left)
    trimmed = SeamPieces(pieces.edge, t0, t1, pieces.wall, pieces.base, pieces.gap_mm)
    return JoinedPieces(trimmed, joined.joint, joined.weld).select(np.flatnonzero(kept))


def _longest_free(whole: Interval, taken: list[Interval]) -> Interval:
    """Return the longest part of an interval that no other covers; its length is zero if all is covered."""
    low, high = whole
    cuts = sorted({low, high, *(t for interval in taken for t in interval if low < t < high)})
    parts = [(a, b) for a, b in pairwise(cuts) if not _is_covered((a + b) / 2, taken)]
    return max(parts, key=lambda part: part[1] - part[0], default=(low, low))


def _is_covered(t: float, taken: list[Interval]) -> bool:
    return any(low <= t <= high for low, high in taken)


def _without_twins(graph: BrepGraph, joined: JoinedPieces, gap_mm: float) -> JoinedPieces:
    """Keep one of two coinciding pieces (edge of A on B, edge of B on A), a fillet rather than a groove."""
    pieces = joined.pieces
    groove = np.array([weld is not WeldType.FILLET for weld in joined.weld], dtype=bool)
    rank = np.empty(len(pieces), dtype=np.int64)
    rank[np.lexsort((np.arange(len(pieces)), pieces.gap_mm[:, 1], groove))] = np.arange(len(pieces))
    twins = _twins(graph, pieces, near=NEAR_GAPS * gap_mm)
    better, worse = np.where((rank[twins[:, 0]] < rank[twins[:, 1]])[:, None], twins, twins[:, ::-1]).T
    kept = np.ones(len(pieces), dtype=bool)
    for row in np.lexsort((rank[worse], rank[better])):
        if kept[better[row]]:
            kept[worse[row]] = False
    return joined.select(np.flatnonzero(kept))


def _twins(graph: BrepGraph, pieces: SeamPieces, *, near: float) -> IntArray:
    """Return pairs of pieces between the same solids whose middles and ends lie nearer than `near`; shape (k, 2)."""
    if len(pieces) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    start, middle, end = (
        evaluate_edges(graph, pieces.edge, t)[0] for t in (pieces.t0, (pieces.t0 + pieces.t1) / 2, pieces.t1)
    )
    solids = solids_of(graph, pieces)
    pairs = cKDTree(middle).query_pairs(near, output_type="ndarray").astype(np.int64)
    i, j = pairs[:, 0], pairs[:, 1]
    along = np.maximum(np.linalg.norm(start[i] - start[j], axis=1), np.linalg.norm(end[i] - end[j], axis=1))
    against = np.maximum(np.linalg.norm(start[i] - end[j], axis=1), np.linalg.norm(end[i] - start[j], axis=1))
    same = (solids[i] == solids[j]).all(axis=1) & (np.minimum(along, against) <= near)
    return np.asarray(pairs[same], dtype=np.int64)
