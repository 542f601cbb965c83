"""What a plan of touches is asked for, and how well the place of the part is known before it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import numpy as np

from wpcal.calibrate.errors.prediction import length_quantile
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.motion import standoff
from wpcal.core.options import opt, opt_deg
from wpcal.core.tangent import point_jacobian
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.touch.searches.plan import MOST_TOUCHES
from wpcal.touch.searches.setup import TouchSetup

LEAST_TOUCHES = 6  #: Each touch on a face gives one number, and a place has six.
USUAL_TOUCHES = 8  #: Six hold the part, two test them.
TOUCHES_PER_BODY = 2  #: For each further body that may move: what most fillets need.
HIT_LEVEL = 0.99  #: Share of the parts that a search meets within its stroke.


class Pattern(StrEnum):
    """The pattern of a plan."""

    BEST = "best"  #: Any set of touches.
    THREE_TWO_ONE = "3-2-1"  #: Three touches on one side of the part, two on a second, one on a third.
    THREE_POINT = "three-point"  #: Three places, at each of which two sides of the part are touched.

    @property
    def touches(self) -> int | None:
        """How many touches the pattern has; None if any number."""
        return None if self is Pattern.BEST else LEAST_TOUCHES


@dataclass(frozen=True, slots=True)
class NominalError:
    """How far the part may stand from where it is planned.

    Raises `InputError` when one is negative, or both are zero.
    """

    sigma_mm: float = opt(
        1.0,
        "Standard deviation per axis of where the part stands: strokes are as long as 99 % of the parts need.",
        "--uncertainty-mm",
    )
    sigma_rad: float = opt_deg(0.3, "Standard deviation per axis of how the part is turned.", "--uncertainty-deg")
    #: shape (6, 6). What a first stage left: covariance of the turn (rad) and of the motion (mm) of the part's middle.
    left: FloatArray | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        if not (0.0 <= self.sigma_mm < math.inf and 0.0 <= self.sigma_rad <= math.pi):
            raise InputError(
                f"the uncertainty of the part's place: expected 0 or more, got {self.sigma_mm:g} mm and "
                f"{math.degrees(self.sigma_rad):g} degrees"
            )

    def covariances(self, points: FloatArray, centre: FloatArray) -> FloatArray:
        """Return the covariance of places of the part, mm², shape (n, 3, 3).

        `points`: shape (n, 3). In `part`, mm.
        `centre`: shape (3,). Middle of the part.
        """
        J = point_jacobian(points - centre)
        return np.asarray(np.einsum("nij,jl,nkl->nik", J, self.covariance, J), dtype=np.float64)

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the turn (rad) and of the motion (mm) of the middle of the part, shape (6, 6)."""
        return np.diag(np.repeat([self.sigma_rad**2, self.sigma_mm**2], 3)) if self.left is None else self.left

    @property
    def root(self) -> FloatArray:
        """A matrix that times its transpose is the covariance, shape (6, 6)."""
        if self.left is None:
            return np.diag(np.repeat([self.sigma_rad, self.sigma_mm], 3))
        values, ways = np.linalg.eigh(self.left)
        return np.asarray(ways * np.sqrt(np.maximum(values, 0.0)))


def displacement_mm(covariances: FloatArray, directions: FloatArray) -> FloatArray:
    """Return how far places may be displaced along directions, either way, with a probability of 99 %, shape (n,), mm.

    `covariances`: shape (n, 3, 3). Of the places, mm².
    `directions`: shape (n, 3). Unit vectors in the same frame.
    """
    along = np.einsum("ni,nij,nj->n", directions, covariances, directions)
    return length_quantile(along[:, None, None], HIT_LEVEL)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TouchOptions:
    """What is asked of a plan of touches."""

    touches: int | None = opt(
        None,
        "Number of touches: searches, without that on a post.  [default: 8; 6 with a pattern; with --bodies 2 more per "
        "further body]",
        "--touches",
        "--count",
    )
    tolerance_mm: float | None = opt(
        None, "Allowed error: as many searches, at most 60, as keep all seams within it, with 95 % confidence."
    )
    pattern: Pattern = opt(
        Pattern.BEST,
        "Pattern of the touches: any, three on one side with two and one on two others, or two sides at each of three "
        "places.",
    )
    robot: RobotField | None = opt(
        None,
        "The robot's own smooth error: standard deviation per axis, and the distance over which it changes (0.3,500). "
        "Or an identification.json, or a file of wpcal drift --cell-errors. Without it, the prior of an uncalibrated "
        "six-axis arm counts.",
        "--robot-mm",
        metavar="AMPLITUDE,LENGTH|FILE",
        read=RobotField.read,
    )
    nominal: NominalError = field(default_factory=NominalError)
    wire_mm: float = opt(1.2, "Diameter of the wire.", "--wire-diameter-mm")
    standoff_mm: float = standoff()
    torch: TorchShape = USUAL_TORCH
    post_base: tuple[float, float, float] | None = opt(
        None,
        "Top of a post at a known place in the base, mm: it is touched first and solves the stick-out.",
        "--post",
        metavar="X,Y,Z",
    )
    setup: TouchSetup = opt(
        None,
        "For a plan of touches: repeatability, stick-out, latency and speed of the cell (TOML).  [default: usual "
        "values]",
        default_factory=TouchSetup,
        metavar="FILE",
        type=Path,
        read="wpcal.touch.searches.setup:read_touch_setup",
        is_shown=False,
    )
    up_base: tuple[float, float, float] = (0.0, 0.0, 1.0)
    most_tilt_rad: float = math.radians(60.0)
    seed: int = 0

    def __post_init__(self) -> None:
        if self.touches is not None and not LEAST_TOUCHES <= self.touches <= MOST_TOUCHES:
            raise InputError(
                f"{self.touches} touches: expected {LEAST_TOUCHES} to {MOST_TOUCHES}; a place has six freedoms, and "
                "each touch holds one"
            )
        if self.touches is not None and self.pattern.touches not in (None, self.touches):
            raise InputError(f"the pattern {self.pattern} has {self.pattern.touches} touches, got {self.touches}")
        if self.tolerance_mm is not None and not 0.0 < self.tolerance_mm < math.inf:
            raise InputError(f"the tolerance must be a positive length, got {self.tolerance_mm:g} mm")
        if self.tolerance_mm is not None and self.pattern is not Pattern.BEST:
            raise InputError(f"the pattern {self.pattern} has its number of touches: leave it or the tolerance away")
        if not 0.0 < self.wire_mm < 2.0 * self.torch.mouth_mm:
            raise InputError(f"the wire: expected a diameter above 0 and below the nozzle's, got {self.wire_mm:g} mm")

    def count(self, bodies: int = 1) -> int:
        """Return how many searches a part of this many bodies gets; with a tolerance, how many at least."""
        if self.touches is not None:
            return self.touches
        return LEAST_TOUCHES if self.tolerance_mm is not None and bodies > 1 else self.usual(bodies)

    def usual(self, bodies: int) -> int:
        """Return how many searches a part of this many bodies gets if nothing is said."""
        return min((self.pattern.touches or USUAL_TOUCHES) + TOUCHES_PER_BODY * (bodies - 1), MOST_TOUCHES)
