"""Why several answers fit, and what would tell them apart: symmetries in words, and the point to teach next."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.tangent import log_rotation

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

EXACT_MM = 0.01
"""A motion that carries features onto features this nearly is a symmetry of the model; STEP files round at 1e-3 mm."""
TURN_RAD = math.radians(0.5)
"""A smaller turn is a shift; turns are named in whole degrees where they are this close to one."""
FIRST_TRIED = 64
"""Features that a motion must carry to features before all are looked at: a chance motion fails on the first few."""
AXIS_NAMES = ("x", "y", "z")


@dataclass(frozen=True, slots=True, eq=False)
class PartMotion:
    """A motion of the part that carries one answer into another."""

    R: FloatArray  #: shape (3, 3).
    t_mm: FloatArray  #: shape (3,). In `part`, mm.

    @classmethod
    def between(cls, points: FloatArray, first: IntArray, second: IntArray) -> PartMotion:
        """Fit the motion that carries the features of one answer to those of another.

        `points`: shape (N, 3). Of the features, in `part`, mm.
        `first`, `second`: shape (n,). Rows of the features in the two answers.
        """
        return cls(*kabsch(points[first], points[second], np.full(len(first), 1.0 / len(first))))

    def is_symmetry(self, points: FloatArray, tree: cKDTree, *, within_mm: float) -> bool:
        """Tell whether the motion carries every feature to a feature; a few are tried first.

        `points`: shape (N, 3). Of the features, in `part`, mm.
        """
        for some in (points[:: len(points) // FIRST_TRIED + 1], points):
            if float(np.max(tree.query(some @ self.R.T + self.t_mm)[0])) > within_mm:
                return False
        return True

    def in_words(self) -> str:
        """Say what the motion is: ``a half turn about the line along z through (50, 30, 0)``."""
        turn = log_rotation(self.R)
        angle = float(np.linalg.norm(turn))
        if angle < TURN_RAD:
            return f"a shift by {_place(self.t_mm)} mm"
        axis = turn / angle
        axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
        along = float(axis @ self.t_mm)
        across = self.t_mm - along * axis
        # The point of the axis nearest the origin: (I - R) c = t without its part along the axis.
        centre = np.linalg.pinv(np.eye(3) - self.R) @ across
        words = f"{_turn(angle)} about the line along {_direction(axis)} through {_place(centre)}"
        return words if abs(along) < EXACT_MM else f"{words} with a shift of {along:.4g} mm along it"


def _turn(angle: float) -> str:
    names = {180: "a half turn", 120: "a third of a turn", 90: "a quarter turn"}
    degrees = math.degrees(angle)
    whole = round(degrees)
    if abs(degrees - whole) > math.degrees(TURN_RAD):
        return f"a turn of {degrees:.1f}°"
    return names.get(whole, f"a turn of {whole}°")


def _direction(axis: FloatArray) -> str:
    k = int(np.argmax(np.abs(axis)))
    if abs(axis[k]) > math.cos(TURN_RAD):
        return AXIS_NAMES[k]
    return f"({', '.join(f'{v + 0.0:.3f}' for v in axis)})"


def _place(p: FloatArray) -> str:
    return f"({', '.join(f'{round(v, 1) + 0.0:g}' for v in p)})"


@dataclass(frozen=True, slots=True)
class NextPoint:
    """The feature to teach as well."""

    row: int  #: Of the features tried.
    #: Expected number of wrong answers that still fit when it is taught, of those that were looked at.
    others_left: float


def best_next_point(
    tried: FloatArray,
    tree: cKDTree,
    R: FloatArray,
    t: FloatArray,
    weights: FloatArray,
    *,
    alike: BoolArray,
    tolerance_mm: float,
) -> NextPoint:
    """Find the feature that tells most answers apart when it is taught as well, without a name.

    When answer A is true, the touched feature f is seen at ``A f``; answer B explains that where a feature lies near
    ``B⁻¹ A f``. The feature with the smallest expected number of such B, over A by its weight, is the best; of equal
    ones that with the greatest least distance.

    `tried`: shape (k, 3). Features that may be taught, in `part`, mm.
    `R`, `t`: shape (m, 3, 3) and (m, 3). ``T_base_part`` of the answers.
    `weights`: shape (m,). Probabilities of the answers.
    `alike`: shape (m, m). Pairs of answers that no point can tell apart; every answer with itself.
    """
    seen = np.einsum("aij,fj->afi", R, tried) + t[:, None]
    left = np.zeros(len(tried))
    least = np.full(len(tried), np.inf)
    for b in range(len(R)):
        back = (seen - t[b]) @ R[b]
        distance = np.asarray(tree.query(back.reshape(-1, 3))[0]).reshape(back.shape[:2])
        others = ~alike[b]
        left += weights[others] @ (distance[others] < tolerance_mm)
        least = np.minimum(least, distance[others].min(axis=0, initial=np.inf))
    best = np.lexsort((-least, np.round(left, 6)))[0]
    return NextPoint(int(best), float(left[best]))
