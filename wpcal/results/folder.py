"""A finished calibration as files: ``calibration.json`` and ``seams.json`` of one folder, checked for agreement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wpcal.calibrate.result import SCHEMA as CALIBRATION_SCHEMA
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import FormatError, FrameError, InputError
from wpcal.core.records import read_json
from wpcal.core.robot_space import RobotSpace
from wpcal.core.transform import RigidTransform
from wpcal.seam.record import SEAMS_SCHEMA, seams_from_record
from wpcal.seam.seam import Seam

_WRONG_SPACE = {
    RobotSpace.IDENTIFIED: "the points were taught through an identified robot; give its file with --robot, or the "
    "robot's error comes back when the controller replays the seams with its nominal model",
    RobotSpace.NOMINAL: "the points were taught through the controller's own nominal model; leave --robot away: "
    "corrected at one end only, the robot's error comes back",
}
SAME_POSE = 1e-9
"""Both files are written with all digits from one result: anything beyond round-off means two calibrations."""


@dataclass(frozen=True, slots=True, eq=False)
class FinishedCalibration:
    """What `wpcal export` starts from.

    Parameters
    ----------
    T_base_part : RigidTransform
    seams : tuple of Seam
        With frames in `base`.
    u95_mm : tuple of (ndarray or None)
        The 95 % error at every frame of each seam, mm, where the file has it.
    calibration : dict
        The record of ``calibration.json``.
    part_glb : bytes or None
        ``part.glb``, the part's triangles, where there is one.
    """

    T_base_part: RigidTransform
    seams: tuple[Seam, ...]
    u95_mm: tuple[FloatArray | None, ...]
    calibration: dict[str, Any]
    part_glb: bytes | None = None

    def select(self, names: Sequence[str] | None = None, *, everything: bool = False) -> FinishedCalibration:
        """Return the accepted seams, those named, or all of them.

        Raises
        ------
        InputError
            When a name is unknown or nothing is left.
        """
        known = [seam.name for seam in self.seams]
        unknown = [name for name in names or () if name not in known]
        if unknown:
            raise InputError(f"unknown seam {', '.join(unknown)}; the file has {', '.join(known) or 'none'}")
        rows = [
            row
            for row, seam in enumerate(self.seams)
            if (seam.name in names if names is not None else everything or seam.accepted)
        ]
        if not rows:
            what = f"none of the {len(known)} seams is accepted" if known else "the calibration has no seams"
            raise InputError(f"{what}; nothing to export (--all takes candidates, too)")
        seams = tuple(self.seams[row] for row in rows)
        return replace(self, seams=seams, u95_mm=tuple(self.u95_mm[row] for row in rows))


def read_finished(folder: Path, *, space: RobotSpace = RobotSpace.NOMINAL) -> FinishedCalibration:
    """Read ``calibration.json`` and ``seams.json``.

    Parameters
    ----------
    folder : Path
        As `wpcal calibrate` wrote it.
    space : RobotSpace
        In which robot space the seams are expected.

    Raises
    ------
    InputError
        When the folder or a file is not there.
    FrameError
        When the seams are not in `base`, or in another robot space than expected.
    FormatError
        When a file breaks its format, or the two do not come from one calibration.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; expected the folder of a finished calibration")
    path = folder / "seams.json"
    calibration = read_json(folder / "calibration.json", schema=CALIBRATION_SCHEMA)
    record = read_json(path, schema=SEAMS_SCHEMA)
    if record.get("frame") != "base" or record.get("T_base_part") is None:
        raise FrameError(f"{path}: expected seams in the frame 'base', got {record.get('frame')!r}")
    found = RobotSpace.parse(record.get("robot_space", ""))
    if found is not space:
        raise FrameError(f"{path}: {_WRONG_SPACE[found]}")
    T_base_part = RigidTransform.from_matrix(record["T_base_part"], target="base", source="part")
    fitted = RigidTransform.from_matrix(calibration.get("T_base_part", ()), target="base", source="part")
    if not T_base_part.is_close(fitted, atol_mm=SAME_POSE, atol_rad=SAME_POSE):
        raise FormatError("T_base_part differs from the one in calibration.json: two calibrations", path=str(path))
    seams = seams_from_record(record, path=str(path))
    part = folder / "part.glb"
    part_glb = part.read_bytes() if part.is_file() else None
    return FinishedCalibration(T_base_part, seams, _errors(record), calibration, part_glb)


def _errors(record: dict[str, Any]) -> tuple[FloatArray | None, ...]:
    columns = [[frame.get("u95_mm") for frame in seam["frames"]] for seam in record["seams"]]
    return tuple(frozen(column) if column and None not in column else None for column in columns)
