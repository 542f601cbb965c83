"""`--part` of plans: the part whose triangles are compared, where no part.glb is beside the seams."""

from __future__ import annotations

from pathlib import Path

from wpcal.cli.shared_help import path_option

PARTS = "wpcal.parts"
"""The entry-point group: functions from a path to the bytes of a part.glb, named by a suffix without the dot."""
MESH_SUFFIX = ".glb"

part_option = path_option(
    "--part",
    "part",
    metavar="PART.step|part.glb",
    help="The part that is compared with the robot, in the frame of the seams.  [default: part.glb beside the seams]",
)


def read_part_option(path: Path | None) -> bytes | None:
    """Return the triangles of a part as ``part.glb`` has them; None if no part is given.

    Raises `InputError` when the file cannot be read, or nothing that is installed reads files with this suffix.
    """
    from wpcal.core.errors import InputError
    from wpcal.core.input_file import read_bytes
    from wpcal.core.installed import installed

    if path is None:
        return None
    suffix = path.suffix.lower()
    if suffix == MESH_SUFFIX:
        return read_bytes(path)
    readers = {entry.name: entry for entry in installed(PARTS)}
    name = {".stp": "step"}.get(suffix, suffix.removeprefix("."))
    if name not in readers:
        known = ", ".join([MESH_SUFFIX, *(f".{each}" for each in sorted(readers))])
        raise InputError(f"--part {path}: expected one of {known}")
    found: bytes = readers[name].load()(path)
    return found
