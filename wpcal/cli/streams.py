"""Standard output and error that never end a command: what they cannot take is lost, and the command can say so.

Names from files are printed with their control characters as escapes.

The exit code is the result's. ``wpcal calibrate … | true`` has a verdict, too, although nobody reads what it prints.
"""

from __future__ import annotations

import io
import os
import sys

from wpcal.core.wording import printable

_OUTPUT, _ERRORS = 1, 2
"""Their file descriptors."""


class LossyFile(io.FileIO):
    """A file descriptor that drops what it cannot write, and remembers the first reason."""

    def __init__(self, descriptor: int) -> None:
        super().__init__(descriptor, "wb", closefd=False)
        self.lost_because = ""

    def write(self, data: object, /) -> int:
        """Write, or drop all of it. Return how much the caller need not give again."""
        try:
            return super().write(data) or 0  # type: ignore[arg-type]  # a buffer, as in FileIO
        except OSError as error:
            self.lost_because = self.lost_because or (error.strerror or str(error)).lower()
            return memoryview(data).nbytes  # type: ignore[arg-type]


class PrintableText(io.TextIOWrapper):
    """Text in which control characters are shown as escapes: names of files and solids cannot steer the terminal."""

    def write(self, text: str, /) -> int:
        """Write a text that may hold names from files."""
        super().write(printable(text))
        return len(text)

    def write_styled(self, text: str) -> int:
        """Write a text whose escape sequences are wpcal's own."""
        return super().write(text)


def protect_streams() -> LossyFile | None:
    """Replace standard output and error by streams that cannot fail."""
    closed = _open_missing()
    output = _lossy(sys.stdout, _OUTPUT) if sys.stdout is sys.__stdout__ else None
    if output is not None:
        sys.stdout = _text_to(output, sys.stdout)
        output.lost_because = "it is closed" if _OUTPUT in closed else ""
    errors = _lossy(sys.stderr, _ERRORS) if sys.stderr is sys.__stderr__ else None
    if errors is not None:
        sys.stderr = _text_to(errors, sys.stderr)
    return output


def _open_missing() -> list[int]:
    """Open the null device for each standard descriptor that is closed, or a file of ours would take its number."""
    closed = []
    for descriptor in range(_ERRORS + 1):
        try:
            os.fstat(descriptor)
        except OSError:
            closed.append(descriptor)
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number
    return closed


def _lossy(stream: object, descriptor: int) -> LossyFile | None:
    if stream is None:  # Python found it closed
        return LossyFile(descriptor)
    if not isinstance(stream, io.TextIOWrapper):
        return None
    try:
        stream.flush()
        return LossyFile(stream.fileno())
    except (OSError, ValueError):
        return None


def _text_to(raw: LossyFile, stream: object) -> PrintableText:
    """Return the text stream; a terminal without Greek letters shows question marks."""
    encoding = stream.encoding if isinstance(stream, io.TextIOWrapper) else "utf-8"
    return PrintableText(
        io.BufferedWriter(raw),
        encoding=encoding,
        errors="replace",
        line_buffering=raw.fileno() == _ERRORS or raw.isatty(),
    )
