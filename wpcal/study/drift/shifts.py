"""When the mean of a channel changes suddenly: the largest step between two stretches of jobs, again on both sides."""

from __future__ import annotations

import numpy as np
from scipy.special import stdtrit

from wpcal.core.arrays import FloatArray
from wpcal.study.drift.control import moving_range_sigma, without_events

FALSE_ALARM = 0.01  #: Probability that a page without any change shows a shift.
LEAST_STRETCH = 3  #: Jobs between two shifts. One job that is off is not a shift; the chart shows it.
SIGMA_DEGREES = 0.4  #: Degrees of freedom of sigma from the median moving range, per job.


def find_shifts(values: FloatArray) -> list[int]:
    """Return the first jobs after sudden changes, in order.

    `values`: shape (n, c). Channels that scatter from job to job with a constant sigma. Channels without scatter are
    not looked at.
    """
    sigma = moving_range_sigma(values)
    keep = sigma > 0
    n, channels = values.shape[0], int(keep.sum())
    if channels == 0 or n < 2 * LEAST_STRETCH:
        return []
    places = n - 2 * LEAST_STRETCH + 1
    limit = -float(stdtrit(max(2.0, SIGMA_DEGREES * (n - 1)), FALSE_ALARM / (2 * places * channels)))
    kept = without_events(values)[:, keep]
    scaled = (kept - np.median(kept, axis=0)) / sigma[keep]
    sums = np.concatenate([np.zeros((1, channels)), np.cumsum(scaled, axis=0)])
    found: list[int] = []
    stretches = [(0, n)]
    while stretches:
        start, end = stretches.pop()
        cut = _largest_step(sums, start, end, limit)
        if cut is not None:
            found.append(cut)
            stretches += [(start, cut), (cut, end)]
    return sorted(found)


def _largest_step(sums: FloatArray, start: int, end: int, limit: float) -> int | None:
    """Return where the mean changes most between two jobs, if by more than a limit."""
    cuts = np.arange(start + LEAST_STRETCH, end - LEAST_STRETCH + 1)
    if len(cuts) == 0:
        return None
    before, after = (cuts - start)[:, None], (end - cuts)[:, None]
    step = (sums[end] - sums[cuts]) / after - (sums[cuts] - sums[start]) / before
    score = np.abs(step) / np.sqrt(1 / before + 1 / after)
    largest = score.max(axis=1)
    best = int(largest.argmax())
    return int(cuts[best]) if largest[best] > limit else None
