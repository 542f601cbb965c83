"""Consecutive pieces: from pieces of edges to curves."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import near_pairs
from wpcal.seam.seam import SeamPieces

SAME_POINT_MM = 0.01  #: Ends nearer than this are one point: kernels place vertices within 1e-3 mm or better.
ROUND_MM = 1e-6  #: Coordinates are compared after rounding to this (DESIGN §3).


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Pieces in order."""

    rows: IntArray  #: shape (k,). Rows of the pieces in order.
    flip: BoolArray  #: shape (k,). Whether a piece is reversed.
    closed: bool


@dataclass(frozen=True, slots=True, eq=False)
class Bridges:
    """Which ends of pieces may be joined by a straight bridge."""

    join_mm: float  #: Largest length of a bridge, mm.
    slip_mm: float  #: How far a bridge may lead sideways, mm.
    #: shape (k, 2, 3). Direction out of the joint at the start and at the end of each piece. On both ends of a bridge
    #: it is the same within the angle by which the direction of travel may turn.
    side: FloatArray


def chain_pieces(
    graph: BrepGraph, pieces: SeamPieces, group: IntArray, *, split_rad: float, bridges: Bridges | None = None
) -> list[Chain]:
    """Join consecutive pieces of one group if the direction turns by at most `split_rad`.

    `group`: shape (k,). Only pieces with the same number are joined.
    `split_rad`: Largest turn of the direction of travel from one piece to the next, rad.
    """
    p, out = _ends(graph, pieces)
    link = _links(p.reshape(-1, 3), out.reshape(-1, 3), np.repeat(group, 2), np.cos(split_rad))
    if bridges is not None:
        _add_bridges(link, p.reshape(-1, 3), out.reshape(-1, 3), np.repeat(group, 2), bridges, np.cos(split_rad))
    used = np.zeros(len(pieces), dtype=bool)
    loose = [end for end in range(2 * len(pieces)) if end not in link]
    starts = [*loose, *range(0, 2 * len(pieces), 2)]
    return [_walk(start, link, used) for start in starts if not used[start // 2]]


def _ends(graph: BrepGraph, pieces: SeamPieces) -> tuple[FloatArray, FloatArray]:
    """Return the two end points of each piece and the unit directions that leave it there; arrays (k, 2, 3)."""
    p, out = [], []
    for t, other in ((pieces.t0, pieces.t1), (pieces.t1, pieces.t0)):
        point, slope = evaluate_edges(graph, pieces.edge, t)
        way = slope * np.sign(t - other)[:, None]
        p.append(point)
        out.append(way / np.linalg.norm(way, axis=1, keepdims=True))
    return np.stack(p, axis=1), np.stack(out, axis=1)


def _links(p: FloatArray, out: FloatArray, group: IntArray, least_cos: float) -> dict[int, int]:
    """Pair ends that continue each other, the straightest pairs first; each end is paired once."""
    a, b = near_pairs(p, SAME_POINT_MM).T
    straight = -np.einsum("ki,ki->k", out[a], out[b])
    fits = (group[a] == group[b]) & (straight >= least_cos)
    order = np.lexsort((b[fits], a[fits], np.round(-straight[fits], 9)))
    link: dict[int, int] = {}
    for i, j in zip(a[fits][order], b[fits][order], strict=True):
        if i not in link and j not in link:
            link[int(i)], link[int(j)] = int(j), int(i)
    return link


def _add_bridges(
    link: dict[int, int], p: FloatArray, out: FloatArray, group: IntArray, bridges: Bridges, least_cos: float
) -> None:
    """Pair ends that are left, the nearest first, if each goes on towards the other on one side of the joint."""
    ends = np.array([end for end in range(len(p)) if end not in link], dtype=np.int64)
    if len(ends) == 0:
        return
    a, b = ends[near_pairs(p[ends], bridges.join_mm)].T
    way = p[b] - p[a]
    length = np.linalg.norm(way, axis=1)
    side = bridges.side.reshape(-1, 3)
    fits = (group[a] == group[b]) & (-np.einsum("ki,ki->k", out[a], out[b]) >= least_cos)
    fits &= (np.einsum("ki,ki->k", side[a], side[b]) >= least_cos) & (a // 2 != b // 2)
    for end, towards in ((a, way), (b, -way)):
        along = np.einsum("ki,ki->k", out[end], towards)
        aside = np.linalg.norm(towards - along[:, None] * out[end], axis=1)
        fits &= (along >= -bridges.slip_mm) & (aside <= bridges.slip_mm)
    order = np.lexsort((b[fits], a[fits], np.round(length[fits], 6)))
    for i, j in zip(a[fits][order].tolist(), b[fits][order].tolist(), strict=True):
        if i not in link and j not in link:
            link[i], link[j] = j, i


def _walk(start: int, link: dict[int, int], used: BoolArray) -> Chain:
    rows, flip = [], []
    end, closed = start, False
    while not used[end // 2]:
        used[end // 2] = True
        rows.append(end // 2)
        flip.append(end % 2 == 1)
        beyond = link.get(end ^ 1)
        if beyond is None:
            break
        closed = beyond == start
        end = beyond
    return Chain(np.array(rows, dtype=np.int64), np.array(flip, dtype=bool), closed)


def rounded_places(p: FloatArray) -> FloatArray:
    """Return places, shape (n, k), for comparing: rounded to `ROUND_MM`, without a negative zero."""
    return np.asarray(np.round(p / ROUND_MM) * ROUND_MM + 0.0, dtype=np.float64)


def groups(keys: list[tuple[object, ...]]) -> IntArray:
    """Return the number of each key: equal keys have equal numbers, in the order of first use."""
    numbers: dict[tuple[object, ...], int] = defaultdict(lambda: len(numbers))
    return np.array([numbers[key] for key in keys], dtype=np.int64)
