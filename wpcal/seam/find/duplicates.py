"""The same seam found twice: by an edge of either member, or by one edge on two neighbouring faces."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise

import numpy as np

from wpcal.brep.boxes import BoxTree
from wpcal.brep.curves import arc_length, evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import distance_to_segments
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import near_pairs
from wpcal.seam.find.contact import CONTACT_SAMPLES
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.limits import LEAST_CANDIDATE_MM, NEAR_GAPS
from wpcal.seam.pieces import sample_pieces, solids_of
from wpcal.seam.seam import JointType, SeamPieces, WeldType

Interval = tuple[float, float]
SHARES = np.linspace(0.0, 1.0, CONTACT_SAMPLES)  #: Places along a piece at which curves are compared.
COVER_SHARES = np.linspace(0.0, 1.0, 9)
"""Places along a piece at which it is compared with better ones: neither is shorter than the gap between two others."""
CURVE_SAMPLES = 129
"""Points of a curved piece for distances: on a circle of 1000 mm radius it is 0.3 mm from its chords."""
SAME_SIDE_COS = 0.3
"""Two pieces in one place are one weld if the cosine between their directions out of the joint is above this. Fillet
and flush groove are 45 degrees apart; the two fillets of a thin plate, and the two sides of bars that touch along their
edges, 90 degrees or more."""
MIDDLE_SHARES = (0.4, 0.6)
"""Places near the middle of a piece; one of them is not where two others meet, as at the start of a circle."""
PARALLEL_COS = 0.85  #: Pieces run along each other within 32 degrees.
SAME_MM = 1e-9  #: A point is beyond the end of a piece if the end is the nearest point, within round-off.
OPPOSED_LENGTH = 1e-6  #: The sum of two opposed normals is shorter than this: they say nothing about the side.
WORDS = (JointType.TEE, JointType.LAP, JointType.CORNER, JointType.BUTT, JointType.EDGE, JointType.UNKNOWN)
"""The joint words; where two descriptions of one weld differ, the earlier one is taken, so equal joints have equal
words."""
ROUND_DIGITS = 6
"""Gaps, mm, are compared after rounding to this many digits: otherwise round-off decides between equal ones."""
CHUNK = 200_000  #: Points compared with segments in one array: some 50 MB.


def without_duplicates(graph: BrepGraph, joined: JoinedPieces, *, gap_mm: float) -> JoinedPieces:
    """Return pieces of which no two cover the same stretch of the same joint.

    `gap_mm`: Gap within which they were found, mm.

    Returns: If one edge is near two faces of the other member, the stretch belongs to the nearer face. If an edge of A
    on B and an edge of B on A coincide, a fillet is preferred to a groove, then the smaller gap, then the joint word
    (`WORDS`). A piece that runs all along such better ones is left out. Welds on opposite sides of one contact are two
    welds.
    """
    return without_covered(graph, _without_twins(graph, _without_overlaps(graph, joined), gap_mm), gap_mm=gap_mm)


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
    side = outward(graph, pieces, (t0 + t1) / 2)
    for rows in rows_of.values():
        taken: list[tuple[int, Interval]] = []
        for row in sorted(rows, key=lambda row: (round(float(pieces.gap_mm[row, 1]), ROUND_DIGITS), row)):
            whole = (float(t0[row]), float(t1[row]))
            beside = [interval for other, interval in taken if _is_one_side(side[row], side[other])]
            t0[row], t1[row] = left = _longest_free(whole, beside)
            cut = left != whole
            kept[row] = not cut or arc_length(graph, int(pieces.edge[row]), *left) >= LEAST_CANDIDATE_MM
            if kept[row]:
                taken.append((row, left))
    trimmed = SeamPieces(pieces.edge, t0, t1, pieces.wall, pieces.base, pieces.gap_mm)
    return JoinedPieces(trimmed, joined.joint, joined.weld).select(np.flatnonzero(kept))


def _is_one_side(one: FloatArray, other: FloatArray) -> bool:
    """Tell whether two directions out of a joint are on one side of it; a missing one is on either."""
    return bool(one @ other > SAME_SIDE_COS) or not (one.any() and other.any())


def _longest_free(whole: Interval, taken: list[Interval]) -> Interval:
    """Return the longest part of an interval that no other covers; its length is zero if all is covered."""
    low, high = whole
    cuts = sorted({low, high, *(t for interval in taken for t in interval if low < t < high)})
    parts = [(a, b) for a, b in pairwise(cuts) if not any(one <= (a + b) / 2 <= other for one, other in taken)]
    return max(parts, key=lambda part: part[1] - part[0], default=(low, low))


def _ranks(graph: BrepGraph, joined: JoinedPieces, *, by_length: bool) -> IntArray:
    """Return the rank of each piece: the lower is kept where two are the same weld."""
    pieces = joined.pieces
    groove = np.array([weld is not WeldType.FILLET for weld in joined.weld], dtype=bool)
    word = np.array([WORDS.index(joint) for joint in joined.joint], dtype=np.int64)
    chords = np.diff(sample_pieces(graph, pieces, SHARES)[1], axis=1) if by_length else np.zeros((len(pieces), 1, 3))
    length = np.round(np.linalg.norm(chords, axis=2).sum(axis=1), 3)
    rank = np.empty(len(pieces), dtype=np.int64)
    columns = (np.arange(len(pieces)), word, np.round(pieces.gap_mm[:, 1], ROUND_DIGITS), -length, groove)
    rank[np.lexsort(columns)] = np.arange(len(pieces))
    return rank


def _without_twins(graph: BrepGraph, joined: JoinedPieces, gap_mm: float) -> JoinedPieces:
    """Keep one of two coinciding pieces (edge of A on B, edge of B on A), a fillet rather than a groove."""
    pieces = joined.pieces
    rank = _ranks(graph, joined, by_length=False)
    twins = _twins(graph, pieces, near=NEAR_GAPS * gap_mm)
    better, worse = np.where((rank[twins[:, 0]] < rank[twins[:, 1]])[:, None], twins, twins[:, ::-1]).T
    kept = np.ones(len(pieces), dtype=bool)
    for row in np.lexsort((rank[worse], rank[better])):
        if kept[better[row]]:
            kept[worse[row]] = False
    return joined.select(np.flatnonzero(kept))


def without_covered(graph: BrepGraph, joined: JoinedPieces, *, gap_mm: float) -> JoinedPieces:
    """Leave out pieces that run all along better ones of the same two solids, on the same side.

    Where the rim of a ring comes near the border of its plate, the border is in contact with the ring as well. It is
    the same weld.

    `gap_mm`: Gap within which they were found, mm.
    """
    pieces, near = joined.pieces, NEAR_GAPS * gap_mm
    if len(pieces) == 0:
        return joined
    rank = _ranks(graph, joined, by_length=True)
    points = sample_pieces(graph, pieces, COVER_SHARES)[1]
    low, high = points.min(axis=1), points.max(axis=1)
    solids = solids_of(graph, pieces)
    worse, better = BoxTree.of(low - 2.0 * near, high + 2.0 * near).meeting(low, high)
    pairs = (rank[better] < rank[worse]) & (solids[worse] == solids[better]).all(axis=1)
    worse, better = worse[pairs], better[pairs]
    pairs = _are_beside(graph, pieces, worse, better)
    worse, better = worse[pairs], better[pairs]
    is_near = are_near(graph, pieces, points[worse], better, near)
    kept = np.ones(len(pieces), dtype=bool)
    order = np.argsort(rank[worse], kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(worse[order])) + 1) if len(order) else ():
        others = rows[kept[better[rows]]]
        kept[worse[rows[0]]] = not is_near[others].any(axis=0).all()
    return joined.select(np.flatnonzero(kept))


def are_near(graph: BrepGraph, pieces: SeamPieces, points: FloatArray, row: IntArray, near: float) -> BoolArray:
    """Tell which points, shape (k, n, 3), are nearer than `near` to the piece at `row`, shape (k,)."""
    found = np.zeros(points.shape[:2], dtype=bool)
    straight = graph.edge_kind[pieces.edge[row]] == CurveKind.LINE
    for rows, count in ((np.flatnonzero(straight), 2), (np.flatnonzero(~straight), CURVE_SAMPLES)):
        for own in np.array_split(rows, max(1, len(rows) * count * points.shape[1] // CHUNK)):
            curve = sample_pieces(graph, pieces.select(row[own]), np.linspace(0.0, 1.0, count))[1]
            shape = (len(own), points.shape[1], count - 1, 3)
            p = np.broadcast_to(points[own][:, :, None], shape).reshape(-1, 3)
            ends = (np.broadcast_to(end[:, None], shape).reshape(-1, 3) for end in (curve[:, :-1], curve[:, 1:]))
            found[own] = distance_to_segments(p, *ends).reshape(shape[:3]).min(axis=2) <= near
    return found


def _are_beside(graph: BrepGraph, pieces: SeamPieces, row: IntArray, other: IntArray) -> BoolArray:
    """Tell which first pieces of pairs are beside the second near their middle: parallel, on its side of the joint.

    What only follows the end of the second, in its direction or across it, is not beside it.
    """
    beside = np.zeros(len(row), dtype=bool)
    for share in MIDDLE_SHARES:
        own = np.flatnonzero(~beside)
        t = pieces.t0[row[own]] * (1.0 - share) + pieces.t1[row[own]] * share
        beside[own] = _is_beside(graph, pieces.select(row[own]), t, pieces.select(other[own]))
    return beside


def _is_beside(graph: BrepGraph, pieces: SeamPieces, at: FloatArray, along: SeamPieces) -> BoolArray:
    p, slope = evaluate_edges(graph, pieces.edge, at)
    t, curve = sample_pieces(graph, along, SHARES)
    a, b = curve[:, :-1].reshape(-1, 3), curve[:, 1:].reshape(-1, 3)
    off = distance_to_segments(np.repeat(p, len(SHARES) - 1, axis=0), a, b).reshape(len(p), len(SHARES) - 1)
    rows, nearest = np.arange(len(p)), np.argmin(off, axis=1)
    to_ends = np.linalg.norm(curve[:, [0, -1]] - p[:, None], axis=2).min(axis=1)
    way = (curve[:, 1:] - curve[:, :-1])[rows, nearest]
    cosine = np.einsum("ki,ki->k", way, slope) / np.linalg.norm(way, axis=1) / np.linalg.norm(slope, axis=1)
    beside = (off[rows, nearest] < to_ends - SAME_MM) & (np.abs(cosine) > PARALLEL_COS)
    here = outward(graph, pieces, at)
    there = outward(graph, along, (t[rows, nearest] + t[rows, nearest + 1]) / 2)
    facing = np.einsum("ki,ki->k", here, there) > SAME_SIDE_COS
    return np.asarray(beside & (facing | ~here.any(axis=1) | ~there.any(axis=1)), dtype=bool)


def outward(graph: BrepGraph, pieces: SeamPieces, t: FloatArray) -> FloatArray:
    """Return the direction out of the joint at a place of each piece.

    `t`: shape (k,). Edge parameters.
    Returns ndarray, shape (k, 3). Unit vectors; zero where the two normals are opposed.
    """
    p = evaluate_edges(graph, pieces.edge, t)[0]
    sides = sum(project_to_faces(graph, face, p).normal for face in (pieces.wall, pieces.base))
    length = np.linalg.norm(sides, axis=1, keepdims=True)
    return np.asarray(sides / np.where(length > OPPOSED_LENGTH, length, np.inf), dtype=np.float64)


def _twins(graph: BrepGraph, pieces: SeamPieces, *, near: float) -> IntArray:
    """Return pairs of pieces between the same solids whose middles and ends lie nearer than `near`; shape (k, 2)."""
    if len(pieces) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    start, middle, end = (
        evaluate_edges(graph, pieces.edge, t)[0] for t in (pieces.t0, (pieces.t0 + pieces.t1) / 2, pieces.t1)
    )
    solids = solids_of(graph, pieces)
    pairs = near_pairs(middle, near)
    i, j = pairs[:, 0], pairs[:, 1]
    along = np.maximum(np.linalg.norm(start[i] - start[j], axis=1), np.linalg.norm(end[i] - end[j], axis=1))
    against = np.maximum(np.linalg.norm(start[i] - end[j], axis=1), np.linalg.norm(end[i] - start[j], axis=1))
    same = (solids[i] == solids[j]).all(axis=1) & (np.minimum(along, against) <= near)
    i, j = i[same], j[same]
    return np.asarray(pairs[same][_are_beside(graph, pieces, i, j)], dtype=np.int64)
