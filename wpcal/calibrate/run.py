"""`calibrate`: taught points or touches in; the pose of the part, its proof or evidence and its error out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import scipy
from numpy.typing import ArrayLike

from wpcal.calibrate.errors.prediction import SigmaSource, TeachingError
from wpcal.calibrate.observe.points import PointProblem, search_points
from wpcal.calibrate.observe.touch_problem import search_touches
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.options import TOLERANCE_MM, FitOptions, Known
from wpcal.calibrate.result import CalibrationResult
from wpcal.calibrate.solve.least_squares import require_spread
from wpcal.calibrate.solver_report import Solver, SolverReport
from wpcal.calibrate.trust.blame import Diagnosis
from wpcal.calibrate.trust.criteria import (
    BLUNDER,
    CriteriaComparison,
    Criterion,
    CriterionFit,
    FitProblem,
    advise_criterion,
    compare_criteria,
)
from wpcal.calibrate.trust.diagnose import require_plausible_units
from wpcal.calibrate.trust.neighbours import FeaturePlaces
from wpcal.calibrate.trust.scale import ScaleFit, fit_scale
from wpcal.calibrate.trust.silent import SilentSearches, silent_issues
from wpcal.calibrate.trust.touch_evidence import TouchEvidence
from wpcal.calibrate.trust.verdict import Suggest, VerdictEvidence, bias_advice, judge_evidence, verdict_issues
from wpcal.calibrate.trust.which_body import explain_by_body
from wpcal.calibrate.trust.without import Distrusted, compare_without
from wpcal.core.arrays import FloatArray, as_points
from wpcal.core.errors import FrameError, GeometryError, InputError
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs
from wpcal.core.transform import RigidTransform
from wpcal.core.version import __version__
from wpcal.core.wording import plural, short
from wpcal.optim.annealing import AnnealingSchedule

COMPARED = 20_000
"""Above this number the criteria are not compared and blunders are not searched for: at this number both take some
tenths of a second."""


def calibrate(
    observed: PointPairs | Touches,
    *,
    criterion: Criterion | None = None,
    solver: Solver = Solver.ANNEALING,
    schedule: AnnealingSchedule | None = None,
    seed: int = 0,
    tolerance_mm: float = TOLERANCE_MM,
    T_nominal_part: RigidTransform | None = None,
    teaching: TeachingError | None = None,
    check: PointPairs | Touches | None = None,
    certify: bool = False,
    seam_points: ArrayLike | None = None,
    seam_names: Sequence[str] = (),
    suggest: Suggest | None = None,
    features: Mapping[str, FloatArray] | None = None,
    postures: Mapping[str, FloatArray] | None = None,
    silent: SilentSearches | None = None,
    body_of: Mapping[str, str] | None = None,
) -> CalibrationResult:
    """Find the pose of the real part.

    `observed`: Points of the model (frame ``part``) with the same points as taught (frame ``base``), mm; or touches on
    points, edges and faces of the part. The residual of a touch is its distance from what it lies on. In the result
    each touch is the pair of where it was made and where it should have been.
    `criterion`: What is minimised; the paper's is the largest distance. ``ROBUST`` leaves out what the others
    contradict. By default the criterion that predicts the least error of the seams; of touches that state their errors,
    that is ``WEIGHTED``.
    `solver`: Where the search starts: for points that of the minimax fit (the other criteria need no search), for
    touches that of every fit.
    `schedule`: `AnnealingSchedule.yin2003` for the published one. Points are then searched by the six-tuple itself,
    from the nominal place.
    `T_nominal_part`: Where the cell's model has the part. By default the identity; touches then must hold the part in
    one place.
    `certify`: Close a gap between answer and bound by branch and bound over all rotations, which may take minutes. No
    such proof exists for touches, and this option does not change their fit.
    `seam_points`: shape (k, 3), optional. Part frame, mm: where the verdict judges the predicted error and the criteria
    are compared. By default the fitted points of the model.
    `seam_names`: length k. The seam of each point.
    `features`: shape (3,), optional. Places of the part that can be touched as points, by name, in `part`, mm. A
    suspicious point is tried on them: it may have been touched on the neighbour of its feature.
    `postures`: shape (3, 3), optional. The axes of the tool (or of the flange) in the base at each touch, as columns,
    by the names of the observations. If they differ, they show whether the tool centre point of the controller is at
    the tip.
    `silent`: Searches of a touch program that found nothing. They are not fitted; the verdict is not ``PASS`` if one of
    them should have met the part.
    `body_of`: The body of the part that each observation lies on, by its name. Several wrong ones on one body are then
    first explained by that body: it may have been tacked elsewhere, or be of another revision.

    Returns: For touches the lower bound is zero, because nothing is proved; its `touches` says what the starts found.

    Raises `GeometryError` when there are fewer than three pairs, or they are collinear or coincident; when touches
    leave a motion of the part free (the message names it) or fit two places equally well.
    Raises `UnitError` when the two sides are in different units.
    Raises `FrameError` when pairs or the nominal place are in other frames than ``part``, ``base`` and ``nominal``.
    Raises `InputError` when the tolerance is not a positive length, or the weighted criterion finds no covariances.
    """
    nominal = RigidTransform.identity(target="nominal", source="part") if T_nominal_part is None else T_nominal_part
    _require_usable(observed, nominal, tolerance_mm)
    model = teaching or TeachingError()
    given = None if seam_points is None else as_points(seam_points, name="seam points")
    asked = FitOptions(criterion=criterion, solver=solver, seed=seed, teaching=model, certify=certify)
    known = Known(check, T_nominal_part, nominal, schedule, given, features or {}, postures or {})
    problem, report, evidence = _problem(observed, asked, known)
    fit_by = cache(problem.fit)
    fit = fit_by(criterion or (Criterion.WEIGHTED if problem.has_covariances else Criterion.LEAST_SQUARES))
    points = _paired(observed, fit.T).p_source if given is None else given
    criteria, found, distrusted = _assess(problem, fit_by, fit, points, body_of or {})
    fit = fit if criterion or criteria is None else fit_by(criteria.least)
    pairs, checked = _paired(observed, fit.T), None if check is None else _paired(check, fit.T)
    scale, found = _scale(problem, fit, found)
    if scale is not None and scale.is_found and model.scale_error is None:
        fit = replace(fit, budget=replace(fit.budget, scale=math.hypot(scale.scale, 0.5 * scale.error_95)))
    found = found if silent is None else replace(found, issues=(*found.issues, *silent_issues(silent, fit)))
    if found.tool is not None:  # the bias that the touches show counts as a stated one does
        model = replace(model, tcp_bias_mm=max(model.tcp_bias_mm, found.tool.bound_mm))
        fit = replace(fit, budget=replace(fit.budget, tool=model.tool_covariance))
    judged = VerdictEvidence(
        problem=problem,
        fit=fit,
        residuals=problem.judge_residuals(fit, check),
        check=checked,
        issues=found.issues,
        distrusted=distrusted,
        tolerance_mm=tolerance_mm,
        points_part=points,
        seam_names=tuple(seam_names),
        remedy=_remedy(fit_by(criteria.least), fit, points, tolerance_mm, problem.word) if criteria else "",
    )
    return CalibrationResult(
        pairs=pairs,
        check=checked,
        T_base_part=fit.T,
        T_nominal_part=nominal,
        T_base_nominal=fit.T @ nominal.inverse(),
        criterion=fit.criterion,
        objective_mm=fit.objective_mm,
        lower_bound_mm=fit.lower_bound_mm,
        covariance=fit.covariance,
        sigma=fit.sigma,
        budget=fit.budget,
        teaching=model,
        judgement=judge_evidence(judged, suggest=suggest),
        solver=report,
        criteria=criteria,
        issues=(*found.issues, *verdict_issues(pairs, checked, fit.T, tolerance_mm), *bias_advice(problem.teaching)),
        tolerance_mm=tolerance_mm,
        seams=_by_seam(points, seam_names),
        versions={"wpcal": __version__, "numpy": np.__version__, "scipy": scipy.__version__},
        distrusted=distrusted,
        suspect=found.suspect,
        tool=found.tool,
        scale=scale,
        touches=evidence,
        criterion_advice=advise_criterion(fit, criteria, problem.word),
        postures=postures or {},
    )


def _scale(problem: FitProblem, fit: CriterionFit, found: Diagnosis) -> tuple[ScaleFit | None, Diagnosis]:
    """Fit the scale of the part; where it explains what looked like wrong observations, it takes their place."""
    budget, rows = fit.budget, fit.budget.belief.rows
    known = None if budget.sigma.source is SigmaSource.ESTIMATED else math.sqrt(budget.belief.s2)
    scale = None if rows is None else fit_scale(rows, len(fit.rows), known, problem.teaching.robot)
    if scale is None or not scale.is_found or found.tool is not None:
        return scale, found
    if found.suspect is not None:
        if not isinstance(problem, PointProblem):
            return scale, found
        larger = problem.scaled(scale.scale)
        again = larger.diagnose(larger.fit(fit.criterion))
        if again.suspect is not None:
            return scale, found
        found = again
    return scale, replace(found, issues=(scale.issue, *found.issues))


def _remedy(other: CriterionFit, fit: CriterionFit, points: FloatArray, tolerance_mm: float, word: str) -> str:
    """Say that another criterion has the seams within the tolerance, or nothing."""
    is_same = other.criterion is fit.criterion
    if is_same or (error := other.budget.joint_errors(other.T.apply(points)).error_95_mm) > tolerance_mm:
        return ""
    return f"--criterion {other.criterion.value} predicts {short(error)} mm from the same {plural(word)}"


def _by_seam(points: FloatArray, names: Sequence[str]) -> tuple[tuple[str, FloatArray], ...]:
    """Return the points of each seam, or of the fitted points without a name."""
    if not names:
        return (("", points),)
    rows: dict[str, list[int]] = {}
    for row, name in enumerate(names):
        rows.setdefault(name, []).append(row)
    return tuple((name, points[each]) for name, each in rows.items())


def _problem(
    observed: PointPairs | Touches, asked: FitOptions, known: Known
) -> tuple[FitProblem, SolverReport, TouchEvidence | None]:
    """Search the pose where a search is needed, and return the problem that every criterion fits."""
    if isinstance(observed, Touches):
        return search_touches(observed, asked, known)
    minimax, report = None, SolverReport(Solver.EXACT, "closed form and local refinement", asked.seed)
    if asked.criterion is Criterion.MINIMAX:
        minimax, report = search_points(observed, asked, known)
    points_checked = known.check if isinstance(known.check, PointPairs) else None
    places = FeaturePlaces.of(known.features) if known.features else None
    found = (observed, asked.teaching, asked.seed, minimax, points_checked, places, known.postures, known.nominal)
    return PointProblem(*found), report, None


def _require_usable(observed: PointPairs | Touches, nominal: RigidTransform, tolerance_mm: float) -> None:
    if (nominal.target, nominal.source) != ("nominal", "part"):
        raise FrameError(f"expected T_nominal_part, got T_{nominal.target}_{nominal.source}")
    if not (np.isfinite(tolerance_mm) and tolerance_mm > 0):
        raise InputError(f"the tolerance is a positive length, got {tolerance_mm} mm")
    if isinstance(observed, Touches):
        return
    if (observed.source, observed.target) != ("part", "base"):
        raise FrameError(f"expected pairs of part and base, got {observed.source} and {observed.target}")
    require_spread(observed)
    require_plausible_units(observed)


def _paired(observed: PointPairs | Touches, T_base_part: RigidTransform) -> PointPairs:
    return observed.paired(T_base_part) if isinstance(observed, Touches) else observed


def _assess(
    problem: FitProblem,
    fit_by: Callable[[Criterion], CriterionFit],
    fit: CriterionFit,
    seam_points: FloatArray,
    body_of: Mapping[str, str],
) -> tuple[CriteriaComparison | None, Diagnosis, Distrusted | None]:
    """Compare the criteria, find what is wrong with the observations, and fit without those that are named."""
    n = len(problem.names)
    if n > COMPARED:
        message = f"{n} pairs: blunders are not looked for and the criteria not compared above {COMPARED}"
        return None, Diagnosis((Issue("not-compared", message),)), None
    found = explain_by_body(problem, problem.diagnose(fit), body_of, fit.budget.belief.rows)
    comparison = compare_criteria(problem, fit_by, seam_points=seam_points, issues=found.issues)
    wrong = [name for issue in found.issues if issue.code == BLUNDER for name in issue.ids if name in problem.names]
    if not wrong:
        return comparison, found, None
    try:
        without = compare_without(problem, wrong, fit, seam_points=seam_points)
    except GeometryError:  # too few are left: two of four
        without = None
    return comparison, found, without
