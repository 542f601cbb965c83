r"""What makes a path good: the functions of Hou 2018 as printed, and what is made small in their place.

As printed, two functions are no goals for a search. Eq. 1 and eq. 2 are products, so one factor at zero frees the
other; and eq. 2 is least with the torch at a limit of its range, where α = β = 90° is the neutral torch. Eq. 4 sums
absolute steps, which does not tell an even motion from a jerk of the same total. The search therefore makes root mean
squares small: of the deviation from the wished weld position, from the wished torch angles, and of the weighted joint
rates. The printed functions are reported beside them.

The text of the paper at hand has lost the layout of its formulas; each function states the reading.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import InputError
from wpcal.planning.cell.closed_chain import ROTATION, SLOPE, TRAVEL, WORK
from wpcal.planning.cell.robot_cell import RobotCell

OBJECTIVES = ("position_deg", "torch_deg", "motion_deg_per_mm")
"""What a front trades: weld position, torch attitude, motion of the joints."""
ATTITUDE = [SLOPE, ROTATION, WORK, TRAVEL]
"""The coordinates that have a wish and a range."""


@dataclass(frozen=True, slots=True)
class Wishes:
    """The weld position and torch angles that are wished, and how far from them a plan may go.

    Parameters
    ----------
    slope_rad, rotation_rad : float
        θ0 and -φ0 of Hou 2018: the boat position has θ0 8…12° and φ0 0…5°.
    slope_range_rad, rotation_range_rad : float
        θmax and φmax: no plan leaves ``-max … max``.
    work_rad, travel_rad : float
        Wished torch angles (DESIGN §3).
    torch_range_rad : float
        Largest deviation of either torch angle from its wish.

    Raises
    ------
    InputError
        When a wish is outside its range, or a range is not positive or too large.
    """

    slope_rad: float = math.radians(10.0)
    rotation_rad: float = 0.0
    slope_range_rad: float = math.radians(30.0)
    rotation_range_rad: float = math.radians(90.0)
    work_rad: float = 0.0
    travel_rad: float = 0.0
    torch_range_rad: float = math.radians(15.0)

    def __post_init__(self) -> None:
        ranges = (
            ("slope", self.slope_rad, self.slope_range_rad, 80.0),
            ("rotation", self.rotation_rad, self.rotation_range_rad, 180.0),
        )
        for name, wish, largest, most_deg in ranges:
            if not 0 < largest <= math.radians(most_deg):
                what = f"{name}: its range must be above 0 and at most {most_deg:g} deg"
                raise InputError(f"{what}, got {math.degrees(largest):g}")
            if not abs(wish) <= largest:
                raise InputError(f"{name}: {math.degrees(wish):g} deg is outside its range {math.degrees(largest):g}")
        if not 0 < self.torch_range_rad <= math.radians(45.0):
            got = math.degrees(self.torch_range_rad)
            raise InputError(f"torch range: expected above 0 and at most 45 deg, got {got:g}")
        for name, wish in (("work", self.work_rad), ("travel", self.travel_rad)):
            if not abs(wish) <= math.radians(45.0):
                raise InputError(f"{name} angle: expected -45 to 45 deg, got {math.degrees(wish):g}")


def wrapped(angle: FloatArray) -> FloatArray:
    """Return angles in [-π, π]."""
    return np.asarray(angle - 2 * np.pi * np.rint(angle / (2 * np.pi)), dtype=np.float64)


def wished_attitude(wishes: Wishes) -> FloatArray:
    """Return the wished slope, rotation, work and travel, shape (4,), rad."""
    return np.array([wishes.slope_rad, wishes.rotation_rad, wishes.work_rad, wishes.travel_rad])


def attitude_box(wishes: Wishes) -> tuple[FloatArray, FloatArray]:
    """Return the least and largest slope, rotation, work and travel, shape (4,) each, rad."""
    wished = wished_attitude(wishes)
    centre = np.where([False, False, True, True], wished, 0.0)
    range_ = np.array([wishes.slope_range_rad, wishes.rotation_range_rad, *(wishes.torch_range_rad,) * 2])
    return centre - range_, centre + range_


def deviations(coordinates: FloatArray, wishes: Wishes) -> FloatArray:
    """Return how far slope, rotation, work and travel are from what is wished, shape (..., 4), rad."""
    return np.asarray(coordinates[..., ATTITUDE] - wished_attitude(wishes), dtype=np.float64)


def position_deviation(coordinates: FloatArray, wishes: Wishes) -> FloatArray:
    r"""Return the root mean square deviation from the wished weld position, deg: what stands for eq. 1.

    .. math::
        \sqrt{\tfrac1n \sum_i (\theta_i - \theta_0)^2 + (\varphi_i - \varphi_0)^2}

    Parameters
    ----------
    coordinates : ndarray, shape (..., n, 9)
    wishes : Wishes

    Returns
    -------
    ndarray, shape (...)
    """
    squares = (deviations(coordinates, wishes)[..., :2] ** 2).sum(axis=-1)
    return np.asarray(np.degrees(np.sqrt(squares.mean(axis=-1))), dtype=np.float64)


def torch_deviation(coordinates: FloatArray, wishes: Wishes) -> FloatArray:
    """Return the root mean square deviation of work and travel from their wishes, deg: what stands for eq. 2.

    Parameters
    ----------
    coordinates : ndarray, shape (..., n, 9)
    wishes : Wishes

    Returns
    -------
    ndarray, shape (...)
    """
    squares = (deviations(coordinates, wishes)[..., 2:] ** 2).sum(axis=-1)
    return np.asarray(np.degrees(np.sqrt(squares.mean(axis=-1))), dtype=np.float64)


def joint_motion(cell: RobotCell, s_mm: FloatArray, joints: FloatArray) -> FloatArray:
    r"""Return the root mean square of the weighted joint rates along the seam, deg/mm: what stands for eq. 4.

    .. math::
        \sqrt{\frac{1}{L \sum_j K_j} \int_0^L \sum_j K_j\, (dq_j/ds)^2\, ds}

    Parameters
    ----------
    cell : RobotCell
        With K_j of all twelve joints.
    s_mm : ndarray, shape (n,)
    joints : ndarray, shape (..., n, 12)
        Unwrapped, rad.

    Returns
    -------
    ndarray, shape (...)
    """
    steps, ds = np.diff(joints, axis=-2), np.diff(s_mm)
    weights = np.concatenate([cell.weights1, cell.weights2])
    squares = ((steps**2) @ weights / ds).sum(axis=-1)
    return np.asarray(np.degrees(np.sqrt(squares / (weights.sum() * (s_mm[-1] - s_mm[0])))), dtype=np.float64)


def f1_1(slope: FloatArray, rotation: FloatArray, wishes: Wishes) -> float:
    r"""Return the weld position function as printed (Hou 2018, eq. 1).

    .. math::
        f_{1-1} = \frac1n \sum_i
                  \frac{|\theta_i - \theta_0|}{\theta_{max}} \frac{|\varphi_i - \varphi_0|}{\varphi_{max}}

    Parameters
    ----------
    slope, rotation : ndarray, shape (n,)
        Weld position, rad; θ is the slope and φ the rotation with its sign turned. Where the rotation is not defined
        (NaN, vertical travel) it is taken as wished.
    wishes : Wishes

    Notes
    -----
    No sign stands between the two fractions in the text at hand: they are multiplied. Differences of angles are taken
    the shorter way round, because φ just below zero is printed as just below 360°.
    """
    theta = np.abs(wrapped(slope - wishes.slope_rad)) / wishes.slope_range_rad
    phi = np.abs(wrapped(np.nan_to_num(rotation, nan=wishes.rotation_rad) - wishes.rotation_rad))
    return float(np.mean(theta * phi / wishes.rotation_range_rad))


def f1_2(work: FloatArray, travel: FloatArray, wishes: Wishes) -> float:
    r"""Return the torch attitude function as printed (Hou 2018, eq. 2), as a mean over the points.

    .. math::
        f_{1-2} = \frac1n \sum_i (1 - \alpha_i / \alpha_{max})(1 - \beta_i / \beta_{max})

    Parameters
    ----------
    work, travel : ndarray, shape (n,)
        Torch angles of DESIGN §3, rad.
    wishes : Wishes

    Notes
    -----
    α and β are the angles between the wire and the seam's y and x axes; both are 90° for the neutral torch, and their
    largest allowed values are 90° plus the range around the wish. The text at hand prints no sum.
    """
    alpha = np.arccos(np.cos(travel) * np.sin(work))
    beta = np.arccos(np.sin(travel))
    alpha_max = math.pi / 2 + abs(wishes.work_rad) + wishes.torch_range_rad
    beta_max = math.pi / 2 + abs(wishes.travel_rad) + wishes.torch_range_rad
    return float(np.mean((1.0 - alpha / alpha_max) * (1.0 - beta / beta_max)))


def f2(cell: RobotCell, joints: FloatArray) -> float:
    r"""Return the smoothness of the motion as printed (Hou 2018, eq. 4), over the joints of both robots.

    .. math::
        f_2 = \frac1n \sum_i \frac{1}{\sum_j K_j} \sum_j K_j
              \frac{|\delta_{i,j} - \delta_{i-1,j}|}{\delta_{j,max} - \delta_{j,min}}

    Parameters
    ----------
    cell : RobotCell
    joints : ndarray, shape (n, 12)
        Unwrapped, rad.
    """
    weights = np.concatenate([cell.weights1, cell.weights2])
    low, high = (np.concatenate(limits) for limits in zip(cell.arm1.limits, cell.arm2.limits, strict=True))
    parts = np.abs(np.diff(joints, axis=0)) / (high - low)
    return float((parts @ weights).sum() / (len(joints) * weights.sum()))


def f4(clearance_mm: FloatArray, d1_mm: float) -> BoolArray:
    """Tell which states are clear (Hou 2018, eq. 6): 1 where the least distance is larger than d1, 0 elsewhere.

    Parameters
    ----------
    clearance_mm : ndarray, shape (...)
        d_min.
    d1_mm : float
        Safety distance.
    """
    return np.asarray(clearance_mm > d1_mm)
