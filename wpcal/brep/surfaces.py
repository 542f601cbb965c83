"""Nearest points and outward normals on the surfaces of faces, many at once; in closed form except for NURBS.

Parameters (u, v) of a point: plane x, y (mm); cylinder and cone: angle about z and height along z; sphere: longitude
and latitude; torus: angle about z and angle about the tube; NURBS: its own. They are for the trimming test (`trim.py`)
and differ from those in the CAD file.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.core.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Foot:
    """The nearest points of surfaces (not trimmed) to given points."""

    p: FloatArray  #: shape (m, 3). In `part`, mm.
    normal: FloatArray  #: shape (m, 3). Outward unit normal of the face there, in `part`.
    uv: FloatArray  #: shape (m, 2).


def off_axis(points: FloatArray, o: FloatArray, z: FloatArray) -> FloatArray:
    """Return the distance of points of shape (n, 3) from the axis through `o` along the unit vector `z`, shape (n,)."""
    arm = points - o
    return np.asarray(np.linalg.norm(arm - (arm @ z)[:, None] * z, axis=1), dtype=np.float64)


def part_across(vectors: FloatArray, ways: FloatArray) -> FloatArray:
    """Return the part of vectors, shape (n, 3), across unit vectors of that shape."""
    return np.asarray(vectors - np.einsum("ki,ki->k", vectors, ways)[:, None] * ways, dtype=np.float64)


def project_to_faces(graph: BrepGraph, faces: ArrayLike, points: ArrayLike) -> Foot:
    """Find the nearest point of each face's whole surface to a point.

    `faces`: array_like of int, shape (m,).
    `points`: shape (m, 3). In `part`, mm.
    Returns Foot. On the axis or at the centre all directions are equally near; the x direction of the frame is taken.
    """
    f, points = np.asarray(faces, dtype=np.int64), np.asarray(points, dtype=np.float64)
    frame = graph.face_frame[f]
    kinds = graph.face_kind[f]
    p, n, uv = _project_elementary(kinds, frame, graph.face_param[f], points)
    free = np.flatnonzero(kinds == SurfaceKind.NURBS)
    if len(free):
        surface, nearest = graph.face_nurbs[f[free]], graph.nearest_on_nurbs
        uv[free] = nearest.project(surface, points[free])
        p[free], du, dv = nearest.surfaces.evaluate(surface, uv[free])
        n[free] = unit(np.cross(du, dv))
    return Foot(p, n * graph.face_outward[f][:, None], uv)


def offsets_from_faces(graph: BrepGraph, faces: IntArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far points lie outside of surfaces that have a closed form.

    Returns `offset`: ndarray, shape (m,). Along the outward normal, mm; negative inside.
    Returns `uv`: ndarray, shape (m, 2).

    `faces`: shape (m,). None of them free-form.
    `points`: shape (m, 3). In `part`, mm.
    """
    frame, kinds, param = graph.face_frame[faces], graph.face_kind[faces], graph.face_param[faces]
    local = (frame[:, 1:] @ (points - frame[:, 0])[..., None])[..., 0]
    offset, uv = np.empty(len(local)), np.empty((len(local), 2))
    for kind in np.unique(kinds).tolist():
        rows = np.flatnonzero(kinds == kind)
        at = local[rows]
        foot, normal, uv[rows] = _CLOSED_FORMS[kind](at, param[rows])
        offset[rows] = np.einsum("mi,mi->m", at - foot, normal)
    return offset * graph.face_outward[faces], uv


def surface_normals(kinds: IntArray, frames: FloatArray, params: FloatArray, points: FloatArray) -> FloatArray:
    """Return the own normals (plane: z; others: away from axis or centre) of elementary surfaces nearest to points.

    Returns ndarray, shape (m, 3). Unit vectors in `part`.

    `kinds`, `frames`, `params`: shapes (m,), (m, 4, 3), (m, 2). As `face_kind`, `face_frame` and `face_param` of a
    `BrepGraph`.
    `points`: shape (m, 3). In `part`, mm.
    """
    return _project_elementary(kinds, frames, params, points)[1]


def _project_elementary(
    kinds: IntArray, frame: FloatArray, param: FloatArray, points: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return nearest points, own normals and parameters; zero for kinds without a closed form."""
    local = np.einsum("mij,mj->mi", frame[:, 1:], points - frame[:, 0])
    foot, normal, uv = np.zeros_like(local), np.zeros_like(local), np.zeros((len(local), 2))
    for kind in np.flatnonzero(np.bincount(kinds, minlength=len(_CLOSED_FORMS))[: len(_CLOSED_FORMS)]).tolist():
        rows = np.flatnonzero(kinds == kind)
        foot[rows], normal[rows], uv[rows] = _CLOSED_FORMS[kind](local[rows], param[rows])
    axes = frame[:, 1:]
    return frame[:, 0] + np.einsum("mij,mi->mj", axes, foot), np.einsum("mij,mi->mj", axes, normal), uv


def unit(v: FloatArray) -> FloatArray:
    """Return vectors of unit length, shape (..., 3); zero where they are zero."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.asarray(v / np.where(length > 0, length, 1.0), dtype=np.float64)


def square_to(v: FloatArray) -> FloatArray:
    """Return a unit vector square to each vector, shape (..., 3)."""
    return unit(np.cross(v, np.eye(3)[np.argmin(np.abs(v), axis=-1)]))


def _radial(local: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the unit direction away from the z axis (m, 2) and the angle about it (m,)."""
    angle = np.arctan2(local[:, 1], local[:, 0])
    return np.stack([np.cos(angle), np.sin(angle)], axis=1), angle


def _on_plane(local: FloatArray, _: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    uv = local[:, :2]
    return np.column_stack([uv, np.zeros(len(uv))]), np.broadcast_to([0.0, 0.0, 1.0], local.shape), uv


def _on_cylinder(local: FloatArray, param: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    out, angle = _radial(local)
    z = local[:, 2]
    foot = np.column_stack([out * param[:, :1], z])
    return foot, np.column_stack([out, np.zeros(len(z))]), np.column_stack([angle, z])


def _on_cone(local: FloatArray, param: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    out, angle = _radial(local)
    r0, half = param.T
    rho, z = np.linalg.norm(local[:, :2], axis=1), local[:, 2]
    along = (rho - r0) * np.sin(half) + z * np.cos(half)
    r, h = r0 + along * np.sin(half), along * np.cos(half)
    # beyond the apex the other nappe begins: r < 0 turns the radial direction over
    normal = np.column_stack([out * np.cos(half)[:, None], -np.sin(half)])
    return np.column_stack([out * r[:, None], h]), normal, np.column_stack([angle, h])


def _on_sphere(local: FloatArray, param: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    length = np.linalg.norm(local, axis=1, keepdims=True)
    out = np.where(length > 0, local / np.where(length > 0, length, 1.0), [1.0, 0.0, 0.0])
    uv = np.column_stack([np.arctan2(out[:, 1], out[:, 0]), np.arcsin(np.clip(out[:, 2], -1.0, 1.0))])
    return out * param[:, :1], out, uv


def _on_torus(local: FloatArray, param: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    out, angle = _radial(local)
    centre = np.column_stack([out * param[:, :1], np.zeros(len(local))])
    tube = local - centre
    length = np.linalg.norm(tube, axis=1, keepdims=True)
    normal = np.where(length > 0, tube / np.where(length > 0, length, 1.0), np.column_stack([out, np.zeros(len(out))]))
    v = np.arctan2(normal[:, 2], (normal[:, :2] * out).sum(axis=1))
    return centre + normal * param[:, 1:], normal, np.column_stack([angle, v])


_CLOSED_FORMS: dict[int, Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]] = {
    SurfaceKind.PLANE: _on_plane,
    SurfaceKind.CYLINDER: _on_cylinder,
    SurfaceKind.CONE: _on_cone,
    SurfaceKind.SPHERE: _on_sphere,
    SurfaceKind.TORUS: _on_torus,
}
