"""`Obstacle`: what keeps a seam from being planned, where, and by how much; `NoFeasiblePlanError` carries it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from wpcal.core.errors import ConvergenceError


class Constraint(Enum):
    """A kind of limit, by the name that messages and records give it."""

    REACH = "reach"
    JOINT_LIMITS = "joint limits"
    SINGULAR_POSES = "singular poses"
    CLEARANCE = "clearance"
    TORCH_ANGLES = "torch angles"
    WELD_POSITION = "weld position"
    WELD_ZONE = "weld zone"
    JOINT_SPEEDS = "joint speeds"


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle:
    """The limit that is hardest to keep."""

    constraint: Constraint
    says: str  #: What was found, where, and what was asked, for people.
    advice: str = ""  #: The relaxation that would help; empty if none is known.
    s_mm: float | None = None  #: Place along the seam, mm.
    between: tuple[str, str] | None = None  #: Two bodies that are too near to each other.
    robot: int | None = None  #: 1 or 2.
    joint: str | None = None  #: Name on the pendant.
    #: `best`, `asked`: The best value that was attained at this place, and the value that is asked, in `unit`.
    best: float | None = None
    asked: float | None = None
    unit: str = ""  #: ``mm``, ``deg``, ``mm/s``, or empty.

    def describe(self) -> str:
        """Say what was found and what would help."""
        return f"{self.says}; {self.advice}" if self.advice else self.says

    def to_record(self) -> dict[str, Any]:
        """Return plain values for ``pareto.json``."""
        return {
            "constraint": self.constraint.value,
            "says": self.says,
            "advice": self.advice,
            "s_mm": self.s_mm,
            "between": None if self.between is None else list(self.between),
            "robot": self.robot,
            "joint": self.joint,
            "best": self.best,
            "asked": self.asked,
            "unit": self.unit,
        }


class NoFeasiblePlanError(ConvergenceError):
    """The search found no feasible plan."""

    def __init__(self, why: str, obstacle: Obstacle | None = None) -> None:
        self.obstacle = obstacle
        found = "" if obstacle is None else f": {obstacle.describe()}"
        super().__init__(f"no feasible plan: {why}{found}")


def too_near(between: tuple[str, str], s_mm: float, best_mm: float, asked_mm: float, advice: str = "") -> Obstacle:
    """Return the obstacle of two bodies that do not keep their distance.

    Parameters
    ----------
    s_mm : Place along the seam, mm.
    best_mm, asked_mm : float
        Largest distance that was attained there, and the safety distance, mm. Capsules that overlap have a negative
        distance.
    """
    one, two = between
    found = f"{best_mm:.1f} mm" if best_mm >= 0 else f"overlapping by {-best_mm:.1f} mm"
    return Obstacle(
        constraint=Constraint.CLEARANCE,
        says=f"{one} and {two}: at best {found} at s = {s_mm:.1f} mm, {asked_mm:g} mm asked",
        advice=advice,
        s_mm=s_mm,
        between=between,
        best=best_mm,
        asked=asked_mm,
        unit="mm",
    )
