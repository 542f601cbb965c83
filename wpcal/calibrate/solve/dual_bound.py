"""The lower bound of the least largest distance, raised where the multipliers of the answer prove nothing."""

from __future__ import annotations

import numpy as np

from wpcal.calibrate.solve.least_squares import distances, kabsch, weighted_rms
from wpcal.core.arrays import FloatArray

TINY = 1e-300  #: Keeps a division by zero, of exact fits, that is then multiplied by zero.
ASCENT_STEPS = 300  #: Steps of the ascent that raises the bound if local multipliers prove nothing.


def raise_bound(p: FloatArray, q: FloatArray, seeds: FloatArray) -> tuple[FloatArray, float]:
    """Raise the weighted root mean square bound by exponentiated ascent on the simplex.

    The bound's square is concave in the weights with the squared distances as its slope, so steps that shrink as
    1/√k approach its greatest value, also where it has a kink.

    Returns `weights`: shape (n,).
    Returns `bound`: float. mm.

    `p`, `q`: shape (n, 3). Points about their centroids, mm.
    `seeds`: shape (m, n). Weights to start from, rows on the simplex.
    """
    n = len(p)
    bounds = weighted_rms(p, q, seeds)
    best = int(np.argmax(bounds))
    best_weights, best_bound = seeds[best], float(bounds[best])
    w = 0.9 * best_weights + 0.1 / n  # a weight of zero could never grow
    for k in range(1, ASCENT_STEPS + 1):
        R, t = kabsch(p, q, w)
        squares = distances(p, q, R, t) ** 2
        bound = float(np.sqrt(w @ squares))
        if bound > best_bound:
            best_weights, best_bound = w, bound
        w = w * np.exp(squares / max(float(squares.max()), TINY) / np.sqrt(k))
        w = w / w.sum()
    return best_weights, best_bound
