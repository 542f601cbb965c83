"""The four criteria by one door, and what error each of them predicts for a weld on the same data."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from wpcal.calibrate.points.least_squares import fit_least_squares, kabsch
from wpcal.calibrate.points.minimax import MinimaxSolution, solve_minimax
from wpcal.calibrate.points.robust import fit_robust
from wpcal.calibrate.points.weighted import fit_weighted, weighted_lower_bound, weighted_root_mean_square
from wpcal.calibrate.uncertainty import (
    POSTURE_FACTOR,
    TeachingError,
    error_95,
    isotropic_covariance,
    minimax_covariance,
    propagated_covariance,
    residual_sigma,
    unequal_minimax_covariance,
    weighted_covariance,
)
from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.transform import RigidTransform


class Criterion(Enum):
    """What a fit makes small."""

    MINIMAX = "minimax"
    """The largest distance: Yin 2003, eq. (4)."""

    LEAST_SQUARES = "least_squares"
    """The sum of squared distances."""

    WEIGHTED = "weighted"
    """The sum of squares weighted with a covariance per point."""

    ROBUST = "robust"
    """The sum of squares over the points that agree."""


@dataclass(frozen=True, slots=True, eq=False)
class CriterionFit:
    """One criterion's answer on the data, and the error it predicts.

    Parameters
    ----------
    criterion : Criterion
    T : RigidTransform
        ``T_base_part``.
    objective_mm : float
        What the criterion makes small: the largest distance, or a root mean square.
    lower_bound_mm : float
        No rigid transform has a smaller objective.
    covariance : ndarray, shape (6, 6)
        Of ξ about the base's origin, in the order of `wpcal.core.tangent`.
    degrees_of_freedom : float
        Behind the scale of the covariance; infinite where the teaching error is stated.
    rows : ndarray of int
        The points the fit rests on.
    """

    criterion: Criterion
    T: RigidTransform
    objective_mm: float
    lower_bound_mm: float
    covariance: FloatArray
    degrees_of_freedom: float
    rows: IntArray

    def error_95_mm(self, points_part: FloatArray) -> FloatArray:
        """95 % error of points of the part, mm, without the bias of the tool; shape (k,)."""
        moved = self.T.apply(points_part)
        return error_95(moved, self.covariance, degrees_of_freedom=self.degrees_of_freedom)


@dataclass(frozen=True, slots=True)
class CriteriaComparison:
    """Every criterion on the same data.

    Parameters
    ----------
    rows : tuple of dict
        ``criterion``, ``objective_mm``, ``largest_mm``, ``rms_mm``, ``seam_error_95_mm``.
    best : Criterion
    why : str
        One sentence.
    """

    rows: tuple[dict[str, Any], ...]
    best: Criterion
    why: str

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {"rows": list(self.rows), "best": self.best.value, "why": self.why}


def fit_criterion(
    pairs: PointPairs,
    criterion: Criterion,
    *,
    teaching: TeachingError,
    seed: int = 0,
    minimax: MinimaxSolution | None = None,
) -> CriterionFit:
    """Fit with one criterion and work out the covariance of the fit.

    Parameters
    ----------
    pairs : PointPairs
        mm.
    criterion : Criterion
    teaching : TeachingError
        Of points that state no covariances; the residuals of the least-squares fit tell where it states nothing.
    seed : int
        Of the simulated part of the minimax covariance and the triples of the robust fit.
    minimax : MinimaxSolution, optional
        Where it is known already.

    Returns
    -------
    CriterionFit

    Raises
    ------
    GeometryError
        When the points do not fix a rotation.
    InputError
        When the weighted criterion finds no covariances.
    """
    rows = np.arange(len(pairs))
    if criterion is Criterion.MINIMAX:
        found = minimax or solve_minimax(pairs)
        T, objective, bound = found.T, found.objective_mm, found.lower_bound_mm
    elif criterion is Criterion.WEIGHTED:
        T = fit_weighted(pairs)
        objective, bound = weighted_root_mean_square(pairs, T), weighted_lower_bound(pairs)
    else:
        if criterion is Criterion.ROBUST:
            rows = np.flatnonzero(fit_robust(pairs, sigma_mm=teaching.per_axis_mm, seed=seed).inlier)
        T = fit_least_squares(pairs.select(rows)) if len(rows) < len(pairs) else fit_least_squares(pairs)
        r = pairs.p_target[rows] - T.apply(pairs.p_source[rows])
        objective = bound = float(np.sqrt(np.mean(np.sum(r**2, axis=1))))
    covariance, freedom = _covariance(pairs, criterion, T, rows, teaching=teaching, seed=seed)
    return CriterionFit(criterion, T, objective, bound, frozen(covariance), freedom, rows)


def _covariance(
    pairs: PointPairs, criterion: Criterion, T: RigidTransform, rows: IntArray, *, teaching: TeachingError, seed: int
) -> tuple[FloatArray, float]:
    moved = T.apply(pairs.p_source[rows])
    sigma, freedom = teaching.per_axis_mm, math.inf
    if pairs.covariances is not None:
        return _stated_covariance(moved, pairs.covariances[rows], criterion, seed), math.inf
    if sigma is None:
        p, q = pairs.p_source[rows], pairs.p_target[rows]
        if criterion is Criterion.MINIMAX:  # its residuals are not the ones whose sum of squares is χ²
            R, t = kabsch(p, q, np.full(len(rows), 1.0 / len(rows)))
            sigma, freedom = residual_sigma(q - p @ R.T - t)
        else:
            sigma, freedom = residual_sigma(q - moved)
    if criterion is Criterion.MINIMAX:
        return minimax_covariance(moved, sigma, bounded=teaching.is_bounded, seed=seed), freedom
    return isotropic_covariance(moved, sigma), freedom


def _stated_covariance(moved: FloatArray, covariances: FloatArray, criterion: Criterion, seed: int) -> FloatArray:
    """Covariance of ξ where every point states its error."""
    if criterion is Criterion.WEIGHTED:
        return weighted_covariance(moved, covariances)
    if criterion is Criterion.MINIMAX:
        return unequal_minimax_covariance(moved, covariances, seed=seed)
    return propagated_covariance(moved, covariances)


def compare_criteria(
    pairs: PointPairs,
    *,
    teaching: TeachingError,
    seam_points: FloatArray,
    issues: tuple[Issue, ...] = (),
    known: tuple[CriterionFit, ...] = (),
    seed: int = 0,
) -> CriteriaComparison:
    """Fit with every criterion and compare the largest error predicted at the seam points.

    Parameters
    ----------
    pairs : PointPairs
        mm. ``weighted`` takes part where they carry covariances.
    teaching : TeachingError
    seam_points : ndarray, shape (k, 3)
        Part frame, mm.
    issues : tuple of Issue
        Findings on the data: a named blunder decides for ``robust``.
    known : tuple of CriterionFit
        Fits that need not be made again.
    seed : int

    Returns
    -------
    CriteriaComparison
    """
    fits = {fit.criterion: fit for fit in known}
    rows: list[dict[str, Any]] = []
    for criterion in Criterion:
        if criterion is Criterion.WEIGHTED and pairs.covariances is None:
            continue
        fit = fits.get(criterion) or fit_criterion(pairs, criterion, teaching=teaching, seed=seed)
        residuals = Residuals.of(pairs, fit.T)
        error = float(fit.error_95_mm(seam_points).max()) + POSTURE_FACTOR * teaching.tcp_bias_mm
        rows.append(
            {
                "criterion": criterion.value,
                "objective_mm": fit.objective_mm,
                "largest_mm": residuals.largest_mm,
                "rms_mm": residuals.rms_mm,
                "seam_error_95_mm": error,
            }
        )
    best, why = _best(rows, teaching, issues, pairs)
    return CriteriaComparison(tuple(rows), best, why)


def _best(
    rows: list[dict[str, Any]], teaching: TeachingError, issues: tuple[Issue, ...], pairs: PointPairs
) -> tuple[Criterion, str]:
    if any(issue.code == "blunder" for issue in issues):
        return Criterion.ROBUST, "a mis-taught point was named, and robust leaves it out"
    if pairs.covariances is not None:
        return Criterion.WEIGHTED, "the errors of the points are stated one by one, and weighted uses them"
    error = {row["criterion"]: row["seam_error_95_mm"] for row in rows}
    squares, largest = error[Criterion.LEAST_SQUARES.value], error[Criterion.MINIMAX.value]
    model = "bounded" if teaching.is_bounded else "Gaussian"
    if largest < squares:
        return Criterion.MINIMAX, f"for {model} errors it predicts {largest:.3g} mm, least squares {squares:.3g} mm"
    ratio = (
        f"minimax predicts {largest / squares:.2f} times its seam error" if squares > 0 else "all points fit exactly"
    )
    return Criterion.LEAST_SQUARES, f"for {model} errors of equal size {ratio}, and no point stands out"
