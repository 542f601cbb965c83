"""Which pieces of the boundary of a face may cross a meridian: each face is divided into strips along u.

A point is inside a face or not by the pieces that cross its meridian (`trim.py`). A plate with holes has hundreds of
pieces, of which a meridian crosses a few.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray, blocks, numbered_rows

SLACK = 1e-6  #: Pieces and faces are wider than they are by this, mm or rad: they are compared with rounded numbers.
WIDEST_RAD = np.pi / 2 - 1e-3
"""A boundary that is farther from the middle of its angles may go all the way round: its strips do so, too."""
PIECES = 2
"""There is one strip per this many pieces: more strips hold no fewer pieces each, as a piece begins in one or two."""
TOGETHER = 4_000  #: Faces that are divided together: all of a large part would take much memory.
MOST_STRIPS = 512  #: Of a face: a long straight piece is listed in each of them.


@dataclass(frozen=True, slots=True, eq=False)
class Strips:
    """The strips of F faces, and the pieces in each."""

    #: `low`, `width`: shape (F,). Where the strips of a face begin, and how far they go together, in u.
    low: FloatArray
    width: FloatArray
    turns: BoolArray  #: shape (F,). Whether u is an angle.
    first: IntArray  #: shape (F + 1,). The strips of face f are ``first[f]`` to ``first[f + 1] - 1``.
    start: IntArray  #: shape (s + 1,). The pieces in strip i are ``piece[start[i]:start[i + 1]]``, ascending.
    piece: IntArray  #: shape (k,).

    @classmethod
    def of(cls, turns: BoolArray, start: IntArray, begin: FloatArray, end: FloatArray) -> Strips:
        """Divide faces into strips.

        `turns`: shape (F,). Whether u is an angle, rad; otherwise it is a length or a parameter.
        `start`: shape (F + 1,). The pieces of face f are ``start[f]:start[f + 1]``.
        `begin`, `end`: shape (n,). Where the pieces begin and end, in u. One that turns goes the shorter way.
        """
        found = []
        for faces in blocks(len(turns), TOGETHER):
            own = start[faces.start : faces.stop + 1]
            some = slice(own[0], own[-1])
            *columns, piece = _divided(turns[faces], own - own[0], begin[some], end[some])
            found.append((*columns, piece + own[0]))
        low, width, strips, pieces, piece = (np.concatenate(column) for column in zip(*found, strict=True))
        first, start = (np.concatenate([[0], np.cumsum(counts)]) for counts in (strips, pieces))
        return cls(low, width, turns, first, start, piece)

    def pairs(self, faces: IntArray, u: FloatArray, most: int) -> Iterator[tuple[IntArray, IntArray]]:
        """Yield pairs of a row of `faces` and a piece of that face that may cross its meridian.

        `faces`: ndarray of int, shape (m,).
        `u`: shape (m,). The meridians.

        Yields
        ------
        row, piece : ndarray of int, shape (k,). By row, then piece.
        """
        at = _from(self.low, self.turns, faces, u)
        rows = np.flatnonzero((at >= -SLACK) & (at <= self.width[faces] + SLACK))
        first = self.first[faces[rows]]
        strips = self.first[faces[rows] + 1] - first
        number = np.floor(at[rows] / self.width[faces[rows]] * strips).astype(np.int64)
        strip = first + np.clip(number, 0, strips - 1)
        for row, item in items_in_chunks(self.start, strip, most):
            yield rows[row], self.piece[item]


def _divided(
    turns: BoolArray, start: IntArray, begin: FloatArray, end: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray, IntArray, IntArray]:
    """Return `low` and `width` of faces, how many strips each has, how many pieces each strip, and the pieces."""
    low, width = _ranges(turns, start, begin, end)
    face = np.repeat(np.arange(len(turns)), np.diff(start))
    strips = np.clip(np.diff(start) // PIECES, 1, MOST_STRIPS)
    first = np.cumsum(strips) - strips
    run = np.where(turns[face], wrap_angle(end - begin), end - begin)
    at = _from(low, turns, face, begin)
    share = strips[face] / width[face]
    least, most = (
        np.floor(u * share).astype(np.int64)
        for u in (np.minimum(at, at + run) - SLACK, np.maximum(at, at + run) + SLACK)
    )
    goes_round = turns[face] & (width[face] >= 2.0 * np.pi)
    least, most = (np.where(goes_round, number, np.clip(number, 0, strips[face] - 1)) for number in (least, most))
    count = np.minimum(most - least + 1, strips[face])
    row, number = numbered_rows(count)
    number = least[row] + number
    strip = first[face[row]] + np.mod(number, strips[face[row]])
    return low, width, strips, np.bincount(strip, minlength=strips.sum()), row[np.argsort(strip, kind="stable")]


def items_of(start: IntArray, rows: IntArray) -> tuple[IntArray, IntArray]:
    """Return pairs of a place in `rows`, shape (m,), and an item of row i: ``start[i]`` to ``start[i + 1] - 1``."""
    at, number = numbered_rows(start[rows + 1] - start[rows])
    return at, start[rows][at] + number


def items_in_chunks(start: IntArray, rows: IntArray, most: int) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the pairs of `items_of`, about `most` at a time; `start` has the shape (s + 1,), `rows` (m,)."""
    chunk = np.cumsum(start[rows + 1] - start[rows]) // most
    for own in np.split(np.arange(len(rows)), np.flatnonzero(np.diff(chunk)) + 1):
        at, item = items_of(start, rows[own])
        if len(at):
            yield own[at], item


def _ranges(turns: BoolArray, start: IntArray, begin: FloatArray, end: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where the boundary of each face begins in u, and how far it goes; without boundary any range."""
    low, width = np.zeros(len(turns)), np.full(len(turns), 2.0 * np.pi)
    faces = np.flatnonzero(np.diff(start) > 0)
    if len(faces) == 0:
        return low, width
    at, own = start[faces], np.repeat(np.arange(len(faces)), np.diff(start)[faces])
    least, most = np.minimum.reduceat(np.minimum(begin, end), at), np.maximum.reduceat(np.maximum(begin, end), at)
    x, y = (np.add.reduceat(turn(begin) + turn(end), at) for turn in (np.cos, np.sin))
    middle = np.arctan2(y, x)
    cosine = np.minimum.reduceat(np.minimum(*(np.cos(u - middle[own]) for u in (begin, end))), at)
    half = np.arccos(np.clip(cosine, -1.0, 1.0)) + SLACK
    narrow = half <= WIDEST_RAD
    low[faces] = np.where(turns[faces], np.where(narrow, middle - half, 0.0), least - SLACK)
    width[faces] = np.where(turns[faces], np.where(narrow, 2.0 * half, 2.0 * np.pi), most - least + 2.0 * SLACK)
    return low, width


def _from(low: FloatArray, turns: BoolArray, faces: IntArray, u: FloatArray) -> FloatArray:
    """Return how far values of u are from where the strips of their faces begin; angles the way round."""
    off = u - low[faces]
    return np.where(turns[faces], off - 2.0 * np.pi * np.floor(off / (2.0 * np.pi)), off)


def wrap_angle(angle: FloatArray) -> FloatArray:
    """Return angles of any shape in [-pi, pi), rad."""
    return np.asarray(angle - 2 * np.pi * np.floor(angle / (2 * np.pi) + 0.5), dtype=np.float64)  # mod is slower
