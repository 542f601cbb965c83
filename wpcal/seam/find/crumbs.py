"""Solids that are too small to be members: what a cut or a failed union leaves behind in a drawing."""

from __future__ import annotations

import numpy as np

from wpcal.brep.boxes import boxes_of_solids
from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray
from wpcal.seam.limits import LEAST_SEAM_MM


def are_crumbs(graph: BrepGraph, trimmed: TrimmedFaces) -> BoolArray:
    """Tell which solids are crumbs: the diagonal of their box is shorter than the shortest seam, shape (S,).

    A solid that touches crumbs only is searched for welds inside it, as if it stood alone.
    """
    low, high = boxes_of_solids(graph.face_solid, trimmed.face_box, len(graph.solid_names))
    return np.asarray(np.linalg.norm(np.maximum(high - low, 0.0), axis=1) < LEAST_SEAM_MM, dtype=bool)
