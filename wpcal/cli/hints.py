"""The option that helps against an error: library messages name what is missing, commands add the flag."""

from __future__ import annotations

from wpcal.core.errors import ErrorCode, WpcalError

HINTS = {
    ErrorCode.USER_FRAME_MISSING: "--uframe",
    ErrorCode.TOOL_MISSING: "--tool",
    ErrorCode.ARM_MISSING: "--robot and --tool, or --points",
    ErrorCode.POINT_UNUSABLE: "--points",
    ErrorCode.NOMINAL_MISSING: "--nominal",
}


def with_hint(error: WpcalError) -> str:
    """Return the message of an error, with the options that help against it in parentheses."""
    hint = next((flags for code, flags in HINTS.items() if error.code == code), None)
    return str(error) if hint is None else f"{error} ({hint})"
