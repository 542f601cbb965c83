"""The seams of a ``seams.json`` in the frame `part`, one of them as a path, and the part beside them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.brep.moved_mesh import read_moved_glb
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import read_json
from wpcal.core.result_files import PART_FILE
from wpcal.core.robot_space import RobotSpace, common_space
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.closed_chain import SeamPath
from wpcal.seam.record import SEAMS_SCHEMA, seams_from_record
from wpcal.seam.seam import Seam


class PartSeams(NamedTuple):
    """The seams of a file with frames in `part`, its record, and where the robot found the part (None: not known)."""

    record: dict[str, Any]
    seams: tuple[Seam, ...]
    T_base_part: RigidTransform | None


def seams_in_part(path: Path, cell: Cell, *, with_place: bool) -> PartSeams:
    """Read all seams of schema ``wpcal/seams/1`` and bring them into the frame `part`.

    `with_place`: Whether the place of the part is asked for where the frames do not need it.
    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is of another schema version or incomplete.
    Raises `FrameError` when the seams were calibrated with a different model of the robot with the torch.
    """
    record = read_json(path, schema=SEAMS_SCHEMA)
    seams = seams_from_record(record, path=str(path))
    others = [seam.frames.frame for seam in seams if seam.frames.frame != "part"]
    if record.get("T_base_part") is None and others:
        raise FormatError(f"frames are given in {others[0]}, but T_base_part is missing", path=str(path))
    if record.get("T_base_part") is None or not (others or with_place):
        return PartSeams(record, seams, None)
    stated = RobotSpace.parse(str(record.get("robot_space", RobotSpace.NOMINAL.value)))
    robot = "robot 1 of the cell" if cell.has_two_robots else "the robot of the cell"
    common_space(((str(path), stated), (f"{robot} ({cell.arm.name})", cell.arm.space)))
    T_base_part = RigidTransform.from_matrix(record["T_base_part"], target="base", source="part")
    T_part_base = T_base_part.inverse()
    moved = (
        seam if seam.frames.frame == "part" else replace(seam, frames=seam.frames.moved(T_part_base)) for seam in seams
    )
    return PartSeams(record, tuple(moved), T_base_part)


def part_beside(seams_json: Path, part_glb: bytes | None = None) -> tuple[bytes | None, TriangleMaterial | None]:
    """Return the given mesh, or the one that `wpcal calibrate` wrote beside the seams, and the same as triangles.

    Raises `InputError` or `FormatError` if a file cannot be read or is not such a mesh.
    """
    path = seams_json.with_name(PART_FILE)
    if part_glb is None and path.exists():
        part_glb = read_moved_glb(path)
    return part_glb, None if part_glb is None else TriangleMaterial.of(read_part_glb(part_glb, path=str(path)))


def read_held_seams(path: Path, cell: Cell) -> dict[str, Seam]:
    """Read the seams of a part in the hand of robot 2, by name: ``W1``, and so on; errors as in `seams_in_part`."""
    return {seam.name: seam for seam in seams_in_part(path, cell, with_place=False).seams}


def read_seam_path(path: Path, name: str, cell: Cell) -> SeamPath:
    """Read one seam and bring it into the frame `part`; arguments and errors as in `read_held_seams`.

    Raises `InputError` when the file has no seam of that name.
    """
    seams = read_held_seams(path, cell)
    if name not in seams:
        raise InputError(f"{path}: no seam {name!r}; the file has {listed(seams) or 'none'}")
    return SeamPath.of_frames(name, seams[name].frames)
