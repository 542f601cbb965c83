"""The seams of a ``seams.json`` in the frame `part`, and one of them as a path."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import read_json
from wpcal.core.robot_space import RobotSpace, common_space
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.closed_chain import SeamPath
from wpcal.seam.record import SEAMS_SCHEMA, seams_from_record
from wpcal.seam.seam import Seam


def read_held_seams(path: Path, cell: Cell) -> dict[str, Seam]:
    """Read all seams and bring them into the frame `part`, by name: ``W1``, and so on.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is of another schema version or incomplete.
    Raises `FrameError` when the seams were calibrated with a different model of robot 1 than the cell has.
    """
    record = read_json(path, schema=SEAMS_SCHEMA)
    seams = {seam.name: seam for seam in seams_from_record(record, path=str(path))}
    if all(seam.frames.frame == "part" for seam in seams.values()):
        return seams
    if record.get("T_base_part") is None:
        frame = next(seam.frames.frame for seam in seams.values() if seam.frames.frame != "part")
        raise FormatError(f"frames are given in {frame}, but T_base_part is missing", path=str(path))
    common_space(
        (
            (str(path), RobotSpace.parse(str(record.get("robot_space", RobotSpace.NOMINAL.value)))),
            (f"robot 1 of the cell ({cell.arm.name})", cell.arm.space),
        )
    )
    T_base_part = RigidTransform.from_matrix(record["T_base_part"], target="base", source="part")
    T_part_base = T_base_part.inverse()
    return {name: replace(seam, frames=seam.frames.moved(T_part_base)) for name, seam in seams.items()}


def read_seam_path(path: Path, name: str, cell: Cell) -> SeamPath:
    """Read one seam and bring it into the frame `part`; arguments and errors as in `read_held_seams`.

    Raises `InputError` when the file has no seam of that name.
    """
    seams = read_held_seams(path, cell)
    if name not in seams:
        raise InputError(f"{path}: no seam {name!r}; the file has {listed(seams) or 'none'}")
    return SeamPath.of_frames(name, seams[name].frames)
