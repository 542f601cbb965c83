"""Round tubes inside solids: two cylinders about one axis with a thin wall between them, longer than they are wide."""

from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import off_axis
from wpcal.brep.trim import TrimmedFaces, once_per_solid
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

THIN_WALL = 0.6  #: The bore of a tube has this share of its diameter or more: bushes and rollers have thicker walls.
SAME_SIN, SAME_MM = 1e-4, 1e-2
"""Two cylinders are about one axis within this: the sine of the angle, and the distance."""


@dataclass(frozen=True, slots=True, eq=False)
class Tubes:
    """The faces of round tubes; a tube may have several outer faces and several inner ones."""

    face: IntArray  #: shape (n,). Ascending.
    axis: IntArray  #: shape (n,). Faces of one tube have one number.
    wall_mm: FloatArray  #: shape (n,). Thickness of the wall.
    outer: BoolArray  #: shape (n,).


@once_per_solid
def find_tubes(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> Tubes:
    """Find the round tubes in a solid.

    Returns Tubes. Cylinders of one radius about one axis are one tube, also where something is between them.
    """
    faces = np.flatnonzero((graph.face_solid == solid) & (graph.face_kind == SurfaceKind.CYLINDER))
    axis, low, high = _axes(graph, trimmed, faces)
    radius, outward = graph.face_param[faces, 0], graph.face_outward[faces] > 0
    wall = np.full(len(faces), np.nan)
    for number in np.unique(axis).tolist():
        own = np.flatnonzero(axis == number)
        outer, bore = own[outward[own]], own[~outward[own]]
        for row in outer.tolist():
            same = outer[np.abs(radius[outer] - radius[row]) <= SAME_MM]
            is_long = high[same].max() - low[same].min() > 2.0 * radius[row]
            share = radius[bore] / radius[row]
            beside = (low[bore] < high[row]) & (high[bore] > low[row])
            fits = bore[(share >= THIN_WALL) & (share < 1.0) & beside]
            if is_long and len(fits):
                inner = fits[np.argmax(radius[fits])]
                wall[row] = radius[row] - radius[inner]
                around = bore[np.abs(radius[bore] - radius[inner]) <= SAME_MM]
                wall[around] = wall[row]
    rows = np.flatnonzero(np.isfinite(wall))
    return Tubes(faces[rows], axis[rows], wall[rows], outward[rows])


def _axes(graph: BrepGraph, trimmed: TrimmedFaces, faces: IntArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the number of the axis of each cylinder, and from where to where along it its border runs."""
    o, z = graph.face_frame[faces, 0], graph.face_frame[faces, 3]
    axis = np.full(len(faces), -1)
    low, high = np.zeros(len(faces)), np.zeros(len(faces))
    for row in range(len(faces)):
        if axis[row] < 0:
            off = off_axis(o, o[row], z[row])
            same = (np.linalg.norm(np.cross(z, z[row]), axis=1) <= SAME_SIN) & (off <= SAME_MM) & (axis < 0)
            axis[same] = row
        along = trimmed.heights(int(faces[row]), z[axis[row]])
        low[row], high[row] = (along.min(), along.max()) if len(along) else (0.0, 0.0)
    return axis, low, high
