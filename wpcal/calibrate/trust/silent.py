"""Searches that found nothing are evidence: where the fit has the part, they should have found nothing.

A part that is symmetric but for one hole fits the other touches turned by 180 degrees as well. The search in that hole
then misses, and only this shows that the part is turned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.trust.criteria import SILENT, CriterionFit
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.issue import Issue
from wpcal.core.wording import listed

MARGIN_MM = 1.0
"""Beyond the predicted error, a face must be this far inside a stroke, and its border this far from the touch."""


@dataclass(frozen=True, slots=True, eq=False)
class SilentSearches:
    """Searches without a touch."""

    ends: Touches  #: Their targets, with the ends of their strokes as places, in `base`.
    starts: FloatArray  #: shape (n, 3). In `base`, mm.
    #: shape (n,). The touch signal was on at the start; otherwise the stroke ended without contact.
    was_active: BoolArray


def silent_issues(silent: SilentSearches, fit: CriterionFit) -> tuple[Issue, ...]:
    """Name the searches that contradict a fit. One issue, or none."""
    R, t = fit.T.R, fit.T.t_mm
    ends, targets = silent.ends, silent.ends.targets
    start, end = ((p - t) @ R for p in (silent.starts, ends.p_base))
    before, behind = (_above(ends, p) for p in (start, end))
    margin = MARGIN_MM + fit.error_95_mm(end)
    share = np.clip(before / np.where(before == behind, 1.0, before - behind), 0.0, 1.0)
    contact = start + share[:, None] * (end - start)
    is_inside = np.ones(len(ends), dtype=bool)
    normal = targets.nearest(ends.rows, contact).normal
    for side in _sides(normal):
        is_inside &= targets.overhang(ends.rows, contact + margin[:, None] * side) <= 0.0
    missed = ~silent.was_active & (before > 0) & (behind < -margin) & is_inside
    early = silent.was_active & (before > margin)
    wrong = [ends.names[k] for k in np.flatnonzero(missed | early)]
    if not wrong:
        return ()
    one = "search" if len(wrong) == 1 else "searches"
    what = "missed" if missed.any() else "had the signal on at the start"
    where = "a face is inside the stroke" if missed.any() else "the start is clear of the face"
    message = (
        f"{one} {listed(wrong)} {what}, though {where} where the fit has the part; the part may stand in another "
        f"place, turned or mirrored: look at it, and run {listed(wrong)} again"
    )
    return (Issue(SILENT, message, tuple(wrong)),)


def _above(touches: Touches, points: FloatArray) -> FloatArray:
    """Distance of the wire from its face along the outward normal, shape (n,), mm; infinite on edges and at points."""
    near = touches.targets.nearest(touches.rows, points)
    above = np.einsum("ni,ni->n", points - near.p, near.normal) - touches.radius_mm
    return np.asarray(np.where(np.any(near.normal != 0.0, axis=1), above, np.inf))


def _sides(normal: FloatArray) -> list[FloatArray]:
    """Four unit vectors per normal along the face, each of shape (n, 3)."""
    away = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    first = np.cross(normal, away)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-300)
    second = np.cross(normal, first)
    return [first, -first, second, -second]
