"""The faces, edges and points of a part as targets of touches."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.nearest_on_edges import project_to_edges
from wpcal.brep.surfaces import offsets_from_faces, project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate.observe.touches import Nearest, Touches
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.linked import near_tree
from wpcal.core.pairs import PointPairs

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

GRID = 48
"""Samples each way on a free-form face for the annealer: on a face of 500 mm they lie 10 mm apart, and the tangent
plane of the nearest is then off by 25 / radius mm."""
ON_SURFACE_MM = 1e-3  #: Surfaces of two faces are one when they are this near: files are written with three decimals.
SAME_LINE_COS = 1.0 - 1e-9  #: Cosine of directions that are one; 1e-9 is 0.003 degrees, 1e-3 mm on the size of a hole.


class TargetKind(IntEnum):
    """What a touch lies on."""

    POINT = 0
    FACE = 1
    EDGE = 2


def faces_on_surface(graph: BrepGraph, face: int) -> IntArray:
    """Return the faces of a solid that lie on one plane, cylinder or sphere with a face, itself among them.

    Returns ndarray of int. The face alone where it lies on another kind of surface.
    """
    kind = graph.face_kind[face]
    if kind not in (SurfaceKind.PLANE, SurfaceKind.CYLINDER, SurfaceKind.SPHERE):
        return np.array([face])
    mine, frames = graph.face_frame[face], graph.face_frame
    arm, cosine = frames[:, 0] - mine[0], frames[:, 3] @ mine[3]
    along = arm @ mine[3]
    side = graph.face_outward * (np.sign(cosine) if kind == SurfaceKind.PLANE else 1.0)
    same = (graph.face_kind == kind) & (graph.face_solid == graph.face_solid[face]) & (side == graph.face_outward[face])
    if kind == SurfaceKind.PLANE:
        near = np.abs(along)
    else:
        same &= np.abs(graph.face_param[:, 0] - graph.face_param[face, 0]) <= ON_SURFACE_MM
        near = np.linalg.norm(arm - (along[:, None] * mine[3] if kind == SurfaceKind.CYLINDER else 0.0), axis=1)
    if kind != SurfaceKind.SPHERE:
        same &= np.abs(cosine) >= SAME_LINE_COS
    return np.flatnonzero(same & (near <= ON_SURFACE_MM))


@dataclass(frozen=True, eq=False)
class GraphTargets:
    """Targets on a `BrepGraph`, one a touch."""

    trimmed: TrimmedFaces  #: Of the part's graph.
    kind: IntArray  #: shape (n,). `TargetKind`.
    index: IntArray  #: shape (n,). Face or edge of the graph; -1 for points.
    point: FloatArray  #: shape (n, 3). In `part`, mm; NaN for faces and edges.

    @property
    def graph(self) -> BrepGraph:
        """The part."""
        return self.trimmed.graph

    def joined(self, other: GraphTargets) -> tuple[GraphTargets, int]:
        """As `TouchTargets.joined`."""
        kind, index = np.concatenate([self.kind, other.kind]), np.concatenate([self.index, other.index])
        return GraphTargets(self.trimmed, kind, index, np.concatenate([self.point, other.point])), len(self.kind)

    def nearest(self, rows: IntArray, points: FloatArray) -> Nearest:
        """As `TouchTargets.nearest`, with the same shapes: on whole surfaces and curves."""
        p, normal = self.point[rows].copy(), np.zeros((len(rows), 3))
        projector = np.tile(np.eye(3), (len(rows), 1, 1))
        on_face, on_edge = self.kind[rows] == TargetKind.FACE, self.kind[rows] == TargetKind.EDGE
        if on_face.any():
            foot = project_to_faces(self.graph, self.index[rows[on_face]], points[on_face])
            p[on_face], normal[on_face] = foot.p, foot.normal
            projector[on_face] = foot.normal[:, :, None] * foot.normal[:, None, :]
        if on_edge.any():
            p[on_edge], tangent = project_to_edges(self.graph, self.index[rows[on_edge]], points[on_edge])
            projector[on_edge] -= tangent[:, :, None] * tangent[:, None, :]
        return Nearest(p, normal, projector)

    def rough_distances(self, rows: IntArray, points: FloatArray, radius_mm: FloatArray) -> FloatArray:
        """As `TouchTargets.rough_distances`, same shapes; a face reaches as far as the box of its parameters."""
        free = np.isin(rows, self._free_form)
        far = np.empty(len(rows))
        if (~free).any():
            far[~free] = self._elementary_distances(rows[~free], points[~free], radius_mm[~free])
        faces = self.index[rows]
        for face, cloud in self._clouds.items():
            at = np.flatnonzero(free & (faces == face))
            far[at] = cloud.distances(points[at], radius_mm[at])
        return far

    def overhang(self, rows: IntArray, points: FloatArray) -> FloatArray:
        """As `TouchTargets.overhang`, same shapes: exact for faces; for edges the distance beyond the nearer end."""
        over = np.zeros(len(rows))
        face = np.flatnonzero(self.kind[rows] == TargetKind.FACE)
        if len(face):
            over[face] = self._face_overhang(self.index[rows[face]], points[face])
        edge = np.flatnonzero(self.kind[rows] == TargetKind.EDGE)
        if len(edge):
            over[edge] = self._beyond_ends(self.index[rows[edge]], points[edge])
        return over

    def _face_overhang(self, faces: IntArray, points: FloatArray) -> FloatArray:
        """Least overhang over all faces on the surface of each: a wall of two half cylinders is one wall."""
        sets = [self._same_surface[int(face)] for face in faces]
        each = np.repeat(np.arange(len(faces)), [len(s) for s in sets])
        f = np.concatenate(sets)
        foot = project_to_faces(self.graph, f, points[each])
        outside = ~self.trimmed.contains(f, foot.uv)
        over = np.zeros(len(f))
        over[outside] = self.trimmed.boundary_distance(f[outside], foot.p[outside])
        least = np.full(len(faces), np.inf)
        np.minimum.at(least, each, over)
        return least

    @cached_property
    def _same_surface(self) -> dict[int, IntArray]:
        """Faces of the same solid on the surface of each target's face, with the same side outward."""
        faces = np.unique(self.index[self.kind == TargetKind.FACE])
        return {int(face): faces_on_surface(self.graph, int(face)) for face in faces}

    @cached_property
    def centre(self) -> FloatArray:
        """As `TouchTargets.centre`: the mean of the middles of the targets."""
        return np.asarray(np.mean([outline.mean(axis=0) for outline in self._outlines], axis=0))

    @cached_property
    def reach_mm(self) -> float:
        """As `TouchTargets.reach_mm`."""
        return max(float(np.linalg.norm(np.concatenate(self._outlines) - self.centre, axis=1).max()), 1.0)

    @cached_property
    def _outlines(self) -> list[FloatArray]:
        """Points of each target's border, or the target itself."""
        outlines = []
        for kind, index, point in zip(self.kind, self.index, self.point, strict=True):
            if kind == TargetKind.FACE:
                pieces = slice(self.trimmed.start[index], self.trimmed.start[index + 1])
                border = self.trimmed.p0[pieces]
                outlines.append(border if len(border) else self.graph.face_frame[index, :1])
            elif kind == TargetKind.EDGE:
                first, last = self.graph.edge_range[index]
                t = np.linspace(first, last, 9)
                outlines.append(evaluate_edges(self.graph, np.full(9, index), t)[0])
            else:
                outlines.append(point[None])
        return outlines

    @cached_property
    def _free_form(self) -> IntArray:
        faces = np.where(self.kind == TargetKind.FACE, self.index, 0)
        nurbs = (self.kind == TargetKind.FACE) & (self.graph.face_kind[faces] == SurfaceKind.NURBS)
        return np.flatnonzero(nurbs)

    @cached_property
    def _clouds(self) -> dict[int, _Cloud]:
        """By face."""
        return {int(f): _Cloud.of(self.trimmed, int(f)) for f in np.unique(self.index[self._free_form])}

    @cached_property
    def _parameter_box(self) -> FloatArray:
        """Least and greatest (u, v) of each target's face where the parameter is a length, else infinite: (n, 2, 2)."""
        box = np.tile([[-np.inf], [np.inf]], (len(self.kind), 1, 2)).reshape(-1, 2, 2)
        for row in np.flatnonzero(self.kind == TargetKind.FACE):
            face = self.index[row]
            pieces = slice(self.trimmed.start[face], self.trimmed.start[face + 1])
            uv = np.concatenate([self.trimmed.uv0[pieces], self.trimmed.uv1[pieces]])
            first = {SurfaceKind.PLANE: 0, SurfaceKind.CYLINDER: 1, SurfaceKind.CONE: 1}.get(
                SurfaceKind(self.graph.face_kind[face]), 2
            )
            if len(uv) and first < 2:
                box[row, 0, first:], box[row, 1, first:] = uv.min(axis=0)[first:], uv.max(axis=0)[first:]
        return box

    def _elementary_distances(self, rows: IntArray, points: FloatArray, radius_mm: FloatArray) -> FloatArray:
        off, beyond = np.empty(len(rows)), np.zeros(len(rows))
        kind, index = self.kind[rows], self.index[rows]
        face, edge = np.flatnonzero(kind == TargetKind.FACE), np.flatnonzero(kind == TargetKind.EDGE)
        point = np.flatnonzero(kind == TargetKind.POINT)
        if len(face):
            above, uv = offsets_from_faces(self.graph, index[face], points[face])
            off[face] = above - radius_mm[face]
            box = self._parameter_box[rows[face]]
            out = np.maximum(np.maximum(box[:, 0] - uv, uv - box[:, 1]), 0.0)
            beyond[face] = np.hypot(out[:, 0], out[:, 1])
        if len(edge):
            p, tangent = project_to_edges(self.graph, index[edge], points[edge])
            arm = points[edge] - p
            along = np.einsum("mi,mi->m", arm, tangent)
            off[edge] = np.linalg.norm(arm - along[:, None] * tangent, axis=1)
            beyond[edge] = self._beyond_ends(index[edge], points[edge])
        off[point] = np.linalg.norm(points[point] - self.point[rows[point]], axis=1)
        return np.asarray(np.hypot(off, beyond))

    def _beyond_ends(self, edges: IntArray, points: FloatArray) -> FloatArray:
        """Tell how far feet on straight edges lie beyond the ends, mm; 0 on others, which the search takes whole."""
        frame, (first, last) = self.graph.edge_frame[edges], self.graph.edge_range[edges].T
        along = np.einsum("mi,mi->m", points - frame[:, 0], frame[:, 1])
        beyond = np.maximum(np.maximum(first - along, along - last), 0.0)
        return np.where(self.graph.edge_kind[edges] == CurveKind.LINE, beyond, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class _Cloud:
    """Samples of a free-form face with their tangent planes, for the annealer."""

    tree: cKDTree
    p: FloatArray
    normal: FloatArray
    spacing_mm: float

    @classmethod
    def of(cls, trimmed: TrimmedFaces, face: int) -> _Cloud:
        graph = trimmed.graph
        pieces = slice(trimmed.start[face], trimmed.start[face + 1])
        uv = np.concatenate([trimmed.uv0[pieces], trimmed.uv1[pieces]])
        axes = (np.linspace(uv[:, k].min(), uv[:, k].max(), GRID) for k in (0, 1))
        grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        inside = trimmed.contains(np.full(len(grid), face), grid)
        grid = grid[inside] if inside.any() else grid
        p, du, dv = graph.nearest_on_nurbs.surfaces.evaluate(np.full(len(grid), graph.face_nurbs[face]), grid)
        normal = np.cross(du, dv)
        normal *= graph.face_outward[face] / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        tree = near_tree(p)
        spacing = float(np.asarray(tree.query(p, k=2)[0])[:, 1].max()) if len(p) > 1 else 0.0
        return cls(tree, p, normal, spacing)

    def distances(self, points: FloatArray, radius_mm: FloatArray) -> FloatArray:
        """Distance from the tangent plane of the nearest sample; beside the cloud the way to it counts as well."""
        _, k = self.tree.query(points)
        off = points - self.p[k]
        along = np.einsum("mi,mi->m", off, self.normal[k])
        beside = np.linalg.norm(off - along[:, None] * self.normal[k], axis=1)
        return np.asarray(np.hypot(along - radius_mm, np.maximum(beside - self.spacing_mm, 0.0)))


def points_as_touches(pairs: PointPairs, trimmed: TrimmedFaces) -> Touches:
    """Return taught points as touches whose targets are their points of the part."""
    n = len(pairs)
    targets = GraphTargets(trimmed, np.full(n, TargetKind.POINT), np.full(n, -1), pairs.p_source)
    return Touches(
        pairs.names, pairs.p_target, np.zeros(n), targets, pairs.names, pairs.covariances, pairs.space, np.arange(n)
    )
