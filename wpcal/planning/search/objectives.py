"""The objectives of planning: one table, one function per objective.

To add an objective, add a row to `OBJECTIVES` and the function that the row names. Fronts, files, tables, the page and
NSGA-II follow the table. The deterministic search minimises an objective if its row says which residuals carry its
weight (`Residuals`); otherwise the search only reports and compares it.

The functions of Hou 2018 cannot be minimised as printed. Eq. 1 and eq. 2 are products: if one factor is zero, the other
is unconstrained. Eq. 2 is also least with the torch at a limit of its range, because α = β = 90° is the neutral torch.
Eq. 4 sums absolute steps: an even motion and a jerk of the same total cost the same. The search therefore minimises
root mean squares: of the deviation from the target weld position, of the deviation from the target torch angles, and of
the weighted joint rates. The printed functions are reported beside them.

The text of the paper at hand has lost the layout of its formulas. Each function says how the formula was read.

Also here: `WeldTargets`: the weld position and torch angles that a plan should have, and how far it may be from them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import partial

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.motion import torch_range, travel_angle, work_angle
from wpcal.core.options import opt_deg
from wpcal.core.same_bits import arc_tangent, product, sine_cosine
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.closed_chain import COORDINATES, ROTATION, SLOPE, TRAVEL, WORK

ATTITUDE = [SLOPE, ROTATION, WORK, TRAVEL]  #: The coordinates that have a target and a range.


@dataclass(frozen=True, slots=True)
class WeldTargets:
    """The target weld position and torch angles, and how far from them a plan may go.

    Raises `InputError` when a target is outside its range, or a range is not positive or too large.
    """

    slope_rad: float = opt_deg(10.0, "Target slope of the weld, uphill.", least=-180.0, most=180.0)
    rotation_rad: float = opt_deg(0.0, "Target rotation of the joint.", least=-180.0, most=180.0)
    slope_range_rad: float = math.radians(30.0)
    rotation_range_rad: float = math.radians(90.0)
    work_rad: float = work_angle()
    travel_rad: float = travel_angle()
    torch_range_rad: float = torch_range()

    def __post_init__(self) -> None:
        ranges = (
            ("slope", self.slope_rad, self.slope_range_rad, 80.0),
            ("rotation", self.rotation_rad, self.rotation_range_rad, 180.0),
        )
        for name, target, largest, most_deg in ranges:
            if not 0 < largest <= math.radians(most_deg):
                what = f"{name}: its range must be above 0 and at most {most_deg:g} deg"
                raise InputError(f"{what}, got {math.degrees(largest):g}")
            if not abs(target) <= largest:
                raise InputError(f"{name}: {math.degrees(target):g} deg is outside its range {math.degrees(largest):g}")
        if not 0 < self.torch_range_rad <= math.radians(45.0):
            got = math.degrees(self.torch_range_rad)
            raise InputError(f"torch range: expected above 0 and at most 45 deg, got {got:g}")
        for name, target in (("work", self.work_rad), ("travel", self.travel_rad)):
            if not abs(target) <= math.radians(45.0):
                raise InputError(f"{name} angle: expected -45 to 45 deg, got {math.degrees(target):g}")

    @property
    def attitude_rad(self) -> FloatArray:
        """Target slope, rotation, work and travel, shape (4,), rad."""
        return np.array([self.slope_rad, self.rotation_rad, self.work_rad, self.travel_rad])

    @property
    def attitude_box_rad(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest slope, rotation, work and travel, shape (4,) each, rad."""
        centre = np.where([False, False, True, True], self.attitude_rad, 0.0)
        range_ = np.array([self.slope_range_rad, self.rotation_range_rad, *(self.torch_range_rad,) * 2])
        return centre - range_, centre + range_


def target_coordinates(targets: WeldTargets, count: int) -> FloatArray:
    """Return coordinates of `count` points with the target weld position and torch angles, shape (count, 9).

    Place, yaw and spin are zero.
    """
    coordinates = np.zeros((count, COORDINATES))
    coordinates[:, ATTITUDE] = targets.attitude_rad
    return coordinates


def deviations(coordinates: FloatArray, targets: WeldTargets) -> FloatArray:
    """Return how far slope, rotation, work and travel are from their targets, rad.

    `coordinates`: ndarray, shape (..., 9).
    Returns ndarray, shape (..., 4). In the order of `ATTITUDE`.
    """
    return np.asarray(coordinates[..., ATTITUDE] - targets.attitude_rad, dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class PathValues:
    """What an objective is a function of: one path, or many paths along the leading axes."""

    cell: Cell
    targets: WeldTargets
    s_mm: FloatArray  #: shape (n,). Arc length at the points of the seam.
    coordinates: FloatArray  #: shape (..., n, 9). mm and rad, as in `wpcal.planning.cell.closed_chain`.
    joints: FloatArray  #: shape (..., n, 12). Robot 1, then robot 2; unwrapped, rad.


class Residuals(Enum):
    """Which residuals of the least-squares model carry the weight of an objective."""

    TARGET_DEVIATIONS = "target deviations"
    """Deviations of the objective's coordinates from their targets, at every point."""
    JOINT_STEPS = "joint steps"  #: Joint steps between neighbouring points.
    NONE = "none"  #: The deterministic search reports the objective and does not minimise it.


@dataclass(frozen=True, slots=True, eq=False)
class Objective:
    """One row of the table."""

    name: str  #: Key in files, with the unit.
    #: `label`, `unit`: For tables and pages.
    label: str
    unit: str
    value: Callable[[PathValues], FloatArray]  #: The objective of `PathValues`; shape (...). Smaller is better.
    residuals: Residuals = Residuals.NONE  #: What its weight multiplies in the least squares.
    #: Columns of `ATTITUDE` that it measures; empty unless `residuals` is TARGET_DEVIATIONS.
    coordinates: tuple[int, ...] = ()
    symbol: str = ""  #: Key of the paper's function in ``as_printed``; empty where the paper has none.
    printed: Callable[[PathValues], float] | None = None  #: The paper's function as printed, of one path.

    @property
    def title(self) -> str:
        """Label and unit, for the axis of a chart."""
        return f"{self.label}, {self.unit}"


def root_mean_square_deviation(path: PathValues, columns: tuple[int, ...]) -> FloatArray:
    r"""Return the root mean square deviation of some coordinates from their targets (eqs 1 and 2), deg, shape (...).

    .. math::
        \sqrt{\tfrac1n \sum_i \sum_k (x_{ik} - x_{0k})^2}
    """
    rows = [ATTITUDE.index(column) for column in columns]
    off = path.coordinates[..., list(columns)] - path.targets.attitude_rad[rows]
    return np.asarray(np.degrees(np.sqrt((off**2).sum(axis=-1).mean(axis=-1))), dtype=np.float64)


def joint_motion(path: PathValues) -> FloatArray:
    r"""Return the root mean square of the weighted joint rates along the seam (in place of eq. 4), deg/mm, shape (...).

    .. math::
        \sqrt{\frac{1}{L \sum_j K_j} \int_0^L \sum_j K_j\, (dq_j/ds)^2\, ds}
    """
    s_mm, steps = path.s_mm, np.diff(path.joints, axis=-2)
    weights = path.cell.joint_weights
    squares = (product(steps**2, weights) / np.diff(s_mm)).sum(axis=-1)
    return np.asarray(np.degrees(np.sqrt(squares / (weights.sum() * (s_mm[-1] - s_mm[0])))), dtype=np.float64)


def printed_position(path: PathValues) -> float:
    r"""Return the weld position function as printed (Hou 2018, eq. 1, f1-1).

    .. math::
        f_{1-1} = \frac1n \sum_i
                  \frac{|\theta_i - \theta_0|}{\theta_{max}} \frac{|\varphi_i - \varphi_0|}{\varphi_{max}}

    θ is the slope and φ the rotation with the opposite sign.

    A rotation that is not defined (NaN, vertical travel) counts as on target. The text at hand shows no operator
    between the two fractions, so they are multiplied. Differences of angles are taken the shorter way round, because φ
    just below zero is printed as just below 360°.
    """
    slope, rotation, targets = path.coordinates[:, SLOPE], path.coordinates[:, ROTATION], path.targets
    theta = np.abs(wrapped(slope - targets.slope_rad)) / targets.slope_range_rad
    phi = np.abs(wrapped(np.nan_to_num(rotation, nan=targets.rotation_rad) - targets.rotation_rad))
    return float(np.mean(theta * phi / targets.rotation_range_rad))


def wrapped(angle: FloatArray) -> FloatArray:
    """Return angles of any shape in [-π, π], rad."""
    return np.asarray(angle - 2 * np.pi * np.rint(angle / (2 * np.pi)), dtype=np.float64)


def printed_torch(path: PathValues) -> float:
    r"""Return the torch attitude function as printed (Hou 2018, eq. 2, f1-2), as a mean over the points.

    .. math::
        f_{1-2} = \frac1n \sum_i (1 - \alpha_i / \alpha_{max})(1 - \beta_i / \beta_{max})

    α and β are the angles between the wire and the seam's y and x axes. Both are 90° for the neutral torch. Their
    largest allowed values are 90° plus the range around the target. The text at hand prints no sum.
    """
    work, travel, targets = path.coordinates[:, WORK], path.coordinates[:, TRAVEL], path.targets
    (work_sine, travel_sine), (_, travel_cosine) = sine_cosine(np.stack([work, travel]))
    alpha = _arc_cosine(travel_cosine * work_sine)
    beta = _arc_cosine(travel_sine)
    alpha_max = math.pi / 2 + abs(targets.work_rad) + targets.torch_range_rad
    beta_max = math.pi / 2 + abs(targets.travel_rad) + targets.torch_range_rad
    return float(np.mean((1.0 - alpha / alpha_max) * (1.0 - beta / beta_max)))


def _arc_cosine(x: FloatArray) -> FloatArray:
    return arc_tangent(np.sqrt((1.0 - x) * (1.0 + x)), x)


def printed_smoothness(path: PathValues) -> float:
    r"""Return the smoothness of the motion as printed (Hou 2018, eq. 4, f2), over the joints of both robots.

    .. math::
        f_2 = \frac1n \sum_i \frac{1}{\sum_j K_j} \sum_j K_j
              \frac{|\delta_{i,j} - \delta_{i-1,j}|}{\delta_{j,max} - \delta_{j,min}}
    """
    weights = path.cell.joint_weights
    low, high = path.cell.limits
    parts = np.abs(np.diff(path.joints, axis=0)) / (high - low)
    return float(product(parts, weights).sum() / (len(path.joints) * weights.sum()))


POSITION = Objective(
    name="position_deg",
    label="position",
    unit="deg",
    value=partial(root_mean_square_deviation, columns=(SLOPE, ROTATION)),
    residuals=Residuals.TARGET_DEVIATIONS,
    coordinates=(SLOPE, ROTATION),
    symbol="f1_1",
    printed=printed_position,
)
TORCH = Objective(
    name="torch_deg",
    label="torch",
    unit="deg",
    value=partial(root_mean_square_deviation, columns=(WORK, TRAVEL)),
    residuals=Residuals.TARGET_DEVIATIONS,
    coordinates=(WORK, TRAVEL),
    symbol="f1_2",
    printed=printed_torch,
)
MOTION = Objective(
    name="motion_deg_per_mm",
    label="motion",
    unit="deg/mm",
    value=joint_motion,
    residuals=Residuals.JOINT_STEPS,
    symbol="f2",
    printed=printed_smoothness,
)
OBJECTIVES = (POSITION, TORCH, MOTION)  #: What a front trades, in the order of the columns of files, tables and charts.
OBJECTIVE_NAMES = tuple(objective.name for objective in OBJECTIVES)

Weights = Mapping[Objective, float]  #: Weights of the squared objectives; an objective that is missing has weight 0.


def objective_values(path: PathValues) -> FloatArray:
    """Return all objectives of one path or of many, shape (..., len(OBJECTIVES)), in the order of `OBJECTIVES`."""
    return np.stack([objective.value(path) for objective in OBJECTIVES], axis=-1)


def printed_values(path: PathValues) -> dict[str, float]:
    """Return the paper's functions of one path as printed, by their symbols."""
    return {row.symbol: row.printed(path) for row in OBJECTIVES if row.printed is not None}


def deviation_weights(weights: Weights) -> FloatArray:
    """Return the weights of the squared deviations of slope, rotation, work and travel, shape (4,), per deg²."""
    by_column = np.zeros(COORDINATES)
    for objective, weight in weights.items():
        if objective.residuals is Residuals.TARGET_DEVIATIONS:
            by_column[list(objective.coordinates)] += weight
    return by_column[ATTITUDE]


def joint_step_weight(weights: Weights) -> float:
    """Return the weight of the squared joint motion, per (deg/mm)²."""
    return float(sum(weight for row, weight in weights.items() if row.residuals is Residuals.JOINT_STEPS))
