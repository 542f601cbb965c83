"""What a client is told of an exception."""

from __future__ import annotations

import os
import traceback
from collections.abc import Mapping
from typing import Any

import click

from cad.rpc.messages import Id, error_line
from cad.session.rows import Rows
from cad.session.session import fault_record
from wpcal.cli.hints import HINTS
from wpcal.core.errors import FormatError, InputError, OutOfMemoryError, WpcalError, fault_words

KERNEL = "KernelError"


def fault_line_of(request_id: Id, error: Exception, message: Mapping[str, Any]) -> bytes:
    """Return the line that says why a request has no result."""
    if isinstance(error, MemoryError | OutOfMemoryError):
        what = "the CAD kernel needs more memory than its limit; set WPCAL_KERNEL_MEMORY_GB to allow more"
        return error_line(request_id, KERNEL, what, code="kernel")
    if isinstance(error, WpcalError):
        return _told(request_id, error, message)
    if isinstance(error, click.ClickException):
        return error_line(request_id, "InputError", error.format_message(), code="input")
    if type(error).__module__.startswith("OCP."):
        what = f"the CAD kernel failed ({type(error).__name__}: {error}); the file may be damaged"
        return error_line(request_id, KERNEL, what, code="kernel")
    if isinstance(error, OSError) and error.filename is not None:
        what = f"{error.filename}: {(error.strerror or str(error)).lower()}"
        return error_line(request_id, "InputError", what, code="input")
    if os.environ.get("WPCAL_DEBUG"):
        traceback.print_exception(error)
    return error_line(request_id, "InternalError", fault_words(error), code="internal")


def _told(request_id: Id, error: WpcalError, message: Mapping[str, Any]) -> bytes:
    """Return the line about an error that wpcal raised on purpose."""
    kind, place = type(error).__name__, dict[str, Any]()
    record: dict[str, Any] = {"message": str(error), "code": str(error.code)}
    taught = message["params"].get("taught")
    if isinstance(error, FormatError):
        place = {"path": error.path or None, "line": error.line, "column": error.column}
        if isinstance(taught, dict) and "path" not in taught and not error.path:
            record = fault_record(error, _rows_of(taught))
            place = {"row": record["row"], "column": record["column"]}
    text, code = record["message"], record["code"]
    return error_line(request_id, kind, text, code=code, hint=HINTS.get(code), **place)


def _rows_of(taught: dict[str, Any]) -> Rows | None:
    try:
        return Rows.from_record(taught)
    except InputError:
        return None
