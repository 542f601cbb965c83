r"""Exact search: every way in which taught points can be points of a model, from the distances between them.

With errors of variance :math:`\sigma^2` per axis the sum of squares of the best rigid fit of n points follows
:math:`\sigma^2 \chi^2_{3n-6}`; an assignment is accepted up to the limit :math:`S` that the true one exceeds once in a
million. The best fit of some of the points never leaves more than the best fit of all. So a pair of points whose
distance is off by :math:`\delta` (its best fit leaves :math:`\delta^2 / 2`) or a triangle whose fit leaves more than
:math:`S` is part of no accepted assignment and can be dropped.

The search chooses the triangle of taught points that the fewest triangles of the model resemble. It finds all of these
from tables of distances. Then it carries each further taught point into the model, where a k-d tree finds the points
nearby.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtri

from wpcal.calibrate.errors.linear_fit import isotropic_covariance
from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.core.arrays import BoolArray, FloatArray, IntArray, as_points, frozen
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.linked import near_tree
from wpcal.core.progress import Progress, no_progress
from wpcal.core.tangent import point_jacobian
from wpcal.taught.match.triangle import Triangle, choose_triangle, fit_triangles

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


MISS = 1e-6
"""Chance that the true assignment is left out. A wrong assignment that is the only answer is then at least as rare."""
LEAST_SIGMA_MM = 0.01  #: Taught points are written with two decimals: a smaller stated error counts as this.
MOST_ANSWERS = 10_000
"""The search stops above this number. Only a pattern of equal holes has more, and nobody reads them."""
CHUNK = 200_000  #: Triangles that are carried further at once: some tens of megabytes.
BLOCK_VALUES = 4_000_000  #: Distances that are computed at once: 16 megabytes.
FLOAT32_SLACK = 2e-6
"""Round-off of a squared distance in float32, as a share of the squared size of the part; later steps are exact."""
SLACK = 1.05  #: The reach of a prediction is a linear estimate with its second-order term; this covers what is left.


@dataclass(frozen=True, slots=True, eq=False)
class Assignments:
    """All ways in which the taught points can be points of the model."""

    rows: IntArray  #: shape (m, n). Model point of every taught point; the best fit first.
    squares_mm2: FloatArray  #: shape (m,). Sum of squared distances of the least-squares fit of each, mm².
    limit_mm2: float  #: The largest sum accepted.
    complete: bool  #: False when there are more than `MOST_ANSWERS`; the search then stopped.


def squares_limit(n: int, sigma_mm: float) -> float:
    """Sum of squares that the true assignment of n points exceeds with the chance `MISS`, mm²."""
    return float(max(sigma_mm, LEAST_SIGMA_MM) ** 2 * chdtri(3 * n - 6, MISS))


def find_assignments(
    p_part: ArrayLike,
    p_base: ArrayLike,
    *,
    sigma_mm: float,
    allowed: Sequence[IntArray | None] | None = None,
    progress: Progress | None = None,
) -> Assignments:
    """Find every assignment of taught points to model points that the teaching error can explain.

    Two taught points may be one model point: it was touched twice.

    Returns: Mirrored ones are not among them.

    `p_part`: shape (N, 3). Points of the model, mm, no two at one place (both would be an answer).
    `p_base`: shape (n, 3). Taught points, mm; n ≥ 3.
    `allowed`: length n. The model points that each taught point may be; None for any.
    Raises `GeometryError` when there are fewer than three taught points, or they lie so nearly on one line that the
    error hides the rotation about it.
    Raises `InputError` when `sigma_mm` is not a length.

    Note: The cost is that of N² distances and of the triangles that resemble the chosen one.
    """
    points, taught = as_points(p_part, name="model points"), as_points(p_base, name="taught points")
    if not (math.isfinite(sigma_mm) and sigma_mm >= 0):
        raise InputError(f"the teaching error is a length that is not negative, got {sigma_mm} mm")
    if len(taught) < 3:
        raise GeometryError(f"points without names need at least 3 taught points, got {len(taught)}")
    limit = squares_limit(len(taught), sigma_mm)
    if len(points) < 3:
        return Assignments(np.empty((0, len(taught)), dtype=np.int64), frozen([]), limit, True)
    search = _Search.prepared(points - points.mean(axis=0), taught - taught.mean(axis=0), limit, allowed)
    return search.run(progress or no_progress)


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """What all steps share: centred points, the limit, the triangle, and a lookup for each further point."""

    points: FloatArray
    taught: FloatArray
    limit: float
    masks: BoolArray
    triangle: Triangle
    order: tuple[int, ...]
    reach: tuple[float, ...]
    tree: cKDTree
    occupancy: Occupancy | None

    @classmethod
    def prepared(
        cls, points: FloatArray, taught: FloatArray, limit: float, allowed: Sequence[IntArray | None] | None
    ) -> _Search:
        """Choose the triangle and the order of the further points: the best predicted first."""
        masks = np.ones((len(taught), len(points)), dtype=bool)
        for row, rows in enumerate(allowed or ()):
            if rows is not None:
                masks[row] = False
                masks[row, rows] = True
        triangle = choose_triangle(points, taught, masks.sum(axis=1), limit)
        order, reach = list(triangle.corners), []
        while len(order) < len(taught):
            left = [k for k in range(len(taught)) if k not in order]
            reaches = [_reach(taught[order], taught[k], limit) for k in left]
            best = int(np.argmin(reaches))
            order.append(left[best])
            reach.append(reaches[best])
        occupancy = Occupancy.around(points, reach[0]) if reach else None
        return cls(points, taught, limit, masks, triangle, tuple(order), tuple(reach), near_tree(points), occupancy)

    def run(self, progress: Progress) -> Assignments:
        found: list[IntArray] = []
        sums: list[FloatArray] = []
        count, complete = 0, True
        for rows in _gathered(self._triangles(progress)):
            kept, squares = self._extended(rows)
            found.append(kept)
            sums.append(squares)
            count += len(kept)
            if count > MOST_ANSWERS:
                complete = False
                break
        rows = np.concatenate(found) if found else np.empty((0, len(self.taught)), dtype=np.int64)
        squares = np.concatenate(sums) if sums else np.empty(0)
        best = np.lexsort((*rows.T[::-1], squares))[:MOST_ANSWERS]
        unordered = np.empty_like(rows[best])
        unordered[:, list(self.order)] = rows[best]
        return Assignments(unordered, frozen(squares[best]), self.limit, complete)

    def _triangles(self, progress: Progress) -> Iterator[IntArray]:
        """Yield the model's triangles whose three sides are within the tolerance, shape (m, 3)."""
        a, b, c = self.triangle.corners
        points = self.points.astype(np.float32)
        squares = np.einsum("ni,ni->n", points, points)
        slack = FLOAT32_SLACK * float(squares.max())
        off = math.sqrt(2.0 * self.limit)  # the fit of two points leaves half the square
        windows = [(max(s - off, 0.0) ** 2 - slack, (s + off) ** 2 + slack) for s in self.triangle.sides]
        starts = np.flatnonzero(self.masks[a])
        step = max(1, BLOCK_VALUES // len(points))
        for first in range(0, len(starts), step):
            block = starts[first : first + step]
            progress(f"comparing distances: {100 * first // len(starts)} %")
            table = squares[block, None] + squares - 2.0 * (points[block] @ points.T)
            near_b = _is_within(table, windows[0]) & self.masks[b]
            near_c = _is_within(table, windows[1]) & self.masks[c]
            useful = np.flatnonzero(near_b.any(axis=1) & near_c.any(axis=1))
            for i in useful:
                at_b, at_c = np.flatnonzero(near_b[i]), np.flatnonzero(near_c[i])
                across = squares[at_b, None] + squares[at_c] - 2.0 * (points[at_b] @ points[at_c].T)
                j, k = np.nonzero(_is_within(across, windows[2]))
                if len(j):
                    yield np.column_stack([np.full(len(j), block[i]), at_b[j], at_c[k]])

    def _extended(self, rows: IntArray) -> tuple[IntArray, FloatArray]:
        """Extend triangles to whole assignments, in the search's order, with their sums of squares."""
        fit = fit_triangles(self.points, rows, self.triangle)
        good = fit.squares_mm2 <= self.limit
        rows, fit = rows[good], fit.select(good)
        squares = fit.squares_mm2
        for place, k in enumerate(self.order[3:]):
            if place == 0:
                predicted = fit.carry(self.taught[k])
                assert self.occupancy is not None
                near = self.occupancy.has_points_near(predicted)
                rows, predicted = rows[near], predicted[near]
            else:
                R, t = self._fits(rows)[1:]
                predicted = R @ self.taught[k] + t
            rows = self._with_next(rows, predicted, self.reach[place], k)
            squares = self._fits(rows)[0]
            rows, squares = rows[squares <= self.limit], squares[squares <= self.limit]
        return rows, squares

    def _with_next(self, rows: IntArray, predicted: FloatArray, reach: float, k: int) -> IntArray:
        """Append every model point within reach of the predicted place of taught point k."""
        if len(rows) == 0:
            return np.empty((0, rows.shape[1] + 1), dtype=np.int64)
        near = near_tree(predicted).sparse_distance_matrix(self.tree, reach, output_type="ndarray")
        which, point = near["i"], near["j"]
        longer = np.column_stack([rows[which], point])
        return np.asarray(longer[self.masks[k, point]])

    def _fits(self, rows: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Sums of squares, rotations and translations (taught to model) of the least-squares fits."""
        n = rows.shape[1]
        target = self.points[rows]
        source = np.broadcast_to(self.taught[list(self.order[:n])], target.shape)
        R, t = kabsch(source, target, np.full(target.shape[:2], 1.0 / n))
        left = target - source @ R.transpose(0, 2, 1) - t[:, None, :]
        return np.einsum("mni,mni->m", left, left), R, t


def _is_within(squares: FloatArray, window: tuple[float, float]) -> BoolArray:
    return np.asarray((squares >= np.float32(window[0])) & (squares <= np.float32(window[1])))


def _gathered(parts: Iterator[IntArray]) -> Iterator[IntArray]:
    """Join small arrays of triangles to chunks."""
    waiting: list[IntArray] = []
    count = 0
    for part in parts:
        waiting.append(part)
        count += len(part)
        if count >= CHUNK:
            yield np.concatenate(waiting)
            waiting, count = [], 0
    if waiting:
        yield np.concatenate(waiting)


def _reach(known: FloatArray, further: FloatArray, limit: float) -> float:
    """Distance at which a further point can lie from the place that the fit of the known points predicts, mm.

    With the residual e of the prediction, whose covariance is σ² (I + C), the sum of squares grows by
    eᵀ (I + C)⁻¹ e; it stays below S for |e| ≤ √(S (1 + λ)), λ the largest eigenvalue of C. The second-order term is
    that of the rotation the same sum allows.
    """
    covariance = isotropic_covariance(known, 1.0)
    J = point_jacobian(further[None])[0]
    spread = float(np.linalg.eigvalsh(J @ covariance @ J.T)[-1])
    turn_squared = limit * float(np.linalg.eigvalsh(covariance[:3, :3])[-1])
    arm = float(np.linalg.norm(further - known.mean(axis=0)))
    return SLACK * (math.sqrt(limit * (1.0 + spread)) + 0.5 * turn_squared * arm)


MOST_BOXES = 2.5e7  #: One byte per box: 25 megabytes.
BOXES_PER_POINT = 1000.0
"""About a hundred boxes are marked around a point: nine of ten places far from all points are then told at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Occupancy:
    """Boxes of one size over the points; those near a point are marked."""

    low: FloatArray  #: shape (3,). Corner of the table, mm.
    size_mm: float  #: Side of a box.
    marked: BoolArray  #: shape (nx, ny, nz).

    @classmethod
    def around(cls, points: FloatArray, reach_mm: float) -> Occupancy:
        """Mark every box that holds a place within reach of a point, and some that only nearly do.

        `points`: shape (N, 3). mm.
        """
        from scipy.ndimage import binary_dilation

        span = np.ptp(points, axis=0) + 4.0 * reach_mm
        boxes = min(MOST_BOXES, BOXES_PER_POINT * len(points))
        size = max(0.5 * reach_mm, float(np.cbrt(np.prod(span) / boxes)))
        low = points.min(axis=0) - 2.0 * reach_mm
        shape = np.ceil(span / size).astype(np.int64) + 1
        marked = np.zeros(shape, dtype=bool)
        marked[tuple(((points - low) / size).astype(np.int64).T)] = True
        return cls(low, size, np.asarray(binary_dilation(marked, _ball(reach_mm / size))))

    def has_points_near(self, places: FloatArray) -> BoolArray:
        """Tell for places, shape (m, 3), whether a point may be within reach; False means that none is."""
        box: IntArray = np.floor((places - self.low) / self.size_mm).astype(np.int64)
        inside = ((box >= 0) & (box < self.marked.shape)).all(axis=1)
        box[~inside] = 0
        return np.asarray(inside & self.marked[tuple(box.T)])


def _ball(reach: float) -> BoolArray:
    """Boxes whose nearest corner is within reach of some place in the middle box; reach in box sides."""
    n = int(np.ceil(reach))
    steps = np.maximum(np.abs(np.arange(-n, n + 1)) - 1, 0)
    square = steps**2
    return np.asarray(square[:, None, None] + square[:, None] + square <= reach**2)
