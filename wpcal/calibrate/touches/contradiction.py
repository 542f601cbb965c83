"""Find the touch that the others contradict: fit without each touch in turn, and test whether one stands out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri, fdtri

from wpcal.calibrate.criteria import BLUNDER
from wpcal.calibrate.outlier_limits import CLEAR_FACTOR, FALSE_ALARM, FLOOR_MM, LEAST_SIGMA_MM
from wpcal.calibrate.touches.fit import Pose, fit_squares, scaled_jacobian
from wpcal.calibrate.touches.touches import Touches
from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue

MOST_JUDGED = 60
"""At most this many touches are left out in turn, those with the largest residuals: each costs one fit."""
HELD = 1e-3
"""If a motion is free without a touch (below this share of the largest singular value), the others cannot judge it."""


@dataclass(frozen=True, slots=True, eq=False)
class ContradictedTouch:
    """A touch that the others contradict.

    Parameters
    ----------
    row : int
    off_mm : float
        How far that touch lies from its target when the others are fitted without it, mm.
    """

    row: int
    off_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class _Without:
    """The fit without one touch: its sum of squares, its degrees of freedom."""

    row: int
    pose: Pose
    total: float
    freedom: int

    @property
    def mean(self) -> float:
        return self.total / self.freedom


def find_contradicted(touches: Touches, pose: Pose, sigma_mm: float | None) -> ContradictedTouch | None:
    """Find the touch without which the rest agree, if one stands out.

    Parameters
    ----------
    touches : Touches
        If they carry covariances, residuals are weighted with these.
    pose : Pose
        Near the answer.
    sigma_mm : float or None
        Teaching error per axis of touches without covariances, if stated. With stated errors the sums of squares are
        compared with χ², otherwise their ratio with F.

    Returns
    -------
    ContradictedTouch or None
        None also if either of two touches could be the wrong one.
    """
    stated = touches.covariances is not None
    pose = fit_squares(touches, pose, weighted=stated)
    unit = 1.0 if stated or sigma_mm is None else max(sigma_mm, LEAST_SIGMA_MM)
    whole, squares = int(pose.at.rank.sum()) - 6, _squares(touches, pose)
    tried = []
    for row in np.argsort(-squares, kind="stable")[:MOST_JUDGED]:
        freedom = whole - int(pose.at.rank[row])
        others = touches.select(np.delete(np.arange(len(touches)), row))
        if freedom >= 1 and _is_held(others, pose):
            rest = fit_squares(others, pose, weighted=stated)
            tried.append(_Without(int(row), rest, float(_squares(others, rest).sum()) / unit**2, freedom))
    if not tried:
        return None
    tried.sort(key=lambda without: without.mean)
    total, known = float(squares.sum()) / unit**2, stated or sigma_mm is not None
    named = _named_by_size(total, whole, tried) if known else _named_by_ratio(total, whole, tried)
    if named is None:
        return None
    off = float(touches.select([named.row]).linearised(named.pose.R, named.pose.t).distances[0])
    return ContradictedTouch(named.row, off) if off > FLOOR_MM else None


def contradiction_issues(touches: Touches, found: ContradictedTouch | None) -> tuple[Issue, ...]:
    """Report the contradicted touch."""
    if found is None:
        return ()
    name = touches.names[found.row]
    message = f"the other touches contradict {name} ({found.off_mm:.3g} mm off their fit): touch it again"
    return (Issue(BLUNDER, message, (name,)),)


def _squares(touches: Touches, pose: Pose) -> FloatArray:
    """Squared residuals, or dᵀ Λ d with the inverse covariances; shape (n,)."""
    weights = pose.at.information(touches.covariances)
    return np.asarray(np.einsum("ni,nij,nj->n", pose.at.d, weights, pose.at.d))


def _is_held(touches: Touches, pose: Pose) -> bool:
    J, _, _ = scaled_jacobian(touches, Pose.of(touches, pose.R, pose.t))
    values = np.linalg.svd(J.reshape(-1, 6), compute_uv=False)
    return bool(len(values) == 6 and values[-1] > HELD * values[0])


def _named_by_size(total: float, whole: int, tried: list[_Without]) -> _Without | None:
    """Find the only touch without which the stated errors explain the rest, if they do not explain all."""
    level = FALSE_ALARM / len(tried)
    explained = [without for without in tried if without.total <= float(chdtri(without.freedom, level))]
    return explained[0] if total > float(chdtri(whole, level)) and len(explained) == 1 else None


def _named_by_ratio(total: float, whole: int, tried: list[_Without]) -> _Without | None:
    """Find the touch without which the residuals are much smaller than without any other."""
    first = tried[0]
    rivals = [w for w in tried[1:] if w.mean <= max(CLEAR_FACTOR * first.mean, FLOOR_MM**2)]
    gone = whole - first.freedom
    ratio = float(fdtri(gone, first.freedom, 1.0 - FALSE_ALARM / len(tried)))
    stands_out = total - first.total > max(ratio * first.mean * gone, FLOOR_MM**2)
    return first if stands_out and not rivals else None
