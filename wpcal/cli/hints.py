"""The option that helps against an error: library messages name what is missing, commands add the flag."""

from __future__ import annotations

from collections.abc import Mapping

from click import NoSuchOption

from wpcal.core.errors import ErrorCode, WpcalError

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


def with_hint(error: BaseException, message: str) -> str:
    """Return the message of an error, with the options that help against it in parentheses."""
    hint = HINTS.get(error.code) if isinstance(error, WpcalError) else None
    if isinstance(error, NoSuchOption) and error.ctx is not None:
        has = {flag for each in error.ctx.command.params for flag in each.opts}
        hint = next(iter(has & {INSTEAD.get(error.option_name, "")}), None)
    return message if hint is None else f"{message} ({hint})"
