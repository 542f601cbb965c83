"""`ParetoSet`: plans to choose from; which vectors of objectives are not dominated, and the volume they dominate."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.same_bits import first_least
from wpcal.planning.plan.plan import Plan
from wpcal.planning.search.objectives import MOTION, OBJECTIVE_NAMES, POSITION


class Preference(Enum):
    """Which plan of a front is taken."""

    POSITION = "position"  #: The least deviation from the target weld position.
    SMOOTH = "smooth"  #: The least joint motion.
    BALANCED = "balanced"
    """The plan nearest to the best value of every objective, each scaled by its range over the front."""


MINIMISED = {Preference.POSITION: POSITION, Preference.SMOOTH: MOTION}
"""The one objective that decides; BALANCED weighs all of them."""


@dataclass(frozen=True, slots=True, eq=False)
class ParetoSet:
    """Plans none of which is at least as good as another in every objective.

    Raises `InputError` when there is no plan.
    """

    plans: tuple[Plan, ...]  #: With all objectives of `OBJECTIVES`.

    def __post_init__(self) -> None:
        if not self.plans:
            raise InputError("a front needs at least one plan")

    def __len__(self) -> int:
        return len(self.plans)

    @property
    def values(self) -> FloatArray:
        """Objectives, shape (m, k), in the order of `OBJECTIVES`."""
        return np.array([[plan.objectives[name] for name in OBJECTIVE_NAMES] for plan in self.plans])

    def chosen(self, preference: Preference) -> int:
        """Return the row of the plan that a preference takes."""
        if preference in MINIMISED:
            name = MINIMISED[preference].name
            return int(first_least([plan.objectives[name] for plan in self.plans]))
        values = self.values
        low, high = values.min(axis=0), values.max(axis=0)
        scaled = (values - low) / np.where(high > low, high - low, 1.0)
        return int(first_least(np.linalg.norm(scaled, axis=1)))


def is_nondominated(values: FloatArray) -> BoolArray:
    """Tell which rows no other row beats. A row beats another if it is nowhere worse and somewhere better, shape (m,).

    `values`: shape (m, k). Smaller is better. Of equal rows the first stays.
    """
    no_worse = (values[:, None] <= values).all(axis=2)
    better = (values[:, None] < values).any(axis=2)
    earlier = np.tri(len(values), k=-1, dtype=bool).T  # [i, j]: row i comes before row j
    beats = no_worse & (better | earlier)
    return np.asarray(~beats.any(axis=0))


def thin_front(values: FloatArray, count: int) -> IntArray:
    """Choose rows that are far from each other: the best of each objective first, then always the farthest one.

    `values`: shape (m, k). Scaled by the range of each column for the distances.
    """
    span = np.ptp(values, axis=0)
    scaled = values / np.where(span > 0, span, 1.0)
    chosen = list(dict.fromkeys(int(row) for row in scaled.argmin(axis=0)))[:count]
    nearest = np.min([np.linalg.norm(scaled - scaled[row], axis=1) for row in chosen], axis=0)
    nearest[chosen] = -1.0
    while len(chosen) < min(count, len(values)):
        chosen.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, np.linalg.norm(scaled - scaled[chosen[-1]], axis=1))
        nearest[chosen[-1]] = -1.0
    return np.array(sorted(chosen), dtype=np.int64)


def hypervolume(values: FloatArray, reference: FloatArray) -> float:
    """Return the volume of the points that some row beats and that beat the reference.

    `values`: shape (m, k). Smaller is better. Rows that do not beat the reference in every objective add nothing.
    `reference`: shape (k,). In the units of the objectives.
    Raises `InputError` when the numbers of objectives differ.

    Notes
    -----
    Slices along the last objective: m times the volume of one objective less. Meant for tens of rows and few
    objectives.

    Examples
    --------
    Two squares of side 2 and 3 that share one of side 2 by 1:

    >>> hypervolume(np.array([[1.0, 2.0], [2.0, 0.0]]), np.array([4.0, 4.0]))
    10.0
    """
    if values.ndim != 2 or values.shape[1] != len(reference):
        raise InputError(f"expected rows of {len(reference)} objectives, got shape {values.shape}")
    inside = values[(values < reference).all(axis=1)]
    if len(inside) == 0:
        return 0.0
    if inside.shape[1] == 1:
        return float(reference[0] - inside.min())
    inside = inside[np.argsort(inside[:, -1], kind="stable")]
    heights = np.diff(np.append(inside[:, -1], reference[-1]))
    return float(
        sum(
            height * hypervolume(inside[: i + 1, :-1], reference[:-1]) for i, height in enumerate(heights) if height > 0
        )
    )
