"""Tests whether 95 % of simulated errors stay below the predicted 95 % error."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.calibrate.errors.linear_fit import LinearFit, isotropic_covariance
from wpcal.calibrate.errors.prediction import COVERAGE, length_quantile
from wpcal.calibrate.trust.criteria import Criterion
from wpcal.core.arrays import FloatArray, as_points, frozen
from wpcal.core.tangent import point_jacobian
from wpcal.study.teaching_error import fit_trials


def error_95(points_base: ArrayLike, covariance: FloatArray, *, degrees_of_freedom: float = math.inf) -> FloatArray:
    """Length that the error of a point stays below with 95 %, by the covariance of ξ about the origin, shape (k,)."""
    J = point_jacobian(as_points(points_base, name="points"))
    return length_quantile(J @ covariance @ J.transpose(0, 2, 1), COVERAGE, degrees_of_freedom=degrees_of_freedom)


@dataclass(frozen=True, slots=True, eq=False)
class CoverageStudy:
    """Errors of a seam point in simulated calibrations, and what was predicted."""

    errors_mm: FloatArray  #: shape (trials,). Length of the seam point's error.
    rms_mm: FloatArray  #: shape (trials,). Root mean square residual of each fit.
    predicted_mm: float  #: The 95 % error predicted from the teaching error.

    @property
    def coverage(self) -> float:
        """Share of the errors that stay below the prediction."""
        return float(np.mean(self.errors_mm <= self.predicted_mm))


def run_coverage_study(
    points: FloatArray,
    seam_point: FloatArray,
    *,
    sigma_mm: float,
    trials: int = 2000,
    criterion: Criterion = Criterion.MINIMAX,
    seed: int = 0,
) -> CoverageStudy:
    """Simulate calibrations with Gaussian errors of the taught points and compare a seam point's error.

    `points`: shape (n, 3). Reference points, mm.
    `seam_point`: shape (3,). Same frame, mm.
    """
    p = as_points(points, name="reference points")
    centre = p.mean(axis=0)
    seam = as_points([seam_point], name="seam point") - centre
    rng = np.random.default_rng(seed)
    taught = (p - centre) + sigma_mm * rng.standard_normal((trials, *p.shape))
    R, t = fit_trials(p - centre, taught, criterion)
    moved = (seam @ R.transpose(0, 2, 1))[:, 0] + t
    residuals = taught - (p - centre) @ R.transpose(0, 2, 1) - t[:, None, :]
    rms = np.sqrt(np.mean(np.sum(residuals**2, axis=2), axis=1))
    covariance = isotropic_covariance(p - centre, sigma_mm)
    if criterion is Criterion.MINIMAX:
        covariance = covariance + sigma_mm**2 * LinearFit.of_points(p - centre).excess()
    predicted = float(error_95(seam, covariance)[0])
    return CoverageStudy(frozen(np.linalg.norm(moved - seam[0], axis=1)), frozen(rms), predicted)
