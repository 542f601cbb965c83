"""The points that the others contradict, and the answer with them and without them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.calibrate.criteria import Criterion, CriterionFit, fit_criterion
from wpcal.calibrate.uncertainty import POSTURE_FACTOR, TeachingError
from wpcal.core.arrays import FloatArray
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.tangent import log_rotation


@dataclass(frozen=True, slots=True)
class FitSummary:
    """One of two fits that are compared.

    Parameters
    ----------
    points : int
        Points the fit rests on.
    largest_mm, rms_mm : float
        Residuals of these points.
    seam_error_95_mm : float
        Largest predicted 95 % error along the seams.
    """

    points: int
    largest_mm: float
    rms_mm: float
    seam_error_95_mm: float

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "points": self.points,
            "largest_mm": self.largest_mm,
            "rms_mm": self.rms_mm,
            "seam_error_95_mm": self.seam_error_95_mm,
        }


@dataclass(frozen=True, slots=True)
class Distrusted:
    """Points that the others contradict, and what leaving them out changes.

    Parameters
    ----------
    names : tuple of str
    off_mm : tuple of float
        How far each of them lies from the fit of the others.
    criterion : Criterion
        Of both fits.
    with_them, without_them : FitSummary
    shift_mm : float
        The furthest that leaving them out moves a point of the seams.
    turn_rad : float
        The angle by which it turns the part.
    """

    names: tuple[str, ...]
    off_mm: tuple[float, ...]
    criterion: Criterion
    with_them: FitSummary
    without_them: FitSummary
    shift_mm: float
    turn_rad: float

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "names": list(self.names),
            "off_mm": list(self.off_mm),
            "criterion": self.criterion.value,
            "with": self.with_them.to_record(),
            "without": self.without_them.to_record(),
            "shift_mm": self.shift_mm,
            "turn_rad": self.turn_rad,
        }


def compare_without(
    pairs: PointPairs,
    names: Sequence[str],
    criterion: Criterion,
    *,
    teaching: TeachingError,
    seam_points: FloatArray,
    known: Sequence[CriterionFit] = (),
    seed: int = 0,
) -> Distrusted:
    """Fit with and without points that are distrusted, by the same criterion.

    Parameters
    ----------
    pairs : PointPairs
        mm. Those that are left fix a rotation.
    names : sequence of str
        The points to leave out.
    criterion : Criterion
        `ROBUST` leaves the points out itself: the two fits are then least squares.
    teaching : TeachingError
    seam_points : ndarray, shape (k, 3)
        Part frame, mm.
    known : sequence of CriterionFit
        Fits of all points that need not be made again.
    seed : int

    Returns
    -------
    Distrusted

    Raises
    ------
    GeometryError
        When the points that are left do not fix a rotation.
    """
    used = Criterion.LEAST_SQUARES if criterion is Criterion.ROBUST else criterion
    out = [pairs.names.index(name) for name in names]
    rest = pairs.select(np.setdiff1d(np.arange(len(pairs)), out))
    fits = {fit.criterion: fit for fit in known}
    first = fits.get(used) or fit_criterion(pairs, used, teaching=teaching, seed=seed)
    second = fit_criterion(rest, used, teaching=teaching, seed=seed)
    moved = second.T.apply(seam_points) - first.T.apply(seam_points)
    return Distrusted(
        tuple(names),
        tuple(float(d) for d in Residuals.of(pairs.select(out), second.T).norms_mm),
        used,
        _summary(pairs, first, teaching, seam_points),
        _summary(rest, second, teaching, seam_points),
        float(np.linalg.norm(moved, axis=1).max()),
        float(np.linalg.norm(log_rotation(second.T.R @ first.T.R.T))),
    )


def _summary(pairs: PointPairs, fit: CriterionFit, teaching: TeachingError, seam_points: FloatArray) -> FitSummary:
    residuals = Residuals.of(pairs, fit.T)
    error = float(fit.error_95_mm(seam_points).max()) + POSTURE_FACTOR * teaching.tcp_bias_mm
    return FitSummary(len(pairs), residuals.largest_mm, residuals.rms_mm, error)
