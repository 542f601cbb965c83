"""The weld position of every frame: slope, rotation and the letters of ISO 6947 (PA … PG), with gravity known.

With u = up (against gravity), x the travel and z out of the joint (DESIGN §3): slope S = asin(x·u), positive uphill;
rotation R = atan2(x·(u⊥ × z), u⊥·z) with u⊥ = u - (u·x) x: 0 when the joint faces up, ±90° sideways, 180° down. Within
1° of vertical travel R is not defined (NaN). Hou 2018, §1.2 writes θ = S and φ = -R modulo 360°.

We do not have the ranges of the standard. The rules here are the principal positions with tolerances of our own; a
caller may pass others.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import InputError
from wpcal.core.same_bits import arc_tangent, product
from wpcal.seam.seam import WeldType

UP = (0.0, 0.0, 1.0)  #: Against gravity in `base`, unless the caller says otherwise.
VERTICAL_RAD = float(np.radians(1.0))  #: Nearer than this to vertical travel the rotation is not defined.


@dataclass(frozen=True, slots=True)
class PositionRule:
    """One principal position; the first rule that matches names a frame."""

    name: str  #: ``PA`` … ``PG``.
    slope_deg: tuple[float, float]  #: Least and greatest slope S.
    rotation_deg: tuple[float, float] | None = None  #: Least and greatest |R|; None if R does not matter.
    weld: WeldType | None = None  #: Only for this weld; None for any.


DEFAULT_RULES = (
    PositionRule("PF", (45.0, 90.0)),
    PositionRule("PG", (-90.0, -45.0)),
    PositionRule("PA", (-45.0, 45.0), (0.0, 22.5)),
    PositionRule("PB", (-45.0, 45.0), (22.5, 80.0), WeldType.FILLET),
    PositionRule("PC", (-45.0, 45.0), (22.5, 112.5)),
    PositionRule("PD", (-45.0, 45.0), (112.5, 157.5)),
    PositionRule("PE", (-45.0, 45.0), (157.5, 180.0)),
)
"""The limits are half-way between the principal positions: rotation 0° for PA, 45° for PB, 90° for PC, 135° for PD,
180° for PE; slope +90° for PF, -90° for PG. A fillet is PB up to 80°, where it faces a wall."""


@dataclass(frozen=True, slots=True, eq=False)
class WeldPositions:
    """Positions of n frames.

    `slope_rad`: ndarray, shape (n,). -π/2 … π/2, positive uphill.
    `rotation_rad`: ndarray, shape (n,). -π … π; NaN where travel is vertical.
    """

    slope_rad: FloatArray
    rotation_rad: FloatArray
    name: tuple[str, ...]  #: ``PA`` … ``PG``.


def weld_slope(tangent: ArrayLike, up: ArrayLike = UP) -> FloatArray:
    """Angle of the weld axis above the horizontal plane, rad, positive uphill, shape (...).

    `tangent`: shape (..., 3). Unit directions of travel.
    `up`: shape (3,). Unit vector against gravity, in the same frame.

    A vertical-up weld:

    >>> float(np.degrees(weld_slope([0, 0, 1])).round(3))
    90.0
    """
    sine = np.clip(product(tangent, up), -1.0, 1.0)
    return arc_tangent(sine, np.sqrt((1.0 - sine) * (1.0 + sine)))


def weld_rotation(tangent: ArrayLike, outward: ArrayLike, up: ArrayLike = UP) -> FloatArray:
    """Angle of the joint about the weld axis, rad: 0 facing up, ±π/2 sideways, π down; NaN for vertical travel.

    `tangent`, `outward`: shape (..., 3). The x and z axes of seam frames, unit vectors.
    `up`: shape (3,). Unit vector against gravity, in the same frame.
    Returns ndarray, shape (...).

    A fillet on a horizontal plate, bisector leaning 45 degrees:

    >>> half = 2**-0.5
    >>> float(np.degrees(weld_rotation([1, 0, 0], [0, half, half])).round(3))
    -45.0
    """
    x, z = np.asarray(tangent, dtype=np.float64), np.asarray(outward, dtype=np.float64)
    u = np.asarray(up, dtype=np.float64)
    across = u - product(x, u)[..., None] * x
    sine = np.einsum("...i,...i->...", x, np.cross(across, z))
    angle = arc_tangent(sine, np.einsum("...i,...i->...", across, z))
    vertical = np.abs(weld_slope(x, u)) > np.pi / 2 - VERTICAL_RAD
    return np.asarray(np.where(vertical, np.nan, angle), dtype=np.float64)


def weld_positions(
    R: ArrayLike, weld: WeldType, *, up: ArrayLike = UP, rules: Sequence[PositionRule] = DEFAULT_RULES
) -> WeldPositions:
    """Name the weld position of every frame.

    `R`: shape (n, 3, 3). Seam frames (columns x, y, z) in a frame in which `up` is known, `base` as a rule.
    `up`: shape (3,). Against gravity; scaled to unit length.
    Raises `InputError` if `up` has no length.
    """
    frames, u = np.asarray(R, dtype=np.float64), np.asarray(up, dtype=np.float64)
    length = float(np.linalg.norm(u))
    if not length > 0:
        raise InputError("the direction against gravity (up) has length zero")
    slope = weld_slope(frames[:, :, 0], u / length)
    rotation = weld_rotation(frames[:, :, 0], frames[:, :, 2], u / length)
    names = np.full(len(frames), "-", dtype="<U8")
    for rule in reversed(rules):  # so the first rule overrides later ones
        if rule.weld in (None, weld):
            names[_fits(rule, np.degrees(slope), np.degrees(rotation))] = rule.name
    return WeldPositions(slope, rotation, tuple(str(name) for name in names))


def usual_position(R: FloatArray, weld: WeldType) -> str:
    """Return the position of most of the frames of shape (n, 3, 3), of which z is up; ``-`` if it has no name."""
    return Counter(weld_positions(R, weld).name).most_common(1)[0][0]


def _fits(rule: PositionRule, slope_deg: FloatArray, rotation_deg: FloatArray) -> BoolArray:
    fits = (rule.slope_deg[0] <= slope_deg) & (slope_deg <= rule.slope_deg[1])
    if rule.rotation_deg is not None:
        turn = np.nan_to_num(np.abs(rotation_deg), nan=-1.0)
        fits &= (rule.rotation_deg[0] <= turn) & (turn <= rule.rotation_deg[1])
    return np.asarray(fits, dtype=bool)
