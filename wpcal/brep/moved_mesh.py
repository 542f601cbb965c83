"""The triangles of a part whose bodies moved: each solid where its body is."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.mesh import PartMesh
from wpcal.brep.mesh_glb import read_part_glb, write_part_glb
from wpcal.core.arrays import FloatArray
from wpcal.core.input_file import read_bytes
from wpcal.core.records import read_json
from wpcal.core.result_files import CALIBRATION_FILE, CALIBRATION_SCHEMA, PART_FILE


def moved_glb(data: bytes, calibration: Mapping[str, Any], *, path: str = PART_FILE) -> bytes:
    """Return ``part.glb`` with every solid moved as its body was found to have moved.

    ``part.glb`` holds the model. Torches and robots meet the real part: what is compared with it needs the moved one.

    Raises `FormatError` when `data` is not such a file.
    """
    bodies = calibration.get("bodies")
    if bodies is None:
        return data
    motions = {name: np.array(body["T_part_moved"]) for body in bodies["bodies"] for name in body["solids"]}
    return write_part_glb(moved_mesh(read_part_glb(data, path=path), motions)) if motions else data


def read_moved_glb(path: Path) -> bytes:
    """Read ``part.glb`` of a result folder, with each solid where the calibration beside it says.

    Raises `InputError` or `FormatError` when a file cannot be read.
    """
    data, beside = read_bytes(path), path.with_name(CALIBRATION_FILE)
    if not beside.exists():
        return data
    return moved_glb(data, read_json(beside, schema=CALIBRATION_SCHEMA), path=str(path))


def moved_mesh(mesh: PartMesh, T_part_moved: Mapping[str, FloatArray]) -> PartMesh:
    """Return a mesh with solids moved within `part`.

    `T_part_moved`: shape (4, 4). By the name of the solid, mm; solids without a motion stay.
    """
    solids = []
    for solid in mesh.solids:
        T = T_part_moved.get(solid.name)
        if T is None:
            solids.append(solid)
            continue
        normals = None if solid.normals is None else solid.normals @ T[:3, :3].T
        solids.append(replace(solid, points=solid.points @ T[:3, :3].T + T[:3, 3], normals=normals))
    return replace(mesh, solids=tuple(solids))
