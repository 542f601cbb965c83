"""A part as triangles: what a page shows of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray

Rgb = tuple[float, float, float]
"""A colour as files write it: sRGB, 0…1."""


@dataclass(frozen=True, slots=True, eq=False)
class SolidMesh:
    """One solid as triangles with the edges of its faces.

    Parameters
    ----------
    name : str
    points : ndarray, shape (n, 3)
        Part frame, mm. Faces share no point, so that an edge between two faces stays sharp.
    triangles : ndarray of int, shape (m, 3)
        Rows of `points`, counter-clockwise seen from outside.
    edges : ndarray of int, shape (k, 2)
        Segments of the edges of the model, as rows of `points`.
    color_rgb : tuple of float or None
        sRGB in 0…1; None where the file states none.
    normals : ndarray, shape (n, 3), or None
        Outward unit normals of the faces at the points; where there are none, `vertex_normals` stands in.
    """

    name: str
    points: FloatArray
    triangles: IntArray
    edges: IntArray
    color_rgb: Rgb | None = None
    normals: FloatArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PartMesh:
    """A part as triangles, in the frame `part`.

    Parameters
    ----------
    solids : tuple of SolidMesh
    deflection_mm : float
        No triangle is further from its face than this.
    angle_rad : float
        Greatest turn of a curved face's normal along one triangle.
    sha256 : str or None
        Of the STEP file it was made from.
    """

    solids: tuple[SolidMesh, ...]
    deflection_mm: float
    angle_rad: float
    sha256: str | None = None

    @property
    def triangle_count(self) -> int:
        """Number of triangles of all solids."""
        return sum(len(solid.triangles) for solid in self.solids)


def vertex_normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return unit normals of points: the sum of the areas of their triangles, as vectors.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    triangles : ndarray of int, shape (m, 3)

    Returns
    -------
    ndarray, shape (n, 3)
        Outward; (0, 0, 1) for points of no triangle and of triangles without area.
    """
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    area = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    rows = triangles.ravel()
    total = np.stack([np.bincount(rows, area[:, axis], minlength=len(points)) for axis in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    flat = np.broadcast_to([0.0, 0.0, 1.0], total.shape)
    return np.where(length > 0.0, total / np.where(length > 0.0, length, 1.0), flat)
