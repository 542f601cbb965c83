"""Touches on points, edges and faces as a problem that every criterion fits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar, Self

import numpy as np

from wpcal.calibrate.errors.heavy_tails import ROUND_OFF, has_heavy_tails, motion_square
from wpcal.calibrate.errors.of_touches import budget_of_touches
from wpcal.calibrate.errors.prediction import TeachingError, postures_of
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.options import FitOptions, Known
from wpcal.calibrate.solve.starts import PoseSearch, search_pose, two_places
from wpcal.calibrate.solve.touches import Pose, fit_minimax, fit_squares, scaled_jacobian
from wpcal.calibrate.solver_report import Solver, SolverReport
from wpcal.calibrate.trust.blame import Diagnosis, Suspect
from wpcal.calibrate.trust.contradiction import HELD, contradiction_issues, find_contradicted, least_without, squares_of
from wpcal.calibrate.trust.criteria import RIVAL, Criterion, CriterionFit, FitProblem
from wpcal.calibrate.trust.held_motions import held_motions
from wpcal.calibrate.trust.residuals import ResidualEvidence, unchecked_names
from wpcal.calibrate.trust.tool_offset import LEAST_ROWS, TOOL_OFFSET, PosedRows, ToolOffset, find_tool_offset
from wpcal.calibrate.trust.touch_evidence import RivalPlace, TouchEvidence
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.issue import Issue
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import short
from wpcal.optim.annealing import AnnealingSchedule

BESIDE_MM = 1.0
"""A contact further than this beyond the border of its face is reported: a teaching error does not explain it."""


LEAST_AGREEING = 8  #: Touches that can contradict each other: six hold the part.


@dataclass(frozen=True, slots=True, eq=False)
class TouchProblem(FitProblem):
    """A `FitProblem` of touches, with the poses from which the fits start."""

    touches: Touches
    #: Of touches that state no covariances. If it states nothing, the residuals of the least-squares fit tell.
    teaching: TeachingError
    seed: int  #: Of the simulated part of the minimax covariance.
    start: Pose  #: The least-squares fit of all touches.
    annealed: Pose | None  #: The annealer's best pose: a second start of the minimax fit.
    contradicted: Suspect | None  #: The touches that the others contradict; `Criterion.ROBUST` leaves them out.
    rivals: tuple[RivalPlace, ...] = ()  #: Other places that the touches do not exclude.
    #: shape (k, 3). Part frame, mm: where the distance to these places is compared with the predicted error.
    seam_points: FloatArray | None = None
    #: shape (3, 3). The axes of the tool in the base, by the names of the touches and check touches that say them.
    postures: Mapping[str, FloatArray] = field(default_factory=dict)
    check: Touches | None = None  #: Touches that are not fitted; they take part in the tests.

    word: ClassVar[str] = "touch"
    compared: ClassVar[tuple[Criterion, ...]] = (Criterion.MINIMAX, Criterion.LEAST_SQUARES, Criterion.WEIGHTED)

    @property
    def observed(self) -> Touches:
        """The touches."""
        return self.touches

    def fit(self, criterion: Criterion) -> CriterionFit:
        """Fit by one criterion and compute the covariance of the fit; nothing is proved, so the bound is zero.

        Raises `InputError` when the weighted criterion finds no covariances.
        """
        if criterion is Criterion.WEIGHTED and not self.has_covariances:
            raise InputError("the weighted criterion needs an error for every touch: a column sigma_mm")
        kept = np.arange(len(self.touches))
        if criterion is Criterion.ROBUST and self.contradicted is not None:
            kept = np.flatnonzero(~np.isin(self.names, self.contradicted.names))
        fitted = self.touches.select(kept)
        pose, objective = self._pose(fitted, criterion)
        postures = postures_of(fitted.names, self.postures)
        budget = budget_of_touches(fitted, pose, criterion, self.teaching, seed=self.seed, postures=postures)
        T = RigidTransform(pose.R, pose.t, "base", "part")
        is_heavy = False
        if criterion is Criterion.MINIMAX:
            squares = fit_squares(fitted, self.start, weighted=self.has_covariances)
            is_heavy = touches_have_heavy_tails(fitted, squares)
            if is_heavy:
                budget = budget.moved_by(motion_square(RigidTransform(squares.R, squares.t, "base", "part"), T))
        return CriterionFit(criterion, T, objective, 0.0, budget, kept, is_heavy)

    def distances_mm(self, T: RigidTransform) -> FloatArray:
        """Distances of the touches from what they lie on, mm, shape (n,)."""
        return self.touches.linearised(T.R, T.t_mm).distances

    def select(self, rows: IntArray) -> Self:
        """Return the problem of some of the touches, indices of shape (m,)."""
        return replace(self, touches=self.touches.select(rows), contradicted=None, check=None)

    def agrees(self, rows: IntArray) -> bool:
        """Whether some touches, indices of shape (m,), hold the part and contradict none of each other."""
        rest = self.touches.select(rows)
        pose, _, J = squares_of(rest, Pose.of(rest, self.start.R, self.start.t), None)
        holds = (
            len(rest) >= LEAST_AGREEING and np.linalg.matrix_rank(J.reshape(-1, 6), tol=HELD * np.linalg.norm(J)) == 6
        )
        return holds and find_contradicted(rest, pose, self._tested_sigma_mm(rest)) is None

    def judge_residuals(self, fit: CriterionFit, check: Touches | None = None) -> ResidualEvidence:
        """Say how the fitted touches agree, and which of them neither the others nor the check touches test."""
        fitted = self.touches.select(fit.rows)
        start = Pose.of(fitted, fit.T.R, fit.T.t_mm)
        at = fit_squares(fitted, start).at
        squares = float(np.sum(at.d**2))
        J, pivot, length = scaled_jacobian(fitted, start)
        more = None
        if check is not None:
            more = check.linearised(fit.T.R, fit.T.t_mm).jacobian(pivot) / np.repeat([length, 1.0], 3)
        unchecked = unchecked_names(fitted.names, J, start.at.A, more)
        return ResidualEvidence(squares, fit.budget.belief.chance, int(at.rank.sum()) - 6, len(fitted), unchecked)

    def diagnose(self, fit: CriterionFit) -> Diagnosis:
        """Name the touches that the others contradict, a wrong tool, and touches beyond the border of their face."""
        fitted, suspect = self.touches.select(fit.rows), self.contradicted
        tool = self._tool_offset()
        if tool is not None:
            suspect = None
        named = contradiction_issues(suspect) if tool is None else (Issue(TOOL_OFFSET, tool.sentence),)
        return Diagnosis((*named, *self._rival_issues(fit), *_border_issues(fitted, fit.T)), suspect, tool)

    def _tool_offset(self) -> ToolOffset | None:
        """Test the tool centre point on the touches whose posture is known, against the touches that look wrong."""
        seen = self.touches if self.check is None else self.touches.joined(self.check)
        posed = seen.select([i for i, name in enumerate(seen.names) if name in self.postures])
        if len(posed) < LEAST_ROWS:
            return None
        sigma_mm = self._tested_sigma_mm(posed)
        pose, information, J = squares_of(posed, self.start, sigma_mm)
        frames = np.array([self.postures[name] for name in posed.names])
        stated = self.teaching.tool_covariance
        if posed.shared is not None:  # an error that is the same in the tool at all touches, as that of the stick-out
            fixed = frames.swapaxes(1, 2) @ posed.shared
            stated = stated + fixed.mean(axis=0) @ fixed.mean(axis=0).T
        is_scaled = self.has_covariances or sigma_mm is not None
        numbers = int(pose.at.rank.sum())
        rows = PosedRows(pose.at.d, J, pose.at.A @ frames, information, numbers, is_scaled, stated)
        wrong = () if self.contradicted is None else self.contradicted.names
        rest = least_without(posed, pose, sigma_mm, wrong)
        return find_tool_offset(rows, rival_squares=rest, rival_count=max(len(wrong), 1))

    def _tested_sigma_mm(self, touches: Touches) -> float | None:
        return self.teaching.tested_sigma_mm(touches.p_base, postures_of(touches.names, self.postures))

    def _rival_issues(self, fit: CriterionFit) -> tuple[Issue, ...]:
        """Say that the part may lie in another place, further off than the predicted error."""
        points = self.touches.linearised(fit.T.R, fit.T.t_mm).contact_part
        _, error_mm = fit.largest_error_95(points if self.seam_points is None else self.seam_points)
        far = [rival for rival in self.rivals if rival.apart_mm > error_mm]
        if not far:
            return ()
        first = max(far, key=lambda rival: rival.apart_mm)
        places = "another place" if len(far) == 1 else f"{len(far)} other places"
        message = (
            f"the touches fit the part in {places} as well, up to {short(first.apart_mm)} mm away (RMS "
            f"{short(first.rms_mm)} mm there, which the teaching error explains): touch one more face, or give the "
            "rough nominal place of the part"
        )
        return (Issue(RIVAL, message),)

    def _pose(self, touches: Touches, criterion: Criterion) -> tuple[Pose, float]:
        """Fit by one criterion; the value is the largest residual or a root mean square, mm."""
        if criterion is Criterion.MINIMAX:
            pose = fit_minimax(touches, fit_squares(touches, self.start))
            annealed = self.annealed
            if annealed is not None and Pose.of(touches, annealed.R, annealed.t).largest_mm < pose.largest_mm:
                pose = fit_minimax(touches, annealed)
            return pose, pose.largest_mm
        if criterion is Criterion.WEIGHTED:
            pose = fit_squares(touches, self.start, weighted=True)
            weights = pose.at.information(touches.covariances)
            squares = np.einsum("ni,nij,nj->", pose.at.d, weights, pose.at.d)
            return pose, math.sqrt(squares / np.trace(weights, axis1=1, axis2=2).sum())
        pose = fit_squares(touches, self.start)
        return pose, math.sqrt(np.mean(pose.at.distances**2))


def touches_have_heavy_tails(touches: Touches, fit: Pose) -> bool:
    """Test the shape of the residuals of the least-squares fit, weighted where the touches state their errors."""
    J, _, length = scaled_jacobian(touches, fit)
    return has_heavy_tails(fit.at.d, J, fit.at.information(touches.covariances), round_off_mm=ROUND_OFF * length)


def search_touches(
    touches: Touches, asked: FitOptions, known: Known
) -> tuple[TouchProblem, SolverReport, TouchEvidence]:
    """Search the pose of the touches, and check that they hold the part in one place.

    Raises `GeometryError` when a motion of the part is not held (the message names it), or two places fit equally well.
    """
    if len(touches) < 3:
        raise GeometryError(f"{len(touches)} touches cannot hold a part; six on three faces do (3-2-1)")
    nominal, teaching, seam_points = known.T_nominal_part, asked.teaching, known.seam_points
    place = None if nominal is None else RigidTransform(nominal.R, nominal.t_mm, "base", "part")
    chosen = (known.schedule or AnnealingSchedule.default()) if asked.solver is Solver.ANNEALING else None
    check = known.check if isinstance(known.check, Touches) else None
    found = search_pose(
        touches, nominal=place, schedule=chosen, seed=asked.seed, sigma_mm=teaching.per_axis_mm, seam_points=seam_points
    )
    motions = held_motions(touches, found.pose)
    if found.rival is not None:
        raise two_places(touches, found.pose, found.rival)
    sigma_mm = teaching.tested_sigma_mm(touches.p_base, postures_of(touches.names, known.postures))
    contradicted = find_contradicted(touches, found.pose, sigma_mm, check=check)
    problem = TouchProblem(
        touches,
        teaching,
        asked.seed,
        found.pose,
        found.annealed,
        contradicted,
        found.evidence.rivals,
        seam_points,
        known.postures,
        check,
    )
    return problem, _report(found, chosen, asked.seed), TouchEvidence(touches.words, found.evidence, motions)


def _report(found: PoseSearch, schedule: AnnealingSchedule | None, seed: int) -> SolverReport:
    polish, starts = "damped Gauss-Newton from many starts, then an active set", found.evidence.starts
    if found.run is None or found.annealed is None or schedule is None:
        return SolverReport(Solver.EXACT, polish, seed, starts=starts)
    return SolverReport.of_run(
        found.run,
        schedule,
        method=f"simulated annealing, {polish}",
        seed=seed,
        starts=starts,
        annealed_objective_mm=found.annealed.largest_mm,
    )


def _border_issues(touches: Touches, T: RigidTransform) -> tuple[Issue, ...]:
    over = touches.targets.overhang(touches.rows, touches.linearised(T.R, T.t_mm).contact_part)
    beyond = np.flatnonzero(over > BESIDE_MM)
    if len(beyond) == 0:
        return ()
    listed = ", ".join(f"{touches.names[i]} by {short(over[i])} mm ({touches.words[i]})" for i in beyond[:6])
    message = f"touches beyond the border of what they should lie on: {listed}; is the right face named?"
    return (Issue("beside-face", message, tuple(touches.names[i] for i in beyond)),)
