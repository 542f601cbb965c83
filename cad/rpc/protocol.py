"""Which methods there are, and what their params must be: as the schemas ``wpcal/rpc-METHOD/1`` say."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from typing import Any

from cad.rpc.messages import MessageFaultError, Request
from wpcal.core.errors import FormatError
from wpcal.core.record_check import check_record
from wpcal.core.schemas import schema_names, schema_text
from wpcal.printable import printable

PREFIX = "wpcal/rpc-"
HANDLE = "handle"


@cache
def method_names() -> tuple[str, ...]:
    """Return the names of all methods, sorted."""
    return tuple(name.removeprefix(PREFIX).rpartition("/")[0] for name in schema_names() if name.startswith(PREFIX))


def schema_of(method: str) -> str:
    """Return the name of the schema of a method, with ``params`` and ``result``."""
    return f"{PREFIX}{method}/1"


@cache
def params_of(method: str) -> Mapping[str, Any]:
    """Return the schemas of the params of a method, by their names."""
    schema = json.loads(schema_text(schema_of(method)))
    found: Mapping[str, Any] = schema["properties"]["params"].get("properties", {})
    return found


def takes_handle(method: str) -> bool:
    """Tell whether a method is about an opened part."""
    return HANDLE in params_of(method)


def check_request(request: Request) -> None:
    """Refuse a request whose method is unknown, or whose params are not as its schema says.

    Raises
    ------
    MessageFaultError
    """
    if request.method not in method_names():
        what = f"{printable(request.method[:100])}: no such method; known: {', '.join(method_names())}"
        raise MessageFaultError(what, id=request.id, kind="UnknownMethod")
    known = params_of(request.method)
    unknown = sorted(set(request.params) - set(known))
    if unknown:
        what = f"params: {printable(', '.join(unknown)[:200])}: not known by {request.method}"
        raise MessageFaultError(f"{what}; known: {', '.join(known) or 'none'}", id=request.id)
    try:
        check_record({"params": request.params}, schema_of(request.method), path="", is_complete=True)
    except FormatError as error:
        raise MessageFaultError(error.what, id=request.id) from None
