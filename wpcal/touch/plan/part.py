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
    """The part that is located.

    Parameters
    ----------
    name : str
        File name.
    seams : sequence of Seam
        Where the error counts; frames in `part`.
    features : sequence of ReferenceFeature
        Their names are written into the plan.
    material : Material or None
        Its solids, with which the torch is compared: triangles are fast. None: the exact faces.
    tacked : Tacked or None
        The bodies that may move; None: the part moves as one.
    """

    name: str
    graph: BrepGraph
    trimmed: TrimmedFaces
    seams: Sequence[Seam]
    features: Sequence[ReferenceFeature] = ()
    material: Material | None = None
    tacked: Tacked | None = None
