"""Points that are near each other, and things that belong together through pairs.

SciPy is imported where it is needed: it takes 0.4 s, and a command that finds its answers in the cache needs none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


def near_pairs(points: FloatArray, within: float) -> IntArray:
    """Return the pairs of points, shape (n, d), that are at most `within` apart, shape (k, 2); the first is smaller.

    >>> near_pairs(np.array([[0.0, 0.0], [5.0, 0.0], [5.5, 0.0]]), 1.0).tolist()
    [[1, 2]]
    """
    if len(points) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    return np.asarray(near_tree(points).query_pairs(within, output_type="ndarray"), dtype=np.int64)


def near_tree(points: FloatArray) -> cKDTree:
    """Return a tree in which points, shape (n, d), are searched by their place."""
    from scipy.spatial import cKDTree

    return cKDTree(points)


def linked_groups(count: int, a: IntArray, b: IntArray) -> IntArray:
    """Return the group of each of `count` things; `a` and `b`, shape (k,), are the two of each pair that is linked.

    Returns shape (count,). Groups are numbered in the order of their first things.

    >>> linked_groups(4, np.array([0]), np.array([2])).tolist()
    [0, 1, 0, 2]
    """
    least = np.arange(count)  # of each thing, a thing of its group with a smaller number, or itself
    while True:
        one, other = least[a], least[b]
        apart = one != other
        if not apart.any():
            return np.asarray(np.unique(least, return_inverse=True)[1], dtype=np.int64)
        np.minimum.at(least, np.maximum(one, other)[apart], np.minimum(one, other)[apart])
        while True:
            further = least[least]
            if np.array_equal(further, least):
                break
            least = further
