"""Where curves go through surfaces: zeros of heights above a surface, many at once."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import FloatArray, IntArray

SECANT_ROUNDS = 4
"""From the sample before and after: on an edge of 1 m and a surface bent to 100 mm the crossing is then known to a few
micrometres."""

Height: TypeAlias = Callable[[FloatArray], FloatArray]
"""Height above a surface, mm, shape (n,), at parameters of shape (n,)."""


def heights(graph: BrepGraph, faces: IntArray, points: FloatArray) -> FloatArray:
    """Return how far points are above surfaces, on the outer side positive, shape (n,), mm.

    `faces`: ndarray of int, shape (n,).
    `points`: shape (n, 3). In `part`, mm.
    """
    foot = project_to_faces(graph, faces, points)
    return np.asarray(np.einsum("ki,ki->k", points - foot.p, foot.normal), dtype=np.float64)


def find_crossings(height: Height, a: FloatArray, b: FloatArray) -> FloatArray:
    """Return where heights are zero between parameters at which they have different signs, by secants, shape (n,).

    `height`: Of parameters, shape (n,).
    `a`, `b`: shape (n,). The two ends of each interval.
    """
    ha, hb = height(a), height(b)
    for _ in range(SECANT_ROUNDS):
        middle = _secant(a, b, ha, hb)
        hm = height(middle)
        same = (hm > 0) == (ha > 0)
        a, ha = np.where(same, middle, a), np.where(same, hm, ha)
        b, hb = np.where(same, b, middle), np.where(same, hb, hm)
    return _secant(a, b, ha, hb)


def _secant(a: FloatArray, b: FloatArray, ha: FloatArray, hb: FloatArray) -> FloatArray:
    return np.asarray(a - ha * (b - a) / np.where(hb == ha, 1.0, hb - ha), dtype=np.float64)
