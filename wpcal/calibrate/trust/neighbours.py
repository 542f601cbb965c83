"""Was a point touched on another feature than its row says? Each suspicious point is tried on the other features.

One assignment is exchanged at a time. A point that the others contradict is tried on every feature of the part; it
must then fit the others as a good point does. If the others name no point, every point is tried on the features near
its own, and the sum of squares must fall by a factor that good points reach by chance in one file of a hundred.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, fdtrc

from wpcal.calibrate.solve.error_rows import ErrorRows
from wpcal.calibrate.trust.residuals import CLEAR_FACTOR, FALSE_ALARM
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.pairs import PointPairs

NEAR = 16
"""Nearest other places that every point is tried on if no point is named: the corners and edge middles around it."""
SAME_PLACE_MM = 1e-4  #: Features nearer than this are one place: the rim of a hole and its circle.


@dataclass(frozen=True, slots=True, eq=False)
class FeaturePlaces:
    """Places of the part that can be touched as points, each once."""

    names: tuple[str, ...]  #: length k. Of the features; those at the same place are joined by a space.
    p: FloatArray  #: shape (k, 3). In `part`, mm.

    @classmethod
    def of(cls, features: Mapping[str, FloatArray]) -> FeaturePlaces:
        """Collect features by name, each with a point in `part`, shape (3,), mm."""
        points = np.array(list(features.values()), dtype=np.float64).reshape(-1, 3)
        cells = np.rint(points / SAME_PLACE_MM).tolist()
        seen: dict[tuple[float, ...], list[int]] = {}
        for row, cell in enumerate(map(tuple, cells)):
            seen.setdefault(cell, []).append(row)
        known = list(features)
        names = tuple(" ".join(known[row] for row in rows) for rows in seen.values())
        return cls(names, points[[rows[0] for rows in seen.values()]])

    def at(self, point: FloatArray) -> str:
        """Name of the feature at a point in `part`, shape (3,), mm; empty if there is none."""
        near = np.flatnonzero(np.abs(self.p - point).max(axis=1) <= 2.0 * SAME_PLACE_MM)
        return self.names[int(near[0])] if len(near) else ""


@dataclass(frozen=True, slots=True)
class Neighbour:
    """One exchanged assignment."""

    row: int
    place: int  #: Index into the places.
    total: float  #: Sum of squares with it.


def find_neighbours(
    pairs: PointPairs, places: FeaturePlaces, *, named: tuple[int, ...], sigma_mm: float | None
) -> tuple[Neighbour, ...]:
    """Find the rows that fit if they were touched on another feature.

    `pairs`: At least four, mm.
    Returns: One per row. Empty if no exchange explains the data, or several do about as well.
    """
    if not len(places.p) or len(pairs) < 4:
        return ()
    rows = ErrorRows.of(pairs, sigma_mm)
    shifted = places.p - pairs.p_source.mean(axis=0)
    if len(named) < 2:
        found = _of_any(rows, shifted)  # a feature is stronger evidence than an error of any direction
        if found is not None:
            return (found,)
    each = (_of_named(rows, shifted, row, [i for i in range(len(rows)) if i not in named]) for row in named)
    return tuple(found for found in each if found is not None)


def _of_named(rows: ErrorRows, places: FloatArray, row: int, others: list[int]) -> Neighbour | None:
    apart = np.linalg.norm(places - rows.p[row], axis=1) > SAME_PLACE_MM
    rest = rows.select(np.array(others))
    freedom, before = 3 * len(others) - 6, rest.sum_of_squares()
    tried = rows.select(np.array([*others, row]))
    sums = np.where(apart, _sums(tried, np.full(len(places), len(others)), places), np.inf)
    best = int(np.argmin(sums))
    added = max(float(sums[best]) - before, 0.0)
    if rows.scaled:
        chance = float(chdtrc(3, added))
    else:
        floor = rows.floor(freedom)
        chance = float(fdtrc(3, freedom, added / 3.0 / ((before + floor) / freedom)))
    if chance < FALSE_ALARM or not _is_clear(rows, sums, best):
        return None
    return Neighbour(row, best, float(sums[best]))


def _of_any(rows: ErrorRows, places: FloatArray) -> Neighbour | None:
    n, total = len(rows), rows.sum_of_squares()
    distance = np.linalg.norm(rows.p[:, None] - places[None], axis=2)
    distance[:, distance.min(axis=0) <= SAME_PLACE_MM] = np.inf
    near = np.argsort(distance, axis=1)[:, : min(NEAR, int(np.isfinite(distance[0]).sum()))]
    if near.shape[1] == 0:
        return None
    row, place = np.repeat(np.arange(n), near.shape[1]), near.reshape(-1)
    sums = _sums(rows, row, places[place])
    best, freedom = int(np.argmin(sums)), 3 * n - 6
    floor = rows.floor(freedom)
    explained = float(fdtrc(freedom, freedom, (total + floor) / (sums[best] + floor))) * len(sums) < FALSE_ALARM
    if rows.scaled and not explained:
        rejected = float(chdtrc(freedom, total)) * len(sums) < FALSE_ALARM
        explained = rejected and float(chdtrc(freedom, float(sums[best]))) >= FALSE_ALARM
    if not explained or not _is_clear(rows, sums, best):
        return None
    return Neighbour(int(row[best]), int(place[best]), float(sums[best]))


def _is_clear(rows: ErrorRows, sums: FloatArray, best: int) -> bool:
    """Tell whether every other exchange fits much worse."""
    freedom = 3 * len(rows) - 6
    least = float(sums[best]) + rows.floor(freedom)
    if rows.scaled:
        least = max(least, float(freedom))
    return bool(np.count_nonzero(sums <= CLEAR_FACTOR * least) == 1)


def _sums(rows: ErrorRows, row: IntArray, places: FloatArray) -> FloatArray:
    """Sum of squares with row `row[k]` at place k, shape (m,)."""
    m, n = len(row), len(rows)
    batch = rows.select(np.tile(np.arange(n), (m, 1)))
    p = batch.p.copy()
    p[np.arange(m), row] = places
    moved = replace(batch, p=p)
    return np.asarray(moved.squares(*moved.fit()).sum(axis=1))
