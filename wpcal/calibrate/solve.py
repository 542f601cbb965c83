"""`calibrate`: point pairs in, the part's place with its proof and its error out."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike

from wpcal import __version__
from wpcal.calibrate.criteria import CriteriaComparison, Criterion, CriterionFit, compare_criteria, fit_criterion
from wpcal.calibrate.distrust import Distrusted, compare_without
from wpcal.calibrate.points.annealed import SearchProblem, about_centroid, about_origin
from wpcal.calibrate.points.diagnose import find_issues, require_plausible_units
from wpcal.calibrate.points.least_squares import distances, require_spread
from wpcal.calibrate.points.minimax import MinimaxSolution, core_subset, solve_minimax
from wpcal.calibrate.result import CalibrationResult, Solver, SolverReport
from wpcal.calibrate.uncertainty import TeachingError
from wpcal.calibrate.verdict import bias_advice, verdict_issues
from wpcal.core.arrays import FloatArray, as_points
from wpcal.core.errors import FrameError, InputError
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs
from wpcal.core.transform import RigidTransform
from wpcal.optim.annealing import AnnealingReport, AnnealingSchedule, anneal

COMPARED = 20_000
"""Largest set whose criteria are compared and whose blunders are looked for: some tenths of a second."""


def calibrate(
    pairs: PointPairs,
    *,
    criterion: Criterion = Criterion.MINIMAX,
    solver: Solver = Solver.ANNEALING,
    schedule: AnnealingSchedule | None = None,
    seed: int = 0,
    tolerance_mm: float = 0.5,
    T_nominal_part: RigidTransform | None = None,
    teaching: TeachingError | None = None,
    check: PointPairs | None = None,
    certify: bool = False,
    seam_points: ArrayLike | None = None,
) -> CalibrationResult:
    """Find where the real part stands.

    Parameters
    ----------
    pairs : PointPairs
        Points of the model (frame ``part``) and as taught on the real part (frame ``base``), mm.
    criterion : Criterion
        What is made small; the paper's is the largest distance.
    solver : Solver
        Where the minimax search starts. The other criteria need no search.
    schedule : AnnealingSchedule, optional
        `AnnealingSchedule.yin2003` for the published one: it then moves the six-tuple itself from the nominal place.
    seed : int
        Of every random number.
    tolerance_mm : float
        A point further off than this makes the verdict ``FAIL``.
    T_nominal_part : RigidTransform, optional
        Where the cell's model has the part; the identity where not given.
    teaching : TeachingError, optional
        The residuals tell where not given.
    check : PointPairs, optional
        Points touched to judge the fit, left out of it.
    certify : bool
        Close a gap between answer and bound by branch and bound over all rotations, which may take minutes.
    seam_points : array_like, shape (k, 3), optional
        Part frame, mm: where the criteria are compared. The points of the model where not given.

    Returns
    -------
    CalibrationResult

    Raises
    ------
    GeometryError
        When there are fewer than three pairs, or they are collinear or coincident.
    UnitError
        When the two sides are in different units.
    FrameError
        When pairs or the nominal place are in other frames than ``part``, ``base`` and ``nominal``.
    InputError
        When the tolerance is not a positive length, or the weighted criterion finds no covariances.

    Notes
    -----
    ``T_base_part = T_base_nominal @ T_nominal_part``; the paper's six-tuple is that of ``T_base_nominal``.

    References
    ----------
    Yin, Chen, Lu (2003), eq. (1) to (9).
    """
    nominal = RigidTransform.identity(target="nominal", source="part") if T_nominal_part is None else T_nominal_part
    _require_usable(pairs, nominal, tolerance_mm)
    model = teaching or TeachingError()
    minimax, annealed, report = None, None, SolverReport(Solver.EXACT, "closed form and local refinement", seed)
    if criterion is Criterion.MINIMAX:
        minimax, annealed, report = _search(pairs, nominal, solver, schedule, seed, certify=certify)
    fit = fit_criterion(pairs, criterion, teaching=model, seed=seed, minimax=minimax)
    points = pairs.p_source if seam_points is None else as_points(seam_points, name="seam points")
    criteria, issues, distrusted = _assess(pairs, fit, model, points, seed)
    T_base_nominal = fit.T @ nominal.inverse()
    return CalibrationResult(
        pairs=pairs,
        check=check,
        T_base_part=fit.T,
        T_nominal_part=nominal,
        T_base_nominal=T_base_nominal,
        criterion=criterion,
        objective_mm=fit.objective_mm,
        annealed_objective_mm=annealed,
        lower_bound_mm=fit.lower_bound_mm,
        covariance=fit.covariance,
        degrees_of_freedom=fit.degrees_of_freedom,
        teaching=model,
        solver=report,
        criteria=criteria,
        warnings=(*issues, *verdict_issues(pairs, check, fit.T, tolerance_mm), *bias_advice(model)),
        tolerance_mm=tolerance_mm,
        versions={"wpcal": __version__, "numpy": np.__version__, "scipy": scipy.__version__},
        distrusted=distrusted,
    )


def _require_usable(pairs: PointPairs, nominal: RigidTransform, tolerance_mm: float) -> None:
    if (pairs.source, pairs.target) != ("part", "base"):
        raise FrameError(f"expected pairs of part and base, got {pairs.source} and {pairs.target}")
    if (nominal.target, nominal.source) != ("nominal", "part"):
        raise FrameError(f"expected T_nominal_part, got T_{nominal.target}_{nominal.source}")
    if not (np.isfinite(tolerance_mm) and tolerance_mm > 0):
        raise InputError(f"the tolerance is a positive length, got {tolerance_mm} mm")
    require_spread(pairs)
    require_plausible_units(pairs)


def _search(
    pairs: PointPairs,
    nominal: RigidTransform,
    solver: Solver,
    schedule: AnnealingSchedule | None,
    seed: int,
    *,
    certify: bool,
) -> tuple[MinimaxSolution, float | None, SolverReport]:
    """Anneal where asked for, and polish to the certified optimum."""
    if solver is Solver.EXACT:
        found = solve_minimax(pairs, certify=certify)
        return found, None, SolverReport(solver, "interior point", seed, starts=found.starts)
    T, run, problem_schedule = anneal_pairs(pairs, nominal=nominal, schedule=schedule, seed=seed)
    found = solve_minimax(pairs, start=T, certify=certify)
    raw = float(distances(pairs.p_source, pairs.p_target, T.R, T.t_mm).max())
    report = SolverReport(
        solver,
        "simulated annealing, then interior point",
        seed,
        evaluations=run.evaluations,
        temperatures=run.temperatures,
        starts=found.starts,
        schedule=problem_schedule,
        trace=run.trace,
    )
    return found, raw, report


def anneal_pairs(
    pairs: PointPairs,
    *,
    nominal: RigidTransform | None = None,
    schedule: AnnealingSchedule | None = None,
    seed: int = 0,
) -> tuple[RigidTransform, AnnealingReport, str]:
    """Search the least largest distance by annealing alone.

    Parameters
    ----------
    pairs : PointPairs
        mm. Of more than 64 pairs the annealer sees the 64 that matter most.
    nominal : RigidTransform, optional
        ``T_nominal_part``; used by the published schedule, which starts from there.
    schedule : AnnealingSchedule, optional
    seed : int

    Returns
    -------
    T : RigidTransform
        ``T_target_source``, not polished.
    report : AnnealingReport
    name : str
        ``default``, ``yin2003`` or ``custom``.
    """
    chosen = schedule or AnnealingSchedule()
    names = {AnnealingSchedule(): "default", AnnealingSchedule.yin2003(): "yin2003"}
    name = names.get(chosen, "custom")
    rows = core_subset(pairs.p_source, pairs.p_target)
    p, q = pairs.p_source[rows], pairs.p_target[rows]
    if name == "yin2003":
        place = nominal or RigidTransform.identity(target="nominal", source=pairs.source)
        problem = about_origin(place.apply(p), q)
        run = _run(problem, chosen, seed)
        R, t = problem.motion(run.state)
        return RigidTransform(R, t, pairs.target, place.target) @ place, run, name
    problem = about_centroid(p, q)
    run = _run(problem, chosen, seed)
    return RigidTransform(*problem.motion(run.state), pairs.target, pairs.source), run, name


def _run(problem: SearchProblem, schedule: AnnealingSchedule, seed: int) -> AnnealingReport:
    return anneal(
        problem.cost,
        problem.lower,
        problem.upper,
        rng=np.random.default_rng(seed),
        schedule=schedule,
        start=problem.start,
        periodic=problem.periodic,
    )


def _assess(
    pairs: PointPairs, fit: CriterionFit, teaching: TeachingError, points: FloatArray, seed: int
) -> tuple[CriteriaComparison | None, tuple[Issue, ...], Distrusted | None]:
    if len(pairs) > COMPARED:
        message = f"{len(pairs)} pairs: blunders are not looked for and the criteria not compared above {COMPARED}"
        return None, (Issue("not-compared", message),), None
    issues = find_issues(pairs, sigma_mm=teaching.per_axis_mm, seed=seed)
    comparison = compare_criteria(pairs, teaching=teaching, seam_points=points, issues=issues, known=(fit,), seed=seed)
    wrong = [issue.ids for issue in issues if issue.code == "blunder"]
    if not wrong:
        return comparison, issues, None
    distrusted = compare_without(
        pairs, wrong[0], fit.criterion, teaching=teaching, seam_points=points, known=(fit,), seed=seed
    )
    return comparison, issues, distrusted
