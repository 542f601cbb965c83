"""The part that touches locate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import Material
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam.seam import Seam
from wpcal.taught.features.reference import ReferenceFeature
from wpcal.touch.advise.moved_model import Tacked


@dataclass(frozen=True, slots=True, eq=False)
class TouchPart:
    """The part that is located."""

    name: str  #: File name.
    graph: BrepGraph
    trimmed: TrimmedFaces
    seams: Sequence[Seam]  #: Where the error counts; frames in `part`.
    features: Sequence[ReferenceFeature] = ()  #: Their names are written into the plan.
    #: Its solids, with which the torch is compared: triangles are fast. None: the exact faces.
    material: Material | None = None
    tacked: Tacked | None = None  #: The bodies that may move; None: the part moves as one.
