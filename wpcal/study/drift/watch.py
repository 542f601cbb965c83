"""Everything that `wpcal drift` says about the jobs of one part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.options import opt
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.core.wording import counted
from wpcal.study.drift.causes import Likely, SeenDirections, find_pattern, likely_cause
from wpcal.study.drift.control import FIRST_JOBS, ROUND_OFF, Charts, control_charts, moving_range_sigma
from wpcal.study.drift.jobs import PartJobs
from wpcal.study.drift.shifts import find_shifts

LEAST_JOBS = 8
POSE_CHANNELS = (("x", "mm"), ("y", "mm"), ("z", "mm"), ("turn x", "deg"), ("turn y", "deg"), ("turn z", "deg"))
"""Where the middle of the touched points is, and how the part is turned, both from the median pose, along the axes of
`base`. Unlike the numbers of a pendant they do not mix: a turn moves the middle by nothing, and no angle wraps."""


@dataclass(frozen=True, slots=True)
class Shift:
    """A sudden change."""

    at: int  #: First job after it.
    move: FloatArray  #: Change of the mean of the pose channels, mm and degrees.
    likely: Likely


@dataclass(frozen=True, slots=True)
class PartDrift:
    """What changes from job to job of one part."""

    jobs: PartJobs
    pose: Charts  #: Of the six channels `POSE_CHANNELS`.
    distance: Charts  #: Of the length of each residual, mm.
    seam: Charts | None  #: Of the largest predicted error of a seam, mm; None if a job has none.
    largest: FloatArray  #: In how many jobs a point has the largest residual.
    shifts: tuple[Shift, ...]
    first: int  #: Jobs that gave the centres.

    @property
    def most_wrong(self) -> int | None:
        """The point that is named as wrong most; without one, the point with the largest residual most; or None."""
        if len(self.jobs.points) == 0:
            return None
        rms = np.sqrt((self.distance.values**2).mean(axis=0))
        order = np.lexsort((rms, self.largest, self.jobs.suspected))
        return int(order[-1]) if rms[order[-1]] > 0 else None


@dataclass(frozen=True, slots=True, kw_only=True)
class JobsAsked:
    """Which jobs are watched."""

    part: str | None = opt(None, "Only the jobs on this STEP file.", "--on-part", metavar="NAME")
    first: int = opt(FIRST_JOBS, "The first N jobs give the centres of the charts.", metavar="N", least=3)


def watch_part(jobs: PartJobs, *, first: int = FIRST_JOBS) -> PartDrift:
    """Return charts, shifts and their likely causes. Raises `InputError` when there are fewer than 8 jobs."""
    if len(jobs.names) < LEAST_JOBS:
        raise InputError(
            f"{jobs.file}: {counted(len(jobs.names), 'job')} with a calibration; drift needs at least {LEAST_JOBS} of "
            "one part"
        )
    pose = pose_channels(jobs.T_base_part, jobs.places)
    in_part = np.einsum("nji,npj->npi", jobs.T_base_part[:, :3, :3], jobs.residuals)
    pattern = find_pattern(jobs.places, in_part) if jobs.points else None
    left = np.empty((len(pose), 0)) if pattern is None or pattern.freedom == 0 else pattern.project(in_part)
    distance = np.linalg.norm(jobs.residuals, axis=2)
    has_seams = bool(np.isfinite(jobs.seam_error_mm).all())
    cuts = find_shifts(np.hstack([pose, left]))
    largest = np.bincount(distance.argmax(axis=1), minlength=distance.shape[1]) if jobs.points else np.empty(0)
    return PartDrift(
        jobs=jobs,
        pose=control_charts(pose, first=first),
        distance=control_charts(distance, first=first),
        seam=control_charts(jobs.seam_error_mm[:, None], first=first) if has_seams else None,
        largest=largest.astype(float),
        shifts=_shifts(cuts, pose, left, pattern),
        first=min(first, len(pose)),
    )


def pose_channels(T_base_part: FloatArray, places: FloatArray) -> FloatArray:
    """Return the pose of each job from the median pose.

    `T_base_part`: shape (n, 4, 4).
    `places`: shape (p, 3). Touched points in `part`, mm.

    Returns shape (n, 6). Of the middle of the places x, y, z in mm; turns about x, y, z in degrees. Both along the axes
    of `base`.
    """
    middle = places.mean(axis=0) if len(places) else np.zeros(3)
    at = T_base_part[:, :3, :3] @ middle + T_base_part[:, :3, 3]
    turns = T_base_part[:, :3, :3]
    q = quaternion_from_rotation(turns @ turns[len(turns) // 2].T)
    sine = np.linalg.norm(q[:, :3], axis=1)
    angle = 2 * np.arctan2(sine, q[:, 3])
    off = q[:, :3] * np.divide(angle, sine, out=np.full_like(angle, 2.0), where=sine > 0)[:, None]
    return np.hstack([at - np.median(at, axis=0), np.degrees(off - np.median(off, axis=0))])


def _shifts(cuts: list[int], pose: FloatArray, left: FloatArray, pattern: SeenDirections | None) -> tuple[Shift, ...]:
    ends = [0, *cuts, len(pose)]
    variance = 0.0
    if pattern is not None and pattern.freedom:
        variance = max(float((moving_range_sigma(left) ** 2).sum()) / pattern.freedom, ROUND_OFF**2)
    found = []
    for before, at, after in zip(ends, cuts, ends[2:], strict=False):

        def step(values: FloatArray, before: int = before, at: int = at, after: int = after) -> FloatArray:
            return np.asarray(values[at:after].mean(axis=0) - values[before:at].mean(axis=0))

        likely = Likely.unknown()
        if pattern is not None and variance > 0:
            share = variance * (1 / (at - before) + 1 / (after - at))
            likely = likely_cause(step(left), share, after - before, pattern)
        found.append(Shift(at, step(pose), likely))
    return tuple(found)
