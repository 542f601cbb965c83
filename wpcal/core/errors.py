"""What can go wrong, as types a caller can tell apart; every message names what, where and what was expected."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class WpcalError(Exception):
    """Anything that wpcal raises on purpose; `exit_code` is what the command line ends with."""

    exit_code = 2


class InputError(WpcalError, ValueError):
    """The caller's data cannot be used."""


class FrameError(InputError):
    """Two quantities stand in different frames."""


class UnitError(InputError):
    """A unit is missing, unknown or implausible."""


class GeometryError(InputError):
    """Degenerate geometry: collinear, coincident, mirrored, empty or ambiguous."""


class FormatError(InputError):
    """A file breaks its format; the message begins with the file and, where known, the line and column.

    Parameters
    ----------
    message : str
        What is wrong and what was expected.
    path : str, optional
        The file, as the user named it.
    line : int, optional
        Line in the file, counted from 1.
    column : str or int, optional
        Name of the column, or its place counted from 1.

    Attributes
    ----------
    what : str
        The message without the place.
    """

    def __init__(
        self, message: str, *, path: str | None = None, line: int | None = None, column: str | int | None = None
    ) -> None:
        self.what, self.path, self.line, self.column = message, path, line, column
        place = ", ".join(
            part
            for part in (
                path,
                None if line is None else f"line {line}",
                None if column is None else f"column {column}",
            )
            if part
        )
        super().__init__(f"{place}: {message}" if place else message)


@contextmanager
def blamed_on(path: str) -> Iterator[None]:
    """Name the file that the data came from in a `GeometryError` or `UnitError` raised inside; no file, no change.

    Parameters
    ----------
    path : str
        The file, as the user named it; may be empty.
    """
    try:
        yield
    except (GeometryError, UnitError) as error:
        if not path:
            raise
        raise type(error)(f"{path}: {error}") from None


class ConvergenceError(WpcalError, RuntimeError):
    """A solver stopped before its goal; `best` is the best answer so far.

    Parameters
    ----------
    message : str
        What was not reached.
    best : object, optional
        The best answer found.
    """

    exit_code = 1

    def __init__(self, message: str, *, best: Any = None) -> None:
        self.best = best
        super().__init__(message)


class KernelError(WpcalError, RuntimeError):
    """The CAD kernel failed; raised in `cad` only."""

    exit_code = 70
