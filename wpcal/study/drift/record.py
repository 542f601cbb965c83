"""The record ``wpcal/drift/1`` (``drift.json``), and the sentences about shifts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wpcal.core.arrays import BoolArray
from wpcal.study.drift.causes import Cause
from wpcal.study.drift.control import CUSUM_H, CUSUM_K, LIMIT_SIGMAS, Charts
from wpcal.study.drift.jobs import FailedJob
from wpcal.study.drift.shifts import FALSE_ALARM
from wpcal.study.drift.watch import POSE_CHANNELS, PartDrift, Shift

RULES = (
    {
        "name": "individuals",
        "rule": f"a job is outside if it is more than {LIMIT_SIGMAS:g} sigma from the centre; sigma is the median "
        "moving range / 0.954, the centre the mean of the first jobs",
        "false_alarm": "0.3 % of the jobs per number with a known sigma; 0.4 % with 200 jobs, 0.7 % with 30, "
        "1.5 % with 8",
    },
    {
        "name": "cusum",
        "rule": f"sums of what exceeds {CUSUM_K:g} sigma on either side; alarm above {CUSUM_H:g} sigma, then from 0 "
        "again",
        "false_alarm": "one in 465 jobs per number with a known centre and sigma; one in about 200 when the first 25 "
        "jobs give the centre",
    },
    {
        "name": "shift",
        "rule": "largest change of the mean between two stretches of at least 3 jobs, over the pose and what is left "
        "of all residuals after a rigid motion, and again on both sides",
        "false_alarm": f"at most {FALSE_ALARM * 100:g} % of the parts without any change",
    },
)
"""The rates are those of normally distributed errors without any change, simulated."""
UNORDERED = "not all have a date with a time, or only some have a time zone"
"""Why jobs are in the order of their lists."""


def drift_record(
    parts: Sequence[PartDrift],
    failed: Sequence[FailedJob],
    left_out: Sequence[str],
    corrected: Sequence[Sequence[str]] | None = None,
) -> dict[str, Any]:
    """Return the record; `corrected`: of each part, what was corrected alike on the pendant."""
    return {
        "schema": "wpcal/drift/1",
        "parts": [
            {**part_record(part), "corrected": list(alike)}
            for part, alike in zip(parts, corrected or [()] * len(parts), strict=True)
        ],
        "failed": [{"job": job.job, "out": job.out, "error": job.error} for job in failed],
        "left_out": list(left_out),
        "rules": [dict(rule) for rule in RULES],
    }


def part_record(part: PartDrift) -> dict[str, Any]:
    """Return what is said about one part."""
    jobs = part.jobs
    worst = part.most_wrong
    return {
        "part": {"file": jobs.file, "sha256": jobs.sha256 or None},
        "jobs": len(jobs.names),
        "first_job": jobs.names[0],
        "last_job": jobs.names[-1],
        "order": "when" if jobs.by_time else "list",
        "centre_from_jobs": part.first,
        "pose": [
            {"name": name, "unit": unit, **_chart(part.pose, column, jobs.names)}
            for column, (name, unit) in enumerate(POSE_CHANNELS)
        ],
        "points": [_point(part, column) for column in range(len(jobs.points))],
        "points_not_in_all_jobs": list(jobs.left_out),
        "most_wrong": None if worst is None else jobs.points[worst],
        "seam_error": None if part.seam is None else {"unit": "mm", **_chart(part.seam, 0, jobs.names)},
        "shifts": [_shift(part, shift) for shift in part.shifts],
    }


def shift_sentence(part: PartDrift, shift: Shift) -> str:
    """Return what a person reads about a shift."""
    names = [part.jobs.points[point] for point in shift.likely.points]
    match shift.likely.cause:
        case Cause.FIXTURE:
            return "all points moved together: fixture or base"
        case Cause.TOUCH if len(names) == 1:
            return f"one point is touched elsewhere: touch of {names[0]} (by about {shift.likely.amount:.2f} mm)"
        case Cause.TOUCH:
            return f"one point is touched elsewhere: one of {', '.join(names)}; the touches do not tell which"
        case Cause.ROBOT:
            growth = shift.likely.amount * 1000
            return f"grows with reach: robot, or another size of the parts ({growth:+.2f} mm per metre)"
    return "unclear: the residuals do not fit one cause"


def _chart(charts: Charts, column: int, names: Sequence[str]) -> dict[str, Any]:
    centre, sigma = float(charts.centre[column]), float(charts.sigma[column])
    return {
        "centre": centre,
        "sigma": sigma,
        "lower": centre - LIMIT_SIGMAS * sigma,
        "upper": centre + LIMIT_SIGMAS * sigma,
        "last": float(charts.values[-1, column]),
        "outside": _named(charts.outside[:, column], names),
        "cusum_alarms": _named(charts.alarms[:, column], names),
    }


def _named(marked: BoolArray, names: Sequence[str]) -> list[str]:
    return [names[row] for row in np.flatnonzero(marked).tolist()]


def _point(part: PartDrift, column: int) -> dict[str, Any]:
    values = part.distance.values[:, column]
    return {
        "name": part.jobs.points[column],
        "rms_mm": float(np.sqrt((values**2).mean())),
        "largest_mm": float(values.max()),
        "largest_in_job": part.jobs.names[int(values.argmax())],
        "mean_base_mm": part.jobs.residuals[:, column].mean(axis=0).tolist(),
        "jobs_largest": int(part.largest[column]),
        "jobs_named_wrong": int(part.jobs.suspected[column]),
    }


def _shift(part: PartDrift, shift: Shift) -> dict[str, Any]:
    jobs = part.jobs
    return {
        "job": jobs.names[shift.at],
        "number": shift.at + 1,
        "when": jobs.when[shift.at] or None,
        "cause": shift.likely.cause.value,
        "points": [jobs.points[point] for point in shift.likely.points],
        "sentence": shift_sentence(part, shift),
        "xyz_mm": shift.move[:3].tolist(),
        "turn_deg": shift.move[3:].tolist(),
    }
