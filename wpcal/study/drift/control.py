"""Control charts: individuals with moving ranges, and CUSUM. All channels at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray

MEDIAN_RANGE = 0.953873  #: Median of the difference of two normal numbers with sigma 1.
MEAN_RANGE = 1.128379  #: Its mean.
ROUND_OFF = 1e-9  #: Scatter below this (mm, degrees) is round-off.
LIMIT_SIGMAS = 3.0
CUSUM_K, CUSUM_H = 0.5, 5.0
"""In sigmas: slack per job and limit. It is the usual choice for changes of the mean by one sigma."""
EVENT_SIGMAS, NEIGHBOURS = 6.0, 7
"""The median of seven jobs is within 1.4 sigma of their mean in 99.9 %: of 10 000 sound jobs none is an event."""
FIRST_JOBS = 25  #: Jobs of which the centre is the mean.


@dataclass(frozen=True, slots=True)
class Charts:
    """Charts of c channels over n jobs."""

    values: FloatArray
    #: `centre`, `sigma`: Mean of the first jobs without events, and the scatter from job to job.
    centre: FloatArray
    sigma: FloatArray
    outside: BoolArray  #: More than 3 sigma from the centre.
    #: `cusum_up`, `cusum_down`: In sigmas, both >= 0. Each begins again at 0 after an alarm.
    cusum_up: FloatArray
    cusum_down: FloatArray
    alarms: BoolArray  #: Jobs at which one of the two exceeds its limit.


def moving_range_sigma(values: FloatArray) -> FloatArray:
    """Return the scatter of channels from job to job: the median moving range over 0.954.

    A sudden shift changes one moving range only, so that the median hardly sees it. If most jobs are equal, the median
    is 0: then it is the mean moving range over 1.128.

    `values`: shape (n, c).
    Returns shape (c,). In the units of the values; 0 if all jobs are equal.
    """
    ranges = np.abs(np.diff(values, axis=0))
    median, mean = np.median(ranges, axis=0) / MEDIAN_RANGE, ranges.mean(axis=0) / MEAN_RANGE
    sigma = np.where(median > ROUND_OFF, median, mean)
    return np.where(sigma > ROUND_OFF, sigma, 0.0)


def without_events(values: FloatArray) -> FloatArray:
    """Return channels in which single jobs far from their neighbours have the value of these.

    A mistyped touch is an event of its own, not a shift, and it must not move the centre of a chart. A job is one if it
    is more than `EVENT_SIGMAS` from the median of `NEIGHBOURS` jobs around it (Hampel 1974); a shift moves these, too.

    `values`: shape (n, c). Row by row the jobs in their order.
    """
    half = NEIGHBOURS // 2
    if len(values) < NEIGHBOURS + 1:
        return values
    wide = np.pad(values, ((half, half), (0, 0)), mode="reflect")
    around = np.lib.stride_tricks.sliding_window_view(wide, NEIGHBOURS, axis=0)
    middle = np.median(around, axis=-1)
    return np.asarray(np.where(np.abs(values - middle) > EVENT_SIGMAS * moving_range_sigma(values), middle, values))


def control_charts(values: FloatArray, *, first: int = FIRST_JOBS) -> Charts:
    """Return the charts of channels. `values`: shape (n, c). Row by row the jobs in their order."""
    kept = without_events(values)
    centre = kept[:first].mean(axis=0)
    sigma = moving_range_sigma(values)
    off = values - centre
    scaled = np.divide(kept - centre, sigma, out=np.zeros_like(off), where=sigma > 0)
    up, down, alarms = _cusum(scaled)
    return Charts(
        values=values,
        centre=centre,
        sigma=sigma,
        outside=np.abs(off) > LIMIT_SIGMAS * sigma + ROUND_OFF,
        cusum_up=up,
        cusum_down=down,
        alarms=alarms,
    )


def _cusum(scaled: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    both = np.stack([scaled, -scaled]) - CUSUM_K
    sums = np.empty_like(both)
    now = np.zeros_like(both[:, 0])
    for job in range(both.shape[1]):
        now = np.maximum(0.0, now + both[:, job])
        sums[:, job] = now
        now = np.where((now > CUSUM_H).any(axis=0), 0.0, now)
    return sums[0], sums[1], np.asarray((sums > CUSUM_H).any(axis=0))
