"""Points on triangles, close enough that nothing of the surface is far from one of them."""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray

MOST_SAMPLES = 4_000_000  #: Points in one array: 100 MB.


def surface_points(corners: FloatArray, spacing: float) -> list[FloatArray]:
    """Return points on triangles: every place is between three that are at most `spacing` from it, shape (k, 3), mm.

    So the hulls of slices of them hold the surface. Rows of points (`wpcal.seam.judge.room`) are fewer, and do not.

    `corners`: shape (m, 3, 3). Any frame, mm.
    `spacing`: mm.
    """
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    steps = np.maximum(np.ceil(longest / spacing), 1).astype(int)
    found = []
    for count in np.unique(steps):
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        u, v = (i[i + j <= count] / count, j[i + j <= count] / count)
        weights = np.stack([1.0 - u - v, u, v], axis=1)
        own = corners[steps == count]
        parts = np.array_split(own, len(own) * len(weights) // MOST_SAMPLES + 1)
        found += [np.einsum("wk,mkx->mwx", weights, some).reshape(-1, 3) for some in parts]
    return found
