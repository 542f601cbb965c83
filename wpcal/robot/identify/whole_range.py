r"""What an identified arm is predicted to be worth over the whole range of its joints, beside the nominal one.

With the covariance C of the parameters and the Jacobian J of the positions, the identified arm is off by
:math:`J \delta`, δ ~ N(0, C). The nominal one is off by :math:`a + J \delta`, where a is how far the two are apart. Its
mean square is greater by

.. math:: g = \overline{|a|^2} + 2\, v^\top \delta, \qquad v = \overline{J^\top a}.

The identified arm is better where the 95 % interval of g is above zero.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
from scipy.special import ndtri

from wpcal.core.wording import short
from wpcal.robot.identify.least_squares import LeastSquaresFit
from wpcal.robot.identify.parameters import KinematicModel
from wpcal.robot.kinematics.arm import Arm

POSES = 400  #: Drawn evenly within the limits of the joints; the root mean square is then good to a few hundredths.
LEVEL = 0.95


@dataclass(frozen=True, slots=True)
class WholeRange:
    """Predicted root mean square position errors over all poses within the limits of the joints."""

    nominal_mm: float
    identified_mm: float
    is_better: bool  #: Whether the identified arm is better, with 95 % confidence.

    def to_record(self) -> dict[str, float | bool]:
        """Return plain values for a JSON file."""
        return asdict(self)

    @property
    def reason(self) -> str:
        """Why the nominal arm stays in use, if it does."""
        return (
            "over the whole range of the joints the identified arm is predicted to be off by "
            f"{short(self.identified_mm)} mm and the nominal one by {short(self.nominal_mm)} mm, which is no gain with "
            "95 % confidence: measure poses over the whole range (--plan); the nominal arm stays in use"
        )


def predict_whole_range(arm: Arm, nominal: KinematicModel, fit: LeastSquaresFit) -> WholeRange:
    """Predict the errors of both arms, each in the base and with the tool that suits it best.

    `nominal`: The nominal links in their fitted base and tool.
    """
    low, high = arm.limits
    theta = arm.model_angles(np.random.default_rng(0).uniform(low, high, (POSES, len(low))))
    reflector = np.arange(POSES) % len(fit.model.reflectors_flange)
    apart = fit.model.poses(theta, reflector)[0] - nominal.poses(theta, reflector)[0]
    J = fit.model.jacobian(fit.parameters, theta, reflector)[:, 3:]
    own = float(np.einsum("pim,mn,pin->", J, fit.covariance, J)) / POSES
    gain, v = float(np.sum(apart**2)) / POSES, np.einsum("pim,pi->m", J, apart) / POSES
    least = gain - float(ndtri(LEVEL)) * 2.0 * math.sqrt(max(float(v @ fit.covariance @ v), 0.0))
    return WholeRange(math.sqrt(own + gain), math.sqrt(own), least > 0.0)
