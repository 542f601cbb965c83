"""Between which first parameters u the boundary of a face lies: no piece of it crosses a meridian outside of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import SurfaceKind
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

ROUND = (SurfaceKind.CYLINDER, SurfaceKind.CONE)
SLACK = 1e-6
"""A range is wider than the boundary by this, mm or rad: pieces are compared with rounded numbers."""
WIDEST_RAD = np.pi / 2 - 1e-3
"""A boundary that is farther from the middle of its angles may go all the way round: it has no range."""


@dataclass(frozen=True, slots=True, eq=False)
class URanges:
    """The ranges of u of the boundaries of F faces: the middle and half the width, which may be infinite.

    Parameters
    ----------
    middle, half : ndarray, shape (F,)
        mm on planes, rad on cylinders and cones; half is infinite on all other faces.
    is_round : ndarray of bool, shape (F,)
        Whether u is an angle.
    """

    middle: FloatArray
    half: FloatArray
    is_round: BoolArray

    @classmethod
    def of(cls, kinds: IntArray, start: IntArray, first: FloatArray, last: FloatArray) -> URanges:
        """Measure the ranges.

        Parameters
        ----------
        kinds : ndarray of int, shape (F,)
        start : ndarray of int, shape (F + 1,)
            The pieces of face i are ``start[i]:start[i + 1]``.
        first, last : ndarray, shape (n,)
            Where the pieces begin and end, in u.
        """
        middle, half, is_round = np.zeros(len(kinds)), np.full(len(kinds), np.inf), np.isin(kinds, ROUND)
        faces = np.flatnonzero(np.diff(start) > 0)
        if len(faces) == 0:
            return cls(middle, half, is_round)
        at, own = start[faces], np.repeat(np.arange(len(faces)), np.diff(start)[faces])
        low, high = np.minimum.reduceat(np.minimum(first, last), at), np.maximum.reduceat(np.maximum(first, last), at)
        x, y = (np.add.reduceat(turn(first) + turn(last), at) for turn in (np.cos, np.sin))
        angle = np.arctan2(y, x)
        cosine = np.minimum.reduceat(np.minimum(*(np.cos(u - angle[own]) for u in (first, last))), at)
        width = np.arccos(np.clip(cosine, -1.0, 1.0))
        turns, flat = is_round[faces], kinds[faces] == SurfaceKind.PLANE
        middle[faces] = np.where(turns, angle, (low + high) / 2)
        narrow = np.where(width <= WIDEST_RAD, width + SLACK, np.inf)
        half[faces] = np.where(turns, narrow, np.where(flat, (high - low) / 2 + SLACK, np.inf))
        return cls(middle, half, is_round)

    def hold(self, faces: IntArray, u: FloatArray) -> BoolArray:
        """Tell which values of u, shape (m,), are in the range of their face, shape (m,)."""
        off, half = np.abs(u - self.middle[faces]), self.half[faces]
        turns = self.is_round[faces]
        return np.where(turns, (off <= half) | (2.0 * np.pi - off <= half), off <= half)
