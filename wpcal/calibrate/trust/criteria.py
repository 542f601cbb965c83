"""The four criteria, what every kind of observation offers for them, and one comparison of what they predict."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from enum import Enum
from itertools import permutations
from typing import Any, ClassVar, Self

import numpy as np

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.prediction import Sigma, TeachingError
from wpcal.calibrate.solve.least_squares import distances
from wpcal.calibrate.trust.blame import Diagnosis
from wpcal.calibrate.trust.residuals import ResidualEvidence
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import plural, short

BLUNDER = "blunder"  #: Code of the issue that names observations which the others contradict.
NEIGHBOUR = "neighbour-feature"
"""Code of the issue that a row was touched on another feature; its ids are the row's name and that feature."""
RIVAL = "rival-placement"  #: Code of the issue that the touches do not exclude another place of the part.
SILENT = "silent-search"  #: Code of the issue that a search found nothing where the fit has a face.
TWO_BODIES = "touch-on-two-bodies"
"""Code of the issue that touches lie where corners or edges of two bodies coincide in the model."""
NOT_NAMED = "blunder-not-named"  #: Code of the issue that points are wrong and the data cannot tell which.


class Criterion(Enum):
    """What a fit minimises."""

    MINIMAX = "minimax"  #: The largest distance: Yin 2003, eq. (4).
    LEAST_SQUARES = "least_squares"  #: The sum of squared distances.
    WEIGHTED = "weighted"  #: The sum of squares weighted with a covariance per observation.
    ROBUST = "robust"  #: The sum of squares over the observations that agree.


@dataclass(frozen=True, slots=True, eq=False)
class CriterionFit:
    """The fit by one criterion, and the error it predicts."""

    criterion: Criterion
    T: RigidTransform  #: ``T_base_part``.
    objective_mm: float  #: What the criterion minimises: the largest distance, or a root mean square.
    lower_bound_mm: float  #: No rigid transform has a smaller objective.
    budget: ErrorBudget  #: What the predicted errors rest on.
    rows: IntArray  #: shape (m,). Indices of the observations that were fitted.
    #: Whether the residuals have heavier tails than the criterion's covariance assumes, so that it was widened.
    has_heavy_tails: bool = False
    #: Other fits that are exactly as good, or the furthest of them if they are a whole family.
    equal: tuple[RigidTransform, ...] = ()

    @property
    def covariance(self) -> FloatArray:
        """Of ξ about the base's origin, in the order of `wpcal.core.tangent`, shape (6, 6)."""
        return self.budget.covariance

    @property
    def sigma(self) -> Sigma:
        """The teaching error behind the covariance."""
        return self.budget.sigma

    def error_95_mm(self, points_part: FloatArray) -> FloatArray:
        """Predict the 95 % error of points of the part, shape (k,), mm; part frame, mm."""
        return self.budget.error_95_mm(self.T.apply(points_part))

    def largest_error_95(self, points_part: FloatArray) -> tuple[int, float]:
        """Return the row of the point with the largest `error_95_mm`, and that error, mm; shape (k, 3), part frame."""
        return self.budget.largest_error_95(self.T.apply(points_part))


class FitProblem(ABC):
    """Observations of one kind (points or touches) with all that is needed to fit them by any criterion."""

    __slots__ = ()
    word: ClassVar[str]  #: What one observation is called in messages.
    compared: ClassVar[tuple[Criterion, ...]]  #: Criteria that are compared on these observations.
    teaching: TeachingError  #: What is known of the error of an observation that states none.

    @property
    @abstractmethod
    def observed(self) -> Any:
        """The observations: `PointPairs` or `Touches`."""

    @abstractmethod
    def fit(self, criterion: Criterion) -> CriterionFit:
        """Fit by one criterion, and compute the covariance of the fit.

        Raises `InputError` when the weighted criterion finds no covariances.
        """

    @abstractmethod
    def distances_mm(self, T: RigidTransform) -> FloatArray:
        """Residual lengths at a pose ``T_base_part``, mm, shape (n,)."""

    @abstractmethod
    def select(self, rows: IntArray) -> Self:
        """Return the problem of some of the observations, indices of shape (m,)."""

    @abstractmethod
    def judge_residuals(self, fit: CriterionFit, check: Any = None) -> ResidualEvidence:
        """Say how the fitted observations agree, and which of them neither others nor the check ones test."""

    @abstractmethod
    def diagnose(self, fit: CriterionFit) -> Diagnosis:
        """Say what is wrong with the observations. Wrong ones are the ids of an issue with the code `BLUNDER`."""

    @abstractmethod
    def agrees(self, rows: IntArray) -> bool:
        """Whether some of the observations, indices of shape (m,), hold the part and contradict none of each other."""

    def off_mm(self, names: Sequence[str]) -> tuple[float, ...]:
        """Return how far observations are from the least-squares fit of all others, mm."""
        rest = np.flatnonzero(~np.isin(self.names, names))
        distance = self.distances_mm(self.select(rest).fit(Criterion.LEAST_SQUARES).T)
        return tuple(float(distance[self.names.index(name)]) for name in names)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the observations."""
        return tuple(self.observed.names)

    @property
    def has_covariances(self) -> bool:
        """Whether every observation states its own error."""
        return self.observed.covariances is not None


@dataclass(frozen=True, slots=True)
class FitSummary:
    """How well one fit agrees with its observations, and the error it predicts."""

    points: int  #: Observations.
    #: `largest_mm`, `rms_mm`: Their residuals.
    largest_mm: float
    rms_mm: float
    seam_error_95_mm: float  #: Largest predicted 95 % error along the seams.

    @classmethod
    def of(cls, problem: FitProblem, fit: CriterionFit, seam_points: FloatArray) -> FitSummary:
        """Summarise the fit of a problem. `seam_points`: shape (k, 3). Part frame, mm."""
        d = problem.distances_mm(fit.T)
        return cls(len(d), float(d.max()), float(np.sqrt(np.mean(d**2))), fit.largest_error_95(seam_points)[1])

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class CriteriaComparison:
    """Every criterion on the same data."""

    #: ``criterion``, ``objective_mm``, ``lower_bound_mm``, ``largest_mm``, ``rms_mm``, ``seam_error_95_mm``.
    rows: tuple[dict[str, Any], ...]
    best: Criterion
    why: str  #: One sentence.
    #: Largest distance with a frame through three points, as pendants teach it: by the best three, and the worst.
    three_point_frame_mm: tuple[float, float] | None = None

    @property
    def least(self) -> Criterion:
        """The criterion that predicts the least error of the seams with all observations."""
        weighted = [row for row in self.rows if row["criterion"] == Criterion.WEIGHTED.value]
        rows = weighted or [row for row in self.rows if row["criterion"] != Criterion.ROBUST.value]
        squares_first = sorted(rows, key=lambda row: row["criterion"])  # of equal ones the closed form
        return Criterion(min(squares_first, key=lambda row: row["seam_error_95_mm"])["criterion"])

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        record: dict[str, Any] = {"rows": list(self.rows), "best": self.best.value, "why": self.why}
        if self.three_point_frame_mm is not None:
            record["three_point_frame_mm"] = list(self.three_point_frame_mm)
        return record


def compare_criteria(
    problem: FitProblem,
    fit_by: Callable[[Criterion], CriterionFit],
    *,
    seam_points: FloatArray,
    issues: tuple[Issue, ...] = (),
) -> CriteriaComparison:
    """Fit with every criterion and compare the largest error predicted at the seam points.

    `seam_points`: shape (k, 3). Part frame, mm.
    """
    rows: list[dict[str, Any]] = []
    for criterion in problem.compared:
        if criterion is Criterion.WEIGHTED and not problem.has_covariances:
            continue
        fit = fit_by(criterion)
        summary = FitSummary.of(problem, fit, seam_points).to_record()
        del summary["points"]
        bounds = {"objective_mm": fit.objective_mm, "lower_bound_mm": fit.lower_bound_mm}
        rows.append({"criterion": criterion.value, **bounds, **summary})
    best, why = _best(rows, problem, issues)
    pairs = problem.observed
    wizard = three_point_frames(pairs.p_source, pairs.p_target) if isinstance(pairs, PointPairs) else None
    return CriteriaComparison(tuple(rows), best, why, wizard)


def three_point_frames(model: FloatArray, real: FloatArray) -> tuple[float, float] | None:
    """Return the largest distance with the best and the worst frame through an origin, an x and a plane point, mm.

    `model`, `real`: shape (n, 3). mm. Of more points, `MOST_FRAMED` give the frames. None without four points, or
    without three that hold a frame.
    """
    rows = np.unique(np.linspace(0, len(model) - 1, MOST_FRAMED).round().astype(np.int64))
    chosen = np.array(list(permutations(rows.tolist(), 3)), dtype=np.int64).reshape(-1, 3)
    (a, is_frame), (b, is_real) = _frames(model[chosen]), _frames(real[chosen])
    held = is_frame & is_real
    if len(model) < 4 or not held.any():
        return None
    R, origin = b[held] @ a[held].transpose(0, 2, 1), chosen[held, 0]
    largest = distances(model, real, R, real[origin] - (R @ model[origin, :, None])[..., 0]).max(axis=1)
    return float(largest.min()), float(largest.max())


def _frames(p: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return axes of frames as columns, shape (k, 3, 3), and whether their points, shape (k, 3, 3), hold one."""
    x, other = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    z = np.cross(x, other)
    size, long = np.linalg.norm(z, axis=1), np.linalg.norm(x, axis=1)
    held = size > LEAST_SINE * long * np.linalg.norm(other, axis=1)
    x, z = x / np.where(held, long, 1.0)[:, None], z / np.where(held, size, 1.0)[:, None]
    return np.stack([x, np.cross(z, x), z], axis=2), held


MOST_FRAMED = 8  #: Points of which three give a frame.
LEAST_SINE = 0.2  #: Of the angle between x and the plane point, as seen from the origin: 12°.
CLEARLY_LESS = 0.9  #: Another criterion is worth a line if it predicts less than this share of the seam error.


def advise_criterion(fit: CriterionFit, comparison: CriteriaComparison | None, word: str) -> str | None:
    """Say in one line that another criterion than minimax predicts clearly less error, or suits the residuals better.

    Returns str or None. None if there is nothing to say.
    """
    if comparison is None or fit.criterion is not Criterion.MINIMAX:
        return None
    error = {row["criterion"]: row["seam_error_95_mm"] for row in comparison.rows}
    other = Criterion.LEAST_SQUARES if comparison.best is Criterion.MINIMAX else comparison.best
    mine, theirs = error[Criterion.MINIMAX.value], error.get(other.value)
    if theirs is None or not (fit.has_heavy_tails or theirs < CLEARLY_LESS * mine):
        return None
    why = ""
    if fit.has_heavy_tails:
        why = (
            "the residuals have heavier tails than Gaussian errors (kurtosis test, 5 %), so the predicted errors of "
            "minimax were widened; "
        )
    return (
        f"{why}--criterion {other.value} predicts {short(theirs)} mm at worst, minimax {short(mine)} mm. Minimax makes "
        f"its largest residuals equal by construction: they do not show which {word} is worst"
    )


def _best(rows: list[dict[str, Any]], problem: FitProblem, issues: tuple[Issue, ...]) -> tuple[Criterion, str]:
    word = problem.word
    if any(issue.code == BLUNDER and set(issue.ids) & set(problem.names) for issue in issues):
        return Criterion.ROBUST, f"a mis-taught {word} was named, and robust leaves it out"
    if problem.has_covariances:
        return Criterion.WEIGHTED, f"the errors of the {plural(word)} are stated one by one, and weighted uses them"
    error = {row["criterion"]: row["seam_error_95_mm"] for row in rows}
    squares, largest = error[Criterion.LEAST_SQUARES.value], error[Criterion.MINIMAX.value]
    model = "bounded" if problem.teaching.is_bounded else "Gaussian"
    if largest < squares:
        told = f"for {model} errors it predicts {short(largest)} mm, least squares {short(squares)} mm"
        return Criterion.MINIMAX, told
    ratio = (
        f"minimax predicts {largest / squares:.2f} times its seam error"
        if squares > 0
        else f"all {plural(word)} fit exactly"
    )
    return Criterion.LEAST_SQUARES, f"for {model} errors of equal size {ratio}, and no {word} stands out"
