"""The part that touches locate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import Material
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.tangent import point_jacobian
from wpcal.seam.seam import Seam
from wpcal.taught.features.reference import ReferenceFeature
from wpcal.touch.plan.options import NominalError
from wpcal.touch.weldment import Tacked


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


@dataclass(frozen=True, slots=True, eq=False)
class PartPlace:
    """The part as it stands: what candidates are measured against, in `part`."""

    up: FloatArray  #: shape (3,). Against gravity.
    centre: FloatArray  #: shape (3,). Middle of its box.
    size_mm: float  #: Half the diagonal of the box.
    #: `floor_mm`, `top_mm`: Lowest and highest level along `up`.
    floor_mm: float
    top_mm: float
    tacked: Tacked | None = None  #: Its bodies, if they may move; None: the part moves as one.

    @classmethod
    def of(cls, trimmed: TrimmedFaces, up: FloatArray, tacked: Tacked | None = None) -> PartPlace:
        """Measure the boxes of the faces. `up`: shape (3,). Against gravity, in `part`."""
        low, high = trimmed.face_box
        some = np.isfinite(low).all(axis=1)
        least, most = low[some].min(axis=0), high[some].max(axis=0)
        levels = np.where(up >= 0, low[some], high[some]) @ up, np.where(up >= 0, high[some], low[some]) @ up
        size = float(np.linalg.norm(most - least)) / 2.0
        return cls(up, (least + most) / 2.0, size, float(levels[0].min()), float(levels[1].max()), tacked)

    def body_of(self, face: IntArray) -> IntArray:
        """Return the body of faces, shape (n,); -1 where none may move."""
        return np.full(len(face), -1) if self.tacked is None else self.tacked.face_body[face]

    def covariances(self, p: FloatArray, face: IntArray, nominal: NominalError) -> FloatArray:
        """Return the covariance of places of the part, with the motion of their body, mm², shape (n, 3, 3).

        `p`: shape (n, 3). In `part`, mm.
        `face`: shape (n,).
        """
        return nominal.covariances(p, self.centre) + self.of_bodies(p, face)

    def of_bodies(self, p: FloatArray, face: IntArray) -> FloatArray:
        """Return the part of the covariance that comes from the motion of the body, mm², shape (n, 3, 3).

        `p`, of shape (n, 3), is in `part`, mm; `face` has the shape (n,).
        """
        found = np.zeros((len(p), 3, 3))
        body = self.body_of(face)
        some = np.flatnonzero(body >= 0)
        if self.tacked is not None and len(some):
            bodies = self.tacked.bodies
            J = point_jacobian(p[some] - bodies.centroid_part[body[some]])
            found[some] = np.einsum("nij,nj,nkj->nik", J, bodies.scales[body[some]] ** 2, J)
        return found
