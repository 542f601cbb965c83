"""`Plan`: one way to weld a seam with two robots; `ParetoSet`: the plans between which one chooses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.planning.cell.robot_cell import CellState


class Preference(Enum):
    """Which plan of a front is taken."""

    POSITION = "position"
    """The least deviation from the wished weld position."""
    SMOOTH = "smooth"
    """The least joint motion."""
    BALANCED = "balanced"
    """The one nearest to the best of every objective, each scaled by its range over the front."""


class Freedom(Enum):
    """What is known of a path between the bodies of a cell."""

    UNCHECKED = "unchecked"
    FREE = "free"
    NOT_FREE = "not free"


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """One path of both robots along a seam.

    Parameters
    ----------
    seam : str
        Name of the seam in ``seams.json``.
    s_mm : array_like, shape (n,)
        Arc length at the points, increasing.
    state : CellState
        n points.
    slope_rad, rotation_rad : array_like, shape (n,)
        Weld position against gravity (DESIGN §3); the rotation is NaN in vertical travel.
    work_rad, travel_rad : array_like, shape (n,)
        Torch angles (DESIGN §3).
    objectives : mapping of str to float
        What is made small, by name.
    printed : mapping of str to float
        The paper's functions as printed, by the names f1_1, f1_2, f2.
    clearance_mm : array_like, shape (n,), optional
        Least distance between bodies at the points; None where nothing was checked.
    found_by : str
        ``ladder`` or ``nsga2``.
    freedom : Freedom
        What the check between the points found.

    Raises
    ------
    InputError
        When lengths differ.
    """

    seam: str
    s_mm: FloatArray
    state: CellState
    slope_rad: FloatArray
    rotation_rad: FloatArray
    work_rad: FloatArray
    travel_rad: FloatArray
    objectives: Mapping[str, float]
    printed: Mapping[str, float]
    clearance_mm: FloatArray | None = None
    found_by: str = "ladder"
    freedom: Freedom = Freedom.UNCHECKED

    def __post_init__(self) -> None:
        for name in ("s_mm", "slope_rad", "rotation_rad", "work_rad", "travel_rad", "clearance_mm"):
            values = getattr(self, name)
            if values is None:
                continue
            values = frozen(values)
            if values.shape != (len(self.state),):
                raise InputError(f"plan: {name} has shape {values.shape}, the path has {len(self.state)} points")
            object.__setattr__(self, name, values)

    def __len__(self) -> int:
        return len(self.s_mm)


@dataclass(frozen=True, slots=True, eq=False)
class ParetoSet:
    """Plans of which none is at least as good as another in every objective.

    Parameters
    ----------
    plans : tuple of Plan
    names : tuple of str
        Names of the k objectives, all made small.

    Raises
    ------
    InputError
        When there is no plan.
    """

    plans: tuple[Plan, ...]
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        if not self.plans:
            raise InputError("a front needs at least one plan")

    def __len__(self) -> int:
        return len(self.plans)

    @property
    def values(self) -> FloatArray:
        """Objectives, shape (m, k)."""
        return np.array([[plan.objectives[name] for name in self.names] for plan in self.plans])

    def chosen(self, preference: Preference) -> int:
        """Return the index of the plan that a preference takes."""
        values = self.values
        if preference is Preference.POSITION:
            return int(np.argmin(values[:, self.names.index("position_deg")]))
        if preference is Preference.SMOOTH:
            return int(np.argmin(values[:, self.names.index("motion_deg_per_mm")]))
        low, high = values.min(axis=0), values.max(axis=0)
        scaled = (values - low) / np.where(high > low, high - low, 1.0)
        return int(np.argmin(np.linalg.norm(scaled, axis=1)))
