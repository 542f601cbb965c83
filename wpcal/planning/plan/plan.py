"""`Plan`: one way to weld a seam with two robots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.planning.cell.cell import CellState


class CollisionVerdict(Enum):
    """What is known about collisions on a path."""

    UNCHECKED = "unchecked"
    FREE = "free"
    NOT_FREE = "not free"


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """One path of both robots along a seam.

    Raises `InputError` when lengths differ.
    """

    seam: str  #: Name of the seam in ``seams.json``.
    s_mm: FloatArray  #: shape (n,). Arc length at the points, increasing, mm.
    state: CellState  #: n points.
    #: `slope_rad`, `rotation_rad`: shape (n,). Weld position relative to gravity (DESIGN §3); the rotation is NaN in
    #: vertical travel.
    slope_rad: FloatArray
    rotation_rad: FloatArray
    #: `work_rad`, `travel_rad`: shape (n,). Torch angles (DESIGN §3).
    work_rad: FloatArray
    travel_rad: FloatArray
    objectives: Mapping[str, float]  #: By name; smaller is better.
    printed: Mapping[str, float]  #: The paper's functions as printed, by their symbols f1_1, f1_2, f2.
    #: shape (n,). Least distance between bodies at the points, mm; None if the plan was not checked.
    clearance_mm: FloatArray | None = None
    found_by: str = "ladder"  #: ``ladder`` or ``nsga2``.
    verdict: CollisionVerdict = CollisionVerdict.UNCHECKED  #: Result of the check between the points.

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
