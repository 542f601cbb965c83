"""Which of many vectors of objectives are worth choosing from, and how much of the space they dominate."""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import InputError


def is_nondominated(values: FloatArray) -> BoolArray:
    """Tell which rows no other row beats: none is at least as good everywhere and better somewhere.

    Parameters
    ----------
    values : ndarray, shape (m, k)
        All made small. Of equal rows the first stays.

    Returns
    -------
    ndarray of bool, shape (m,)
    """
    no_worse = (values[:, None] <= values).all(axis=2)
    better = (values[:, None] < values).any(axis=2)
    earlier = np.tri(len(values), k=-1, dtype=bool).T  # [i, j]: row i comes before row j
    beats = no_worse & (better | earlier)
    return np.asarray(~beats.any(axis=0))


def spread_rows(values: FloatArray, count: int) -> IntArray:
    """Choose rows that lie far from each other: the best of each objective first, then always the farthest one.

    Parameters
    ----------
    values : ndarray, shape (m, k)
        Scaled by the range of each column for the distances.
    count : int
        At most so many rows.

    Returns
    -------
    ndarray of int
        Increasing.
    """
    span = np.ptp(values, axis=0)
    scaled = values / np.where(span > 0, span, 1.0)
    chosen = list(dict.fromkeys(int(row) for row in scaled.argmin(axis=0)))[:count]
    nearest = np.min([np.linalg.norm(scaled - scaled[row], axis=1) for row in chosen], axis=0)
    nearest[chosen] = -1.0
    while len(chosen) < min(count, len(values)):
        chosen.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, np.linalg.norm(scaled - scaled[chosen[-1]], axis=1))
        nearest[chosen[-1]] = -1.0
    return np.array(sorted(chosen), dtype=np.int64)


def hypervolume(values: FloatArray, reference: FloatArray) -> float:
    """Return the volume of all that some row beats and that beats the reference.

    Parameters
    ----------
    values : ndarray, shape (m, k)
        All made small; rows that do not beat the reference in every objective add nothing.
    reference : ndarray, shape (k,)

    Raises
    ------
    InputError
        When the numbers of objectives differ.

    Notes
    -----
    Slices along the last objective: m times the volume of one objective less. Meant for tens of rows and few
    objectives.

    Examples
    --------
    Two squares of side 2 and 3 that share one of side 2 by 1:

    >>> hypervolume(np.array([[1.0, 2.0], [2.0, 0.0]]), np.array([4.0, 4.0]))
    10.0
    """
    if values.ndim != 2 or values.shape[1] != len(reference):
        raise InputError(f"expected rows of {len(reference)} objectives, got shape {values.shape}")
    inside = values[(values < reference).all(axis=1)]
    if len(inside) == 0:
        return 0.0
    if inside.shape[1] == 1:
        return float(reference[0] - inside.min())
    inside = inside[np.argsort(inside[:, -1], kind="stable")]
    heights = np.diff(np.append(inside[:, -1], reference[-1]))
    return float(
        sum(
            height * hypervolume(inside[: i + 1, :-1], reference[:-1]) for i, height in enumerate(heights) if height > 0
        )
    )
