"""Whether the files of one result folder come from one calibration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from wpcal.brep.mesh_glb import read_part_glb
from wpcal.core.errors import FormatError, FrameError
from wpcal.core.input_file import holds_file, read_bytes, sha256_of
from wpcal.core.transform import RigidTransform

SAME_POSE_MM = 1e-9
"""All files are written with all digits from one result: a larger difference of positions means two calibrations."""
SAME_POSE_RAD = 1e-9
"""The same for rotations: 1e-9 rad moves a point at one metre by 1e-6 mm, and round-off is a thousand times smaller."""


def agreed_pose(calibration: Mapping[str, Any], seams: Mapping[str, Any], *, path: Path) -> RigidTransform:
    """Return the ``T_base_part`` that both records state.

    Raises `FrameError` when the seams are not in `base`.
    Raises `InputError` when a pose is not a rigid motion.
    Raises `FormatError` when the poses differ by more than `SAME_POSE_MM` or `SAME_POSE_RAD`.
    """
    if seams["frame"] != "base" or seams["T_base_part"] is None:
        raise FrameError(f"{path}: expected seams in the frame 'base', got {seams['frame']!r}")
    of_seams, fitted = (
        RigidTransform.from_matrix(record["T_base_part"], target="base", source="part")
        for record in (seams, calibration)
    )
    if not of_seams.is_close(fitted, atol_mm=SAME_POSE_MM, atol_rad=SAME_POSE_RAD):
        raise FormatError("T_base_part differs from the one in calibration.json: two calibrations", path=str(path))
    return of_seams


def check_same_part(part_glb: bytes, calibration: Mapping[str, Any], *, path: Path) -> None:
    """Refuse a mesh of another part than the calibrated one.

    Raises `FormatError` when the file is not such a mesh, or was made from another STEP file.
    """
    expected = calibration.get("inputs", {}).get("part", {}).get("sha256")
    if read_part_glb(part_glb, path=str(path)).sha256 != expected:
        raise FormatError("was made from another STEP file than calibration.json", path=str(path))


def files_changed(folder: Path, request: Mapping[str, Any]) -> Iterator[str]:
    """Yield the names of files that are not as `wpcal calibrate` wrote them; missing ones are not named."""
    for name, written in request["files"].items():
        if holds_file(folder, name) and sha256_of(read_bytes(folder / name)) != written:
            yield name


def check_same_run(folder: Path, calibration: Mapping[str, Any]) -> None:
    """Refuse files of another run than ``calibration.json``. A file that is not there is not missed.

    Raises `FormatError` when a listed file has another SHA-256.
    """
    for name, expected in calibration.get("files", {}).items():
        if holds_file(folder, name) and sha256_of(read_bytes(folder / name)) != expected:
            what = "is not the file that the calibration in calibration.json wrote; calibrate again, or move it away"
            raise FormatError(what, path=str(folder / name))
