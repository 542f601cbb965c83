"""Triangles of taught points among those of the model: which one to look for, and the best fit of many at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import GeometryError

SAMPLED = 256
"""Model points whose distances to all others stand for all distances: the counts are then good to some percent."""
MOST_CORNERS = 24  #: The triangle is chosen among this many taught points: 2024 triangles.
LEAST_HEIGHT = 3.0
"""Least height of the triangle, in units of √S: below it the error could turn the third corner to the other side."""
SIDE_COST = 200.0
"""Work for one candidate corner against that for one candidate triangle: a row of a table against a few products."""


@dataclass(frozen=True, slots=True, eq=False)
class Triangle:
    """Three taught points in the plane that they span."""

    corners: tuple[int, int, int]  #: Rows a, b, c of the taught points.
    sides: tuple[float, float, float]  #: Lengths ab, ac, bc, mm.
    centre: FloatArray  #: shape (3,). Of the corners, mm.
    axes: FloatArray  #: shape (3, 3). Rows: along ab, across it towards c, normal; right-handed.
    plane: FloatArray  #: shape (3, 2). The corners about the centre along the first two axes, mm.

    @classmethod
    def of(cls, taught: FloatArray, corners: tuple[int, int, int]) -> Triangle:
        """Lay the frame into three of the taught points, shape (n, 3), mm."""
        p = taught[list(corners)]
        axes = _axes(p[None])[0]
        centre = p.mean(axis=0)
        ab, ac, bc = (float(np.linalg.norm(p[i] - p[j])) for i, j in ((0, 1), (0, 2), (1, 2)))
        return cls(corners, (ab, ac, bc), centre, axes, (p - centre) @ axes[:2].T)


@dataclass(frozen=True, slots=True, eq=False)
class TriangleFits:
    """Least-squares fits of the taught triangle to m triangles of the model."""

    triangle: Triangle
    centre: FloatArray  #: shape (m, 3).
    axes: FloatArray  #: shape (m, 3, 3). Rows: where the axes of the taught triangle come to lie.
    squares_mm2: FloatArray  #: shape (m,). Sums of squared distances, mm².

    def select(self, rows: BoolArray) -> TriangleFits:
        """Keep the fits under a mask of shape (m,)."""
        return TriangleFits(self.triangle, self.centre[rows], self.axes[rows], self.squares_mm2[rows])

    def carry(self, taught: FloatArray) -> FloatArray:
        """Place of a taught point in the model under each fit, shape (m, 3)."""
        local = self.triangle.axes @ (taught - self.triangle.centre)
        return np.asarray(self.centre + local @ self.axes)


def fit_triangles(points: FloatArray, rows: IntArray, triangle: Triangle) -> TriangleFits:
    r"""Fit the taught triangle to triangles of the model, in closed form.

    The best fit lays plane on plane and centre on centre; the turn in the plane that makes
    :math:`\sum |q_i - R p_i|^2` smallest has the tangent :math:`\sum p_i \times q_i / \sum p_i \cdot q_i`.

    `points`: shape (N, 3). Of the model, in `part`, mm.
    `rows`: shape (m, 3). Images of the corners a, b, c, as rows of `points`.
    Returns: One fit per row; the sum of squares is infinite for three points on a line.
    """
    p = points[rows]
    centre = p.mean(axis=1)
    axes = _axes(p)
    local = np.einsum("mni,mji->mnj", p - centre[:, None], axes[:, :2])
    dot = np.einsum("mnj,nj->m", local, triangle.plane)
    cross = local[:, :, 1] @ triangle.plane[:, 0] - local[:, :, 0] @ triangle.plane[:, 1]
    length = np.hypot(dot, cross)
    squares = np.einsum("mnj,mnj->m", local, local) + float(np.sum(triangle.plane**2)) - 2.0 * length
    flat = ~(np.linalg.norm(axes[:, 2], axis=1) > 0.5) | (length == 0)
    safe = np.where(flat, 1.0, length)
    cos, sin = (dot / safe)[:, None], (cross / safe)[:, None]
    turned = np.stack([cos * axes[:, 0] + sin * axes[:, 1], cos * axes[:, 1] - sin * axes[:, 0], axes[:, 2]], axis=1)
    return TriangleFits(triangle, centre, turned, np.where(flat, np.inf, np.maximum(squares, 0.0)))


def choose_triangle(points: FloatArray, taught: FloatArray, candidates: IntArray, limit: float) -> Triangle:
    """Choose the taught triangle that fewest triangles of the model resemble.

    Raises `GeometryError` when no triangle is wide enough for the teaching error.

    `points`: shape (N, 3). Of the model, mm.
    `taught`: shape (n, 3). mm.
    `candidates`: shape (n,). Number of model points that each taught point may be.
    """
    rows = _far_apart(taught, candidates)
    near = _partners(points, taught[rows], limit) * candidates[rows] / len(points)  # [a, b]: images of b for one of a
    a, b, c = np.ogrid[: len(rows), : len(rows), : len(rows)]
    pairs = near[a, b] * near[a, c]
    cost = candidates[rows][a] * (SIDE_COST + pairs + pairs * near[b, c] / candidates[rows][c])
    height = _heights(taught[rows])
    usable = (b < c) & (a != b) & (a != c) & (height >= LEAST_HEIGHT * math.sqrt(limit))
    if not usable.any():
        raise GeometryError(
            "the taught points lie too nearly on one line for their teaching error: which features they are cannot be "
            "told; teach a point off the line"
        )
    best = np.unravel_index(int(np.argmin(np.where(usable, cost, np.inf))), cost.shape)
    i, j, k = (int(rows[v]) for v in best)
    return Triangle.of(taught, (i, j, k))


def _axes(p: FloatArray) -> FloatArray:
    """Right-handed axes of triangles (m, 3, 3): along ab, across, normal; zero where the corners lie on a line."""
    along, side = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    normal = np.cross(along, side)
    x, z = (v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), np.finfo(float).tiny) for v in (along, normal))
    return np.stack([x, np.cross(z, x), z], axis=1)


def _far_apart(taught: FloatArray, candidates: IntArray) -> IntArray:
    """Pick at most `MOST_CORNERS` taught points: those with fewest candidates, then the farthest from the picked."""
    picked = [int(np.argmin(candidates))]
    distance = np.linalg.norm(taught - taught[picked[0]], axis=1)
    while len(picked) < min(len(taught), MOST_CORNERS):
        score = np.where(np.isin(np.arange(len(taught)), picked), -1.0, distance / candidates)
        picked.append(int(np.argmax(score)))
        distance = np.minimum(distance, np.linalg.norm(taught - taught[picked[-1]], axis=1))
    return np.array(picked)


def _partners(points: FloatArray, taught: FloatArray, limit: float) -> FloatArray:
    """Mean number of model points at about the distance of each two taught points from a model point."""
    sample = points[np.linspace(0, len(points) - 1, min(SAMPLED, len(points))).astype(np.int64)]
    table = np.sort(np.linalg.norm(sample[:, None] - points[None], axis=2).ravel())
    side = np.linalg.norm(taught[:, None] - taught[None], axis=2)
    off = math.sqrt(2.0 * limit)
    counts = np.searchsorted(table, side + off) - np.searchsorted(table, side - off)
    return np.asarray(counts / len(sample))


def _heights(p: FloatArray) -> FloatArray:
    """Least height of every triangle of some points, shape (n, n, n), mm."""
    side = np.linalg.norm(p[:, None] - p[None], axis=2)
    area = np.linalg.norm(np.cross((p[None, :] - p[:, None])[:, :, None], (p[None, :] - p[:, None])[:, None]), axis=3)
    longest = np.maximum(np.maximum(side[:, :, None], side[:, None, :]), side[None])
    return np.asarray(area / np.maximum(longest, np.finfo(float).tiny))
