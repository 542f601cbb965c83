"""What decides on the verdict of a weldment whose bodies may have moved (`wpcal.calibrate.trust.verdict`).

The rules are those of a part that is one body, in the model in which bodies move within their tack tolerances:

* A wrong touch is one that the others contradict also if bodies moved.
* A touch is unchecked if it could be off by `GROSS_MM` and look like a motion of its body. That is so where no other
  touch sees this motion and the tack tolerance is above about 2.5 mm.
* No ``FAIL`` for a predicted error that is too large: touches on the bodies lower it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from wpcal.calibrate.errors.of_bodies import MOST_POINTS, MeetingPoints, error_jacobian, joint_error, meeting_errors
from wpcal.calibrate.errors.prediction import Sigma, SigmaSource, length_quantile
from wpcal.calibrate.moved import MovedBodies
from wpcal.calibrate.trust.residuals import FALSE_ALARM
from wpcal.calibrate.trust.verdict import CheckPoints, Ground, Predicted, VerdictReason, check_level
from wpcal.core.arrays import IntArray
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs
from wpcal.core.wording import listed, short

GROSS_MM = 10.0
"""A touch on a wrong face, or one that slipped off an edge, is off by the thickness of a plate or more."""


@dataclass(frozen=True, slots=True, eq=False)
class BodiesEvidence:
    """Everything that decides on the verdict of a weldment."""

    moved: MovedBodies
    touch_names: tuple[str, ...]  #: Of the fitted touches.
    points: MeetingPoints  #: k points of the accepted seams; of the fitted touches if there is no seam.
    seam_names: Sequence[str]  #: length k or 0. The seam of each point.
    sigma: Sigma  #: The error of the touches.
    #: Touches that were not fitted, with their place on the moved part in `part`, and the body of each, shape (n,).
    check: tuple[PointPairs, IntArray] | None
    issues: Sequence[Issue]  #: Of the part as one body.
    tolerance_mm: float
    word: str = "touch"
    remedy: str = "touch its bodies again"

    def predicted(self) -> Predicted:
        """Return the predicted error of the seams."""
        moved = self.moved
        own = meeting_errors(moved.fit, self.points).total_mm
        worst = np.argsort(-own, kind="stable")[:MOST_POINTS]
        J, rest = error_jacobian(moved.fit, self.points.select(worst))
        seam = self.seam_names[int(worst[0])] if self.seam_names else ""
        error_mm = joint_error(J, moved.fit.covariance, rest)
        told = f"{moved.sentence()}; {moved.tolerances_sentence()}"
        if moved.fit.modes is not None and moved.fit.modes.belief.field.amplitude_mm:
            told = f"{told}; {moved.fit.modes.belief.field.describe()}"
        return Predicted(seam, float(own[worst[0]]), error_mm, 0.0, told)

    def contradictions(self, _: Predicted) -> Iterator[Ground]:
        """Name touches, contacts or bodies that the others contradict, then residuals that nothing explains."""
        moved, contacts = self.moved, self.moved.contacts
        is_broken = contacts is not None and bool(contacts.broken)
        if moved.wrong:
            holding = contacts is not None and not is_broken
            kept, remedy = (" and stay on each other", ", or calibrate without --contacts") if holding else ("", "")
            what = f"the other touches contradict {listed(moved.wrong)}, also if bodies moved{kept}"
            yield Ground(VerdictReason.CONTRADICTION, what, f"touch there again{remedy}")
        if is_broken:
            remedy = "calibrate without --contacts, or allow a wider gap (--contacts MM)"
            yield Ground(VerdictReason.CONTRADICTION, moved.contacts_sentence(), remedy)
        if moved.doubtful:
            yield Ground(VerdictReason.CONTRADICTION, moved.far_sentence())
        if self.sigma.source is SigmaSource.STATED and _is_too_large(moved):
            what = (
                f"the residuals are larger than the stated error of the touches ({short(self.sigma.mm)} mm per axis) "
                "and the motions of the bodies explain: a body is bent or differs from its model, or the stated error "
                "is too small"
            )
            yield Ground(VerdictReason.STATED_ERROR, moved.far_sentence() if moved.far else what)

    def doubts(self, _: Predicted) -> Iterator[Ground]:
        """Name touches that nothing tests, bodies that are too far away, and residuals that are larger than usual."""
        unchecked = unchecked_touches(self.moved, self.touch_names, self.sigma.mm)
        if unchecked:
            remedy = "if one is wrong, it looks like a motion of its body. Touch its body once more, on the same face"
            yield Ground(VerdictReason.UNCHECKED, f"nothing tests {listed(unchecked)}", remedy)
        if self.moved.far:
            yield Ground.told(VerdictReason.LARGE_RESIDUALS, self.moved.far_sentence())
        if self.sigma.source is not SigmaSource.STATED and _is_too_large(self.moved):
            what = (
                f"careful touches ({self.sigma.mm:g} mm per axis) and the motions of the bodies do not explain the "
                "residuals"
            )
            remedy = "look for a bent plate or a wrong model, or state the error of the touches"
            yield Ground(VerdictReason.LARGE_RESIDUALS, what, remedy)

    def checked(self) -> CheckPoints | None:
        """Return the touches that test the fit."""
        if self.check is None:
            return None
        fit, (pairs, body) = self.moved.fit, self.check
        J, rest = error_jacobian(fit, MeetingPoints.on(body, pairs.p_source))
        by_fit = J @ fit.covariance @ J.transpose(0, 2, 1) + np.diag(rest)[:, None, None] * np.eye(3)
        own = self.sigma.mm**2 * np.eye(3) if pairs.covariances is None else pairs.covariances
        limits = length_quantile(
            by_fit + own, check_level(len(pairs)), degrees_of_freedom=self.sigma.degrees_of_freedom
        )
        return CheckPoints.of(pairs, fit.T_base_part.apply(pairs.p_source), limits)

    def passed(self, shown: Predicted) -> str:
        """Say within what the seams are."""
        those = "the accepted seams" if shown.seam else "the touched points"
        return f"{those} are within {short(shown.error_mm)} mm with 95 % confidence ({shown.told})"


def unchecked_touches(moved: MovedBodies, names: Sequence[str], sigma_mm: float) -> tuple[str, ...]:
    r"""Name the touches that could be off by `GROSS_MM` and look like a motion of their body.

    A touch i that is off by e leaves the normalised residual :math:`e \sqrt{P_{ii}} / \sigma`; the test for wrong
    touches finds it if this is above its limit.

    References: Baarda (1968), A testing procedure for use in geodetic networks: the least error that a test finds.
    """
    touched = moved.fit.whitened
    limit = math.sqrt(float(chdtri(1, FALSE_ALARM / len(touched.r))))
    found = GROSS_MM / sigma_mm * np.sqrt(np.maximum(np.diag(touched.residual_matrix()), 0.0)) > limit
    rows = touched.touch[~found & (touched.touch >= 0)]
    return tuple(names[i] for i in np.unique(rows).tolist())


def _is_too_large(moved: MovedBodies) -> bool:
    """Whether the residuals are larger than the errors of the touches and the tack tolerances explain."""
    touched = moved.fit.whitened
    freedom = len(touched.r) - int(np.linalg.matrix_rank(touched.J))
    square = float(touched.r @ touched.residual_matrix() @ touched.r)
    return freedom > 0 and square > float(chdtri(freedom, FALSE_ALARM))
