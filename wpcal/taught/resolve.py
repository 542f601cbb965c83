"""From rows of a taught file to touches: which face, edge or point of the part each row lies on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wpcal.brep.curves import edge_polylines
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.nearest_on_edges import project_to_edges
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces, distance_to_segments
from wpcal.calibrate.observe.targets import GraphTargets, TargetKind
from wpcal.calibrate.observe.touches import NamedAxis, Touches
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.taught.columns import MODEL_COLUMNS
from wpcal.taught.features.reference import FeatureKind, ReferenceFeature, feature_named
from wpcal.taught.kinds import TouchKind
from wpcal.taught.table import TaughtPoints

ON_SURFACE_MM = 1e-3  #: A feature lies on a surface if it is this near: features are named after rounding to this.
SAME_SIZE_MM = 1e-3  #: Radii of a feature and of a face agree within this: files are written with three decimals.
SAME_DIRECTION = 1.0 - 1e-3
"""Least cosine between directions that are the same: 2.6 degrees, far less than between two faces of a corner."""
AMBIGUOUS_MM = 0.5
"""If the second nearest face is less than this further away than the nearest, a model point could mean either."""


def touches_of(
    taught: TaughtPoints,
    trimmed: TrimmedFaces,
    features: Sequence[ReferenceFeature],
    *,
    use: str,
    T_nominal_part: RigidTransform | None = None,
) -> Touches:
    """Find what each row of a taught file lies on.

    Raises `FormatError` with file and line: when a feature is unknown or has no such face, when a model point is
    equally near to two faces, or when a row names nothing and `T_nominal_part` is not given.
    """
    rows = [i for i, word in enumerate(taught.use) if word == use]
    finder = _Finder(taught, trimmed, features, T_nominal_part)
    kinds, indices, points = list(zip(*map(finder.target, rows), strict=True)) or ((), (), ())
    targets = GraphTargets(
        trimmed,
        np.array(kinds, dtype=np.int64),
        np.array(indices, dtype=np.int64),
        np.array(points, dtype=np.float64).reshape(-1, 3),
    )
    return Touches(
        tuple(taught.names[i] for i in rows),
        taught.p_base[rows],
        np.zeros(len(rows)) if taught.radius_mm is None else taught.radius_mm[rows],
        targets,
        tuple(map(finder.words, rows, indices)),
        None if taught.covariances is None else taught.covariances[rows],
        taught.space,
        np.arange(len(rows)),
        shared=None if taught.shared is None else taught.shared[rows],
    )


def named_axes(features: Sequence[ReferenceFeature]) -> tuple[NamedAxis, ...]:
    """Return the axes of holes and rims: they name the rotations that touches leave free."""
    kinds = (FeatureKind.HOLE, FeatureKind.CIRCLE)
    ordered = sorted((f for f in features if f.kind in kinds), key=lambda f: kinds.index(f.kind))
    return tuple(NamedAxis(f.name, f.p_mm, f.direction) for f in ordered if f.direction is not None)


class _Finder:
    """Looks for the face, edge or point of a row."""

    def __init__(
        self,
        taught: TaughtPoints,
        trimmed: TrimmedFaces,
        features: Sequence[ReferenceFeature],
        T_nominal_part: RigidTransform | None,
    ) -> None:
        self.taught, self.trimmed, self.features = taught, trimmed, features
        self.to_part = None if T_nominal_part is None else T_nominal_part.inverse()

    @property
    def graph(self) -> BrepGraph:
        return self.trimmed.graph

    def target(self, row: int) -> tuple[TargetKind, int, FloatArray]:
        """Return kind, index and point of a row's target."""
        kind, nowhere = self.taught.kind_of(row), np.full(3, np.nan)
        feature = self._feature(row)
        if kind.target is TargetKind.POINT:
            return kind.target, -1, self._model_point(row) if feature is None else feature.p_mm
        if kind.target is TargetKind.EDGE:
            return kind.target, self._edge(row, feature), nowhere
        return kind.target, self._face(row, kind, feature), nowhere

    def words(self, row: int, index: int) -> str:
        """Say what a row lies on: the name of its feature, or the solid of its face or edge."""
        kind, name = self.taught.kind_of(row), self.taught.features[row]
        if name or kind.target is TargetKind.POINT:
            return f"{kind.value} {name}".strip()
        solids = self.graph.edge_solid if kind.target is TargetKind.EDGE else self.graph.face_solid
        solid = solids[index]
        return f"{kind.value} of {self.graph.solid_names[solid]}"

    def _feature(self, row: int) -> ReferenceFeature | None:
        name = self.taught.features[row]
        if not name:
            return None
        try:
            return feature_named(self.features, name)
        except InputError as error:
            raise self._fault(row, str(error), "feature") from None

    def _model_point(self, row: int) -> FloatArray:
        point = np.asarray(self.taught.p_part[row])
        if not np.isnan(point).any():
            return point
        if self.taught.kind_of(row).target is TargetKind.POINT:
            raise self._fault(row, "a point among touches needs its feature or its model point", "feature")
        if self.to_part is None:
            what = f"names no feature and no model point ({', '.join(MODEL_COLUMNS)}); to find the face without them, "
            raise self._fault(
                row, f"{what}give the nominal place of the part", "feature", code=ErrorCode.NOMINAL_MISSING
            )
        return np.asarray(self.to_part.apply(self.taught.p_base[row][None])[0])

    def _face(self, row: int, kind: TouchKind, feature: ReferenceFeature | None) -> int:
        faces = np.flatnonzero(np.isin(self.graph.face_kind, kind.surfaces))
        if kind.is_inside:
            faces = faces[self.graph.face_outward[faces] < 0]  # the wall of a hole faces its axis
        if feature is not None:
            faces = faces[self._carries(faces, feature)]
            if len(faces) == 0:
                raise self._fault(row, f"{feature.name} has no face to touch as {kind.value}", "kind")
            return int(faces[0])
        if len(faces) == 0:
            raise self._fault(row, f"the part has no face to touch as {kind.value}", "kind")
        point = self._model_point(row)
        faces = self._facing(row, faces[self._within_reach(faces, point)], point)
        at = np.tile(point, (len(faces), 1))
        foot = project_to_faces(self.graph, faces, at)
        inside = self.trimmed.contains(faces, foot.uv)
        distance = np.linalg.norm(foot.p - at, axis=1)
        distance[~inside] = self.trimmed.boundary_distance(faces[~inside], at[~inside])
        best = int(np.argmin(distance))
        rivals = np.flatnonzero(distance < distance[best] + AMBIGUOUS_MM)
        if not self._same_surface(faces[rivals], foot.p[best], foot.normal[best]).all():
            raise self._fault(
                row, "the model point is equally near to two faces: give one further from their edge", "kind"
            )
        return int(faces[best])

    def _facing(self, row: int, faces: IntArray, point: FloatArray) -> IntArray:
        """Keep the faces whose outward normal is that of the row, if it states one and any face has it."""
        if self.taught.normal_part is None:
            return faces
        foot = project_to_faces(self.graph, faces, np.tile(point, (len(faces), 1)))
        facing = faces[foot.normal @ self.taught.normal_part[row] >= SAME_DIRECTION]
        return facing if len(facing) else faces

    def _within_reach(self, faces: IntArray, point: FloatArray) -> BoolArray:
        """Tell which faces can be the nearest, from their bounding boxes."""
        low, high = (corner[faces] for corner in self.trimmed.face_box)
        least = np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0), axis=1)
        most = np.linalg.norm(np.maximum(np.abs(point - low), np.abs(point - high)), axis=1)
        return np.asarray(least <= most.min() + AMBIGUOUS_MM, dtype=bool)

    def _same_surface(self, faces: IntArray, p: FloatArray, normal: FloatArray) -> BoolArray:
        foot = project_to_faces(self.graph, faces, np.tile(p, (len(faces), 1)))
        near = np.linalg.norm(foot.p - p, axis=1) <= ON_SURFACE_MM
        return np.asarray(near & (foot.normal @ normal >= SAME_DIRECTION), dtype=bool)

    def _carries(self, faces: IntArray, feature: ReferenceFeature) -> BoolArray:
        """Tell which faces a feature has: a plane through it, a wall about its axis, a sphere about its centre."""
        graph, p = self.graph, feature.p_mm
        kind, frame, size = graph.face_kind[faces], graph.face_frame[faces], graph.face_param[faces, 0]
        arm, axis = p - frame[:, 0], frame[:, 3]
        height = np.einsum("mi,mi->m", arm, axis)
        off = np.linalg.norm(arm - height[:, None] * axis, axis=1)
        along = np.ones(len(faces), dtype=bool)
        if feature.direction is not None:
            along = np.abs(axis @ feature.direction) >= SAME_DIRECTION
        radius = size if feature.diameter_mm is None else feature.diameter_mm / 2
        sized = np.abs(size - radius) <= SAME_SIZE_MM
        solid = np.array([graph.solid_names[s] == feature.solid for s in graph.face_solid[faces]])
        plane = (kind == SurfaceKind.PLANE) & (np.abs(height) <= ON_SURFACE_MM) & along
        wall = (kind == SurfaceKind.CYLINDER) & (off <= ON_SURFACE_MM) & along & sized
        ball = (kind == SurfaceKind.SPHERE) & (np.linalg.norm(arm, axis=1) <= ON_SURFACE_MM) & sized
        return np.asarray((plane | wall | ball) & solid, dtype=bool)

    def _edge(self, row: int, feature: ReferenceFeature | None) -> int:
        point = self._model_point(row) if feature is None else feature.p_mm
        start, _, samples = edge_polylines(self.graph)
        pieces = np.setdiff1d(np.arange(len(samples) - 1), start[1:-1] - 1)
        edge = np.searchsorted(start, pieces, side="right") - 1
        distance = distance_to_segments(np.tile(point, (len(pieces), 1)), samples[pieces], samples[pieces + 1])
        best = int(np.argmin(distance))
        rivals = np.unique(edge[distance < distance[best] + AMBIGUOUS_MM])
        p, tangent = project_to_edges(self.graph, rivals, np.tile(point, (len(rivals), 1)))
        mine = int(np.flatnonzero(rivals == edge[best])[0])
        near = np.linalg.norm(p - p[mine], axis=1) <= ON_SURFACE_MM
        if not (near & (np.abs(tangent @ tangent[mine]) >= SAME_DIRECTION)).all():
            raise self._fault(
                row, "the model point is equally near to two edges: give one further from their corner", "kind"
            )
        if self.graph.edge_kind[edge[best]] == CurveKind.DEGENERATE:
            raise self._fault(row, "there is no edge to touch", "kind")
        return int(edge[best])

    def _fault(self, row: int, what: str, column: str, *, code: str | None = None) -> FormatError:
        line = self.taught.lines[row] if self.taught.path else None
        return FormatError(what, path=self.taught.path, line=line, column=column, code=code)
