"""GLB: the calibrated seams as lines and the tool's triads along them, for viewers of glTF.

glTF wants metres and y up: a place (x, y, z) in mm of the base is written as (x, z, -y) / 1000. Nodes carry the names
of the seams.
"""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.export import Exporter, WeldPath, WeldProgram
from wpcal.export.naming import NameRules, safe_name

NAMES = NameRules("GLB", 60)
"""The name of the file; glTF itself sets no limit."""
GLTF_FROM_BASE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""z up becomes y up."""
MM = 1e-3
TRIAD_MM = 5.0
"""Length of an axis: half of the largest step that seams are cut into by default, so that neighbours stay apart."""
AXIS_COLOURS = np.array([[220, 40, 40, 255], [40, 170, 60, 255], [40, 90, 220, 255]], dtype=np.uint8)
"""x red, y green, z blue, as everywhere."""
SEAM_COLOUR = np.array([240, 140, 20, 255], dtype=np.uint8)


def write_glb(program: WeldProgram) -> dict[str, bytes]:
    """Write one GLB file.

    Parameters
    ----------
    program : WeldProgram

    Returns
    -------
    dict of str to bytes
        ``NAME.glb``: a node a seam, and a node ``SEAM triads`` with the axes of the tool.
    """
    import trimesh

    scene = trimesh.Scene()
    for path in program.paths:
        name = path.seam.name
        scene.add_geometry(_seam(path), node_name=name, geom_name=name)
        triads = f"{name} triads"
        scene.add_geometry(_triads(path), node_name=triads, geom_name=triads)
    data: bytes = scene.export(file_type="glb")
    return {f"{safe_name(program.controller.program_name, NAMES)}.glb": data}


def _seam(path: WeldPath) -> object:
    from trimesh.path import Path3D
    from trimesh.path.entities import Line

    p = _to_gltf(path.seam.frames.p)
    return Path3D(entities=[Line(np.arange(len(p)), color=SEAM_COLOUR)], vertices=p, process=False)


def _triads(path: WeldPath) -> object:
    """Return the axes of the tool along the seam, a line each."""
    from trimesh.path import Path3D
    from trimesh.path.entities import Line

    start = np.repeat(path.p_base[1:-1], 3, axis=0)
    end = start + TRIAD_MM * np.swapaxes(path.R_base[1:-1], 1, 2).reshape(-1, 3)
    vertices = _to_gltf(np.stack([start, end], axis=1).reshape(-1, 3))
    entities = [Line([2 * row, 2 * row + 1], color=AXIS_COLOURS[row % 3]) for row in range(len(start))]
    return Path3D(entities=entities, vertices=vertices, process=False)


def _to_gltf(p_base: FloatArray) -> FloatArray:
    """Return places of the base, mm, in metres with y up."""
    return np.asarray(p_base @ GLTF_FROM_BASE.T * MM, dtype=np.float64)


GLB = Exporter("glb", "GLB: NAME.glb with seams and tool triads as named nodes", write_glb)
