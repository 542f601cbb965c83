r"""Is the part larger than its model? One number, fitted and tested beside the pose.

A part that is warmer than its drawing, and a robot whose links are longer than its controller believes, both look like
a scale :math:`\varepsilon`: a touch at the distance x from the middle of the touches is off by :math:`\varepsilon x`.
With the pose taken out of the residuals y and of this effect z, and V the covariance of touches and robot,

.. math:: \varepsilon = z^\top V^{-1} y / z^\top V^{-1} z, \qquad u^2(\varepsilon) = 1 / z^\top V^{-1} z.

What is not stated of V is weighed as for every predicted error, with the scale fitted in each case: a smooth error of
the robot that explains the residuals as well leaves no evidence of a scale.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri

from wpcal.calibrate.errors.prediction import COVERAGE
from wpcal.calibrate.errors.robot_field import ResidualRows, RobotField, evidence_of
from wpcal.calibrate.trust.residuals import FALSE_ALARM
from wpcal.core.issue import Issue

SCALE = "scale"  #: Code of the issue that the part is larger or smaller than its model.
LEAST_POINTS = 5  #: A scale is fitted to at least as many observations.
STEEL_PER_K = 12e-6  #: Linear expansion of structural steel up to 100 °C, 1/K (EN 1993-1-1, 3.2.6).


@dataclass(frozen=True, slots=True)
class ScaleFit:
    """How much larger the part is than its model, beyond what the pose explains."""

    scale: float  #: Relative: 5e-4 is 0.5 mm per metre.
    error_95: float  #: Half of its 95 % interval.
    chance: float  #: Probability of such a scale by chance.

    @property
    def is_found(self) -> bool:
        """Whether there is a scale; a false alarm in one fit of a hundred."""
        return self.chance < FALSE_ALARM

    @property
    def issue(self) -> Issue:
        """What was found and what to do."""
        kelvin = self.scale / STEEL_PER_K
        size = "larger" if self.scale > 0 else "smaller"
        message = (
            f"the part is {1e3 * abs(self.scale):.2f} ± {1e3 * self.error_95:.2f} mm per metre {size} than its model "
            f"(steel that is {abs(kelvin):.0f} K {'warmer' if kelvin > 0 else 'colder'} is): measure a known length of "
            "the part with the robot, and with a ruler; --scale free or --part-temperature then give seams this size"
        )
        return Issue(SCALE, message)

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {"scale": self.scale, "error_95": self.error_95, "chance": self.chance, "is_found": self.is_found}


def fit_scale(rows: ResidualRows, count: int, s: float | None, field: RobotField | None) -> ScaleFit | None:
    """Fit the scale to the residuals of `count` observations; None of fewer than `LEAST_POINTS`.

    `s`: The factor on the errors of the rows that is known, or None.
    """
    if count < LEAST_POINTS or len(rows.y) < 2 or not rows.z @ rows.z > 0:
        return None
    nodes, found = evidence_of(rows, s, field)
    weight, variance = nodes.weighed(-0.5 * (found.log_det + found.left(1.0))), 1.0 / found.weight
    scale = float(np.sum(weight * found.size))
    spread = float(np.sum(weight * (variance + (found.size - scale) ** 2)))
    chance = float(np.sum(weight * 2.0 * ndtr(-np.abs(found.size) / np.sqrt(variance))))
    return ScaleFit(scale, float(ndtri((1.0 + COVERAGE) / 2.0)) * math.sqrt(spread), min(chance, 1.0))
