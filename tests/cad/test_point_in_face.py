"""Trimmed faces of every surface: left of a boundary is inside, right of it outside, and rays meet them."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from OCP.gp import gp_Dir, gp_Lin, gp_Pnt
from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector

from cad.kernel.to_brep import to_brep
from cad.samples.parts import box, cut, cylinder
from cad.workpiece.workpiece import open_workpiece
from wpcal.brep import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.hits import find_hits
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray

ASIDE_MM = 0.05
"""Five times the sag of the polylines of a boundary, and far less than the width of any of these faces."""
ALONG = np.linspace(0.07, 0.93, 9)
"""Places along an edge, away from its ends, where the neighbouring edge would decide."""
ON_MM = 1e-6  #: A point whose distance from the kernel's trimmed face is below this lies on it.
CLEAR_MM = 0.02  #: Points nearer to a boundary than twice the sag of its polyline are not tested.


def slanted(make: Callable[[Any], Any]) -> Any:
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    return make(gp_Ax2(gp_Pnt(3, -5, 7), gp_Dir(0.3, -0.5, 0.8), gp_Dir(0.9, 0.2, 0.1))).Solid()


def shapes() -> dict[str, Any]:
    from OCP import BRepPrimAPI as Make

    third, up, down = 2 * math.pi / 3, math.radians(50), math.radians(-20)
    return {
        "box with a hole": cut(box(60, 40, 10, (0, 0, 0)), cylinder(8, 10, (20, 20, 0), (0, 0, 1))),
        "cylinder": slanted(lambda at: Make.BRepPrimAPI_MakeCylinder(at, 20, 30)),
        "part of a cylinder": slanted(lambda at: Make.BRepPrimAPI_MakeCylinder(at, 20, 30, third)),
        "cone": slanted(lambda at: Make.BRepPrimAPI_MakeCone(at, 20, 8, 30)),
        "pointed cone": slanted(lambda at: Make.BRepPrimAPI_MakeCone(at, 20, 0, 30)),
        "part of a cone": slanted(lambda at: Make.BRepPrimAPI_MakeCone(at, 8, 20, 30, 2 * third)),
        "sphere": slanted(lambda at: Make.BRepPrimAPI_MakeSphere(at, 25)),
        "zone of a sphere": slanted(lambda at: Make.BRepPrimAPI_MakeSphere(at, 25, down, up)),
        "cap of a sphere": slanted(lambda at: Make.BRepPrimAPI_MakeSphere(at, 25, up, math.pi / 2)),
        "part of a zone": slanted(lambda at: Make.BRepPrimAPI_MakeSphere(at, 25, down, up, third)),
        "torus": slanted(lambda at: Make.BRepPrimAPI_MakeTorus(at, 30, 8)),
        "part of a torus": slanted(lambda at: Make.BRepPrimAPI_MakeTorus(at, 30, 8, third)),
        "bored sphere": cut(
            slanted(lambda at: Make.BRepPrimAPI_MakeSphere(at, 25)), cylinder(6, 100, (3, -55, 7), (0, 1, 0))
        ),
        "pipe cut by a pipe": cut(cylinder(25, 80, (0, 0, 0), (0, 0, 1)), cylinder(40, 200, (-100, 0, 0), (1, 0, 0))),
        "torus cut by a plane": cut(
            slanted(lambda at: Make.BRepPrimAPI_MakeTorus(at, 30, 8)), box(100, 100, 100, (0, -50, -50))
        ),
    }


NAMES = list(shapes())


def asked(graph: BrepGraph) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coedges of which left and right can be tested: face, edge and direction."""
    used = ~graph.is_seam_edge[graph.coedge_edge] & (graph.edge_kind[graph.coedge_edge] != CurveKind.DEGENERATE)
    return graph.coedge_face[used], graph.coedge_edge[used], np.where(graph.coedge_forward[used], 1.0, -1.0)


@pytest.mark.parametrize("name", NAMES)
def test_left_of_a_boundary_is_inside_and_right_is_outside(name: str) -> None:
    graph = to_brep([("S", shapes()[name])])
    trimmed = TrimmedFaces.of(graph)
    face, edge, way = (np.repeat(values, len(ALONG)) for values in asked(graph))
    low, high = graph.edge_range[edge].T
    p, slope = evaluate_edges(graph, edge, low + np.tile(ALONG, len(edge) // len(ALONG)) * (high - low))
    travel = slope * (way / np.linalg.norm(slope, axis=1))[:, None]
    left = np.cross(project_to_faces(graph, face, p).normal, travel)
    for side, expected in ((left, True), (-left, False)):
        foot = project_to_faces(graph, face, p + ASIDE_MM * side)
        assert (trimmed.contains(face, foot.uv) == expected).all()
        off = trimmed.boundary_distance(face, foot.p)
        np.testing.assert_allclose(off, ASIDE_MM, rtol=0, atol=CLEAR_MM)


@pytest.mark.parametrize("name", NAMES)
def test_the_kernel_has_the_same_points_on_its_faces(name: str) -> None:
    from cad.kernel.topology import FACE, sub_shape_uses

    shape = shapes()[name]
    graph, kernel_faces = to_brep([("S", shape)]), [face for face, _ in sub_shape_uses(shape, FACE)]
    trimmed, rng = TrimmedFaces.of(graph), np.random.default_rng(0)
    low, high = trimmed.face_box
    both = set()
    for number, kernel_face in enumerate(kernel_faces):
        points = rng.uniform(low[number] - 5.0, high[number] + 5.0, (60, 3))
        foot = project_to_faces(graph, np.full(60, number), points)
        contained = trimmed.contains(np.full(60, number), foot.uv)
        clear = trimmed.boundary_distance(np.full(60, number), foot.p) > CLEAR_MM
        for p, inside in zip(foot.p[clear], contained[clear], strict=True):
            assert (kernel_distance(p, kernel_face) < ON_MM) == inside, (number, p)
            both.add(bool(inside))
    assert True in both


def kernel_distance(p: np.ndarray, face: Any) -> float:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape
    from OCP.gp import gp_Pnt

    vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*p.tolist())).Vertex()
    return float(BRepExtrema_DistShapeShape(vertex, face).Value())


def test_a_patch_of_a_torus_does_not_go_on_along_the_meridians_that_bound_it() -> None:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    rng = np.random.default_rng(0)
    for _ in range(20):  # the ends of two edges at one corner differ by round-off, and a meridian goes between them
        axis, x, place = rng.normal(size=3), rng.normal(size=3), rng.uniform(-500.0, 500.0, 3)
        at = gp_Ax2(gp_Pnt(*place), gp_Dir(*axis), gp_Dir(*x))
        graph = to_brep([("S", BRepPrimAPI_MakeTorus(at, 597.0, 237.0, -0.3, 0.8, 2.0).Solid())])
        trimmed = TrimmedFaces.of(graph)
        (patch,) = np.flatnonzero(graph.face_kind == SurfaceKind.TORUS)
        own = slice(trimmed.start[patch], trimmed.start[patch + 1])
        ends = np.unique([trimmed.uv0[own, 0], trimmed.uv1[own, 0]])  # a point between two pieces once
        u = (ends[:, None] + np.linspace(-1e-13, 1e-13, 41)).ravel()
        assert not trimmed.contains(np.full(len(u), patch), np.column_stack([u, np.full(len(u), 2.0)])).any()


def test_the_samples_have_every_surface() -> None:
    kinds = {int(kind) for shape in shapes().values() for kind in to_brep([("S", shape)]).face_kind}
    assert kinds >= {SurfaceKind.PLANE, SurfaceKind.CYLINDER, SurfaceKind.CONE, SurfaceKind.SPHERE, SurfaceKind.TORUS}


RAYS, LENGTH_MM = 200, 600.0
NEAR_MM = 1e-5
LEAST_SHARE = 0.998
"""Share of the kernel's hits that are found, and of the found ones that are the kernel's; the rest graze a pipe."""


def test_rays_through_bent_free_form_pipes(shared_step: Path) -> None:
    """Four pipes of one face each, outside and inside: their seam edge runs along the pipe."""
    workpiece = open_workpiece(shared_step.parent / "blind" / "mini" / "em_re.step")
    graph, trimmed = workpiece.graph, workpiece.trimmed
    assert len(graph.nurbs_surfaces) == 8
    rng = np.random.default_rng(4)
    low, high = (corner[graph.face_nurbs >= 0] for corner in trimmed.face_box)
    origins = rng.uniform(low.min(axis=0), high.max(axis=0), (RAYS, 3))
    rays = rng.normal(size=(RAYS, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    found = find_hits(trimmed, origins, rays, length_mm=LENGTH_MM)
    expected: list[list[float]] = [[] for _ in range(RAYS)]
    for shape in workpiece.solids:
        kernel = IntCurvesFace_ShapeIntersector()
        kernel.Load(shape, 1e-6)
        for row in range(RAYS):
            kernel.Perform(gp_Lin(gp_Pnt(*origins[row].tolist()), gp_Dir(*rays[row].tolist())), 0.0, LENGTH_MM)
            expected[row] += [kernel.WParameter(k) for k in range(1, kernel.NbPnt() + 1)]
    assert sum(map(len, expected)) > RAYS
    hits = [np.sort(wanted) for wanted in expected]
    found_at = [found.at_mm[found.ray == row] for row in range(RAYS)]
    for these, those in ((hits, found_at), (found_at, hits)):
        met = [is_among(at, there) for at, there in zip(these, those, strict=True)]
        assert np.concatenate(met).mean() >= LEAST_SHARE


def is_among(at: FloatArray, there: FloatArray) -> BoolArray:
    return (np.abs(at[:, None] - there) <= NEAR_MM).any(axis=1)
