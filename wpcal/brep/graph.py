"""`BrepGraph`: the boundary of a part as plain arrays, with no kernel object inside.

Words: a *face* is a trimmed piece of a surface, an *edge* a trimmed piece of a curve, a *vertex* a point; a *coedge* is
one use of an edge by a face. Seen from outside the material, a face lies to the left of its coedges. A *seam edge*
closes a face onto itself (the generatrix where a cylinder begins and ends): two coedges of one face on one edge.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np

from wpcal.brep.nearest import NearestOnSurfaces
from wpcal.brep.nurbs import NurbsCurve, NurbsSurface
from wpcal.brep.solid_facts import SolidFacts
from wpcal.brep.spans import CurveSet
from wpcal.brep.surface_cells import SurfaceCells
from wpcal.core.arrays import BoolArray, FloatArray, IntArray


class _Kind(IntEnum):
    """Kinds that arrays are compared with: asked for an override that is not there, an enumeration takes 8 µs."""

    __array_ufunc__ = np.ndarray.__array_ufunc__


class SurfaceKind(_Kind):
    """The surface of a face; the parameters of each kind are in `BrepGraph.face_param`."""

    PLANE = 0  #: No parameter; the normal is the z axis of the frame.
    CYLINDER = 1  #: Radius; the axis is z.
    CONE = 2  #: Radius at the frame's origin, half angle (rad): the radius at height h is ``r + h tan(angle)``.
    SPHERE = 3  #: Radius.
    TORUS = 4  #: Radius of the circle of centres, radius of the tube.
    NURBS = 5  #: Stored in `BrepGraph.nurbs_surfaces`.
    NONE = 6  #: A face without a surface (tessellated only).


class CurveKind(_Kind):
    """The curve of an edge; its points are ``o + t x``, ``o + a cos t x + b sin t y`` or those of a NURBS curve."""

    LINE = 0
    CIRCLE = 1  #: Radius, radius.
    ELLIPSE = 2  #: The two half axes along x and y.
    NURBS = 3  #: Stored in `BrepGraph.nurbs_curves`.
    DEGENERATE = 4  #: No curve: the apex of a cone or the pole of a sphere.


@dataclass(frozen=True, eq=False)
class BrepGraph:
    """The faces, edges, vertices and coedges of a part; lengths in mm, coordinates in the frame `part`."""

    solid_names: tuple[str, ...]  #: length S. Names of the placed solids, unique.
    face_solid: IntArray  #: shape (F,). The solid that a face bounds.
    face_kind: IntArray  #: shape (F,). `SurfaceKind`.
    face_frame: FloatArray  #: shape (F, 4, 3). Rows: origin, x, y, z of the surface's frame.
    face_param: FloatArray  #: shape (F, 2).
    #: shape (F,). +1 or -1: the outward normal is this times the surface's own (plane: z; others: away from the axis or
    #: centre; NURBS: du × dv).
    face_outward: FloatArray
    face_nurbs: IntArray  #: shape (F,). Index into `nurbs_surfaces`, or -1.
    #: `edge_kind`, `edge_frame`, `edge_param`, `edge_nurbs`: The same for edges, shapes (E,), (E, 4, 3), (E, 2), (E,).
    edge_kind: IntArray
    edge_frame: FloatArray
    edge_param: FloatArray
    edge_nurbs: IntArray
    edge_range: FloatArray  #: shape (E, 2). First and last parameter.
    edge_vertices: IntArray  #: shape (E, 2). Vertices at the first and the last parameter.
    vertex_p: FloatArray  #: shape (V, 3).
    #: `coedge_face`, `coedge_edge`: shape (C,).
    coedge_face: IntArray
    coedge_edge: IntArray
    coedge_forward: BoolArray  #: shape (C,). Whether the coedge runs with its edge's parameter.
    nurbs_surfaces: tuple[NurbsSurface, ...] = ()
    nurbs_curves: tuple[NurbsCurve, ...] = ()
    #: length S or 0. What the file says about each solid besides its shape; empty if nothing is known.
    solid_facts: tuple[SolidFacts, ...] = ()
    #: shape (E,). For an edge that was added in the groove between two faces, the radius of the ball that fits into the
    #: mouth of the groove; 0 for other edges. None: all are 0.
    edge_ball_mm: FloatArray | None = None

    @property
    def balls_mm(self) -> FloatArray:
        """The radius of the ball in the mouth of each edge's groove, mm, shape (E,); 0 where there is no groove."""
        return np.zeros(self.edge_count) if self.edge_ball_mm is None else self.edge_ball_mm

    def with_columns(self, **columns: Any) -> BrepGraph:
        """Return the graph with other columns, and with what was computed for free-form shapes that stay."""
        other = replace(self, **columns)
        stays = {name: vars(self)[name] for name, of in TABLES.items() if name in vars(self) and of not in columns}
        vars(other).update(stays)
        return other

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.face_kind)

    @property
    def edge_count(self) -> int:
        """Number of edges."""
        return len(self.edge_kind)

    @cached_property
    def edge_faces(self) -> IntArray:
        """The face to the left and to the right of each edge, -1 where there is none; shape (E, 2).

        The face in column 0 uses the edge forward, that in column 1 reversed. If more than two faces share an edge (not
        a manifold), the last ones are kept.
        """
        faces = np.full((self.edge_count, 2), -1, dtype=np.int64)
        side = np.where(self.coedge_forward, 0, 1)
        faces[self.coedge_edge, side] = self.coedge_face
        return faces

    @cached_property
    def is_seam_edge(self) -> BoolArray:
        """Whether both coedges of an edge belong to one face; shape (E,)."""
        left, right = self.edge_faces.T
        return np.asarray((left == right) & (left >= 0), dtype=bool)

    @cached_property
    def edge_solid(self) -> IntArray:
        """The solid of each edge's faces, -1 for an edge without a face; shape (E,)."""
        solid = np.full(self.edge_count, -1, dtype=np.int64)
        solid[self.coedge_edge] = self.face_solid[self.coedge_face]
        return solid

    @cached_property
    def vertex_solid(self) -> IntArray:
        """The solid of each vertex's edges, -1 for a free vertex; shape (V,)."""
        solid = np.full(len(self.vertex_p), -1, dtype=np.int64)
        for column in (0, 1):
            used = self.edge_vertices[:, column] >= 0
            solid[self.edge_vertices[used, column]] = self.edge_solid[used]
        return solid

    @cached_property
    def curve_set(self) -> CurveSet:
        """The NURBS curves, to be evaluated together."""
        return CurveSet.of(self.nurbs_curves)

    @cached_property
    def nearest_on_nurbs(self) -> NearestOnSurfaces:
        """The NURBS surfaces, to be evaluated and projected on together."""
        return NearestOnSurfaces.of(self.nurbs_surfaces)

    @cached_property
    def nurbs_cells(self) -> SurfaceCells:
        """The NURBS surfaces in cells, in which rays are followed."""
        return SurfaceCells.of(self.nearest_on_nurbs.surfaces, self.nearest_on_nurbs.breaks)

    @cached_property
    def size_mm(self) -> float:
        """Diagonal of the box around the vertices, mm."""
        if len(self.vertex_p) == 0:
            return 0.0
        return float(np.linalg.norm(self.vertex_p.max(axis=0) - self.vertex_p.min(axis=0)))


TABLES = {"curve_set": "nurbs_curves", "nearest_on_nurbs": "nurbs_surfaces", "nurbs_cells": "nurbs_surfaces"}
"""What is computed for free-form shapes, and the column that it depends on."""
