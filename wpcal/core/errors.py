"""What can go wrong, as types and codes that a caller can tell apart.

Every message says what is wrong, where, and what was expected.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from typing import Any


class ErrorCode(StrEnum):
    """Every code of an error, for programs: a message may be reworded, its code stays.

    The first seven are the usual codes of the classes below. The others name one cause each, where a page or a command
    acts on the cause. Extensions may use other words.
    """

    INPUT = "input"  #: The data cannot be used, and no other code says why.
    FRAME = "frame"  #: Two quantities are in different frames.
    UNIT = "unit"  #: A unit is missing, unknown or implausible.
    GEOMETRY = "geometry"  #: The geometry is degenerate.
    FORMAT = "format"  #: A file breaks its format.
    CONVERGENCE = "convergence"  #: A solver stopped before its goal.
    KERNEL = "kernel"  #: The CAD kernel failed.
    EXISTS = "exists"  #: An output file or folder already exists; the caller must allow overwriting.
    USER_FRAME_MISSING = "user-frame-missing"
    """A program does not contain the values of its user frame; the caller must give them."""
    TOOL_MISSING = "tool-missing"  #: A position is that of the flange or of the joints; the caller must give the tool.
    ARM_MISSING = "arm-missing"  #: A position is stored as joint values; the caller must give the arm and the tool.
    POINT_UNUSABLE = "point-unusable"
    """A program stores a point without a usable position; the caller can name the points to read."""
    NOMINAL_MISSING = "nominal-missing"  #: The nominal place of the part would resolve this; the caller must give it.
    ROBOT_SPACE = "robot-space"
    """A result was taught through an identified robot and is used without it, or the other way round."""
    NO_SEAM = "no-seam"  #: The part has no seam; the caller can also take notches inside one solid.
    NOTHING_ACCEPTED = "nothing-accepted"  #: No seam is accepted; the caller can take the candidates as well.
    PART_MISSING = "part-missing"
    """A result folder has no triangles of the part, with which poses and moves are checked."""
    POSE_IN_MATERIAL = "pose-in-material"  #: The torch would be inside the part at a pose.
    JOINT_PATH = "joint-path"
    """An arm cannot follow a seam or a way within its joint limits and without changing its branch."""
    NO_FREE_WAY = "no-free-way"  #: No checked way of the torch leads from one seam to the next.
    FEATURES_NOT_CHOSEN = "features-not-chosen"  #: No set of features could be chosen; the caller can name them.
    MARK_UNKNOWN = "mark-unknown"  #: No edge has the name, layer or colour that the caller gave.
    SOLID_UNKNOWN = "solid-unknown"  #: No solid, product or instance has the name that the caller gave.
    EDGE_UNKNOWN = "edge-unknown"  #: No edge is at the place that the caller gave.
    PORT_UNUSABLE = "port-unusable"  #: The port cannot be opened; the caller can choose another.
    WELD_RULES_MISSING = "weld-rules-missing"
    """Weld data was written with rules of the user; the caller must give them again."""
    WELDS_MISSING = "welds-missing"  #: Arc instructions need weld data.
    PLACE_UNWRITABLE = "place-unwritable"
    """Nothing can be written at the place of an output; the caller can choose another."""


def fault_words(error: object, *, debug: bool = True) -> str:
    """Say that an error which nobody foresaw is a defect of wpcal. `debug`: Whether WPCAL_DEBUG=1 shows its place."""
    kind = f"{type(error).__name__}: " if isinstance(error, Exception) else ""
    return f"internal error ({kind}{error}); this is our fault{': set WPCAL_DEBUG=1 to see where' if debug else ''}"


LONGEST_MESSAGE = 2000  #: Characters of a message. The longest of wpcal's own have 500.


class WpcalError(Exception):
    """Anything that wpcal raises on purpose.

    `code`: The cause, for programs: an `ErrorCode`. By default the usual code of the class.
    """

    exit_code = 2
    code: str = ErrorCode.INPUT

    def __init__(self, message: str = "", *, code: str | None = None) -> None:
        super().__init__(whole_text(message))
        if code is not None:
            self.code = code


def whole_text(message: str) -> str:
    """Return a message that can be written: names in a file may be longer than any page, or no Unicode text."""
    if len(message) > LONGEST_MESSAGE:
        message = f"{message[:LONGEST_MESSAGE]}…"
    return message if message.isascii() else message.encode("utf-8", errors="backslashreplace").decode("utf-8")


class InputError(WpcalError, ValueError):
    """The caller's data cannot be used."""


class FrameError(InputError):
    """Two quantities are in different frames."""

    code = ErrorCode.FRAME


class UnitError(InputError):
    """A unit is missing, unknown or implausible."""

    code = ErrorCode.UNIT


class GeometryError(InputError):
    """Degenerate geometry: collinear, coincident, mirrored, empty or ambiguous."""

    code = ErrorCode.GEOMETRY


class FormatError(InputError):
    """A file breaks its format; the message begins with the file and, where known, the line and column."""

    code = ErrorCode.FORMAT

    def __init__(
        self,
        message: str,
        *,
        path: str | None = None,
        line: int | None = None,
        column: str | int | None = None,
        code: str | None = None,
    ) -> None:
        self.what, self.path, self.line, self.column = message, path, line, column
        place = ", ".join(
            part
            for part in (path, f"line {line}" if line else None, None if column is None else f"column {column}")
            if part
        )
        super().__init__(f"{place}: {message}" if place else message, code=code)


@contextmanager
def fields_of(path: str, wrong: type[InputError] = InputError) -> Iterator[None]:
    """Name the file in errors raised inside, where its fields are read; a missing one is a `FormatError`."""
    try:
        yield
    except FormatError:
        raise
    except InputError as error:
        raise wrong(f"{path}: {error}") from None
    except KeyError as error:
        raise FormatError(f"the field {error.args[0]!r} is missing", path=path) from None
    except (TypeError, ValueError, AttributeError) as error:
        raise FormatError(f"a field has a wrong type: {error}", path=path) from None


@contextmanager
def blamed_on(path: str) -> Iterator[None]:
    """Put the file's name before the message of a `GeometryError` or `UnitError` raised inside."""
    try:
        yield
    except (GeometryError, UnitError) as error:
        if not path:
            raise
        raise type(error)(f"{path}: {error}", code=error.code) from None


class ConvergenceError(WpcalError, RuntimeError):
    """A solver stopped before it reached its goal."""

    exit_code = 1
    code = ErrorCode.CONVERGENCE

    def __init__(self, message: str, *, best: Any = None, code: str | None = None) -> None:
        self.best = best
        super().__init__(message, code=code)


class KernelError(WpcalError, RuntimeError):
    """The CAD kernel failed on a file, or reached a limit of time or memory; raised in `cad` only."""

    code = ErrorCode.KERNEL


class OutOfMemoryError(KernelError):
    """The CAD kernel ran out of memory."""
