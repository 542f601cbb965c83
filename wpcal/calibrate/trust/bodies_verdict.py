"""The verdict on a weldment whose bodies may have moved.

The checks are those of a rigid part (`wpcal.calibrate.trust.verdict`), in the model in which bodies move within their
tack tolerances. Three of them differ:

* A wrong touch is one that the others contradict also if bodies moved.
* A touch is unchecked if it could be off by `GROSS_MM` and look like a motion of its body. That is so where no other
  touch sees this motion and the tack tolerance is above about 2.5 mm.
* No ``FAIL`` for a predicted error that is too large: touches on the bodies lower it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from wpcal.calibrate.errors.of_bodies import MOST_POINTS, MeetingPoints, joint_error, meeting_errors, meeting_jacobian
from wpcal.calibrate.errors.prediction import Sigma, SigmaSource, length_quantile
from wpcal.calibrate.moved import MovedBodies
from wpcal.calibrate.trust.criteria import RIVAL, SILENT
from wpcal.calibrate.trust.residuals import FALSE_ALARM
from wpcal.calibrate.trust.verdict import Verdict, VerdictKind, VerdictReason
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs
from wpcal.core.wording import listed

TWO_BODIES = "touch-on-two-bodies"
"""Code of the issue that touches lie where corners or edges of two bodies coincide in the model."""
_DOUBTS = {
    TWO_BODIES: VerdictReason.UNCHECKED,
    RIVAL: VerdictReason.RIVAL,
    SILENT: VerdictReason.SILENT_SEARCH,
}
GROSS_MM = 10.0
"""A touch on a wrong face, or one that slipped off an edge, is off by the thickness of a plate or more."""


@dataclass(frozen=True, slots=True, eq=False)
class BodiesEvidence:
    """What decides on the verdict."""

    moved: MovedBodies
    touch_names: tuple[str, ...]  #: Of the fitted touches.
    points: MeetingPoints  #: k points of the accepted seams; of the fitted touches if there is no seam.
    seam_names: Sequence[str]
    sigma: Sigma  #: The error of the touches.
    bias_mm: float  #: Allowance for an error of the tool centre point, mm.
    #: shape (n,). Touches that were not fitted, with their place on the moved part in `part`, and the body of each.
    check: tuple[PointPairs, IntArray] | None
    issues: Sequence[Issue]  #: Of the part as one body.
    tolerance_mm: float


def judge_bodies(evidence: BodiesEvidence) -> Verdict:
    """Judge whether the seams are shown to be within the tolerance."""
    moved, tolerance = evidence.moved, evidence.tolerance_mm
    own = meeting_errors(moved.fit, evidence.points).total_mm
    worst = np.argsort(-own, kind="stable")[:MOST_POINTS]
    J = meeting_jacobian(moved.fit.motions, evidence.points.select(worst))
    error_mm = joint_error(J, moved.fit.covariance) + evidence.bias_mm
    seam = evidence.seam_names[int(worst[0])] if evidence.seam_names else ""
    failed = _failure(evidence)
    if failed is not None:
        return Verdict(VerdictKind.FAIL, failed[1], seam, failed[0], error_mm)
    what = f"{moved.sentence()}; {moved.tolerances_sentence()}"
    if error_mm > tolerance:
        where = f"seam {seam} may be" if seam else "a touched point may be"
        sentence = (
            f"{where} off by {error_mm:.3g} mm (95 %), which is more than the tolerance of {tolerance:g} mm "
            f"({what}): touch its bodies again"
        )
        return Verdict(VerdictKind.UNSURE, sentence, seam, VerdictReason.ERROR, error_mm)
    unsure = _doubt(evidence)
    if unsure is not None:
        return Verdict(VerdictKind.UNSURE, unsure[1], seam, unsure[0], error_mm)
    those = "the accepted seams" if seam else "the touched points"
    sentence = f"{those} are within {error_mm:.3g} mm with 95 % confidence ({what})"
    return Verdict(VerdictKind.PASS, sentence, seam, VerdictReason.WITHIN, error_mm)


def _failure(evidence: BodiesEvidence) -> tuple[VerdictReason, str] | None:
    """Return why the fit is shown to be wrong, or None."""
    moved = evidence.moved
    contradiction = _contradiction(moved)
    if contradiction:
        return VerdictReason.CONTRADICTION, contradiction
    if evidence.sigma.source is SigmaSource.STATED and _contradicts(moved):
        if moved.far:
            return VerdictReason.STATED_ERROR, moved.far_sentence()
        what = (
            f"the residuals are larger than the stated error of the touches ({evidence.sigma.mm:.3g} mm per axis) and "
            "the motions of the bodies explain: a body is bent or differs from its model, or the stated error is too "
            "small"
        )
        return VerdictReason.STATED_ERROR, what
    off, limits, names = _checked(evidence)
    if len(off):
        worst = int(np.argmax(off / limits))
        if off[worst] > max(limits[worst], evidence.tolerance_mm):
            what = (
                f"check touch {names[worst]} is off by {off[worst]:.3g} mm; the errors of the fit and of the touch "
                f"explain at most {limits[worst]:.3g} mm"
            )
            return VerdictReason.CHECK_CONTRADICTS, what
    return None


def _contradiction(moved: MovedBodies) -> str:
    """Say which touches, contacts or bodies contradict the others; empty if none does."""
    contacts = moved.contacts
    if moved.wrong:
        holding = contacts is not None and not contacts.broken
        kept = " and stay on each other" if holding else ""
        remedy = ", or calibrate without --contacts" if holding else ""
        return (
            f"the other touches contradict {listed(moved.wrong)}, also if bodies moved{kept}: touch there again{remedy}"
        )
    if contacts is not None and contacts.broken:
        return f"{moved.contacts_sentence()}: calibrate without --contacts, or allow a wider gap (--contacts MM)"
    return moved.far_sentence() if moved.doubtful else ""


def _doubt(evidence: BodiesEvidence) -> tuple[VerdictReason, str] | None:
    """Return why a small predicted error does not show that the seams are within the tolerance, or None."""
    for issue in evidence.issues:
        if issue.code in _DOUBTS:
            return _DOUBTS[issue.code], issue.message
    unchecked = unchecked_touches(evidence.moved, evidence.touch_names, evidence.sigma.mm)
    if unchecked:
        what = (
            f"nothing tests {listed(unchecked)}: if one is wrong, it looks like a motion of its body. Touch its body "
            "once more, on the same face"
        )
        return VerdictReason.UNCHECKED, what
    if evidence.moved.far:
        return VerdictReason.LARGE_RESIDUALS, evidence.moved.far_sentence()
    if evidence.sigma.source is not SigmaSource.STATED and _contradicts(evidence.moved):
        what = (
            f"careful touches ({evidence.sigma.mm:g} mm per axis) and the motions of the bodies do not explain the "
            "residuals: look for a bent plate or a wrong model, or state the error of the touches"
        )
        return VerdictReason.LARGE_RESIDUALS, what
    off, _, names = _checked(evidence)
    if len(off) and off.max() > evidence.tolerance_mm:
        worst = int(np.argmax(off))
        what = f"check touch {names[worst]} is off by {off[worst]:.3g} mm, which its own error may explain"
        return VerdictReason.CHECK, f"{what}: touch it again"
    return None


def unchecked_touches(moved: MovedBodies, names: Sequence[str], sigma_mm: float) -> tuple[str, ...]:
    r"""Name the touches that could be off by `GROSS_MM` and look like a motion of their body.

    A touch i that is off by e leaves the normalised residual :math:`e \sqrt{P_{ii}} / \sigma`; the test for wrong
    touches finds it if this is above its limit.

    References
    ----------
    Baarda (1968), A testing procedure for use in geodetic networks: the least error that a test finds.
    """
    touched = moved.fit.whitened
    limit = math.sqrt(float(chdtri(1, FALSE_ALARM / len(touched.r))))
    found = GROSS_MM / sigma_mm * np.sqrt(np.maximum(np.diag(touched.residual_matrix()), 0.0)) > limit
    rows = touched.touch[~found & (touched.touch >= 0)]
    return tuple(names[i] for i in np.unique(rows).tolist())


def _contradicts(moved: MovedBodies) -> bool:
    """Whether the residuals are larger than the errors of the touches and the tack tolerances explain."""
    touched = moved.fit.whitened
    freedom = len(touched.r) - int(np.linalg.matrix_rank(touched.J))
    square = float(touched.r @ touched.residual_matrix() @ touched.r)
    return freedom > 0 and square > float(chdtri(freedom, FALSE_ALARM))


def _checked(evidence: BodiesEvidence) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Return how far every check touch is off, what its error and that of the fit explain, mm, and their names."""
    if evidence.check is None:
        return np.zeros(0), np.zeros(0), ()
    fit, (pairs, body) = evidence.moved.fit, evidence.check
    off = np.linalg.norm(pairs.p_target - fit.T_base_part.apply(pairs.p_source), axis=1)
    J = meeting_jacobian(fit.motions, MeetingPoints.on(body, pairs.p_source))
    own = evidence.sigma.mm**2 * np.eye(3) if pairs.covariances is None else pairs.covariances
    spread = J @ fit.covariance @ J.transpose(0, 2, 1) + own
    return off, length_quantile(spread, 1.0 - FALSE_ALARM / len(off)) + evidence.bias_mm, pairs.names
