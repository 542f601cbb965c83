"""Point pairs as a problem that every criterion fits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import ClassVar, Self

import numpy as np

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.heavy_tails import ROUND_OFF, has_heavy_tails, motion_square
from wpcal.calibrate.errors.linear_fit import LinearFit
from wpcal.calibrate.errors.prediction import TeachingError, postures_of
from wpcal.calibrate.errors.robot_field import ResidualRows
from wpcal.calibrate.options import FitOptions, Known
from wpcal.calibrate.solve.annealed import anneal_pairs
from wpcal.calibrate.solve.error_rows import ErrorRows
from wpcal.calibrate.solve.least_squares import (
    distances,
    fit_least_squares,
    kabsch,
    other_least_squares,
    require_spread,
)
from wpcal.calibrate.solve.minimax import CERTIFIED_MM, MinimaxSolution, solve_minimax
from wpcal.calibrate.solve.weighted import fit_weighted, weighted_lower_bound, weighted_root_mean_square
from wpcal.calibrate.solver_report import Solver, SolverReport
from wpcal.calibrate.trust.blame import Diagnosis
from wpcal.calibrate.trust.criteria import RIVAL, Criterion, CriterionFit, FitProblem
from wpcal.calibrate.trust.diagnose import diagnose_pairs, join_pairs, tested_error
from wpcal.calibrate.trust.neighbours import FeaturePlaces
from wpcal.calibrate.trust.residuals import FLOOR_MM, ResidualEvidence, unchecked_names
from wpcal.calibrate.trust.robust import contradicted_points
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.tangent import point_jacobian
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import short
from wpcal.optim.annealing import AnnealingSchedule

LEAST_AGREEING = 4  #: Points that can contradict each other: three that agree tell little.


@dataclass(frozen=True, slots=True, eq=False)
class PointProblem(FitProblem):
    """A `FitProblem` of point pairs."""

    pairs: PointPairs  #: mm.
    #: Of points that state no covariances. If it states nothing, the residuals of the least-squares fit tell.
    teaching: TeachingError
    seed: int = 0  #: Of the simulated part of the minimax covariance and of the triples of the robust fit.
    minimax: MinimaxSolution | None = None  #: If it is known already.
    #: Points that are not fitted; a wrong point is searched for among all of them together.
    check: PointPairs | None = None
    places: FeaturePlaces | None = None  #: Of the part: a suspicious point is tried on them.
    #: shape (3, 3). The axes of the tool in the base, by the names of the points and check points that say them.
    postures: Mapping[str, FloatArray] = field(default_factory=dict)
    #: ``T_nominal_part``: of equally good fits the one turned least from it is taken.
    nominal: RigidTransform | None = None

    word: ClassVar[str] = "point"
    compared: ClassVar[tuple[Criterion, ...]] = tuple(Criterion)

    @property
    def observed(self) -> PointPairs:
        """The points."""
        return self.pairs

    def fit(self, criterion: Criterion) -> CriterionFit:
        """Fit by one criterion and compute the covariance of the fit.

        Raises `GeometryError` when the points do not fix a rotation.
        Raises `InputError` when the weighted criterion finds no covariances.
        """
        if criterion is Criterion.ROBUST and len(rows := self._agreeing()) < len(self.pairs):
            return self._squares(rows)
        if criterion in (Criterion.ROBUST, Criterion.LEAST_SQUARES):
            return replace(_least_squares(self), criterion=criterion)
        pairs, rows = self.pairs, np.arange(len(self.pairs))
        equal: tuple[RigidTransform, ...] = ()
        if criterion is Criterion.MINIMAX:
            found = self.minimax or solve_minimax(pairs, nominal=self.nominal)
            T, objective, bound, equal = found.T, found.objective_mm, found.lower_bound_mm, found.equal
        else:
            T = fit_weighted(pairs)
            objective, bound = weighted_root_mean_square(pairs, T), weighted_lower_bound(pairs)
        budget = self._budget(criterion, T, rows)
        is_heavy = False
        if criterion is Criterion.MINIMAX:
            squares = fit_least_squares(pairs) if pairs.covariances is None else fit_weighted(pairs)
            is_heavy = points_have_heavy_tails(pairs, squares)
            if is_heavy:
                budget = budget.moved_by(motion_square(squares, T))
        return CriterionFit(criterion, T, objective, bound, budget, rows, is_heavy, equal)

    def _squares(self, rows: IntArray) -> CriterionFit:
        """Fit some of the points, indices of shape (m,), by least squares."""
        fitted = self.pairs.select(rows) if len(rows) < len(self.pairs) else self.pairs
        T = fit_least_squares(fitted, nominal=self.nominal)
        other = other_least_squares(fitted, T)
        objective = float(np.sqrt(np.mean(np.sum((fitted.p_target - T.apply(fitted.p_source)) ** 2, axis=1))))
        budget, equal = self._budget(Criterion.ROBUST, T, rows), () if other is None else (other,)
        return CriterionFit(Criterion.ROBUST, T, objective, objective, budget, rows, equal=equal)

    def distances_mm(self, T: RigidTransform) -> FloatArray:
        """Distances of the taught points from the moved model points, mm, shape (n,)."""
        return Residuals.of(self.pairs, T).norms_mm

    def select(self, rows: IntArray) -> Self:
        """Return the problem of some of the points, indices of shape (m,)."""
        return replace(self, pairs=self.pairs.select(rows), minimax=None, check=None)

    def scaled(self, scale: float) -> Self:
        """Return the problem of a part that is larger by a share `scale`."""
        p = self.pairs.p_source
        return replace(self, pairs=replace(self.pairs, p_source=p + scale * (p - p.mean(axis=0))), minimax=None)

    def judge_residuals(self, fit: CriterionFit, check: PointPairs | None = None) -> ResidualEvidence:
        """Say how the fitted points agree, and which of them neither the others nor the check points test."""
        fitted = self.pairs if len(fit.rows) == len(self.pairs) else self.pairs.select(fit.rows)
        p, q = fitted.p_source, fitted.p_target
        R, t = kabsch(p, q, np.full(len(p), 1.0 / len(p)))
        squares = float(np.sum((q - p @ R.T - t) ** 2))
        size = float(np.abs(p - p.mean(axis=0)).max())
        more = None if check is None else point_jacobian((check.p_source - p.mean(axis=0)) / size)
        seen = np.broadcast_to(np.eye(3), (len(p), 3, 3))
        unchecked = unchecked_names(fitted.names, point_jacobian((p - p.mean(axis=0)) / size), seen, more)
        return ResidualEvidence(squares, fit.budget.belief.chance, 3 * len(p) - 6, len(p), unchecked)

    def diagnose(self, fit: CriterionFit) -> Diagnosis:
        """Name swapped, mirrored and mis-taught points, wrong features, a wrong tool, and what cannot be told."""
        found = diagnose_pairs(
            self.pairs,
            check=self.check,
            places=self.places,
            postures=self.postures,
            teaching=self.teaching,
            seed=self.seed,
        )
        issues = [*found.issues, *_equal_places(self.pairs, fit)]
        if fit.criterion is Criterion.MINIMAX and fit.objective_mm - fit.lower_bound_mm > CERTIFIED_MM:
            issues.append(_not_proved(fit))
        return replace(found, issues=tuple(issues))

    def agrees(self, rows: IntArray) -> bool:
        """Whether some points, indices of shape (m,), fix the part and contradict none of each other."""
        rest = self.pairs.select(rows)
        if len(rest) < LEAST_AGREEING or not ErrorRows.of(rest, None).fixes_rotation():
            return False
        return contradicted_points(rest, sigma_mm=self._tested_sigma_mm, seed=self.seed).at_least == 0

    @property
    def _tested_sigma_mm(self) -> float | None:
        return tested_error(self.pairs, self.teaching, self.postures)

    def _agreeing(self) -> IntArray:
        """Rows that neither the other fitted points nor the check points contradict."""
        require_spread(self.pairs)
        seen = self.pairs if self.check is None else join_pairs(self.pairs, self.check)
        wrong = contradicted_points(seen, sigma_mm=self._tested_sigma_mm, seed=self.seed).named
        rows = np.setdiff1d(np.arange(len(self.pairs)), wrong)
        enough = len(rows) >= 3 and ErrorRows.of(self.pairs.select(rows), None).fixes_rotation()
        return rows if enough else np.arange(len(self.pairs))

    def _budget(self, criterion: Criterion, T: RigidTransform, rows: IntArray) -> ErrorBudget:
        """Collect what the errors of the fitted points do to the pose, and what is believed of these errors."""
        if len(rows) < len(self.pairs):
            return self.select(rows)._budget(criterion, T, np.arange(len(rows)))
        pairs, stated = self.pairs, self.pairs.covariances
        weights = None if stated is None or criterion is not Criterion.WEIGHTED else np.asarray(np.linalg.inv(stated))
        belief, sigma = self.teaching.believed(_residual_rows(self), stated)
        fit = LinearFit.of_points(T.apply(pairs.p_source), weights, stated)
        fit = replace(fit, postures=postures_of(pairs.names, self.postures))
        return fit.budget(belief, sigma, self.teaching, is_minimax=criterion is Criterion.MINIMAX, seed=self.seed)


@lru_cache(maxsize=4)
def _least_squares(problem: PointProblem) -> CriterionFit:
    """Fit all points; a robust fit that leaves out none is the same."""
    return problem._squares(np.arange(len(problem.pairs)))


@lru_cache(maxsize=8)
def _residual_rows(problem: PointProblem) -> ResidualRows:
    """Residuals of least squares, whatever the criterion: what they tell of the errors is the same."""
    pairs = problem.pairs
    p, n = pairs.p_source, len(pairs)
    R, t = kabsch(p, pairs.p_target, np.full(n, 1.0 / n))
    moved = p @ R.T + t
    about = moved - moved.mean(axis=0)
    stated = pairs.covariances
    weights = np.tile(np.eye(3), (n, 1, 1)) if stated is None else np.asarray(np.linalg.inv(stated))
    shared = problem.teaching.shared(postures_of(pairs.names, problem.postures))
    return ResidualRows.of(about, point_jacobian(about), pairs.p_target - moved, weights, shared)


def points_have_heavy_tails(pairs: PointPairs, fit: RigidTransform) -> bool:
    """Test the shape of the residuals of the least-squares fit, weighted where the points state their errors."""
    p, n = pairs.p_source - pairs.p_source.mean(axis=0), len(pairs)
    size = float(np.abs(p).max())
    information = np.tile(np.eye(3), (n, 1, 1)) if pairs.covariances is None else np.linalg.inv(pairs.covariances)
    moved = point_jacobian(p @ fit.R.T / size)
    return has_heavy_tails(
        pairs.p_target - fit.apply(pairs.p_source), moved, np.asarray(information), round_off_mm=ROUND_OFF * size
    )


def _equal_places(pairs: PointPairs, fit: CriterionFit) -> tuple[Issue, ...]:
    """Say that the points fit the part in other places exactly as well."""
    if not fit.equal:
        return ()
    p = pairs.p_source
    apart = [float(np.linalg.norm(T.apply(p) - fit.T.apply(p), axis=1).max()) for T in fit.equal]
    if max(apart) <= FLOOR_MM:
        return ()
    message = (
        f"another placement fits the points exactly as well, up to {short(max(apart))} mm away; the one turned least "
        "from the nominal place was taken: check the names of the points, or touch a point that is not symmetric to "
        "others"
    )
    return (Issue(RIVAL, message),)


def _not_proved(fit: CriterionFit) -> Issue:
    message = (
        f"this fit may not be the best one: its largest residual is {fit.objective_mm:.4g} mm, and it is proved only "
        f"that no fit is below {fit.lower_bound_mm:.4g} mm. Check the names of the points; --certify searches on"
    )
    return Issue("not-proved", message)


def search_points(pairs: PointPairs, asked: FitOptions, known: Known) -> tuple[MinimaxSolution, SolverReport]:
    """Search the least largest distance and polish it to the certified optimum. `pairs`: mm."""
    nominal, certify, seed = known.nominal, asked.certify, asked.seed
    if asked.solver is Solver.EXACT:
        found = solve_minimax(pairs, certify=certify, nominal=nominal)
        return found, SolverReport(asked.solver, "interior point", seed, starts=found.starts)
    chosen = known.schedule or AnnealingSchedule.default()
    T, run = anneal_pairs(pairs, nominal=nominal, schedule=chosen, seed=seed)
    found = solve_minimax(pairs, start=T, certify=certify, nominal=nominal)
    report = SolverReport.of_run(
        run,
        chosen,
        method="simulated annealing, then interior point",
        seed=seed,
        starts=found.starts,
        annealed_objective_mm=float(distances(pairs.p_source, pairs.p_target, T.R, T.t_mm).max()),
    )
    return found, report
