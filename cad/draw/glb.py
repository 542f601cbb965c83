"""GLB: the calibrated part, its seams as lines and the tool's triads along them, for viewers of glTF.

In glTF lengths are metres and y points up: a point (x, y, z) in the base, mm, is written as (x, z, -y) / 1000. Nodes
have the names of the seams and of the part's solids. The node ``part`` holds the solids and the calibrated pose.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from wpcal.brep.mesh import PartMesh
from wpcal.brep.mesh_glb import PART_RGB, linear_light, read_part_glb
from wpcal.controllers.language.naming import NameRules, safe_name
from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.registry import Exporter
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform

NAMES = NameRules("GLB", 60)  #: For the name of the file; glTF itself sets no limit.
GLTF_FROM_BASE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  #: z up becomes y up.
MM = 1e-3
TRIAD_MM = 5.0  #: Length of an axis: half of the largest default step along a seam, so that neighbours do not overlap.
AXIS_COLOURS = np.array([[220, 40, 40, 255], [40, 170, 60, 255], [40, 90, 220, 255]], dtype=np.uint8)
"""x red, y green, z blue, as everywhere."""
SEAM_COLOUR = np.array([240, 140, 20, 255], dtype=np.uint8)


def write_glb(program: WeldProgram) -> dict[str, bytes]:
    """Write one GLB file.

    Raises `FormatError` when the calibration's ``part.glb`` is not a GLB file of wpcal.

    Returns: ``NAME.glb``: per seam one node and one node ``SEAM triads`` with the axes of the tool; under ``part`` one
    node per solid, if the calibration has triangles.
    """
    import trimesh

    scene = trimesh.Scene()
    for path in program.paths:
        name = path.seam.name
        scene.add_geometry(_seam(path), node_name=name, geom_name=name)
        triads = f"{name} triads"
        scene.add_geometry(_triads(path), node_name=triads, geom_name=triads)
    if program.part_glb is not None:
        _add_part(scene, read_part_glb(program.part_glb), program.T_base_part)
    data: bytes = scene.export(file_type="glb", include_normals=True)
    return {f"{safe_name(program.controller.program_name, NAMES)}.glb": data}


def _add_part(scene: Any, mesh: PartMesh, T_base_part: RigidTransform) -> None:
    """Add the solids, in mm of `part`, under a node with the pose. Names that are taken get a number."""
    import trimesh
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    gltf_from_base = np.eye(4)
    gltf_from_base[:3, :3] = MM * GLTF_FROM_BASE
    root = _free_name("part", scene)
    scene.graph.update(frame_to=root, frame_from=scene.graph.base_frame, matrix=gltf_from_base @ T_base_part.matrix)
    for solid in mesh.solids:
        colour = linear_light(solid.color_rgb or PART_RGB)
        material = PBRMaterial(
            baseColorFactor=[*colour, 1.0], metallicFactor=0.0, roughnessFactor=0.7, doubleSided=True
        )
        faces = trimesh.Trimesh(
            solid.points, solid.triangles, process=False, visual=TextureVisuals(material=material), validate=False
        )
        name = _free_name(solid.name, scene)
        scene.add_geometry(faces, node_name=name, geom_name=name, parent_node_name=root)


def _free_name(name: str, scene: Any) -> str:
    free, number = name, 1
    while free in scene.graph.nodes:
        number += 1
        free = f"{name}#{number}"
    return free


def _seam(path: WeldPath) -> object:
    from trimesh.path import Path3D
    from trimesh.path.entities import Line

    p = _to_gltf(path.seam.frames.p)
    return Path3D(entities=[Line(np.arange(len(p)), color=SEAM_COLOUR)], vertices=p, process=False)


def _triads(path: WeldPath) -> object:
    """Return the axes of the tool along the seam, one line per axis."""
    from trimesh.path import Path3D
    from trimesh.path.entities import Line

    start = np.repeat(path.p_base[path.weld_rows], 3, axis=0)
    end = start + TRIAD_MM * np.swapaxes(path.R_base[path.weld_rows], 1, 2).reshape(-1, 3)
    vertices = _to_gltf(np.stack([start, end], axis=1).reshape(-1, 3))
    entities = [Line([2 * row, 2 * row + 1], color=AXIS_COLOURS[row % 3]) for row in range(len(start))]
    return Path3D(entities=entities, vertices=vertices, process=False)


def _to_gltf(p_base: FloatArray) -> FloatArray:
    """Convert points in the base, shape (n, 3), mm, to metres with y up."""
    return np.asarray(p_base @ GLTF_FROM_BASE.T * MM, dtype=np.float64)


GLB = Exporter("glb", "GLB: NAME.glb with the part, seams and tool triads as named nodes", write_glb)
