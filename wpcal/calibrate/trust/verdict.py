"""Whether the seams are shown to be within the tolerance: the one verdict, on points, touches and bodies that moved.

The verdict is about the error of the seams, not about the residuals: a fit of three points has small residuals and a
large error, a fit of many points large residuals and a small error. Residuals are compared with the teaching error.

`judge_evidence` holds the order of the rules and the rules of all kinds of observations. What only points and touches
know is in `VerdictEvidence`, what only moved bodies know in `wpcal.calibrate.trust.bodies.BodiesEvidence`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum, StrEnum
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from wpcal.calibrate.errors.prediction import COVERAGE, Sigma, SigmaSource, TeachingError, length_quantile
from wpcal.calibrate.errors.robot_field import USUAL_SIGMA_MM, FieldOrigin
from wpcal.calibrate.trust.criteria import (
    BLUNDER,
    NEIGHBOUR,
    NOT_NAMED,
    RIVAL,
    SILENT,
    TWO_BODIES,
    CriterionFit,
    FitProblem,
)
from wpcal.calibrate.trust.residuals import FALSE_ALARM, ResidualEvidence
from wpcal.calibrate.trust.scale import SCALE
from wpcal.calibrate.trust.tool_offset import TOOL_OFFSET
from wpcal.calibrate.trust.without import Distrusted
from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import MOST_NAMED, listed, plural, short

if TYPE_CHECKING:
    from wpcal.calibrate.trust.bodies import BodiesEvidence

    Evidence: TypeAlias = "VerdictEvidence | BodiesEvidence"

CONTRADICTIONS = (TOOL_OFFSET, BLUNDER, NEIGHBOUR, NOT_NAMED, "swapped-names", "mirrored")
"""Codes of the issues that say that the observations contradict each other."""


class VerdictKind(StrEnum):
    """What is shown."""

    PASS = "PASS"  #: The seams are within the tolerance, with 95 % confidence.
    UNSURE = "UNSURE"  #: Neither is shown. More points decide.
    FAIL = "FAIL"
    """The observations contradict each other or their stated error, or a seam is outside, with 95 % confidence."""


Suggest = Callable[[Sequence[float]], tuple[str, ...]]
"""Says which features to touch next: the fewest that leave the share of the error that may be left after this many."""

MOST_FURTHER = 4  #: Most features asked for at once: more would be touched in vain if one of the first was wrong.


class VerdictReason(Enum):
    """Why the verdict is what it is."""

    WITHIN = "within"
    ERROR = "error"  #: The predicted error is larger than the tolerance.
    UNCHECKED = "unchecked"  #: A wrong touch would leave no residual.
    LARGE_RESIDUALS = "large-residuals"
    """No teaching error is stated, and the residuals are larger than the usual one explains."""
    CHECK = "check"  #: A check point is off by more than the tolerance, which its own error may explain.
    CONTRADICTION = "contradiction"  #: Some observations contradict the others.
    STATED_ERROR = "stated-error"  #: The residuals contradict the stated teaching error.
    CHECK_CONTRADICTS = "check-contradicts"  #: A check point is off by more than all errors explain.
    RIVAL = "rival"  #: The touches do not exclude another place of the part.
    SILENT_SEARCH = "silent-search"  #: A search found nothing where the fit has a face.
    SCALE = "scale"  #: The part is larger or smaller than its model.
    BEYOND = "beyond"  #: A seam is off by more than the tolerance, with 95 % confidence.


DOUBTS = {TWO_BODIES: VerdictReason.UNCHECKED, RIVAL: VerdictReason.RIVAL, SILENT: VerdictReason.SILENT_SEARCH}
"""Issues with these codes leave open whether the fit has the part in the right place."""


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
    next_points: tuple[str, ...] = ()  #: The features to touch next, the fewest that help enough, where they are known.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "kind": self.kind.value,
            "sentence": self.sentence,
            "seam": self.seam or None,
            "reason": self.reason.value,
            "error_95_mm": self.error_95_mm,
            "next_point": next(iter(self.next_points), None),
            "next_points": list(self.next_points),
        }


@dataclass(frozen=True, slots=True)
class Ground:
    """Why a verdict is not `PASS`, and what to do; without a remedy a further observation is asked for."""

    reason: VerdictReason
    sentence: str
    remedy: str = ""

    @classmethod
    def told(cls, reason: VerdictReason, message: str) -> Ground:
        """Take a message apart that says what is wrong, a colon, and what to do."""
        what, _, remedy = message.partition(": ")
        return cls(reason, what, remedy)


@dataclass(frozen=True, slots=True)
class Predicted:
    """The predicted error of the points that count, with the allowance for a bias of the tool."""

    seam: str  #: The seam with the largest error of its own; empty without seams.
    own_mm: float  #: That error: what tables and pages say of this seam.
    error_mm: float  #: No point of all seams is off by more, with 95 % probability.
    least_mm: float  #: Some point is off by as much, with 95 % probability.
    told: str  #: What the prediction rests on.


@dataclass(frozen=True, slots=True, eq=False)
class CheckPoints:
    """Observations that were not fitted."""

    names: Sequence[str]
    off_mm: FloatArray  #: shape (n,). How far each is from its place in the fit.
    limit_mm: FloatArray  #: shape (n,). What the errors of the fit and of the observation explain.

    @classmethod
    def of(cls, pairs: PointPairs, moved: FloatArray, limit_mm: FloatArray) -> CheckPoints:
        """Compare points with their places in the fit, `moved`, shape (n, 3), in `base`, mm."""
        return cls(pairs.names, np.linalg.norm(pairs.p_target - moved, axis=1), limit_mm)


def check_level(count: int) -> float:
    """Level of the test of each of several check points: together 1 % false alarms."""
    return 1.0 - FALSE_ALARM / count


def judge_evidence(evidence: Evidence, *, suggest: Suggest | None = None) -> Verdict:
    """Decide whether the seams are shown to be within the tolerance.

    The tests of the residuals against a stated teaching error and of the check points each raise a false alarm in one
    fit of a hundred. With a true teaching error, a `PASS` with a seam outside and a `FAIL` for its error with all seams
    inside each happen in at most 5 of 100 calibrations.
    """
    shown, check = evidence.predicted(), evidence.checked()
    for found in _failures(evidence, shown, check):
        sentence = f"{found.sentence}: {found.remedy}" if found.remedy else found.sentence
        return Verdict(VerdictKind.FAIL, sentence, shown.seam, found.reason, shown.error_mm)
    for found in _doubts(evidence, shown, check):
        names = suggest(_shares(evidence, shown, found.reason)) if suggest is not None and not found.remedy else ()
        advice = found.remedy or (f"touch {listed(names)} as well" if names else f"one more {evidence.word} would help")
        sentence = f"{found.sentence}: {advice}"
        return Verdict(VerdictKind.UNSURE, sentence, shown.seam, found.reason, shown.error_mm, names)
    return Verdict(VerdictKind.PASS, evidence.passed(shown), shown.seam, VerdictReason.WITHIN, shown.error_mm)


def _shares(evidence: Evidence, shown: Predicted, reason: VerdictReason) -> list[float]:
    """Return which share of the error that the places of the observations leave may be left, with 1, 2, … more of them.

    An estimated teaching error is known better with each observation, and the error that has 95 % falls with it.
    """
    if reason is not VerdictReason.ERROR:
        return [1.0]
    freedom = np.array([evidence.sigma.degrees_of_freedom + 3.0 * k for k in range(MOST_FURTHER + 1)])
    times = length_quantile(np.tile(np.eye(3), (len(freedom), 1, 1)), COVERAGE, degrees_of_freedom=freedom)
    return [evidence.tolerance_mm / shown.error_mm * float(times[0] / each) for each in times[1:]]


def _failures(evidence: Evidence, shown: Predicted, check: CheckPoints | None) -> Iterator[Ground]:
    """Say why the fit is shown to be wrong; the first finding counts."""
    yield from evidence.contradictions(shown)
    if shown.least_mm > evidence.tolerance_mm:
        yield from (Ground.told(VerdictReason.SCALE, each.message) for each in evidence.issues if each.code == SCALE)
        where = f"seam {shown.seam} is" if shown.seam else f"a fitted {evidence.word} is"
        what = f"{where} off by {short(shown.least_mm)} mm or more with 95 % confidence ({shown.told})"
        yield Ground(VerdictReason.BEYOND, f"{what}; the tolerance is {evidence.tolerance_mm:g} mm")
    if check is not None:
        worst = int(np.argmax(check.off_mm / np.maximum(check.limit_mm, np.finfo(float).tiny)))
        off, limit = float(check.off_mm[worst]), float(check.limit_mm[worst])
        if off > max(limit, evidence.tolerance_mm):
            what = (
                f"check {evidence.word} {check.names[worst]} is off by {short(off)} mm; the errors of the fit and of "
                f"the touch explain at most {short(limit)} mm ({evidence.sigma.describe()})"
            )
            yield Ground(VerdictReason.CHECK_CONTRADICTS, what)


def _doubts(evidence: Evidence, shown: Predicted, check: CheckPoints | None) -> Iterator[Ground]:
    """Say why the seams are not shown to be within the tolerance; the first finding counts."""
    for issue in evidence.issues:
        if issue.code in DOUBTS:
            yield Ground.told(DOUBTS[issue.code], issue.message)
        if issue.code == SCALE and shown.error_mm > evidence.tolerance_mm:
            yield Ground.told(VerdictReason.SCALE, issue.message)
    tolerance, all_mm = evidence.tolerance_mm, f"{short(shown.error_mm)} mm"
    if shown.error_mm > tolerance:
        off = f"a fitted {evidence.word} may be off by {all_mm}"
        if shown.seam:
            off = f"seam {shown.seam} may be off by {short(shown.own_mm)} mm, all seams together by {all_mm}"
        what = f"{off} (95 %; {shown.told}), which is more than the tolerance of {tolerance:g} mm"
        yield Ground(VerdictReason.ERROR, what, evidence.remedy)
    yield from evidence.doubts(shown)
    if check is not None and float(check.off_mm.max()) > tolerance:
        worst = int(np.argmax(check.off_mm))
        what = f"check {evidence.word} {check.names[worst]} is off by {short(check.off_mm[worst])} mm"
        yield Ground(VerdictReason.CHECK, f"{what}, which its own error may explain", "touch it again")


@dataclass(frozen=True, slots=True, eq=False)
class VerdictEvidence:
    """Everything that decides on the verdict of a fit of points or touches on a part that is one body."""

    problem: FitProblem
    fit: CriterionFit
    residuals: ResidualEvidence
    check: PointPairs | None
    issues: tuple[Issue, ...]
    distrusted: Distrusted | None
    tolerance_mm: float
    #: shape (k, 3). Points of the accepted seams, or the fitted points if there are none; part frame, mm.
    points_part: FloatArray
    seam_names: tuple[str, ...]  #: length k or 0. The seam of each point.
    remedy: str = ""

    @property
    def word(self) -> str:
        """What one observation is called."""
        return self.problem.word

    @property
    def sigma(self) -> Sigma:
        """The teaching error behind the fit."""
        return self.fit.sigma

    @property
    def largest_mm(self) -> float:
        """Largest residual of a fitted observation."""
        return float(self.problem.distances_mm(self.fit.T)[self.fit.rows].max())

    def predicted(self) -> Predicted:
        """Return the predicted error of the seams."""
        fit = self.fit
        errors = fit.budget.joint_errors(fit.T.apply(self.points_part))
        low, high = np.quantile(errors.drawn_mm, [1.0 - COVERAGE, COVERAGE]).tolist()
        name = self.seam_names[errors.row] if self.seam_names else ""
        return Predicted(name, errors.own_mm, high, low, fit.budget.describe())

    def contradictions(self, shown: Predicted) -> Iterator[Ground]:
        """Name observations that the others contradict, then residuals that the stated error does not explain."""
        for issue in self.issues:
            if issue.code in CONTRADICTIONS and self._matters(issue, shown.error_mm):
                yield Ground(VerdictReason.CONTRADICTION, issue.message)
        if shown.error_mm * self.residuals.birge_ratio > self.tolerance_mm:
            yield from self._unexplained()

    def _unexplained(self) -> Iterator[Ground]:
        """Say that the residuals are larger than the stated errors explain."""
        explained = any(issue.code == TOOL_OFFSET for issue in self.issues)  # the predicted error has an allowance
        if not self.residuals.contradicts_stated or explained:
            return
        yield from (Ground.told(VerdictReason.SCALE, each.message) for each in self.issues if each.code == SCALE)
        than = f"larger than the stated teaching error of {short(self.sigma.mm)} mm per axis explains"
        rows = self.fit.budget.belief.rows
        if self.problem.has_covariances and rows is not None:
            times = float(np.sqrt(np.mean(rows.y**2)))
            than = f"{times:.2g} times as large as the stated errors of the {plural(self.word)} explain"
        what = f"the residuals (RMS {short(self.residuals.rms_mm)} mm) are {than}: "
        wrong = f"a {self.word} is wrong, the part differs from its model, or the stated error is too small"
        yield Ground.told(VerdictReason.STATED_ERROR, what + wrong)

    def _matters(self, issue: Issue, error_mm: float) -> bool:
        """Whether contradicted observations were fitted, or a wrong tool may carry a seam out of the tolerance."""
        if issue.code == TOOL_OFFSET:
            return error_mm > self.tolerance_mm
        if issue.ids and {self.problem.names[row] for row in self.fit.rows}.isdisjoint(issue.ids):
            return False
        if issue.code in (NEIGHBOUR, NOT_NAMED) and self.distrusted is None:
            return self.largest_mm > self.tolerance_mm
        if issue.code not in (BLUNDER, NEIGHBOUR) or self.distrusted is None:
            return True
        return self.distrusted.shift_mm > self.tolerance_mm

    def doubts(self, shown: Predicted) -> Iterator[Ground]:
        """Name what nothing tests, what the others contradict, and residuals that are larger than stated or usual."""
        yield from self._unexplained()
        is_stated, unchecked = self.sigma.source is SigmaSource.STATED, self.residuals.unchecked
        is_robot_known = self.fit.budget.belief.origin not in (FieldOrigin.ASSUMED, FieldOrigin.ESTIMATED)
        if unchecked and not (is_stated and (is_robot_known or len(unchecked) < len(self.fit.rows))):
            what = f"nothing tests {listed(unchecked, MOST_NAMED)}; if one is wrong, no residual shows it"
            yield Ground(VerdictReason.UNCHECKED, what)
        found = self.distrusted
        if found is not None and found.shift_mm + found.without_them.seam_error_95_mm > self.tolerance_mm:
            those = "it" if len(found.names) == 1 else "them"
            what = (
                f"the others contradict {listed(found.names, MOST_NAMED)}; the seams move by "
                f"{short(found.shift_mm)} mm if the fit leaves {those} out"
            )
            yield Ground(VerdictReason.CONTRADICTION, what, f"touch {those} again")
        for issue in self.issues:
            if issue.code in (NEIGHBOUR, NOT_NAMED) and found is None:
                yield Ground(VerdictReason.CONTRADICTION, issue.message, "no seam is shown to be outside")
        if not is_stated and self.largest_mm > self.tolerance_mm and self.residuals.contradicts(USUAL_SIGMA_MM):
            what = (
                f"the largest residual is {short(self.largest_mm)} mm, and careful touches ({USUAL_SIGMA_MM:g} mm per "
                "axis) do not explain the residuals"
            )
            remedy = "look for a bent part or a wrong model, or state the teaching error if the touches were that rough"
            yield Ground(VerdictReason.LARGE_RESIDUALS, what, remedy)

    def checked(self) -> CheckPoints | None:
        """Return the points that test the fit."""
        if self.check is None:
            return None
        check, budget = self.check, self.fit.budget
        moved = self.fit.T.apply(check.p_source)
        own = self.sigma.mm**2 * np.eye(3) if check.covariances is None else check.covariances
        return CheckPoints.of(check, moved, budget.limits_mm(moved, own, check_level(len(check))))

    def passed(self, shown: Predicted) -> str:
        """Say within what the seams are."""
        seams = len(set(self.seam_names))
        what = f"the {seams} accepted seams are" if shown.seam else f"the fitted {plural(self.word)} are"
        if seams == 1:
            what = f"seam {shown.seam} is"
        unchecked = self.residuals.unchecked
        open_ = (
            f"; nothing tests {listed(unchecked, MOST_NAMED)}: one check {self.word} ends this doubt"
            if unchecked
            else ""
        )
        return (
            f"{what} within {short(shown.error_mm)} mm with 95 % confidence ({shown.told}); the tolerance is "
            f"{self.tolerance_mm:g} mm{open_}"
        )


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
    if not teaching.tool_mm:
        return ()
    off_mm = math.sqrt(float(np.trace(teaching.tool_covariance)))
    message = (
        f"a tool centre point off by {short(off_mm)} mm leaves no residual while the torch keeps its posture; "
        "the predicted errors allow for a weld in another posture. Touch in the posture in which the tool centre "
        "point was calibrated (Yin 2003, section 3)"
    )
    return (Issue("tcp-bias", message),)
