"""The direction of travel of chains of pieces (DESIGN §3), for all chains at once.

All runs are stored in one `SeamPieces`; `start` (n + 1 numbers) says where each run begins, and where the last one
ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.last_held import last_held
from wpcal.seam.chain import Chain, rounded_places
from wpcal.seam.pieces import sample_pieces
from wpcal.seam.seam import SeamPieces

CHUNK = 1000  #: Chains sampled in one array: some 50 MB at eight pieces per chain.
LOOP_SAMPLES = 65
"""Points per piece for finding the start of a loop, which is then refined: a piece is at most one turn."""
AREA_SAMPLES = 32  #: Points per piece for the area vector of a loop, of which only the signs are used.
UPRIGHT = 1e-6  #: A component of the area vector below this share of the largest one is round-off: the loop is upright.
HALVINGS = 60  #: Of a parameter interval: to the last bit.


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """Many runs of pieces, each in its direction of travel."""

    pieces: SeamPieces  #: The pieces of the first run in order, then those of the second, ….
    start: IntArray  #: shape (n + 1,). The pieces of run i are ``start[i]:start[i + 1]``.

    @classmethod
    def of(cls, runs: Sequence[SeamPieces]) -> Runs:
        """Store runs."""
        return cls(SeamPieces.joined(runs), np.cumsum([0, *(len(run) for run in runs)]))

    def __len__(self) -> int:
        return len(self.start) - 1

    @property
    def run_of_piece(self) -> IntArray:
        """The run that each piece belongs to."""
        return np.repeat(np.arange(len(self)), np.diff(self.start))

    def run(self, number: int) -> SeamPieces:
        """Return the pieces of one run."""
        return self.pieces.select(np.arange(self.start[number], self.start[number + 1]))

    def ends(self, graph: BrepGraph) -> tuple[FloatArray, FloatArray]:
        """Return the first and the last point of every run, two arrays (n, 3), mm."""
        first, last = self.start[:-1], self.start[1:] - 1
        p0 = evaluate_edges(graph, self.pieces.edge[first], self.pieces.t0[first])[0]
        return p0, evaluate_edges(graph, self.pieces.edge[last], self.pieces.t1[last])[0]


def directed_runs(graph: BrepGraph, pieces: SeamPieces, chains: list[Chain]) -> Runs:
    """Return the pieces of chains in the direction of travel of DESIGN §3. In the order of the chains.

    An open seam starts at its end with the smaller (x, y, z); a closed one at its point with the smallest (x, y, z),
    and runs so that its area vector has a positive z (then y, then x) component.
    """
    parts = [_directed(graph, pieces, chains[first : first + CHUNK]) for first in range(0, len(chains), CHUNK)]
    start = np.concatenate([[0], np.cumsum(np.concatenate([np.diff(part.start) for part in parts]))])
    return Runs(SeamPieces.joined([part.pieces for part in parts]), start)


def _directed(graph: BrepGraph, pieces: SeamPieces, chains: list[Chain]) -> Runs:
    rows, flip = (np.concatenate([getattr(chain, name) for chain in chains]) for name in ("rows", "flip"))
    start = np.concatenate([[0], np.cumsum([len(chain.rows) for chain in chains])])
    runs = Runs(pieces.select(rows).reversed_where(flip), start)
    closed = np.array([chain.closed for chain in chains], dtype=bool)
    p0, p1 = runs.ends(graph)
    runs = _backwards(runs, np.where(closed, _runs_clockwise(graph, runs), precedes(p1, p0)))
    return _from_smallest_points(graph, runs, closed)


def precedes(p: FloatArray, q: FloatArray) -> BoolArray:
    """Tell which rows of p come before those of q, compared by x, then y, then z after rounding, shape (n,).

    `p`, `q`: shape (n, 3). Points in one frame, mm.
    """
    a, b = rounded_places(p), rounded_places(q)
    before = a[:, 2] < b[:, 2]
    for k in (1, 0):
        before = (a[:, k] < b[:, k]) | ((a[:, k] == b[:, k]) & before)
    return np.asarray(before, dtype=bool)


def _backwards(runs: Runs, flip: BoolArray) -> Runs:
    """Reverse the runs marked in `flip`."""
    run = runs.run_of_piece
    rows = np.arange(len(run))
    rows = np.where(flip[run], runs.start[run] + runs.start[run + 1] - 1 - rows, rows)
    return Runs(runs.pieces.select(rows).reversed_where(flip[run]), runs.start)


def _runs_clockwise(graph: BrepGraph, runs: Runs) -> BoolArray:
    """Tell which loops have an area vector that points down (z, then y, then x)."""
    share = np.linspace(0.0, 1.0, AREA_SAMPLES, endpoint=False)
    p = sample_pieces(graph, runs.pieces, share)[1].reshape(-1, 3)
    start = runs.start[:-1] * AREA_SAMPLES
    count = np.diff(runs.start) * AREA_SAMPLES
    p = p - np.repeat(np.add.reduceat(p, start) / count[:, None], count, axis=0)
    after = np.arange(1, len(p) + 1)
    after[start + count - 1] = start
    area = np.add.reduceat(np.cross(p, p[after]), start)
    size = np.abs(area).max(axis=1)
    down = np.zeros(len(area), dtype=bool)
    for k in (0, 1, 2):  # y overrides x, and z both
        down = np.where(np.abs(area[:, k]) > UPRIGHT * size, area[:, k] < 0, down)
    return down


def _from_smallest_points(graph: BrepGraph, runs: Runs, closed: BoolArray) -> Runs:
    """Let each closed run begin at its point with the smallest (x, y, z); a piece is cut in two there if necessary."""
    count = np.diff(runs.start)
    shift, inner = np.zeros(len(runs), dtype=np.int64), np.zeros(len(runs), dtype=bool)
    cut = np.zeros(len(runs))
    loops = np.flatnonzero(closed)
    row, cut[loops] = _smallest_points(graph, runs, loops)
    at_end = cut[loops] == runs.pieces.t1[row]
    inner[loops] = ~at_end & (cut[loops] != runs.pieces.t0[row])
    shift[loops] = row - runs.start[loops] + at_end
    start = np.concatenate([[0], np.cumsum(count + inner)])
    run = np.repeat(np.arange(len(runs)), count + inner)
    place = np.arange(start[-1]) - start[run]
    turned = runs.pieces.select(runs.start[run] + (shift[run] + place) % count[run])
    turned.t0[start[:-1][inner]] = cut[inner]
    turned.t1[start[1:][inner] - 1] = cut[inner]
    return Runs(turned, start)


def _smallest_points(graph: BrepGraph, runs: Runs, loops: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the piece with the smallest point of each loop, and the parameter there."""
    run = runs.run_of_piece
    rows = np.flatnonzero(np.isin(run, loops))
    t, p = sample_pieces(graph, runs.pieces.select(rows), np.linspace(0.0, 1.0, LOOP_SAMPLES))
    x, y, z = rounded_places(p.reshape(-1, 3)).T
    of_sample = np.repeat(run[rows], LOOP_SAMPLES)
    order = np.lexsort((z, y, x, of_sample))
    first = order[np.flatnonzero(np.diff(of_sample[order], prepend=-1))]
    at, column = first // LOOP_SAMPLES, first % LOOP_SAMPLES
    cut = t[at, column]
    inner = np.flatnonzero((column > 0) & (column < LOOP_SAMPLES - 1))
    around = t[at[inner, None], column[inner, None] + np.array([-1, 0, 1])]
    cut[inner] = _lowest_x(graph, runs.pieces.edge[rows[at[inner]]], around)
    return rows[at], cut


def _lowest_x(graph: BrepGraph, edge: IntArray, t: FloatArray) -> FloatArray:
    """Return where x is least between t[:, 0] and t[:, 2]: at the zero of its slope, or t[:, 1] if there is no zero."""
    way = np.sign(t[:, 2] - t[:, 0])

    def slope(row: IntArray, at: FloatArray) -> FloatArray:
        return np.asarray(evaluate_edges(graph, edge[row], at)[1][:, 0] * way[row], dtype=np.float64)

    rows = np.arange(len(t))
    turns = (slope(rows, t[:, 0]) < 0) & (slope(rows, t[:, 2]) > 0)
    low, high = last_held(t[:, 0], t[:, 2], lambda row, at: slope(row, at) < 0, halvings=HALVINGS)
    return np.where(turns, (low + high) / 2, t[:, 1])
