"""The touch that the others contradict: the fit without each in turn, and the test behind naming one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri, fdtri

from wpcal.calibrate.diagnose import CLEAR_FACTOR
from wpcal.calibrate.robust import FALSE_ALARM, FLOOR_MM
from wpcal.core.issue import Issue
from wpcal.touch.fit import Pose, fit_least_squares, scaled_jacobian
from wpcal.touch.touches import Touches

MOST_JUDGED = 60
"""Only so many touches are left out in turn, those with the largest residuals: each costs a fit."""
HELD = 1e-3
"""A touch without which a motion is free (this share of the largest singular value) cannot be judged by the others."""


@dataclass(frozen=True, slots=True, eq=False)
class Doubt:
    """A touch that the others contradict.

    Parameters
    ----------
    row : int
    without : Pose
        The fit of the others, by least squares; its residuals are those of the others.
    off_mm : float
        How far that touch lies from its target then, mm.
    """

    row: int
    without: Pose
    off_mm: float


def find_distrusted(touches: Touches, pose: Pose, sigma_mm: float | None) -> Doubt | None:
    """Name the touch without which the rest agree, where one stands out.

    Parameters
    ----------
    touches : Touches
    pose : Pose
        Their least-squares fit.
    sigma_mm : float or None
        Teaching error per axis, where stated: then the sums of squares are held against χ², else their ratio against F.

    Returns
    -------
    Doubt or None
        None also where two touches could be the wrong one.
    """
    total = float(np.sum(pose.at.d**2))
    rank = pose.at.rank
    whole = int(rank.sum()) - 6
    suspects = np.argsort(-pose.at.distances, kind="stable")[:MOST_JUDGED]
    tried = []
    for row in suspects:
        freedom = whole - int(rank[row])
        others = touches.select(np.delete(np.arange(len(touches)), row))
        if freedom < 1 or not _is_held(others, pose):
            continue
        rest = fit_least_squares(others, pose)
        tried.append((float(np.sum(rest.at.d**2)) / freedom, int(row), freedom, rest))
    if not tried:
        return None
    tried.sort(key=lambda item: item[0])
    mean, row, freedom, rest = tried[0]
    rivals = [item for item in tried[1:] if item[0] <= max(CLEAR_FACTOR * mean, FLOOR_MM**2)]
    if rivals or not _is_explained(total, mean * freedom, whole, freedom, len(tried), sigma_mm):
        return None
    off = touches.select([row]).linearised(rest.R, rest.t).distances[0]
    return Doubt(row, rest, float(off))


def doubt_issues(touches: Touches, pose: Pose, doubt: Doubt | None) -> tuple[Issue, ...]:
    """Say which touch is distrusted, and what the fit is with it and without it."""
    if doubt is None:
        return ()
    name = touches.names[doubt.row]
    before, after = (float(np.sqrt(np.mean(p.at.distances**2))) for p in (pose, doubt.without))
    middle = touches.targets.centre
    moved = float(np.linalg.norm((pose.R - doubt.without.R) @ middle + pose.t - doubt.without.t))
    message = (
        f"the other touches agree without {name}, which is then {doubt.off_mm:.3g} mm off: RMS {before:.3g} mm with it, "
        f"{after:.3g} mm without, and the part's middle moves by {moved:.3g} mm; touch it again, or --criterion robust"
    )
    return (Issue("blunder", message, (name,)),)


def _is_held(touches: Touches, pose: Pose) -> bool:
    J, _, _ = scaled_jacobian(touches, Pose.of(touches, pose.R, pose.t))
    values = np.linalg.svd(J.reshape(-1, 6), compute_uv=False)
    return bool(len(values) == 6 and values[-1] > HELD * values[0])


def _is_explained(total: float, rest: float, whole: int, freedom: int, tests: int, sigma_mm: float | None) -> bool:
    """Tell whether the touches contradict themselves as they are and agree without the one."""
    level = FALSE_ALARM / tests
    if sigma_mm is not None:
        limits = (max(float(chdtri(nu, level)) * sigma_mm**2, FLOOR_MM**2) for nu in (whole, freedom))
        return total > next(limits) and rest <= next(limits)
    gone = whole - freedom
    ratio = float(fdtri(gone, freedom, 1.0 - level))
    return total - rest > max(ratio * rest * gone / freedom, FLOOR_MM**2)
