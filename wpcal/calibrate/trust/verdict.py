"""The verdict on a fit of points or of touches: whether the seams are shown to be within the tolerance.

The verdict judges the error that is predicted for the seams, not the residuals: a fit of three points has small
residuals and a large error, a fit of many points has large residuals and a small error. The residuals are compared with
the teaching error instead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum, StrEnum
from typing import Any

import numpy as np

from wpcal.calibrate.errors.prediction import (
    COVERAGE,
    POSTURE_FACTOR,
    USUAL_SIGMA_MM,
    SigmaSource,
    TeachingError,
    joint_errors,
    length_quantile,
)
from wpcal.calibrate.trust.criteria import BLUNDER, NEIGHBOUR, NOT_NAMED, RIVAL, SILENT, CriterionFit
from wpcal.calibrate.trust.residuals import FALSE_ALARM, ResidualEvidence
from wpcal.calibrate.trust.tool_offset import TOOL_OFFSET
from wpcal.calibrate.trust.without import Distrusted
from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.tangent import point_jacobian
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import plural

MOST_NAMED = 6
"""Most observations that the sentence names."""

CONTRADICTIONS = (TOOL_OFFSET, BLUNDER, NEIGHBOUR, NOT_NAMED, "swapped-names", "mirrored")
"""Codes of the issues that say that the observations contradict each other."""


class VerdictKind(StrEnum):
    """What is shown."""

    PASS = "PASS"
    """The seams are within the tolerance, with 95 % confidence."""
    UNSURE = "UNSURE"
    """Neither is shown. More points decide."""
    FAIL = "FAIL"
    """The observations contradict each other or their stated error, or a seam is outside, with 95 % confidence."""


class VerdictReason(Enum):
    """Why the verdict is what it is."""

    WITHIN = "within"
    ERROR = "error"
    """The predicted error is larger than the tolerance."""
    UNCHECKED = "unchecked"
    """A wrong touch would leave no residual."""
    LARGE_RESIDUALS = "large-residuals"
    """No teaching error is stated, and the residuals are larger than the usual one explains."""
    CHECK = "check"
    """A check point is off by more than the tolerance, which its own error may explain."""
    CONTRADICTION = "contradiction"
    """Some observations contradict the others."""
    STATED_ERROR = "stated-error"
    """The residuals contradict the stated teaching error."""
    CHECK_CONTRADICTS = "check-contradicts"
    """A check point is off by more than all errors explain."""
    RIVAL = "rival"
    """The touches do not exclude another place of the part."""
    SILENT_SEARCH = "silent-search"
    """A search found nothing where the fit has a face."""
    BEYOND = "beyond"
    """A seam is off by more than the tolerance, with 95 % confidence."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """The verdict, as every command and page states it."""

    kind: VerdictKind
    sentence: str  #: For a person; does not repeat the kind.
    seam: str  #: The accepted seam with the largest predicted error. Empty if none was given.
    reason: VerdictReason
    #: With 95 % probability no point of the seams is off by more, with the allowance for a bias of the tool. Without
    #: seams, no fitted point.
    error_95_mm: float
    next_point: str | None = None  #: The feature to touch next, where the caller knows the features.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "kind": self.kind.value,
            "sentence": self.sentence,
            "seam": self.seam or None,
            "reason": self.reason.value,
            "error_95_mm": self.error_95_mm,
            "next_point": self.next_point,
        }


@dataclass(frozen=True, slots=True, eq=False)
class VerdictEvidence:
    """Everything that decides on the verdict of one fit."""

    fit: CriterionFit
    names: tuple[str, ...]  #: Of all observations.
    word: str  #: What one observation is called.
    residuals: ResidualEvidence
    check: PointPairs | None
    issues: tuple[Issue, ...]
    distrusted: Distrusted | None
    teaching: TeachingError
    tolerance_mm: float
    #: shape (k, 3). Points of the accepted seams, or the fitted points if there are none; part frame, mm.
    points_part: FloatArray
    seam_names: tuple[str, ...]  #: length k or 0. The seam of each point.
    largest_mm: float  #: Largest residual of a fitted observation.


def judge_fit(evidence: VerdictEvidence, *, suggest: Callable[[], str | None] | None = None) -> Verdict:
    """Decide whether the seams are shown to be within the tolerance.

    Notes
    -----
    The tests of the residuals against a stated teaching error and of the check points each raise a false alarm in one
    fit of a hundred. With a true teaching error, a `PASS` with a seam outside and a `FAIL` for its error with all seams
    inside each happen in at most 5 of 100 calibrations.
    """
    fit = evidence.fit
    errors = joint_errors(
        fit.T.apply(evidence.points_part), fit.covariance, degrees_of_freedom=fit.sigma.degrees_of_freedom
    )
    bias_mm = POSTURE_FACTOR * evidence.teaching.tcp_bias_mm
    error_mm = float(np.quantile(errors, COVERAGE)) + bias_mm
    least_mm = float(np.quantile(errors, 1.0 - COVERAGE)) - bias_mm
    seam = ""
    if evidence.seam_names:
        seam = evidence.seam_names[fit.largest_error_95(evidence.points_part)[0]]
    failed = _failure(evidence, seam, least_mm, error_mm)
    if failed is not None:
        return Verdict(VerdictKind.FAIL, failed[1], seam, failed[0], error_mm)
    unsure = _rival_place(evidence) or _doubt(evidence, seam, error_mm)
    if unsure is None:
        what = (
            f"the {len(set(evidence.seam_names))} accepted seams are"
            if seam
            else f"the fitted {plural(evidence.word)} are"
        )
        if len(set(evidence.seam_names)) == 1:
            what = f"seam {seam} is"
        sentence = (
            f"{what} within {error_mm:.3g} mm with 95 % confidence ({fit.sigma.describe()}); the tolerance is "
            f"{evidence.tolerance_mm:g} mm"
        )
        return Verdict(VerdictKind.PASS, sentence, seam, VerdictReason.WITHIN, error_mm)
    reason, sentence, remedy = unsure
    found = suggest() if suggest is not None and not remedy else None
    advice = remedy or (f"touch {found} as well" if found else f"one more {evidence.word} would help")
    return Verdict(VerdictKind.UNSURE, f"{sentence}: {advice}", seam, reason, error_mm, found)


def _failure(
    evidence: VerdictEvidence, seam: str, least_mm: float, error_mm: float
) -> tuple[VerdictReason, str] | None:
    """Return why the fit is shown to be wrong, or None."""
    fit, tolerance = evidence.fit, evidence.tolerance_mm
    for issue in evidence.issues:
        if issue.code in CONTRADICTIONS and _matters(evidence, issue, error_mm):
            return VerdictReason.CONTRADICTION, issue.message
    explained = any(issue.code == TOOL_OFFSET for issue in evidence.issues)  # the predicted error has an allowance
    if evidence.residuals.contradicts_stated and not explained:
        sentence = (
            f"the residuals (RMS {evidence.residuals.rms_mm:.3g} mm) are larger than the stated teaching error of "
            f"{fit.sigma.mm:.3g} mm per axis explains: a {evidence.word} is wrong, the part differs from its model, or "
            "the stated error is too small"
        )
        return VerdictReason.STATED_ERROR, sentence
    if least_mm > tolerance:
        where = f"seam {seam} is" if seam else f"a fitted {evidence.word} is"
        sentence = (
            f"{where} off by {least_mm:.3g} mm or more with 95 % confidence ({fit.sigma.describe()}); the tolerance is "
            f"{tolerance:g} mm"
        )
        return VerdictReason.BEYOND, sentence
    return _contradicting_check(evidence)


def _matters(evidence: VerdictEvidence, issue: Issue, error_mm: float) -> bool:
    """Whether contradicted observations were fitted, or a wrong tool may carry a seam out of the tolerance."""
    if issue.code == TOOL_OFFSET:
        return error_mm > evidence.tolerance_mm
    fitted = {evidence.names[row] for row in evidence.fit.rows}
    if issue.ids and fitted.isdisjoint(issue.ids):
        return False
    found = evidence.distrusted
    if issue.code in (NEIGHBOUR, NOT_NAMED) and found is None:
        return evidence.largest_mm > evidence.tolerance_mm
    if issue.code not in (BLUNDER, NEIGHBOUR) or found is None:
        return True
    return found.shift_mm > evidence.tolerance_mm


def _contradicting_check(evidence: VerdictEvidence) -> tuple[VerdictReason, str] | None:
    """Compare the residuals of the check points with the error of the fit there and that of a touch."""
    fit, check = evidence.fit, evidence.check
    if check is None:
        return None
    moved = fit.T.apply(check.p_source)
    J = point_jacobian(moved)
    own = fit.sigma.mm**2 * np.eye(3) if check.covariances is None else check.covariances
    limits = length_quantile(
        J @ fit.covariance @ J.transpose(0, 2, 1) + own,
        1.0 - FALSE_ALARM / len(check),
        degrees_of_freedom=fit.sigma.degrees_of_freedom,
    )
    limits = limits + POSTURE_FACTOR * evidence.teaching.tcp_bias_mm
    off = np.linalg.norm(check.p_target - moved, axis=1)
    worst = int(np.argmax(off / np.maximum(limits, np.finfo(float).tiny)))
    if off[worst] <= max(limits[worst], evidence.tolerance_mm):
        return None
    sentence = (
        f"check {evidence.word} {check.names[worst]} is off by {off[worst]:.3g} mm; the errors of the fit and of the "
        f"touch explain at most {limits[worst]:.3g} mm ({fit.sigma.describe()})"
    )
    return VerdictReason.CHECK_CONTRADICTS, sentence


def _rival_place(evidence: VerdictEvidence) -> tuple[VerdictReason, str, str] | None:
    """Return that the touches do not exclude another place of the part, and what to do; or None."""
    for issue in evidence.issues:
        if issue.code in (RIVAL, SILENT):
            what, _, remedy = issue.message.partition(": ")
            return VerdictReason.RIVAL if issue.code == RIVAL else VerdictReason.SILENT_SEARCH, what, remedy
    return None


def _doubt(evidence: VerdictEvidence, seam: str, error_mm: float) -> tuple[VerdictReason, str, str] | None:
    """Return why the seams are not shown to be within the tolerance, and what to do if not more points; or None."""
    fit, tolerance, word = evidence.fit, evidence.tolerance_mm, evidence.word
    if error_mm > tolerance:
        where = f"seam {seam}" if seam else f"a fitted {word}"
        sentence = (
            f"{where} may be off by {error_mm:.3g} mm (95 %; {fit.sigma.describe()}), which is more than the tolerance "
            f"of {tolerance:g} mm"
        )
        return VerdictReason.ERROR, sentence, ""
    if evidence.residuals.unchecked:
        sentence = f"nothing tests {_listed(evidence.residuals.unchecked)}; if one is wrong, no residual shows it"
        return VerdictReason.UNCHECKED, sentence, ""
    doubted = _doubted_observations(evidence)
    if doubted is not None:
        return doubted
    is_stated = fit.sigma.source is SigmaSource.STATED
    if not is_stated and evidence.largest_mm > tolerance and evidence.residuals.contradicts(USUAL_SIGMA_MM):
        sentence = (
            f"the largest residual is {evidence.largest_mm:.3g} mm, and careful touches ({USUAL_SIGMA_MM:g} mm per "
            "axis) do not explain the residuals"
        )
        remedy = "look for a bent part or a wrong model, or state the teaching error if the touches were that rough"
        return VerdictReason.LARGE_RESIDUALS, sentence, remedy
    if evidence.check is not None:
        off = Residuals.of(evidence.check, fit.T)
        if off.largest_mm > tolerance:
            sentence = f"check {word} {off.worst} is off by {off.largest_mm:.3g} mm, which its own error may explain"
            return VerdictReason.CHECK, sentence, "touch it again"
    return None


def _doubted_observations(evidence: VerdictEvidence) -> tuple[VerdictReason, str, str] | None:
    """Return which observations the others contradict, if that may carry a seam out of the tolerance, or None."""
    found = evidence.distrusted
    if found is not None and found.shift_mm + found.without_them.seam_error_95_mm > evidence.tolerance_mm:
        those = "it" if len(found.names) == 1 else "them"
        sentence = (
            f"the others contradict {_listed(found.names)}; the seams move by {found.shift_mm:.3g} mm if the fit "
            f"leaves {those} out"
        )
        return VerdictReason.CONTRADICTION, sentence, f"touch {those} again"
    unnamed = [issue.message for issue in evidence.issues if issue.code in (NEIGHBOUR, NOT_NAMED)]
    if unnamed and found is None:
        return VerdictReason.CONTRADICTION, unnamed[0], "no seam is shown to be outside"
    return None


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + more


def verdict_issues(
    pairs: PointPairs, check: PointPairs | None, T_base_part: RigidTransform, tolerance_mm: float
) -> tuple[Issue, ...]:
    """Name the fitted and the check points whose residuals exceed the tolerance."""
    found = []
    for group, word in ((pairs, "fitted"), (check, "check")):
        if group is None:
            continue
        residuals = Residuals.of(group, T_base_part)
        over = np.flatnonzero(residuals.norms_mm > tolerance_mm)
        if len(over):
            message = (
                f"the largest residual of the {word} points is {residuals.largest_mm:.4g} mm at {residuals.worst}; the "
                f"tolerance is {tolerance_mm:g} mm"
            )
            found.append(Issue("above-tolerance", message, tuple(group.names[i] for i in over[:20])))
    return tuple(found)


def bias_advice(teaching: TeachingError) -> tuple[Issue, ...]:
    """Say how a stated error of the tool centre point affects the welds, and how to avoid that."""
    if not teaching.tcp_bias_mm:
        return ()
    message = (
        f"a tool centre point off by {teaching.tcp_bias_mm:g} mm leaves no residual while the torch keeps its posture; "
        "the predicted errors allow for a weld a quarter turn away. Touch in the posture in which the tool centre "
        "point was calibrated (Yin 2003, section 3)"
    )
    return (Issue("tcp-bias", message),)
