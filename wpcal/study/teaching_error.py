"""The error study of Yin 2003, section 4: what an error of the taught points does to the calibration.

A known motion carries the model points to the real part, every coordinate gets an error of at most a bound, the part is
calibrated again, and the largest displacement of a reference point is the error e of the trial (eq. (10) to (13)).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np

from wpcal.calibrate.errors.linear_fit import budget_of_design
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.solve.interior_point import solve_interior_point
from wpcal.calibrate.solve.least_squares import centred, distances, kabsch
from wpcal.calibrate.trust.criteria import Criterion
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.options import opt
from wpcal.core.transform import RigidTransform

CHUNK = 4096
"""Trials that are solved together: large enough to hide Python, small enough to stay in the processor's cache."""
PAPER_USUAL_MM = 0.5  #: The paper: the error is usually below this.
UNSTATED = TeachingError()
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95, 0.99)


class ErrorPlace(Enum):
    """Where in the cube of half width `bound_mm` the error of a taught point lies."""

    CUBE = "cube"  #: Anywhere in the cube, evenly, each point for itself.
    CORNERS = "corners"  #: On a corner of the cube, each point for itself: the worst that the bound allows.
    COMMON = "common"  #: Anywhere in the cube, the same for all points: a wrong tool centre point with a fixed posture.


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyOptions:
    """Which errors the taught points get, and how they are fitted.

    Raises `InputError` when the bound is negative, there are no trials, or the criterion is another.
    """

    bound_mm: float = opt(PAPER_USUAL_MM, "Teaching error: largest error per axis.")
    trials: int = opt(10_000, "Number of fits.", least=1)
    place: ErrorPlace = opt(
        ErrorPlace.CUBE, "Errors anywhere in the cube, on its corners, or the same for all points.", "--at"
    )
    criterion: Criterion = opt(
        Criterion.MINIMAX,
        "What is minimised: the largest distance (the published criterion) or the sum of squares.",
        choices=(Criterion.MINIMAX, Criterion.LEAST_SQUARES),
    )
    seed: int = opt(0, "Seed of all random numbers.", least=0)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.bound_mm) and self.bound_mm >= 0) or self.trials < 1:
            what = "expected a bound that is not negative and at least one trial"
            raise InputError(f"{what}, got {self.bound_mm} mm and {self.trials}")
        if self.criterion not in (Criterion.MINIMAX, Criterion.LEAST_SQUARES):
            raise InputError(f"the error study knows minimax and least_squares, got {self.criterion.value}")


USUAL_STUDY = StudyOptions()


@dataclass(frozen=True, slots=True, eq=False)
class ErrorStudy:
    """The errors of the trials and what they say."""

    errors_mm: FloatArray  #: shape (trials,). Largest displacement of a reference point, eq. (13), mm.
    options: StudyOptions
    budget_95_mm: float  #: What no reference point exceeds, with 95 %, with the errors of robot, tool and part as well.

    @property
    def share_below_usual(self) -> float:
        """Share of the trials with e < 0.5 mm."""
        return float(np.mean(self.errors_mm < PAPER_USUAL_MM))

    @property
    def quantiles_mm(self) -> dict[float, float]:
        """Quantiles of e, mm."""
        return dict(zip(QUANTILES, np.quantile(self.errors_mm, QUANTILES).tolist(), strict=True))

    def histogram(self, bins: int = 20) -> tuple[FloatArray, FloatArray]:
        """Counts (bins,) and edges (bins + 1,) in mm from 0 to the extreme."""
        top = float(self.errors_mm.max()) or 1.0
        counts, edges = np.histogram(self.errors_mm, bins=bins, range=(0.0, top))
        return frozen(counts), frozen(edges)

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        counts, edges = self.histogram()
        return {
            "schema": "wpcal/error-study/1",
            "trials": len(self.errors_mm),
            "bound_mm": self.options.bound_mm,
            "at": self.options.place.value,
            "criterion": self.options.criterion.value,
            "seed": self.options.seed,
            "mean_mm": float(self.errors_mm.mean()),
            "extreme_mm": float(self.errors_mm.max()),
            "budget_95_mm": self.budget_95_mm,
            "share_below_0.5_mm": self.share_below_usual,
            "quantiles_mm": {f"{level:g}": value for level, value in self.quantiles_mm.items()},
            "histogram": {"edges_mm": edges.tolist(), "counts": counts.astype(int).tolist()},
        }


def run_error_study(
    p_part: FloatArray,
    T_base_part: RigidTransform,
    options: StudyOptions = USUAL_STUDY,
    *,
    teaching: TeachingError = UNSTATED,
    progress: Callable[[int], None] | None = None,
    fitted: Callable[[Iterator[Chunk]], Iterator[tuple[int, FloatArray]]] | None = None,
) -> ErrorStudy:
    """Simulate calibrations with errors of the taught points.

    `p_part`: shape (n, 3). Reference points of the model, mm.
    `teaching`: What is stated of robot and tool: for the error budget, not for the trials.
    `fitted`: Takes the chunks, and yields the first trial and the errors (trials,) in mm of each, in any order. By
    default they are fitted here, one after another.
    """
    bound_mm, trials, seed = options.bound_mm, options.trials, options.seed
    rng = np.random.default_rng(seed)
    true = centred(T_base_part.apply(p_part))  # the place in the cell shifts model and answer alike
    p = p_part - p_part.mean(axis=0)
    errors, done = np.empty(trials), 0
    chunks = (
        Chunk(
            start,
            p,
            true,
            true + bound_mm * unit_errors(rng, (min(CHUNK, trials - start), len(p), 3), options.place),
            options.criterion,
        )
        for start in range(0, trials, CHUNK)
    )
    here = ((chunk.start, chunk.errors_mm()) for chunk in chunks)
    for start, found in here if fitted is None else fitted(chunks):
        errors[start : start + len(found)] = found
        done += len(found)
        if progress is not None:
            progress(done)
    stated, is_minimax = replace(teaching, bound_mm=bound_mm), options.criterion is Criterion.MINIMAX
    budget = budget_of_design(true, stated, with_minimax=is_minimax, seed=seed)
    expected = budget.joint_errors(true).error_95_mm
    return ErrorStudy(frozen(errors), options, expected)


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Trials that are fitted together."""

    start: int  #: Number of the first one.
    p: FloatArray  #: shape (n, 3). Model points about their centroid, mm.
    true: FloatArray  #: shape (n, 3). Taught points without errors, about their centroid, mm.
    taught: FloatArray  #: shape (trials, n, 3). Taught points with errors, mm.
    criterion: Criterion

    def errors_mm(self) -> FloatArray:
        """Fit every trial; return the largest displacement of a reference point, shape (trials,), mm."""
        R, t = fit_trials(self.p, self.taught, self.criterion)
        return np.asarray(distances(self.p, self.true, R, t).max(axis=1))


def unit_errors(rng: np.random.Generator, shape: tuple[int, int, int], place: ErrorPlace) -> FloatArray:
    """Errors Δ with ‖Δ‖∞ ≤ 1, eq. (11); shape (trials, n, 3)."""
    if place is ErrorPlace.CORNERS:
        return np.asarray(rng.integers(0, 2, shape) * 2.0 - 1.0)
    if place is ErrorPlace.COMMON:
        return np.asarray(np.broadcast_to(rng.uniform(-1.0, 1.0, (shape[0], 1, 3)), shape))
    return rng.uniform(-1.0, 1.0, shape)


def fit_trials(p: FloatArray, q: FloatArray, criterion: Criterion) -> tuple[FloatArray, FloatArray]:
    """Fit many trials of one set of points at once.

    Returns `R`: shape (trials, 3, 3).
    Returns `t`: shape (trials, 3). mm.

    `p`: shape (n, 3). Model points about their centroid, mm.
    `q`: shape (trials, n, 3). Taught points, about where that centroid is, mm.
    """
    source = np.broadcast_to(p, q.shape)
    R, t = kabsch(source, q, np.full(q.shape[:2], 1.0 / len(p)))
    if criterion is Criterion.LEAST_SQUARES:
        return R, np.asarray(t)
    state = solve_interior_point(source, q, R, t)
    return state.R, state.t
