"""An error as a user meets it: with the option that helps against it, and with ``--json`` as data on stdout."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from click import NoSuchOption

from wpcal.core.errors import ErrorCode, FormatError, WpcalError

HINTS: Mapping[str, str] = {
    ErrorCode.EXISTS: "--force",
    ErrorCode.USER_FRAME_MISSING: "--uframe",
    ErrorCode.TOOL_MISSING: "--tool",
    ErrorCode.ARM_MISSING: "--robot and --tool, or --points",
    ErrorCode.POINT_UNUSABLE: "--points",
    ErrorCode.NOMINAL_MISSING: "--nominal",
    ErrorCode.ROBOT_SPACE: "--robot",
    ErrorCode.NO_SEAM: "--concave always",
    ErrorCode.NOTHING_ACCEPTED: "--all",
    ErrorCode.FEATURES_NOT_CHOSEN: "--touch",
    ErrorCode.MARK_UNKNOWN: "--marked",
    ErrorCode.SOLID_UNKNOWN: "--weld, --not, --member",
    ErrorCode.EDGE_UNKNOWN: "--edge, --add-edge",
    ErrorCode.PORT_UNUSABLE: "--port",
    ErrorCode.WELD_RULES_MISSING: "--weld-rules",
    ErrorCode.WELDS_MISSING: "--welds",
    ErrorCode.PLACE_UNWRITABLE: "--out",
}
"""By the code of an error: the options that help."""
INSTEAD: Mapping[str, str] = {"--force": "--resume", "--resume": "--force"}
"""By an option that a command does not have: what it has in its place, if anything."""

ERROR_SCHEMA = "wpcal/error/1"
USAGE, INTERNAL, INTERRUPTED = "usage", "internal", "interrupted"
"""Codes of what is not a `WpcalError`: wrong use of the command line, our own fault, a signal."""


def with_hint(error: BaseException, message: str) -> str:
    """Return the message of an error, with the options that help against it in parentheses."""
    hint = HINTS.get(error.code) if isinstance(error, WpcalError) else None
    if isinstance(error, NoSuchOption) and error.ctx is not None:
        has = {flag for each in error.ctx.command.params for flag in each.opts}
        hint = next(iter(has & {INSTEAD.get(error.option_name, "")}), None)
    return message if hint is None else f"{message} ({hint})"


def error_record(error: BaseException, message: str, exit_code: int, arguments: Sequence[str]) -> dict[str, Any]:
    """Return the record ``wpcal/error/1``."""
    if isinstance(error, FormatError) and error.path:
        place: tuple[Any, ...] = (error.path, error.line, error.column, error.what)
    else:
        file = next((word for word in arguments if word and message.startswith(f"{word}: ")), None)
        place = (file, None, None, message.removeprefix(f"{file}: "))
    file, line, column, what = place
    code = USAGE if exit_code == WpcalError.exit_code else INTERRUPTED if exit_code >= 128 else INTERNAL
    return {
        "schema": ERROR_SCHEMA,
        "exit_code": exit_code,
        "code": str(error.code) if isinstance(error, WpcalError) else code,
        "file": file,
        "line": line,
        "column": None if column is None else str(column),
        "message": " ".join(str(what).split()),
        "hint": HINTS.get(error.code) if isinstance(error, WpcalError) else None,
    }
