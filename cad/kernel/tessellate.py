"""Solids as triangles for pages and GLB files: `wpcal.brep.mesh.PartMesh`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepLib import BRepLib_ToolTriangulatedShape
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopLoc import TopLoc_Location

from cad.kernel.call import KernelObject, kernel_call
from cad.kernel.topology import EDGE, FACE, is_reversed, sub_shapes
from wpcal.brep.mesh import PartMesh, Rgb, SolidMesh, usual_deflection_mm
from wpcal.brep.mesh_glb import write_part_glb
from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.errors import KernelError
from wpcal.core.issue import Issue

ANGLE_RAD = 0.6
"""34° as the kernel counts, which gives about 20 sides per full circle: it looks round, and the mesh stays small."""
MANY_FACES, COARSE_RAD = 3000, 1.0
"""With this many faces each is a few pixels wide on a screen. 12 sides per circle are then enough, in half the time."""


def tessellate(
    solids: Iterable[tuple[str, KernelObject, Rgb | None]], copies: Mapping[int, tuple[int, FloatArray]] | None = None
) -> PartMesh:
    """Turn solids into triangles with the edges of their faces.

    Raises `KernelError` when the kernel fails as a whole.

    `solids`: In the frame `part`, mm; sRGB colours in 0…1, or None.
    `copies`: Solids that are an earlier one at another place, by number: that one, and the way from it, shape (3,), mm.
    They get its triangles.

    Returns: Its deflection is `usual_deflection_mm` of the diagonal of all solids; its angle is `ANGLE_RAD`, or
    `COARSE_RAD` for parts of `MANY_FACES`. Faces that the kernel cannot mesh are left out, as are solids without any
    meshed face.

    The triangles stay attached to the kernel's shapes. Nothing else reads them there.
    """
    given = list(solids)
    deflection = deflection_mm([shape for _, shape, _ in given])
    faces = sum(len(sub_shapes(shape, FACE)) for _, shape, _ in given)
    angle = ANGLE_RAD if faces < MANY_FACES else COARSE_RAD
    meshes: list[SolidMesh | None] = []
    for number, (name, shape, color) in enumerate(given):
        if copies and number in copies:
            first, way_mm = copies[number]
            mesh = meshes[first]
            if mesh is not None:
                mesh = replace(mesh, name=name, points=frozen(mesh.points + way_mm), color_rgb=color)
        else:
            with kernel_call(f"meshing {name}"):
                BRepMesh_IncrementalMesh(shape, deflection, False, angle, False)
                mesh = _solid_mesh(name, shape, color)
        meshes.append(mesh)
    return PartMesh(tuple(mesh for mesh in meshes if mesh is not None), deflection, angle)


def mesh_part(
    solids: Sequence[Any], *, copies: Mapping[int, tuple[int, FloatArray]] | None = None, sha256: str | None = None
) -> tuple[bytes | None, tuple[Issue, ...]]:
    """Return ``part.glb`` of the solids of a STEP file.

    `copies`: Solid, and way of shape (3,), by number, as `tessellate` takes them.
    Returns `part_glb`: None when the kernel fails or no face can be meshed. A calibration does not need the picture.
    Returns `issues`: tuple of Issue. What is missing in the picture.
    """
    try:
        mesh = tessellate(((solid.name, solid.shape, solid.color_rgb) for solid in solids), copies)
    except KernelError as error:
        return None, (Issue("no-mesh", f"the part is not drawn: {error}"),)
    missing = {solid.name for solid in solids} - {solid.name for solid in mesh.solids}
    issues = tuple(Issue("no-mesh", f"{name} is not drawn: it has no triangles", (name,)) for name in sorted(missing))
    return (write_part_glb(replace(mesh, sha256=sha256)) if mesh.solids else None), issues


def deflection_mm(shapes: Iterable[KernelObject]) -> float:
    """Return the largest allowed distance of a triangle from its face, mm."""
    box = Bnd_Box()
    for shape in shapes:
        BRepBndLib.Add_s(shape, box, False)
    return usual_deflection_mm(0.0 if box.IsVoid() else box.CornerMin().Distance(box.CornerMax()))


def _solid_mesh(name: str, shape: KernelObject, color: Rgb | None) -> SolidMesh | None:
    points: list[FloatArray] = []
    normals: list[FloatArray] = []
    triangles: list[IntArray] = []
    edges: list[IntArray] = []
    count = 0
    for face in sub_shapes(shape, FACE):
        location = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, location)
        if mesh is None:
            continue
        turned = is_reversed(face)
        trsf = location.Transformation()
        matrix = np.array([[trsf.Value(row, column) for column in range(1, 5)] for row in range(1, 4)])
        points.append(_nodes(mesh) @ matrix[:, :3].T + matrix[:, 3])
        normals.append(_normals(face, mesh, turned=turned) @ matrix[:, :3].T)
        triangles.append(_triangles(mesh, turned=turned) + count)
        edges.extend(rows + count for rows in _edges(face, mesh, location))
        count += len(points[-1])
    if not points:
        return None
    segments = np.concatenate(edges) if edges else np.zeros((0, 2), dtype=np.int64)
    p, n = frozen(np.concatenate(points)), frozen(np.concatenate(normals))
    return SolidMesh(name, p, np.concatenate(triangles), segments, color, n)


def _nodes(mesh: KernelObject) -> FloatArray:
    nodes = map(mesh.Node, range(1, mesh.NbNodes() + 1))
    return np.array([(p.X(), p.Y(), p.Z()) for p in nodes], dtype=np.float64).reshape(-1, 3)


def _normals(face: KernelObject, mesh: KernelObject, *, turned: bool) -> FloatArray:
    """Return the exact face's normals at the nodes, shape (n, 3): with those of triangles a cylinder looks faceted."""
    BRepLib_ToolTriangulatedShape.ComputeNormals_s(face, mesh)
    directions = map(mesh.Normal, range(1, mesh.NbNodes() + 1))
    rows: FloatArray = np.array([(d.X(), d.Y(), d.Z()) for d in directions], dtype=np.float64).reshape(-1, 3)
    return -rows if turned else rows


def _triangles(mesh: KernelObject, *, turned: bool) -> IntArray:
    corners = [mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)]
    rows: IntArray = np.array(corners, dtype=np.int64).reshape(-1, 3) - 1
    return rows[:, ::-1] if turned else rows


def _edges(face: KernelObject, mesh: KernelObject, location: KernelObject) -> list[IntArray]:
    """Return the boundary of a face as segments, without the edge along which a closed surface meets itself."""
    found = []
    for edge in sub_shapes(face, EDGE):
        if BRep_Tool.Degenerated_s(edge) or BRep_Tool.IsClosed_s(edge, face):
            continue
        polygon = BRep_Tool.PolygonOnTriangulation_s(edge, mesh, location)
        if polygon is None:
            continue
        rows = np.array([polygon.Node(i) for i in range(1, polygon.NbNodes() + 1)], dtype=np.int64) - 1
        found.append(np.stack([rows[:-1], rows[1:]], axis=1))
    return found
