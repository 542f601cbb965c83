"""The options by which seams are found, accepted and cut into frames."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.core.errors import InputError
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam.limits import LEAST_SEAM_MM, MEETING_MM, MOST_BRIDGE_MM, Level, usual_gap_mm

MOST_LEAN_DEG = 60.0
"""At a square fillet a torch that leans by 45 degrees from the bisector lies on a plate."""


class ConcaveEdges(Enum):
    """Whether concave edges inside one solid are taken as seams."""

    ALWAYS = "always"
    NEVER = "never"
    AUTO = "auto"


@dataclass(frozen=True, slots=True)
class StepOptions:
    """How a seam is cut into steps.

    Raises
    ------
    InputError : If a value is not positive, or the least step is larger than the largest.
    """

    chord_mm: float = 0.1  #: Largest distance of the seam from the chord between neighbouring points, mm.
    #: Points nearer than this to their neighbour are removed where the chord bound allows it, mm.
    min_step_mm: float = 1.0
    max_step_mm: float = 10.0  #: Largest distance along the seam between neighbours, mm.
    #: Largest turn of the frame between neighbours, rad. It takes precedence over the least step.
    turn_rad: float = float(np.radians(45.0))

    def __post_init__(self) -> None:
        for name in ("chord_mm", "max_step_mm", "turn_rad"):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} must be positive, got {getattr(self, name)}")
        if not 0 <= self.min_step_mm <= self.max_step_mm:
            raise InputError(f"min_step_mm must be between 0 and max_step_mm, got {self.min_step_mm}")


@dataclass(frozen=True, slots=True)
class Judging:
    """What a person says about members, and how sure a seam must be."""

    #: Names of solids that can be welded, whatever the evidence; ``*`` and ``?`` match any letters. The name of a
    #: product or an instance above stands for all solids in it.
    weld: tuple[str, ...] = ()
    #: Names of solids that are not welded. If both fit a solid, the name with more letters counts.
    not_welded: tuple[str, ...] = ()
    level: Level = Level.USUAL


@dataclass(frozen=True, slots=True)
class Play:
    """A gap that several joints of an assembly have."""

    #: `least_mm`, `gap_mm`, `most_mm`: The narrowest, the median and the widest of these gaps.
    least_mm: float
    gap_mm: float
    most_mm: float
    joints: int  #: How many joints have it.


@dataclass(frozen=True, slots=True)
class Reach:
    """The torch with which reach is judged, and how far it may lean and turn.

    Raises
    ------
    InputError : If a range does not hold 0, or goes beyond 60 degrees (the spin: 180).
    """

    torch: TorchShape = USUAL_TORCH
    #: `work_deg`, `travel_deg`: Least and largest angle across and along the seam; positive travel is push.
    work_deg: tuple[float, float] = (-15.0, 15.0)
    travel_deg: tuple[float, float] = (-35.0, 35.0)
    #: Least and largest turn of a bent neck about the wire; at 0 it bends against the travel.
    spin_deg: tuple[float, float] = (-180.0, 180.0)

    def __post_init__(self) -> None:
        for name, most in (("work", MOST_LEAN_DEG), ("travel", MOST_LEAN_DEG), ("spin", 180.0)):
            low, high = getattr(self, f"{name}_deg")
            if not -most <= low <= 0.0 <= high <= most:
                raise InputError(
                    f"{name} angles of the torch: expected a range around 0 within {most:g} degrees either way, got "
                    f"{low:g} to {high:g}"
                )


@dataclass(frozen=True, slots=True)
class SeamOptions:
    """How seams are found, accepted and cut into frames.

    Raises
    ------
    InputError : If a length is negative or not finite.
    """

    #: Largest gap between members; by default 0.5 mm, on parts smaller than 200 mm 0.25 % of their diagonal.
    gap_mm: float | None = None
    #: `AUTO` takes concave edges of solids that touch no other solid and may be built up of plates, bars and tubes
    #: (`built_up.why_one_piece`).
    concave: ConcaveEdges = ConcaveEdges.AUTO
    split_rad: float = float(np.radians(30.0))  #: A seam ends where its direction turns by more, rad.
    steps: StepOptions = field(default_factory=StepOptions)
    min_length_mm: float = LEAST_SEAM_MM  #: Least length of an accepted seam, mm.
    join_mm: float = MOST_BRIDGE_MM  #: Contacts in one line are joined across interruptions of at most this length, mm.
    judging: Judging = Judging()
    reach: Reach = Reach()
    #: Whether accepted seams that meet at a corner of a member are welded in one run round it, with the short ends
    #: between them (`judge.wrapping`).
    wrap: bool = False
    #: The gaps that joints of this part have by design; by default they are measured (`find.play`).
    play: tuple[Play, ...] | None = None

    def __post_init__(self) -> None:
        for name in ("min_length_mm", "join_mm"):
            if not 0 <= getattr(self, name) < np.inf:
                raise InputError(f"{name} must be 0 or more, got {getattr(self, name)}")

    def gap_for(self, graph: BrepGraph) -> float:
        """Return the gap to use on a part, mm."""
        return usual_gap_mm(graph.size_mm) if self.gap_mm is None else self.gap_mm

    @property
    def most_join_mm(self) -> float:
        """How far the ends of two seams that a person joins may be from each other, mm."""
        return max(MEETING_MM, self.join_mm)

    @property
    def min_edge_mm(self) -> float:
        """Least length of a concave edge, and of a bead's side, that is considered, mm.

        It never exceeds the default: a long seam may consist of edges that are shorter than the seam must be.
        """
        return min(self.min_length_mm, LEAST_SEAM_MM)
