"""Limits of the tests that name a wrong point or a wrong touch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from wpcal.core.arrays import FloatArray

FALSE_ALARM = 0.01  #: Probability, over all points of one fit, that a good point is called wrong.
NAMED_PROBABILITY = 0.55
"""A point or pair is named as wrong if its probability is at least this. Its probability is always said with it."""
FLOOR_MM = 0.01  #: Controllers print hundredths of a millimetre: a smaller difference is not evidence of an error.
LEAST_SIGMA_MM = 1e-6
"""A smaller stated error counts as this. No controller shows less, and the inverse square stays finite."""
CLEAR_FACTOR = 4.0
"""The best explanation is named only if every rival leaves at least this many times its sum of squares."""
SMALLEST = 1e-300  #: A smaller probability has no quantile.
LEAST_REDUNDANCY = 0.01
"""Share of the variance of an observation that its residual must keep. Below it, less than a tenth of a wrong touch
shows in its own residual."""


@dataclass(frozen=True, slots=True)
class ResidualEvidence:
    """The least-squares residuals of the fitted observations, and what they cannot show."""

    squares_mm2: float  #: Sum of the squared residuals.
    chance: float  #: Probability of larger residuals, if the stated errors are true. 1 if none is stated.
    degrees_of_freedom: int  #: Numbers observed minus the six of the pose.
    count: int  #: Observations.
    unchecked: tuple[str, ...]  #: Observations with a direction in which a wrong touch leaves no residual.

    @property
    def rms_mm(self) -> float:
        """Root mean square residual, mm."""
        return float(np.sqrt(self.squares_mm2 / self.count))

    @property
    def contradicts_stated(self) -> bool:
        """Whether the residuals are larger than the stated errors explain; a false alarm in one fit of a hundred."""
        return self.chance < FALSE_ALARM and self.rms_mm > FLOOR_MM

    @property
    def birge_ratio(self) -> float:
        """How many times the stated errors would have to be larger to explain the residuals on average (Birge 1932)."""
        freedom = max(self.degrees_of_freedom, 1)
        return math.sqrt(float(chdtri(freedom, max(self.chance, SMALLEST))) / freedom)

    def contradicts(self, sigma_mm: float) -> bool:
        """Whether the residuals are larger than a teaching error per axis explains, with the same false alarms."""
        limit = float(chdtri(max(self.degrees_of_freedom, 1), FALSE_ALARM))
        return self.degrees_of_freedom >= 1 and self.squares_mm2 > sigma_mm**2 * limit


def unchecked_names(
    names: Sequence[str], jacobians: FloatArray, seen: FloatArray, more: FloatArray | None = None
) -> tuple[str, ...]:
    """Name the observations with a direction in which a wrong touch leaves (almost) no residual.

    With J the derivative of the residuals and M = Σ Jᵀ J, an error of observation i keeps the share
    A − Jᵢ M⁻¹ Jᵢᵀ of itself in its own residual, where A projects on the directions that the observation sees.

    `jacobians`: shape (n, 3, 6). In mm by comparable coordinates of the motion.
    `seen`: shape (n, 3, 3). A.
    `more`: shape (m, 3, 6). Of observations that test the fit without being fitted.

    References: Baarda (1968), A testing procedure for use in geodetic networks: redundancy numbers.
    """
    everything = jacobians if more is None else np.concatenate([jacobians, more])
    information = np.einsum("nik,nil->kl", everything, everything)
    kept = seen - jacobians @ np.linalg.pinv(information, hermitian=True) @ jacobians.transpose(0, 2, 1)
    least = np.linalg.eigvalsh(kept + np.eye(3) - seen)[:, 0]
    return tuple(names[i] for i in np.flatnonzero(least < LEAST_REDUNDANCY).tolist())
