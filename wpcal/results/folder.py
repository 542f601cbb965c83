"""The folder that `wpcal calibrate` writes: read in one place, and checked that its files belong together."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wpcal.brep.moved_mesh import moved_glb
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ErrorCode, FormatError, FrameError, InputError
from wpcal.core.input_file import holds_file, read_bytes, require_folder, sha256_of
from wpcal.core.record_check import check_record
from wpcal.core.records import read_json
from wpcal.core.result_files import CALIBRATION_FILE, CALIBRATION_SCHEMA, JOB_FILE, JOB_SCHEMA, PART_FILE, SEAMS_FILE
from wpcal.core.robot_space import RobotSpace
from wpcal.core.schemas import required_fields
from wpcal.core.transform import RigidTransform
from wpcal.results.agree import agreed_pose, check_same_part, require_as_written
from wpcal.robot.torch.file import torch_of_seams
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam.names import seams_named
from wpcal.seam.record import SEAMS_SCHEMA, errors_from_record, seams_from_record
from wpcal.seam.seam import Seam

RECORD_SCHEMAS = {CALIBRATION_FILE: CALIBRATION_SCHEMA, SEAMS_FILE: SEAMS_SCHEMA}
"""The records of a result folder and what they are."""
_WRONG_SPACE = {
    RobotSpace.IDENTIFIED: "the points were taught through an identified robot; give the file of that robot, or the "
    "robot's error comes back when the controller replays the seams with its nominal model",
    RobotSpace.NOMINAL: "the points were taught through the controller's own nominal model; give no robot file: "
    "corrected at one end only, the robot's error comes back",
}


@dataclass(frozen=True, slots=True, eq=False)
class ResultFolder:
    """The records and the mesh of one finished calibration."""

    path: Path  #: The folder.
    #: `calibration`, `seams`: The records of ``calibration.json`` and ``seams.json``.
    calibration: dict[str, Any]
    seams: dict[str, Any]
    T_base_part: RigidTransform  #: The pose that both records state.
    part_glb: bytes | None  #: ``part.glb``, the part's triangles, where there is one.
    note: str | None  #: What is to be said if the files could not be compared with what was written.


@dataclass(frozen=True, slots=True, eq=False)
class FinishedCalibration:
    """What `wpcal export` starts from."""

    T_base_part: RigidTransform
    seams: tuple[Seam, ...]  #: With frames in `base`.
    #: shape (n,), or None). The 95 % error at each of the n frames of each seam, mm, where the file has it.
    u95_mm: tuple[FloatArray | None, ...]
    calibration: dict[str, Any]  #: The record of ``calibration.json``.
    #: ``part.glb``, the part's triangles, where there is one; with each solid where its body moved.
    part_glb: bytes | None = None
    torch: TorchShape | None = None  #: The torch with which reach was felt; None in files from before it was written.
    note: str | None = None  #: As of `ResultFolder`.

    def select(self, names: Sequence[str] | None = None, *, everything: bool = False) -> FinishedCalibration:
        """Return the accepted seams, those named (``W1``, ``W5-W8``), or all of them.

        Raises `InputError` when a name is unknown or nothing is left.
        """
        known = [seam.name for seam in self.seams]
        chosen = None if names is None else set(seams_named(names, known))
        rows = [
            row
            for row, seam in enumerate(self.seams)
            if (everything or seam.accepted if chosen is None else seam.name in chosen)
        ]
        if not rows:
            if not known:
                raise InputError("the calibration has no seams; nothing to export")
            what = f"none of the {len(known)} seams is accepted; nothing to export except candidates"
            raise InputError(what, code=ErrorCode.NOTHING_ACCEPTED)
        seams = tuple(self.seams[row] for row in rows)
        return replace(self, seams=seams, u95_mm=tuple(self.u95_mm[row] for row in rows))


def read_record(folder: Path, name: str) -> dict[str, Any]:
    """Read one record of a result folder.

    Raises `InputError` when the folder or the file is not there, or cannot be opened.
    Raises `FormatError` when it is not a record of its schema, or lacks a field that every such record has.
    """
    schema, expected = RECORD_SCHEMAS[name], "the folder of a finished calibration"
    require_folder(folder, expected)
    if not os.path.lexists(folder / name):
        raise InputError(f"{folder}: holds no {name}; expected {expected}")
    record = read_json(folder / name, schema=schema)
    missing = [field for field in required_fields(schema) if field not in record]
    if missing:
        raise FormatError(f"lacks {', '.join(missing)}", path=str(folder / name))
    if name == CALIBRATION_FILE:  # nobody writes it by hand
        check_record(record, schema, path=str(folder / name), is_complete=True)
    return record


def read_result_folder(folder: Path, *, is_compared: bool = True) -> ResultFolder:
    """Read ``calibration.json``, ``seams.json`` and, where it is there, ``part.glb``.

    `is_compared`: Whether a file that was changed after the calibration wrote it is refused.
    Raises `InputError` when the folder or a record is not there.
    Raises `FrameError` when the seams are not in `base`.
    Raises `FormatError` when a file breaks its format, was changed, or is not from the same calibration as the others.
    """
    calibration, seams = (read_record(folder, name) for name in RECORD_SCHEMAS)
    note = require_as_written(folder, also=calibration.get("files", ())) if is_compared else None
    T_base_part = agreed_pose(calibration, seams, path=folder / SEAMS_FILE)
    part_glb = None
    if (folder / PART_FILE).is_file():
        part_glb = read_bytes(folder / PART_FILE)
        check_same_part(part_glb, calibration, path=folder / PART_FILE)
    return ResultFolder(folder, calibration, seams, T_base_part, part_glb, note)


def files_of_run(folder: Path) -> tuple[str, ...]:
    """Return the files of the calibration in a folder that the next run replaces, or leaves out.

    They are those that it lists and that are as it wrote them, and ``job.json``: the request for its results.
    """
    try:
        record = read_record(folder, CALIBRATION_FILE)
    except InputError:
        return ()
    listed = record.get("files")
    if not isinstance(listed, dict):
        return ()
    own = [name for name in listed if holds_file(folder, name)]
    ours = [name for name in own if sha256_of(read_bytes(folder / name)) == listed[name]]
    return (*ours, *((JOB_FILE,) if _is_request(folder / JOB_FILE) else ()))


def _is_request(path: Path) -> bool:
    try:
        return bool(read_json(path, schema=JOB_SCHEMA))
    except InputError:
        return False


def read_finished(
    folder: Path, *, space: RobotSpace = RobotSpace.NOMINAL, is_compared: bool = True
) -> FinishedCalibration:
    """Read a result folder with its seams as `Seam` objects; parameters as of `read_result_folder`.

    Raises `InputError` or `FormatError` as `read_result_folder` does.
    Raises `FrameError` when the seams are not in `base`, or in another robot space than expected.
    """
    found = read_result_folder(folder, is_compared=is_compared)
    path = folder / SEAMS_FILE
    stated = RobotSpace.parse(found.seams["robot_space"])
    if stated is not space:
        raise FrameError(f"{path}: {_WRONG_SPACE[stated]}", code=ErrorCode.ROBOT_SPACE)
    seams = seams_from_record(found.seams, path=str(path))
    errors, torch = errors_from_record(found.seams), torch_of_seams(found.seams, path)
    glb = found.part_glb
    if glb is not None:
        glb = moved_glb(glb, found.calibration, path=str(folder / PART_FILE))
    return FinishedCalibration(found.T_base_part, seams, errors, found.calibration, glb, torch, found.note)
