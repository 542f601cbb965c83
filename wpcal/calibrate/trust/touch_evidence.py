"""What only a fit of touches has: what each touch lies on, what holds the part, and what many starts found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from wpcal.core.transform import RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class RivalPlace:
    """Another place of the part that the touches cannot tell from the answer, with 95 % confidence."""

    T: RigidTransform  #: ``T_base_part`` there.
    rms_mm: float  #: Root mean square residual there.
    apart_mm: float  #: The furthest that a point of the seams lies from its place in the answer.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {"T_base_part": self.T.matrix.tolist(), "rms_mm": self.rms_mm, "apart_mm": self.apart_mm}


@dataclass(frozen=True, slots=True)
class StartsEvidence:
    """What many starts found. It takes the place of a proof, which exists for points only."""

    starts: int
    agreeing: int  #: Starts that ended at the answer.
    #: Root mean square residual of the best other place where a start ended. None if there is no other place.
    next_best_rms_mm: float | None
    rivals: tuple[RivalPlace, ...] = ()  #: Other places that the touches do not exclude, best first.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        found = {"starts": self.starts, "agreeing": self.agreeing, "next_best_rms_mm": self.next_best_rms_mm}
        return {**found, "rivals": [rival.to_record() for rival in self.rivals]} if self.rivals else found


@dataclass(frozen=True, slots=True)
class HeldMotion:
    """One of the six motions of the part, and the touches that hold it."""

    motion: str  #: In words, in coordinates of the part.
    singular_value: float  #: Change of all residuals, mm, by 1 mm of that motion at the touches' own radius.
    held_by: tuple[str, ...]  #: Names of touches. The one that holds most comes first.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {"motion": self.motion, "singular_value": self.singular_value, "held_by": list(self.held_by)}


@dataclass(frozen=True, slots=True)
class TouchEvidence:
    """The part of a `CalibrationResult` that only touches on faces and edges have."""

    lies_on: tuple[str, ...]  #: length n. What each fitted touch lies on, in words.
    starts: StartsEvidence
    motions: tuple[HeldMotion, ...]  #: length 6. The best held motion comes first.

    def to_record(self, names: Sequence[str]) -> dict[str, Any]:
        """Return plain values for a JSON file; `names` are those of the fitted touches."""
        return {
            "lies_on": dict(zip(names, self.lies_on, strict=True)),
            "evidence": self.starts.to_record(),
            "freedoms": [motion.to_record() for motion in self.motions],
        }
