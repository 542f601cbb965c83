"""Rings that sit in a groove: a tyre on its rim, a seal in its seat, a pulley between two collars of one shaft.

A ring that is narrower than the other solid on both sides of its seat cannot have been put there as it is: it was
stretched, snapped in, or moulded round. A ring that is welded slides onto its seat from one side. One solid that was
several, such as a shaft with two discs, may hold a ring that was welded before the second disc; so this is a doubt.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import off_axis
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.seam.find.built_up import ROUND_KINDS, is_turned

SAME_AXIS_MM, SAME_AXIS_SIN = 0.2, 2e-3  #: Axes nearer and more parallel than this are one.
THICKEST_GASKET_MM, FEWEST_BOLTS = 5.0, 3
"""Gaskets, and raised faces of flanges, are at most this thick; a flange has at least this many bolts."""
SHOULDER_MM = 0.5  #: A shoulder stands out by more than this: a thread or a press fit is less.
SAME_WIDTH = 0.05  #: Rings end together if their ends are this near, in widths: the shield of a bearing is set back.


class _RoundFace(NamedTuple):
    """One face about an axis: from where to where it is along the axis, and how far from it, mm."""

    is_cylinder: bool
    low: float
    high: float
    least: float
    most: float


def is_ring_in_ring(graph: BrepGraph, trimmed: TrimmedFaces, ring: int, other: int, gap_mm: float) -> bool:
    """Tell whether a ring fills the bore of another one, and both end on both sides; largest play in mm."""
    if not (is_turned(graph, trimmed, ring) and is_turned(graph, trimmed, other)):
        return False
    sides = [[_about(graph, trimmed, ring, solid, way, round_=False) for way in (-1, 1)] for solid in (ring, other)]
    if not all(map(all, sides)):
        return False
    ends = np.array([(min(one.low for one in own), max(one.high for one in own)) for own in (a + b for a, b in sides)])
    if np.abs(ends[0] - ends[1]).max() > SAME_WIDTH * (ends[:, 1] - ends[:, 0]).max():
        return False
    return any(abs(mine.most - seat.most) <= gap_mm for mine in sides[0][1] for seat in sides[1][0])


def is_gasket(graph: BrepGraph, trimmed: TrimmedFaces, ring: int, other: int, gap_mm: float) -> bool:
    """Tell whether a thin ring lies flat on another solid, inside a circle of its bolt holes; largest gap in mm."""
    if not is_turned(graph, trimmed, ring):
        return False
    o, z = _axis(graph, ring)
    bore, outside = (_about(graph, trimmed, ring, ring, way) for way in (-1, 1))
    if not bore or not outside:
        return False
    ends = np.array([(face.low, face.high, face.most) for face in outside])
    low, high, most = ends[:, 0].min(), ends[:, 1].max(), ends[:, 2].max()
    is_plane = (graph.face_solid == other) & (graph.face_kind == SurfaceKind.PLANE)
    planes = np.flatnonzero(is_plane & (np.linalg.norm(np.cross(graph.face_frame[:, 3], z), axis=1) <= SAME_AXIS_SIN))
    height = (graph.face_frame[planes, 0] - o) @ z
    is_on = (np.minimum(np.abs(height - low), np.abs(height - high)) <= gap_mm) & (high - low <= THICKEST_GASKET_MM)
    hollow = (graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward < 0) & (graph.face_solid == other)
    off = off_axis(graph.face_frame[hollow, 0], o, z) - graph.face_param[hollow, 0]
    around = off[off >= most]
    return bool(is_on.any() and len(around) >= FEWEST_BOLTS) and bool(np.ptp(around) <= SAME_AXIS_MM)


def is_held_fast(graph: BrepGraph, trimmed: TrimmedFaces, ring: int, other: int, gap_mm: float) -> bool:
    """Tell whether a solid holds a ring between two shoulders: round its bore, or in a groove; largest play in mm."""
    if not is_turned(graph, trimmed, ring):
        return False
    for outward in (-1, 1):  # the bore of the ring on a seat, or its outside in a groove
        held = _about(graph, trimmed, ring, other, -outward)
        for mine in _about(graph, trimmed, ring, ring, outward, round_=False):
            for seat in held:
                fits = seat.is_cylinder and abs(seat.most - mine.most) <= gap_mm
                if fits and min(seat.high, mine.high) > max(seat.low, mine.low) and _shoulders(seat, held, -outward):
                    return True
    return False


def _shoulders(seat: _RoundFace, faces: list[_RoundFace], outward: int) -> bool:
    """Tell whether faces stand out beyond a seat on both sides of it: wider on a shaft, narrower in a bore."""
    out = [
        face
        for face in faces
        if (face.most > seat.most + SHOULDER_MM if outward > 0 else face.least < seat.least - SHOULDER_MM)
    ]
    middle = (seat.low + seat.high) / 2
    return any(face.high <= middle for face in out) and any(face.low >= middle for face in out)


def _axis(graph: BrepGraph, ring: int) -> tuple[FloatArray, FloatArray]:
    """Return a point on the axis of a turned solid, and its direction."""
    face = np.flatnonzero((graph.face_solid == ring) & np.isin(graph.face_kind, ROUND_KINDS))[0]
    return graph.face_frame[face, 0], graph.face_frame[face, 3]


def _about(
    graph: BrepGraph, trimmed: TrimmedFaces, ring: int, solid: int, outward: int, *, round_: bool = True
) -> list[_RoundFace]:
    """Return the faces of a solid about the axis of a ring that look away from it (`outward` +1), or towards it (-1).

    `round_`: Whether cones and spheres are wanted beside cylinders.
    """
    o, z = _axis(graph, ring)
    kinds = ROUND_KINDS if round_ else (SurfaceKind.CYLINDER,)
    faces = np.flatnonzero(
        (graph.face_solid == solid) & np.isin(graph.face_kind, kinds) & (graph.face_outward * outward > 0)
    )
    off = off_axis(graph.face_frame[faces, 0], o, z)
    turn = np.linalg.norm(np.cross(graph.face_frame[faces, 3], z), axis=1)
    found = []
    for face in faces[(off <= SAME_AXIS_MM) & (turn <= SAME_AXIS_SIN)].tolist():
        points = trimmed.p0[trimmed.start[face] : trimmed.start[face + 1]] - o
        if len(points):
            along, across = points @ z, off_axis(points, np.zeros(3), z)
            is_cylinder = bool(graph.face_kind[face] == SurfaceKind.CYLINDER)
            found.append(_RoundFace(is_cylinder, along.min(), along.max(), across.min(), across.max()))
    return found
