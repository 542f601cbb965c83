"""Which face a person or a search touches at a point of the model, and how far its border is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.taught.kinds import TouchKind

NEAR_MM = 0.5
"""Faces this much farther away than the nearest one may be meant, too: a click is on triangles, not on the face."""
KIND_OF = {
    SurfaceKind.PLANE: TouchKind.PLANE,
    SurfaceKind.SPHERE: TouchKind.SPHERE,
    SurfaceKind.CYLINDER: TouchKind.CYLINDER,
}


@dataclass(frozen=True, slots=True, eq=False)
class TouchedFace:
    """A point on a face."""

    face: int
    kind: TouchKind  #: What the face is in a taught table.
    p_part: FloatArray  #: shape (3,). On the face, mm.
    normal_part: FloatArray  #: shape (3,). Outward unit normal there.
    border_mm: float | None  #: Distance from the border of the face; None of a whole sphere or torus, which has none.


def touched_face(trimmed: TrimmedFaces, point: FloatArray, normal: FloatArray | None = None) -> TouchedFace:
    """Find the face at a point.

    `point`: shape (3,). In `part`, mm; on the face or near to it.
    `normal`: shape (3,). Outward normal as far as it is known: it decides between faces that are equally near.
    Raises `InputError` when the part has no face with a surface.
    """
    graph = trimmed.graph
    low, high = trimmed.face_box
    away = np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0), axis=1)
    away[(graph.face_kind == SurfaceKind.NONE) | ~np.isfinite(away)] = np.inf
    most = np.linalg.norm(np.maximum(np.abs(point - low), np.abs(point - high)), axis=1)
    most = most[np.isfinite(away)].min(initial=np.inf)
    faces = np.flatnonzero(np.isfinite(away) & (away <= most + NEAR_MM))
    if len(faces) == 0:
        raise InputError("the part has no face to touch")
    at = np.broadcast_to(point, (len(faces), 3))
    foot = project_to_faces(graph, faces, at)
    inside = trimmed.contains(faces, foot.uv)
    distance = np.linalg.norm(foot.p - at, axis=1)
    distance[~inside] = trimmed.boundary_distance(faces[~inside], at[~inside])
    near = np.flatnonzero(distance <= distance.min() + NEAR_MM)
    best = near[np.argmin(distance[near])] if normal is None else near[np.argmax(foot.normal[near] @ normal)]
    face, p = int(faces[best]), foot.p[best]
    border = float(trimmed.boundary_distance(np.array([face]), p[None])[0])
    border_mm = (border if np.isfinite(border) else None) if inside[best] else 0.0
    return TouchedFace(face, _kind_of(trimmed, face), p, foot.normal[best], border_mm)


def _kind_of(trimmed: TrimmedFaces, face: int) -> TouchKind:
    surface = SurfaceKind(int(trimmed.graph.face_kind[face]))
    if surface is SurfaceKind.CYLINDER and trimmed.graph.face_outward[face] < 0:
        return TouchKind.HOLE
    return KIND_OF.get(surface, TouchKind.SURFACE)
