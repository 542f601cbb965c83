"""`calibrate_touches`: touches on points, edges and faces in, the part's place with its evidence and its error out."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import ArrayLike

from wpcal import __version__
from wpcal.calibrate.criteria import CriteriaComparison, Criterion
from wpcal.calibrate.distrust import Distrusted, FitSummary
from wpcal.calibrate.result import CalibrationResult, Solver, SolverReport
from wpcal.calibrate.touches.contradiction import Doubt, doubt_issues, find_distrusted
from wpcal.calibrate.touches.covariance import predict_spread
from wpcal.calibrate.touches.fit import Pose, fit_least_squares, fit_minimax
from wpcal.calibrate.touches.held_motions import NamedAxis, held_freedoms
from wpcal.calibrate.touches.starts import Found, search_pose, two_places
from wpcal.calibrate.touches.touches import Touches
from wpcal.calibrate.uncertainty import POSTURE_FACTOR, TeachingError, error_95
from wpcal.calibrate.verdict import bias_advice, verdict_issues
from wpcal.core.arrays import FloatArray, as_points, frozen
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.optim.annealing import AnnealingSchedule

BESIDE_MM = 1.0
"""A contact further beyond the border of its face than this is told: a teaching error does not explain it."""


def calibrate_touches(
    touches: Touches,
    *,
    criterion: Criterion = Criterion.MINIMAX,
    solver: Solver = Solver.ANNEALING,
    schedule: AnnealingSchedule | None = None,
    seed: int = 0,
    tolerance_mm: float = 0.5,
    T_nominal_part: RigidTransform | None = None,
    teaching: TeachingError | None = None,
    check: Touches | None = None,
    axes: Sequence[NamedAxis] = (),
    seam_points: ArrayLike | None = None,
) -> CalibrationResult:
    """Find where the real part stands from touches on its points, edges and faces.

    The residual of a touch is its distance from what it lies on; in the result every touch is the pair of where it was
    made and where, at the answer, it should have been.

    Parameters
    ----------
    touches : Touches
    criterion : Criterion
        What is made small; ``WEIGHTED`` needs covariances, ``ROBUST`` leaves the distrusted touch out.
    solver : Solver
        ``ANNEALING`` searches all poses; ``EXACT`` only starts from the rotations of a cube.
    schedule : AnnealingSchedule, optional
    seed : int
        Of every random number.
    tolerance_mm : float
        A touch further off than this makes the verdict ``FAIL``.
    T_nominal_part : RigidTransform, optional
        Where the cell's model has the part.
    teaching : TeachingError, optional
        The residuals tell where not given.
    check : Touches, optional
        Touches made to judge the fit, left out of it.
    axes : sequence of NamedAxis, optional
        By which motions are spoken of.
    seam_points : array_like, shape (k, 3), optional
        Part frame, mm: where the criteria are compared.

    Returns
    -------
    CalibrationResult
        With a lower bound of zero: nothing is proved for touches that may slide; `evidence` says what the starts found.

    Raises
    ------
    GeometryError
        When a motion of the part is not held, which is named, or two places fit equally well.
    InputError
        When the touches are exactly as many as the freedoms and no teaching error is stated, or the weighted criterion
        finds no covariances.
    """
    model = teaching or TeachingError()
    _require_usable(touches, criterion, tolerance_mm)
    nominal = T_nominal_part
    used = None if nominal is None else RigidTransform(nominal.R, nominal.t_mm, "base", "part")
    chosen = (schedule or AnnealingSchedule()) if solver is Solver.ANNEALING else None
    found = search_pose(touches, nominal=used, schedule=chosen, seed=seed)
    freedoms = held_freedoms(touches, found.pose, axes)
    if found.rival is not None:
        raise two_places(touches, found.pose, found.rival)
    doubt = find_distrusted(touches, found.pose, model.per_axis_mm)
    kept = np.arange(len(touches))
    if criterion is Criterion.ROBUST and doubt is not None:
        kept = np.delete(kept, doubt.row)
    pose, objective = _fit(touches.select(kept), found, criterion)
    spread = predict_spread(touches.select(kept), pose, criterion, model, seed=seed)
    T = RigidTransform(pose.R, pose.t, "base", "part")
    pairs, check_pairs = _pairs(touches, T), None if check is None else _pairs(check, T)
    points = pairs.p_source if seam_points is None else as_points(seam_points, name="seam points")
    place = nominal or RigidTransform.identity(target="nominal", source="part")
    return CalibrationResult(
        pairs=pairs,
        check=check_pairs,
        T_base_part=T,
        T_nominal_part=place,
        T_base_nominal=T @ place.inverse(),
        criterion=criterion,
        objective_mm=objective,
        annealed_objective_mm=None if found.annealed is None else found.annealed.largest_mm,
        lower_bound_mm=0.0,
        covariance=frozen(spread.covariance),
        degrees_of_freedom=spread.degrees_of_freedom,
        teaching=model,
        solver=_report(found, solver, chosen, seed),
        criteria=_compared(touches, found, model, points, doubt is not None, seed),
        warnings=(
            *doubt_issues(touches, doubt),
            *_border_issues(touches.select(kept), pose),
            *verdict_issues(pairs, check_pairs, T, tolerance_mm),
            *bias_advice(model),
        ),
        tolerance_mm=tolerance_mm,
        versions={"wpcal": __version__, "numpy": np.__version__, "scipy": scipy.__version__},
        evidence=found.evidence,
        freedoms=freedoms,
        lies_on=touches.words,
        distrusted=None if doubt is None else _without(touches, found, doubt, criterion, model, points, seed),
    )


def _require_usable(touches: Touches, criterion: Criterion, tolerance_mm: float) -> None:
    if not (math.isfinite(tolerance_mm) and tolerance_mm > 0):
        raise InputError(f"the tolerance is a positive length, got {tolerance_mm} mm")
    if criterion is Criterion.WEIGHTED and touches.covariances is None:
        raise InputError("the weighted criterion needs an error for every touch: a column sigma_mm")
    if len(touches) < 3:
        raise GeometryError(f"{len(touches)} touches cannot hold a part; six on three faces do (3-2-1)")


def _fit(touches: Touches, found: Found, criterion: Criterion) -> tuple[Pose, float]:
    """Fit by one criterion; the value is the largest residual or a root mean square, mm."""
    start = found.pose
    if criterion is Criterion.MINIMAX:
        pose = fit_minimax(touches, fit_least_squares(touches, start))
        if (
            found.annealed is not None
            and Pose.of(touches, found.annealed.R, found.annealed.t).largest_mm < pose.largest_mm
        ):
            pose = fit_minimax(touches, found.annealed)
        return pose, pose.largest_mm
    if criterion is Criterion.WEIGHTED:
        pose = fit_least_squares(touches, start, weighted=True)
        weights = pose.at.information(touches.covariances)
        squares = np.einsum("ni,nij,nj->", pose.at.d, weights, pose.at.d)
        return pose, math.sqrt(squares / np.trace(weights, axis1=1, axis2=2).sum())
    pose = fit_least_squares(touches, start)
    return pose, math.sqrt(np.mean(pose.at.distances**2))


def _pairs(touches: Touches, T: RigidTransform) -> PointPairs:
    """Pair every touch with the point of the part where it should have been."""
    contact = touches.linearised(T.R, T.t_mm).contact_part
    return PointPairs(touches.names, contact, touches.p_base, touches.covariances, space=touches.space)


def _without(
    touches: Touches,
    found: Found,
    doubt: Doubt,
    criterion: Criterion,
    teaching: TeachingError,
    points: FloatArray,
    seed: int,
) -> Distrusted:
    """Fit with and without the distrusted touch by the same criterion; robust leaves it out itself."""
    used = Criterion.LEAST_SQUARES if criterion is Criterion.ROBUST else criterion
    rest = touches.select(np.delete(np.arange(len(touches)), doubt.row))
    (first, one), (second, other) = (_summary(t, found, used, teaching, points, seed) for t in (touches, rest))
    moved = points @ (second.R - first.R).T + second.t - first.t
    off = touches.select([doubt.row]).linearised(second.R, second.t).distances[0]
    return Distrusted(
        (touches.names[doubt.row],),
        (float(off),),
        used,
        one,
        other,
        float(np.linalg.norm(moved, axis=1).max()),
        float(np.linalg.norm(log_rotation(second.R @ first.R.T))),
    )


def _summary(
    touches: Touches, found: Found, criterion: Criterion, teaching: TeachingError, points: FloatArray, seed: int
) -> tuple[Pose, FitSummary]:
    pose, _ = _fit(touches, found, criterion)
    error = _largest_error_95(touches, pose, criterion, teaching, points, seed)
    return pose, FitSummary(len(touches), pose.largest_mm, float(np.sqrt(np.mean(pose.at.distances**2))), error)


def _largest_error_95(
    touches: Touches, pose: Pose, criterion: Criterion, teaching: TeachingError, points: FloatArray, seed: int
) -> float:
    spread = predict_spread(touches, pose, criterion, teaching, seed=seed)
    u95 = error_95(points @ pose.R.T + pose.t, spread.covariance, degrees_of_freedom=spread.degrees_of_freedom)
    return float(u95.max()) + POSTURE_FACTOR * teaching.tcp_bias_mm


def _report(found: Found, solver: Solver, schedule: AnnealingSchedule | None, seed: int) -> SolverReport:
    run, starts = found.run, found.evidence.starts
    if run is None:
        return SolverReport(solver, "damped Gauss-Newton from many starts, then an active set", seed, starts=starts)
    return SolverReport(
        solver,
        "simulated annealing, damped Gauss-Newton from many starts, then an active set",
        seed,
        evaluations=run.evaluations,
        temperatures=run.temperatures,
        starts=starts,
        schedule="default" if schedule == AnnealingSchedule() else "custom",
        trace=run.trace,
    )


def _compared(
    touches: Touches, found: Found, teaching: TeachingError, points: FloatArray, doubted: bool, seed: int
) -> CriteriaComparison:
    """Fit by the largest residual, by least squares and, with stated errors, weighted; compare what they predict."""
    rows, errors = [], {}
    for criterion in (Criterion.MINIMAX, Criterion.LEAST_SQUARES, Criterion.WEIGHTED):
        if criterion is Criterion.WEIGHTED and touches.covariances is None:
            continue
        pose, objective = _fit(touches, found, criterion)
        errors[criterion] = _largest_error_95(touches, pose, criterion, teaching, points, seed)
        rows.append(
            {
                "criterion": criterion.value,
                "objective_mm": objective,
                "largest_mm": pose.largest_mm,
                "rms_mm": float(np.sqrt(np.mean(pose.at.distances**2))),
                "seam_error_95_mm": errors[criterion],
            }
        )
    if doubted:
        return CriteriaComparison(tuple(rows), Criterion.ROBUST, "a touch was named that the others contradict")
    best = min(errors, key=lambda criterion: errors[criterion])
    return CriteriaComparison(tuple(rows), best, f"it predicts {errors[best]:.3g} mm, the least")


def _border_issues(touches: Touches, pose: Pose) -> tuple[Issue, ...]:
    over = touches.targets.overhang(touches.rows, pose.at.contact_part)
    beyond = np.flatnonzero(over > BESIDE_MM)
    if len(beyond) == 0:
        return ()
    listed = ", ".join(f"{touches.names[i]} by {over[i]:.3g} mm ({touches.words[i]})" for i in beyond[:6])
    message = f"touches beyond the border of what they should lie on: {listed}; is the right face named?"
    return (Issue("beside-face", message, tuple(touches.names[i] for i in beyond)),)
