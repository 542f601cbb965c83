"""How seams are found and cut into frames."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.seam.path.discretise import StepOptions

LARGEST_GAP_MM = 0.5
"""A gap that a fillet of usual size bridges."""
GAP_SHARE = 2.5e-3
"""On parts smaller than 200 mm the gap is this share of the diagonal: 0.5 mm would join everything on a small part."""


class ConcaveEdges(Enum):
    """Whether concave edges inside one solid are taken as seams."""

    ALWAYS = "always"
    NEVER = "never"
    AUTO = "auto"


@dataclass(frozen=True, slots=True)
class SeamOptions:
    """How seams are found and cut into frames.

    Parameters
    ----------
    gap_mm : float, optional
        Largest gap between members; by default 0.5 mm, on parts smaller than 200 mm 0.25 % of their diagonal.
    concave : ConcaveEdges
        `AUTO` takes concave edges of solids that touch no other solid and do not look machined
        (`concave.looks_machined`).
    split_rad : float
        A seam ends where its direction turns by more, rad.
    steps : StepOptions
    """

    gap_mm: float | None = None
    concave: ConcaveEdges = ConcaveEdges.AUTO
    split_rad: float = float(np.radians(30.0))
    steps: StepOptions = field(default_factory=StepOptions)

    def gap_for(self, graph: BrepGraph) -> float:
        """Return the gap to use on a part, mm."""
        return min(LARGEST_GAP_MM, GAP_SHARE * graph.size_mm) if self.gap_mm is None else self.gap_mm
