"""Simulated calibrations and their verdicts: how often a verdict is wrong about the seams."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.observe.points import PointProblem
from wpcal.calibrate.trust.criteria import BLUNDER, Criterion
from wpcal.calibrate.trust.verdict import VerdictEvidence, VerdictKind, judge_evidence
from wpcal.calibrate.trust.without import compare_without
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.pairs import PointPairs


@dataclass(frozen=True, slots=True)
class VerdictStudy:
    """Verdicts of simulated calibrations of one part."""

    trials: int
    verdicts: Counter[VerdictKind]
    passed_outside: int  #: `PASS` although a point of a seam is off by more than the tolerance.
    failed_inside: int  #: `FAIL` although every point of the seams is within the tolerance.
    covered: float  #: Share of the seam points whose error stays below their predicted 95 % error.

    def __add__(self, other: VerdictStudy) -> VerdictStudy:
        """Put two studies together."""
        trials = self.trials + other.trials
        covered = (self.covered * self.trials + other.covered * other.trials) / trials
        wrong = (self.passed_outside + other.passed_outside, self.failed_inside + other.failed_inside)
        return VerdictStudy(trials, self.verdicts + other.verdicts, *wrong, covered)


def run_verdict_study(
    sets: Sequence[FloatArray],
    seam_points: FloatArray,
    *,
    errors: Sequence[FloatArray],
    seam_errors: Sequence[FloatArray] | None = None,
    postures: Sequence[FloatArray] | None = None,
    teaching: TeachingError,
    criterion: Criterion = Criterion.LEAST_SQUARES,
    tolerance_mm: float = 0.5,
) -> VerdictStudy:
    """Calibrate simulated points and compare every verdict with the true errors of the seams.

    Raises `InputError` when there are not as many sets as errors.

    `sets`: shape (n, 3). Reference points of each trial, mm.
    `seam_points`: shape (k, 3). Same frame, mm.
    `errors`: shape (n, 3). Errors of the taught points of each trial, mm.
    `seam_errors`: shape (k, 3). What the robot shows beside the real seam points of each trial, mm; by default nothing.
    `postures`: shape (n, 3, 3). The axes of the tool at the points of each trial, if they are known.
    """
    if len(sets) != len(errors) or not sets:
        raise InputError(f"expected errors for every set of points, got {len(sets)} sets and {len(errors)} errors")
    verdicts: Counter[VerdictKind] = Counter()
    passed_outside = failed_inside = 0
    covered = 0.0
    aside = seam_errors or [np.zeros(seam_points.shape)] * len(sets)
    turned = postures or [np.zeros((0, 3, 3))] * len(sets)
    for p, error, robot, frames in zip(sets, errors, aside, turned, strict=True):
        names = tuple(f"P{i}" for i in range(len(p)))
        problem = PointProblem(
            PointPairs(names, p, p + error), teaching, postures=dict(zip(names, frames, strict=False))
        )
        fit = problem.fit(criterion)
        issues = problem.diagnose(fit).issues
        wrong = next((issue.ids for issue in issues if issue.code == BLUNDER), ())
        distrusted = compare_without(problem, wrong, fit, seam_points=seam_points) if wrong else None
        verdict = judge_evidence(
            VerdictEvidence(
                problem=problem,
                fit=fit,
                residuals=problem.judge_residuals(fit),
                check=None,
                issues=issues,
                distrusted=distrusted,
                tolerance_mm=tolerance_mm,
                points_part=seam_points,
                seam_names=("W",) * len(seam_points),
            )
        ).kind
        off = np.linalg.norm(fit.T.apply(seam_points) - seam_points - robot, axis=1)
        is_outside = bool(off.max() > tolerance_mm)
        verdicts[verdict] += 1
        passed_outside += verdict is VerdictKind.PASS and is_outside
        failed_inside += verdict is VerdictKind.FAIL and not is_outside
        covered += float(np.mean(off <= fit.error_95_mm(seam_points)))
    return VerdictStudy(len(sets), verdicts, passed_outside, failed_inside, covered / len(sets))
