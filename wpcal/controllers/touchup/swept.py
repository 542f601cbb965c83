"""Execute a program that was touched up, and sweep it against the part where the corrections have it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import product

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh import SolidMesh
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.calibrate.corrections import BodyPlaces, Explanation
from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.controllers.audit.programs import Surroundings, executed, executed_faults
from wpcal.controllers.judge.execute import programs_of
from wpcal.controllers.touchup.study import TouchUp
from wpcal.core.arrays import FloatArray
from wpcal.core.robot_space import RobotSpace
from wpcal.seam.judge.stations import start_mm

NOT_SEEN = "NOT CHECKED: joint moves, the arm, fixtures, cables"


def faults_of(found: TouchUp, files: Mapping[str, bytes], around: Surroundings) -> list[str]:
    """Return what keeps the files from being called checked, by file and line; empty: no move meets the part.

    `around`: The torch; the part is added.
    """
    reason = _why_not(found)
    if reason:
        return [f"NOT CHECKED: {reason}"]
    place = found.part.finished.T_base_part
    start = max((start_mm(seam) for seam in found.part.seams), default=around.start_mm)
    here = replace(around, T_base_part=place, part=moved_part(found), start_mm=start)
    trace, broken = executed(programs_of(files), here)
    faults = [*((name, each) for name, several in broken.items() for each in several), *executed_faults(trace, here)]
    return [f"{name}{'' if fault.line is None else f', line {fault.line}'}: {fault.message}" for name, fault in faults]


def _why_not(found: TouchUp) -> str:
    finished = found.part.finished
    if finished.part_glb is None:
        return "the result holds no part.glb"
    if RobotSpace.parse(finished.calibration["robot_space"]) is RobotSpace.IDENTIFIED:
        return "its targets are corrected for an identified arm, and are not where the torch will be"
    return "the tool was changed" if found.common is not None and found.common[1] else ""


def moved_part(found: TouchUp) -> TriangleMaterial:
    """Return the part in `base`, every body where the corrections have it, and all in the frame that was moved."""
    mesh = read_part_glb(found.part.finished.part_glb or b"")
    T = np.eye(4) if found.common is None else found.common[0]
    solids = []
    for solid in mesh.solids:
        p = found.part.finished.T_base_part.apply(solid.points)
        if found.explanation is not None:
            p = _where_it_is(solid, p, found, found.explanation)
        solids.append(replace(solid, points=p @ T[:3, :3].T + T[:3, 3], normals=None))
    return TriangleMaterial.of(replace(mesh, solids=tuple(solids)))


def _where_it_is(solid: SolidMesh, p: FloatArray, found: TouchUp, explained: Explanation) -> FloatArray:
    """Move the points of a solid, shape (n, 3), as one rigid body: as the corners of its box are moved."""
    corners = np.array(list(product(*np.stack([p.min(axis=0), p.max(axis=0)], axis=1).tolist())))
    number = found.part.bodies.index(solid.name) if solid.name in found.part.bodies else -1
    moved = corners + explained.seams_at(BodyPlaces.of(corners, number))[0]
    R, t = kabsch(corners, moved, np.full(len(corners), 1.0 / len(corners)))
    return p @ R.T + t
