"""Taught points from a controller's program: which controller wrote the file, and its points in the robot's base."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.registry import Controller, controller_of_file, controllers
from wpcal.controllers.user_frames import ProgramReading, points_in_base
from wpcal.core.errors import InputError
from wpcal.core.input_file import read_bytes, sha256_of
from wpcal.taught.programs import TaughtProgram
from wpcal.taught.table import TaughtPoints


def is_program(path: Path) -> bool:
    """Tell by the suffix whether a file is a controller's program."""
    return controller_of_file(path) is not None


def require_program(path: Path) -> Controller:
    """Return the controller that reads a file.

    Raises `InputError` when no controller reads files of this suffix, with the known suffixes.
    """
    controller = controller_of_file(path)
    if controller is None:
        known = ", ".join(sorted(suffix for one in controllers() for suffix in one.suffixes))
        raise InputError(f"{path}: unknown kind of program {path.suffix or '(no suffix)'!r}; known: {known}")
    return controller


def read_taught_program(path: Path, reading: ProgramReading | None = None) -> TaughtPoints:
    """Read the taught points of a program as points in `base`.

    Raises `InputError` when the file cannot be opened, its suffix is unknown, or `reading` cannot be used.
    Raises `FormatError` when the file breaks its format, holds no points or not the points asked for, or does not say
    the user frame.
    """
    require_program(path)
    raw = read_bytes(path)
    return replace(points_in_base(parse_program(raw, path), reading or ProgramReading()), sha256=sha256_of(raw))


def parse_program(raw: bytes, path: Path) -> TaughtProgram:
    """Return what a program's bytes hold, in the frames that it names; also the points that cannot be used.

    Raises `InputError` when the suffix is unknown.
    Raises `FormatError` when the program breaks its format.
    """
    reader = require_program(path).load_reader()
    return TaughtProgram(str(path), reader, reader.read(raw.decode(ENCODING), str(path)))
