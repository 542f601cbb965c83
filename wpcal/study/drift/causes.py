"""Why the mean changed: all points together, one point, or growing with the distance from the robot.

A rigid motion of the part changes the pose and leaves no residual. What is left after the best rigid motion is compared
with a wrong touch of each point, and with lengths that are all longer by one factor.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from operator import itemgetter

import numpy as np
from scipy.special import chdtri

from wpcal.core.arrays import FloatArray, IntArray

SIGNIFICANCE = 0.001  #: Residuals count as changed if chance does this more rarely.
ALMOST_ALL = 0.9  #: A cause is enough if it explains this share of a change.
ODDS = 6.0  #: Causes are told apart if one is about 20 times as likely (2 ln 20).
SAME_DIRECTION = 1e-4  #: Residuals of a touch on a face have one direction: others are smaller by this factor.


class Cause(StrEnum):
    """Likely cause of a sudden shift."""

    FIXTURE = "fixture or base"
    TOUCH = "touch"
    ROBOT = "robot"
    UNCLEAR = "unclear"


@dataclass(frozen=True, slots=True)
class Likely:
    """A cause, and the points that it is about."""

    cause: Cause
    points: tuple[int, ...] = ()  #: Of a wrong touch; several if they cannot be told apart.
    #: Of a wrong touch of one point: how far it moved, mm. Of the robot: change of all lengths, as a fraction.
    amount: float = 0.0

    @classmethod
    def unknown(cls) -> Likely:
        """Return what is said where no residual could tell causes apart."""
        return cls(Cause.UNCLEAR)


@dataclass(frozen=True, slots=True)
class SeenDirections:
    """The directions in which points are seen, and what is left of them after a rigid motion."""

    directions: FloatArray  #: Unit vectors in `part`, one per row.
    owner: IntArray  #: Point of each row.
    left: FloatArray  #: Takes away what a rigid motion explains.
    growth: FloatArray  #: What is left of a growth by factor 1 of all lengths, mm.
    freedom: int  #: Rows less the motions that they show.

    def project(self, residuals: FloatArray) -> FloatArray:
        """Return what the best rigid motion leaves of residuals, shape (n, m).

        `residuals`: shape (n, p, 3). In `part`, mm.
        """
        along = np.einsum("nmi,mi->nm", residuals[:, self.owner], self.directions)
        return np.asarray(along @ self.left)


def find_pattern(places: FloatArray, residuals: FloatArray) -> SeenDirections:
    """Return the directions in which points are seen.

    `places`: shape (p, 3). Points in `part`, mm.
    `residuals`: shape (n, p, 3). In `part`, mm. They tell whether a point is a place, or a touch on a face or an edge.
    """
    _, sizes, axes = np.linalg.svd(residuals.swapaxes(0, 1), full_matrices=False)
    counted = sizes > SAME_DIRECTION * max(float(sizes.max(initial=0.0)), 1e-12)
    owner, row = np.nonzero(counted)
    directions = axes[owner, row]
    around = places - places.mean(axis=0)
    reach = max(float(np.abs(around).max(initial=0.0)), 1.0)
    motion = np.hstack([np.cross(around[owner], directions) / reach, directions])
    basis, size, _ = np.linalg.svd(motion, full_matrices=False)
    basis = basis[:, size > 1e-9 * max(float(size.max(initial=0.0)), 1e-12)]
    left = np.eye(len(owner)) - basis @ basis.T
    growth = left @ np.einsum("mi,mi->m", around[owner], directions)
    return SeenDirections(directions, owner, left, growth, len(owner) - basis.shape[1])


def likely_cause(step: FloatArray, variance: float, jobs: int, pattern: SeenDirections) -> Likely:
    """Return the likely cause of a change.

    `step`: shape (m,). Change of the mean of what `SeenDirections.project` returns, mm.
    """
    whole = _chi2(step, variance)
    if whole <= chdtri(pattern.freedom, SIGNIFICANCE):
        return Likely(Cause.FIXTURE)
    price = np.log(max(jobs, 2))
    tried = []
    for point in np.unique(pattern.owner):
        left, amounts, used = _explained(step, pattern.left[:, pattern.owner == point])
        tried.append((_chi2(left, variance), used, Likely(Cause.TOUCH, (int(point),), float(np.linalg.norm(amounts)))))
    left, amounts, used = _explained(step, pattern.growth[:, None])
    tried.append((_chi2(left, variance), used, Likely(Cause.ROBOT, (), float(amounts[0]))))
    scored = sorted(
        ((remains + used * price, remains, used, likely) for remains, used, likely in tried), key=itemgetter(0)
    )
    score, remains, used, best = scored[0]
    freedom = pattern.freedom - used
    enough = freedom <= 0 or remains <= chdtri(freedom, SIGNIFICANCE) or remains <= (1 - ALMOST_ALL) * whole
    if not enough:
        return Likely.unknown()
    rivals = [each[3] for each in scored if each[0] - score < ODDS]
    if len(rivals) == 1:
        return best
    if any(each.cause is Cause.ROBOT for each in rivals):
        return Likely(Cause.UNCLEAR, tuple(sorted(point for each in rivals for point in each.points)))
    return Likely(Cause.TOUCH, tuple(sorted(point for each in rivals for point in each.points)))


def _chi2(left: FloatArray, variance: float) -> float:
    return float(left @ left) / variance


def _explained(step: FloatArray, columns: FloatArray) -> tuple[FloatArray, FloatArray, int]:
    """Return what is left of a step, the amounts of the columns, and how many of them count."""
    amounts, _, rank, _ = np.linalg.lstsq(columns, step, rcond=1e-9)
    return step - columns @ amounts, np.asarray(amounts, dtype=float), int(rank)
