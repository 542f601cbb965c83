"""A part as triangles, for the views of pages and other programs."""

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray

DEFLECTION_PART = 2e-4
"""Relative to the part's diagonal: a fifth of a pixel when the whole part fills a screen of 1000 pixels."""
FINEST_MM, COARSEST_MM = 0.02, 0.5
"""Finer than the first makes no difference to a robot. Coarser than the second, a weld is visibly beside its edge."""

Rgb = tuple[float, float, float]  #: A colour as in files: sRGB, 0…1.


@dataclass(frozen=True, slots=True, eq=False)
class SolidMesh:
    """One solid as triangles with the edges of its faces."""

    name: str
    #: shape (n, 3). Part frame, mm. Faces share no point, so that an edge between two faces stays sharp.
    points: FloatArray
    triangles: IntArray  #: shape (m, 3). Rows of `points`, counter-clockwise seen from outside.
    edges: IntArray  #: shape (k, 2). Segments of the edges of the model, as rows of `points`.
    color_rgb: Rgb | None = None  #: sRGB in 0…1; None if the file states no colour.
    #: shape (n, 3). Outward unit normals of the faces at the points; None: computed by `vertex_normals`.
    normals: FloatArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PartMesh:
    """A part as triangles, in the frame `part`."""

    solids: tuple[SolidMesh, ...]
    deflection_mm: float  #: Largest distance of a triangle from its face, mm.
    angle_rad: float  #: Largest change of a face's normal along one triangle, rad.
    sha256: str | None = None  #: Hash of the STEP file.


def vertex_normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return unit normals of points: the direction of the sum of their triangles' area vectors.

    `points`: shape (n, 3). Any frame and unit.
    `triangles`: shape (m, 3). Rows of `points`, counter-clockwise seen from outside.

    Returns shape (n, 3). Outward, in the frame of `points`; (0, 0, 1) for a point without a triangle of non-zero area.
    """
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    area = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    rows = triangles.ravel()
    total = np.stack([np.bincount(rows, area[:, axis], minlength=len(points)) for axis in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    flat = np.broadcast_to([0.0, 0.0, 1.0], total.shape)
    return np.where(length > 0.0, total / np.where(length > 0.0, length, 1.0), flat)


def usual_deflection_mm(size_mm: float) -> float:
    """Return the largest allowed distance of a triangle from its face on a part of a size (diagonal, mm), in mm.

    >>> usual_deflection_mm(1000.0), usual_deflection_mm(10.0)
    (0.2, 0.02)
    """
    return min(max(DEFLECTION_PART * size_mm, FINEST_MM), COARSEST_MM)
