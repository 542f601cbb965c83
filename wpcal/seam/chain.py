"""Pieces in a row: from pieces of edges to curves with one direction."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.seam import SeamPieces

SAME_POINT_MM = 0.01
"""Ends nearer than this are one point: kernels keep vertices to 1e-3 mm or better."""
LOOP_SAMPLES = 65
"""Points a piece at which the start of a loop is sought before it is refined: a piece is at most one turn."""
ROUND_MM = 1e-6
"""Coordinates are compared after rounding to this (DESIGN §3)."""


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Pieces in order.

    Parameters
    ----------
    rows : ndarray of int, shape (k,)
        Rows of the pieces in order.
    flip : ndarray of bool, shape (k,)
        Whether a piece runs backwards.
    closed : bool
    """

    rows: IntArray
    flip: BoolArray
    closed: bool


def chain_pieces(graph: BrepGraph, pieces: SeamPieces, group: IntArray, *, split_rad: float) -> list[Chain]:
    """Join pieces of one group that follow each other with a turn of at most `split_rad`.

    Parameters
    ----------
    graph : BrepGraph
    pieces : SeamPieces
    group : ndarray of int, shape (k,)
        Only pieces of the same group are joined.
    split_rad : float
        Largest turn of the direction of travel from one piece to the next, rad.

    Returns
    -------
    list of Chain
    """
    p, out = _ends(graph, pieces)
    link = _links(p.reshape(-1, 3), out.reshape(-1, 3), np.repeat(group, 2), np.cos(split_rad))
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
    """Pair ends that continue each other, the straightest pairs first; an end is paired once."""
    near = cKDTree(p).query_pairs(SAME_POINT_MM, output_type="ndarray") if len(p) else np.zeros((0, 2), dtype=np.int64)
    a, b = near[:, 0], near[:, 1]
    straight = -np.einsum("ki,ki->k", out[a], out[b])
    fits = (group[a] == group[b]) & (straight >= least_cos)
    order = np.lexsort((b[fits], a[fits], np.round(-straight[fits], 9)))
    link: dict[int, int] = {}
    for i, j in zip(a[fits][order], b[fits][order], strict=True):
        if i not in link and j not in link:
            link[int(i)], link[int(j)] = int(j), int(i)
    return link


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


def directed(graph: BrepGraph, pieces: SeamPieces, chain: Chain) -> SeamPieces:
    """Return the pieces of a chain in the direction of travel of DESIGN §3.

    An open seam starts at its end with the smaller (x, y, z); a closed one at its point with the smallest (x, y, z),
    and runs so that its area vector has a positive z (then y, then x) component.
    """
    run = pieces.select(chain.rows).reversed_where(chain.flip)
    if not chain.closed:
        p0, p1 = evaluate_edges(graph, run.edge, run.t0)[0], evaluate_edges(graph, run.edge, run.t1)[0]
        return _backwards(run) if rounded(p1[-1]) < rounded(p0[0]) else run
    return _from_smallest_point(graph, _backwards(run) if _runs_clockwise(graph, run) else run)


def _from_smallest_point(graph: BrepGraph, run: SeamPieces) -> SeamPieces:
    """Let a closed run begin at its point with the smallest (x, y, z), where a piece is cut in two if need be."""
    share = np.linspace(0.0, 1.0, LOOP_SAMPLES)
    t = run.t0[:, None] + (run.t1 - run.t0)[:, None] * share
    p = evaluate_edges(graph, np.repeat(run.edge, LOOP_SAMPLES), t.ravel())[0]
    row, column = divmod(min(range(len(p)), key=lambda i: rounded(p[i])), LOOP_SAMPLES)
    inner = 0 < column < LOOP_SAMPLES - 1
    cut = _lowest_x(graph, int(run.edge[row]), t[row, column - 1 : column + 2]) if inner else float(t[row, column])
    order = np.roll(np.arange(len(run)), -row)
    if cut == run.t0[row]:
        return run.select(order)
    if cut == run.t1[row]:
        return run.select(np.roll(order, -1))
    turned = run.select(np.append(order, row))
    turned.t0[0], turned.t1[-1] = cut, cut
    return turned


def _lowest_x(graph: BrepGraph, edge: int, t: FloatArray) -> float:
    """Return where x is least between t[0] and t[2]: the zero of its slope, or t[1] where it has none."""
    slopes = evaluate_edges(graph, np.full(3, edge), t)[1][:, 0] * np.sign(t[2] - t[0])
    if not slopes[0] < 0 < slopes[2]:
        return float(t[1])
    low, high = t[0], t[2]
    for _ in range(60):  # to the last bit
        middle = (low + high) / 2
        falls = evaluate_edges(graph, [edge], [middle])[1][0, 0] * np.sign(t[2] - t[0]) < 0
        low, high = (middle, high) if falls else (low, middle)
    return float((low + high) / 2)


def rounded(p: FloatArray) -> tuple[float, ...]:
    """Return coordinates for comparing places: rounded to 1e-6 mm, without a negative zero."""
    return tuple((np.round(p / ROUND_MM) * ROUND_MM + 0.0).tolist())


def _backwards(run: SeamPieces) -> SeamPieces:
    back = run.select(np.arange(len(run))[::-1])
    return back.reversed_where(np.ones(len(run), dtype=bool))


def _runs_clockwise(graph: BrepGraph, run: SeamPieces) -> bool:
    """Tell whether a loop's area vector points down (z, then y, then x)."""
    share = np.linspace(0.0, 1.0, 32, endpoint=False)
    t = run.t0[:, None] + (run.t1 - run.t0)[:, None] * share
    p = evaluate_edges(graph, np.repeat(run.edge, len(share)), t.ravel())[0]
    p = p - p.mean(axis=0)
    area = np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0) / 2
    size = np.abs(area).max()
    for value in area[::-1]:
        if abs(value) > 1e-6 * size:  # a component below that is round-off of a loop that stands upright
            return bool(value < 0)
    return False


def groups(keys: list[tuple[object, ...]]) -> IntArray:
    """Return one number for each distinct key, in the order of first use."""
    numbers: dict[tuple[object, ...], int] = defaultdict(lambda: len(numbers))
    return np.array([numbers[key] for key in keys], dtype=np.int64)
