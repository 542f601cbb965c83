"""What a command with ``--json`` prints on stdout when it fails: the line on stderr, as data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from wpcal.cli.hints import HINTS
from wpcal.core.errors import FormatError, WpcalError

ERROR_SCHEMA = "wpcal/error/1"
USAGE, INTERNAL, INTERRUPTED = "usage", "internal", "interrupted"
"""Codes of what is not a `WpcalError`: wrong use of the command line, our own fault, a signal."""


def error_record(error: BaseException, message: str, exit_code: int, arguments: Sequence[str]) -> dict[str, Any]:
    """Return the record ``wpcal/error/1``."""
    if isinstance(error, FormatError) and error.path:
        place: tuple[Any, ...] = (error.path, error.line, error.column, error.what)
    else:
        file = next((word for word in arguments if word and message.startswith(f"{word}: ")), None)
        place = (file, None, None, message if file is None else message.removeprefix(f"{file}: "))
    file, line, column, what = place
    return {
        "schema": ERROR_SCHEMA,
        "exit_code": exit_code,
        "code": str(error.code) if isinstance(error, WpcalError) else _code_of(exit_code),
        "file": file,
        "line": line,
        "column": None if column is None else str(column),
        "message": " ".join(str(what).split()),
        "hint": HINTS.get(error.code) if isinstance(error, WpcalError) else None,
    }


def _code_of(exit_code: int) -> str:
    return USAGE if exit_code == WpcalError.exit_code else INTERRUPTED if exit_code >= 128 else INTERNAL
