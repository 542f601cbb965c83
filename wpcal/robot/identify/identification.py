"""Identify an arm from measured poses, and judge the result on held-out poses."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from scipy.special import ndtri

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.issue import Issue
from wpcal.core.options import opt
from wpcal.robot.identify.error_summary import (
    PoseErrorSummary,
    Verdict,
    distances_mm,
    judge,
    require_plausible,
    summarise,
    turns_deg,
)
from wpcal.robot.identify.genetic_tabu import EXPECTED_MM, EXPECTED_RAD, GeneticTabuFit, solve_genetic_tabu
from wpcal.robot.identify.identifiability import Noise, split_determined
from wpcal.robot.identify.least_squares import LeastSquaresFit, absorbed_errors, assess, solve_least_squares
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.outliers import (
    OutlierPose,
    find_outliers,
    fold_rows,
    huber_weights,
    split_poses,
    unexpected_poses,
    without_rows,
)
from wpcal.robot.identify.parameters import Group, KinematicModel, Parameter, last_link_first, surrounding_parameters
from wpcal.robot.identify.pose_residuals import Prior, pose_errors
from wpcal.robot.identify.registration import register
from wpcal.robot.identify.whole_range import WholeRange, predict_whole_range
from wpcal.robot.kinematics.arm import Arm

REACH_FACTOR = 1.05
"""A measured position may be farther away than the sum of the arm's lengths by this factor: real lengths differ."""
TOOL_LENGTH_MM = 300.0  #: A welding torch from the flange to the wire's tip: the lever of an angle of the last link.
NOMINAL_NOISE = Noise(sigma_mm=1.0, sigma_rad=float(np.deg2rad(0.25)))
"""Rough error of a nominal arm in one coordinate: weights for fitting its base and tool, so that the errors before
identification are not overstated."""


class IdentificationSolver(Enum):
    """How the parameters are found."""

    LEAST_SQUARES = "least-squares"
    GENETIC_TABU = "ga-tabu"


@dataclass(frozen=True, slots=True)
class IdentifyOptions:
    """What is known and how to proceed."""

    solver: IdentificationSolver = opt(
        IdentificationSolver.LEAST_SQUARES,
        "How the parameters are found: least squares, or the published genetic and tabu search, to compare.",
        "--method",
    )
    free_base: bool = opt(
        False, "The frame of the measurement is not the robot's base: identify it, too.", "--unknown-base"
    )
    free_tool: bool = opt(
        False, "The measured point is at an unknown place on the flange: identify it, too.", "--unknown-tool"
    )
    parameters: tuple[str, ...] | None = opt(
        None,
        "Link parameters to identify, as theta1,d1,…; all by default.",
        metavar="NAMES",
        read=lambda names: tuple(name.strip() for name in names.split(",")),
    )
    folds: int | None = opt(None, "Number of folds to judge by, instead of one set of test poses.", least=2)
    leave_out: tuple[int, ...] = opt(
        (),
        "Lines of the file that are not used, as 57,58: outliers that you agree to drop.",
        metavar="ROWS",
        read="wpcal.robot.identify.poses_file:parse_rows",
    )
    noise: Noise | None = None
    expected_mm: float = opt(EXPECTED_MM, "Expected error of a length; ga-tabu searches three times as far.", above=0)
    expected_rad: float = opt(EXPECTED_RAD, "Expected error of an angle; ga-tabu searches three times as far.", above=0)
    seed: int = opt(0, "Seed of all random numbers.", least=0)


@dataclass(frozen=True, slots=True, eq=False)
class Identification:
    """An identified arm and the proof."""

    arm: Arm  #: The identified arm, with the base and flange frames of the nominal one.
    #: Rank, covariance and noise. After `GENETIC_TABU` it belongs to the point that the search found.
    fit: LeastSquaresFit
    search: GeneticTabuFit | None
    nominal: KinematicModel  #: Nominal links with the base and tool that suit them best.
    #: `train`, `test`: Rows that were fitted, and rows that were judged.
    train: IntArray
    test: IntArray
    observations: PoseObservations  #: The measurements that were used.
    #: `errors_before`, `errors_after`: shape (len(test), 3 or 6). Errors of the test poses: turn (rad, where measured),
    #: then distance (mm).
    errors_before: FloatArray
    errors_after: FloatArray
    #: shape (m,). Of the 95 % interval of each parameter of the fit, mm and rad, with what it absorbs of unseen ones.
    #: None after `GENETIC_TABU`: that search stops short of the minimum which such an interval is about.
    half_widths: FloatArray | None
    verdict: Verdict
    whole_range: WholeRange  #: Predicted errors of both arms over all poses.
    options: IdentifyOptions
    outliers: tuple[OutlierPose, ...] = ()  #: Poses that the others contradict.
    issues: tuple[Issue, ...] = field(default=())

    @property
    def before(self) -> PoseErrorSummary:
        """Errors of the nominal arm on the test poses."""
        return summarise(self.errors_before)

    @property
    def after(self) -> PoseErrorSummary:
        """Errors of the identified arm on the test poses."""
        return summarise(self.errors_after)


def identify_arm(
    arm: Arm, observations: PoseObservations, *, options: IdentifyOptions | None = None, test: BoolArray | None = None
) -> Identification:
    """Identify the parameters of an arm and judge them on held-out poses.

    `test`: shape (N,), optional. Rows to keep back; two sevenths of the poses drawn with the seed unless given, or
    unless `folds` is set.

    Raises `GeometryError` when there are too few poses for the parameters that they determine.
    Raises `InputError` when a position is out of the arm's reach, orientations are given in another convention, or
    options exclude each other.
    Raises `UnitError` when positions or angles are in another unit.
    """
    o = options or IdentifyOptions()
    nominal = arm.as_nominal()
    if o.leave_out:
        observations, test = without_rows(observations, test, o.leave_out)
    task = _Task(nominal, nominal.model_angles(observations.joints), observations, o)
    task.check_reach()
    require_plausible(nominal.chain, task.theta, observations, free_base=o.free_base, free_tool=o.free_tool)
    if o.folds is None:
        train, kept_back = split_poses(observations, test, o.seed)
        final = task.identify(train)
        rounds = [(final, kept_back)]
    else:
        if test is not None:
            raise InputError("give either a column `set` or a number of folds, not both")
        train = np.arange(len(observations))
        folds = list(fold_rows(observations, o.folds, o.seed))
        rounds = [(task.identify(np.setdiff1d(train, rows)), rows) for rows in folds]
        final = task.identify(train)
    before = np.concatenate([task.errors(found.nominal, rows) for found, rows in rounds])
    after = np.concatenate([task.errors(found.fit.model, rows) for found, rows in rounds])
    outliers = task.outliers(final, train, np.concatenate([rows for _, rows in rounds]) if o.folds is None else None)
    whole = predict_whole_range(nominal, final.nominal, final.fit)
    doubts = ("the fit had not settled", not final.fit.converged), (whole.reason, not whole.is_better)
    steps = zip(final.fit.parameters, final.fit.steps, strict=True)
    changes = {each.name: (float(step), each.is_length) for each, step in steps if each.group is Group.LINK}
    return Identification(
        arm=nominal.as_identified(
            nominal.chain.with_table(final.fit.model.chain.table), unseen_tool_mm=_unseen_tool_mm(final.fit, o)
        ),
        fit=final.fit,
        search=final.search,
        nominal=final.nominal,
        train=train,
        test=np.concatenate([rows for _, rows in rounds]),
        observations=observations,
        errors_before=before,
        errors_after=after,
        half_widths=task.half_widths(final, train),
        verdict=judge(before, after, changes=changes, doubts=[why for why, is_so in doubts if is_so]),
        whole_range=whole,
        options=o,
        outliers=outliers,
        issues=_issues(final.fit, outliers, o),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Fitted:
    """One fit, the search that led to it if any, and the nominal links in their fitted base and tool."""

    fit: LeastSquaresFit
    search: GeneticTabuFit | None
    nominal: KinematicModel
    weights: FloatArray
    named: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    without: KinematicModel | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Task:
    """One identification problem; its methods take the rows to use."""

    arm: Arm
    theta: FloatArray
    observations: PoseObservations
    options: IdentifyOptions

    def check_reach(self) -> None:
        """Refuse positions that no pose of the arm can have."""
        chain = self.arm.chain
        reach = REACH_FACTOR * float(np.abs(chain.a).sum() + np.abs(chain.d).sum())
        if self.options.free_tool:
            return  # a long tool may reach anywhere
        p = self.observations.p_base
        if self.options.free_base:
            middle, what = p.mean(axis=0), "the middle of the measured positions"
            reach *= 2.0
        else:
            middle, what = chain.T_base_dh0.t_mm, "the base"
        distance = np.linalg.norm(p - middle, axis=1)
        if distance.max() > reach:
            row = int(np.argmax(distance))
            raise InputError(
                f"the position in row {self.observations.rows[row]} is {distance[row]:.0f} mm from {what}, out of "
                f"reach of {self.arm.name} ({reach:.0f} mm): check the unit, and whether base and tool are known"
            )

    def identify(self, rows: IntArray) -> _Fitted:
        """Fit the given rows."""
        o, theta, seen = self.options, self.theta[rows], self.observations.select(rows)
        nominal = register(self.arm.chain, theta, seen, free_base=o.free_base, free_tool=o.free_tool)
        surroundings = surrounding_parameters(
            free_base=o.free_base, free_tool=o.free_tool, reflectors=None if seen.has_orientations else seen.reflectors
        )
        links = last_link_first(self.arm.chain, o.parameters)
        if surroundings:
            nominal = solve_least_squares(nominal, surroundings, theta, seen, noise=NOMINAL_NOISE).model
        if o.solver is IdentificationSolver.LEAST_SQUARES:
            return self._fit(nominal, (*surroundings, *links), theta, seen)
        if surroundings:
            raise InputError("the ga-tabu solver needs a known base and tool; use least-squares to identify those too")
        return self._search(nominal, links, theta, seen)

    def _fit(
        self, nominal: KinematicModel, parameters: tuple[Parameter, ...], theta: FloatArray, seen: PoseObservations
    ) -> _Fitted:
        """Least squares; poses that the others contradict get little weight."""

        def fit(observations: PoseObservations) -> LeastSquaresFit:
            o = self.options
            expected = (o.expected_mm, o.expected_rad)
            return solve_least_squares(nominal, parameters, theta, observations, noise=o.noise, expected=expected)

        named, without = find_outliers(fit, seen)
        if not named.size:
            return _Fitted(without, None, nominal, seen.weights)
        sigmas = [without.noise.sigma_mm]
        if seen.has_orientations:
            sigmas.insert(0, without.noise.sigma_rad)
        errors = pose_errors(without.model, theta, seen) / np.repeat(sigmas, 3)
        weights = huber_weights(np.sqrt(np.mean(errors**2, axis=1)), seen.poses, named)
        return _Fitted(fit(seen.weighted(weights)), None, nominal, weights, named, without.model)

    def half_widths(self, found: _Fitted, rows: IntArray) -> FloatArray | None:
        """95 % half widths of the parameters; None after a search that does not end at the minimum."""
        if found.search is not None:
            return None
        o, fit = self.options, found.fit
        seen = self.observations.select(rows).weighted(found.weights)
        expected = {"expected_mm": o.expected_mm, "expected_rad": o.expected_rad}
        return fit.half_widths(absorbed=absorbed_errors(fit, self.theta[rows], seen, **expected))

    def outliers(self, found: _Fitted, train: IntArray, test: IntArray | None) -> tuple[OutlierPose, ...]:
        """Name the poses that the fit of the others contradicts, among the fitted ones and those kept back."""
        model = found.without or found.fit.model
        seen = self.observations.select(train)
        named = [_outlier(self.errors(model, train[seen.poses == pose]), seen, pose) for pose in found.named.tolist()]
        if test is None or found.search is not None:
            return tuple(named)
        kept_back = self.observations.select(test)
        for pose in unexpected_poses(found.fit, self.theta[test], kept_back):
            errors = self.errors(model, test[kept_back.poses == pose])
            named.append(_outlier(errors, kept_back, pose, held_back=True))
        return tuple(named)

    def _search(
        self, nominal: KinematicModel, links: tuple[Parameter, ...], theta: FloatArray, seen: PoseObservations
    ) -> _Fitted:
        """Genetic algorithm and tabu search, assessed by least squares at their result."""
        o = self.options
        kept, unseen = split_determined(nominal, links, theta, seen)
        prior, rng = Prior.of(nominal, kept, None), np.random.default_rng(o.seed)
        search = solve_genetic_tabu(prior, theta, seen, rng=rng, expected_mm=o.expected_mm, expected_rad=o.expected_rad)
        fit = assess(prior, search.model, theta, seen, unseen=unseen, noise=o.noise)
        return _Fitted(fit, search, nominal, seen.weights)

    def errors(self, model: KinematicModel, rows: IntArray) -> FloatArray:
        """Errors of the given rows."""
        return pose_errors(model, self.theta[rows], self.observations.select(rows))


def _outlier(errors: FloatArray, observations: PoseObservations, pose: int, *, held_back: bool = False) -> OutlierPose:
    lines = tuple(observations.rows[i] for i in np.flatnonzero(observations.poses == pose))
    turns = turns_deg(errors)
    return OutlierPose(
        lines, float(distances_mm(errors).max()), None if turns is None else float(turns.max()), held_back
    )


def _unseen_of_last_link(fit: LeastSquaresFit, options: IdentifyOptions) -> list[Parameter]:
    """Return the parameters of the last link that an unknown tool hides."""
    last = len(fit.model.chain) - 1
    unseen = [unseen.parameter for unseen in fit.unseen if options.free_tool]
    return [parameter for parameter in unseen if parameter.group is Group.LINK and parameter.index == last]


def _unseen_tool_mm(fit: LeastSquaresFit, options: IdentifyOptions) -> float:
    """95 % error of a tool centre point taught in the controller, from the expected errors of the last link."""
    sigmas = [
        options.expected_mm if parameter.is_length else options.expected_rad * TOOL_LENGTH_MM
        for parameter in _unseen_of_last_link(fit, options)
    ]
    return float(ndtri(0.975) * np.sqrt(np.sum(np.square(sigmas))))


def _issues(fit: LeastSquaresFit, outliers: tuple[OutlierPose, ...], options: IdentifyOptions) -> tuple[Issue, ...]:
    worst_first = sorted(outliers, key=lambda outlier: -outlier.distance_mm)
    issues = [Issue("outlier-pose", str(outlier), tuple(map(str, outlier.rows))) for outlier in worst_first]
    tool = tuple(parameter.name for parameter in _unseen_of_last_link(fit, options))
    if tool:
        issues.append(
            Issue(
                "tool-unknown",
                f"{', '.join(tool)} stay nominal: with an unknown tool no measurement shows them. Their error becomes "
                "an error of the tool centre point in this arm; find the tool centre point in the identified arm "
                "(`wpcal tcp`) before you correct points",
                tool,
            )
        )
    issues += [
        Issue("unseen-parameter", f"{unseen}; it keeps its nominal value", (unseen.name, *unseen.like))
        for unseen in fit.unseen
    ]
    issues += [
        Issue("strong-correlation", f"{first} and {second} go together (correlation {value:+.3f})", (first, second))
        for first, second, value in fit.strong_correlations(Group.LINK)
    ]
    if not fit.converged:
        issues.append(Issue("not-converged", f"the fit had not settled after {fit.iterations} steps"))
    return tuple(issues)
