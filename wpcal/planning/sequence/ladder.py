"""The cheapest way over the rungs of one branch: dynamic programming, with joint steps compared round the circle."""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.same_bits import first_least, product, sine_cosine

STEP_WEIGHT = 1.0  #: Of the squared joint steps, rad², per rung ...
OFF_WEIGHT = 2.0
"""... and of the squared deviation of the torch from its target angles: a torch leans where that saves the arm more."""
LARGEST_STEP_RAD = np.radians(75.0)
"""A joint that turns by more from one rung to the next swings through a singular pose."""


def cheapest_way(joints: FloatArray, usable: BoolArray, off_rad: FloatArray, weights: FloatArray) -> list[int]:
    r"""Return the states of the cheapest way from the first rung, as far as there is one.

    The cost is :math:`\sum_i w_o\,o_i^2 + w_s \sum_{i,j} K_j (2 - 2 \cos \Delta q_{ij})`: the cosine is the squared
    step for small steps, the same for whole turns, and a product of matrices.

    Parameters
    ----------
    joints : shape (m, K, 6). Of one branch, rad.
    usable : ndarray of bool, shape (m, K)
    off_rad : shape (m, K). Deviation of the torch from its targets.
    weights : shape (6,). K_j, positive.
    """
    q = np.nan_to_num(joints)
    ring = np.concatenate(sine_cosine(q), axis=2) * np.sqrt(np.tile(weights, 2))
    own = np.where(usable, OFF_WEIGHT * off_rad**2, np.inf)
    cost, back, ends = own[0], [], [own[0]]
    for i in range(1, len(joints)):
        now, before = np.flatnonzero(usable[i]), np.flatnonzero(np.isfinite(cost))
        if not len(now) or not len(before):
            break
        step = 2.0 * weights.sum() - 2.0 * product(ring[i, now], ring[i - 1, before].T)
        apart = np.abs(q[i, now][:, None] - q[i - 1, before])
        swings = (np.abs(apart - 2 * np.pi * np.rint(apart / (2 * np.pi))) > LARGEST_STEP_RAD).any(axis=2)
        total = np.where(swings, np.inf, STEP_WEIGHT * step + cost[before])
        best = first_least(total, axis=1)
        found = np.full(joints.shape[1], np.inf)
        came = np.zeros(joints.shape[1], dtype=np.int64)
        found[now], came[now] = total[np.arange(len(now)), best] + own[i, now], before[best]
        if not np.isfinite(found).any():
            break
        cost = found
        back.append(came)
        ends.append(cost)
    if not np.isfinite(cost).any():
        return []
    way = [int(first_least(cost))]
    for came in reversed(back):
        way.append(int(came[way[-1]]))
    return way[::-1]
