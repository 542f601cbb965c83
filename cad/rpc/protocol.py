"""Which methods there are, and what their params must be: as the types say (`cad.rpc.types`), one per method."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from cad.rpc.messages import MessageFaultError, Request
from cad.rpc.types import METHODS, answer_schema, method_type
from wpcal.core.errors import FormatError
from wpcal.core.record_check import check_complete
from wpcal.core.record_types import schema
from wpcal.core.wording import printable

HANDLE = "handle"
ANSWER = "answer"  #: The schema of every line that is sent; the others are those of methods.


@cache
def method_names() -> tuple[str, ...]:
    """Return the names of all methods, sorted."""
    return tuple(sorted(METHODS))


@cache
def schema_of(name: str) -> Mapping[str, Any]:
    """Return the JSON Schema of a method, of its ``params`` and ``result``, or of `ANSWER`."""
    if name == ANSWER:
        return answer_schema()
    return schema.schema_of(method_type(name), f"urn:wpcal:schema:rpc-{name}:1", inline=True)


@cache
def params_of(method: str) -> Mapping[str, Any]:
    """Return the schemas of the params of a method, by their names."""
    found: Mapping[str, Any] = schema_of(method)["properties"]["params"]["properties"]
    return found


def takes_handle(method: str) -> bool:
    """Tell whether a method is about an opened part."""
    return HANDLE in params_of(method)


def check_request(request: Request) -> None:
    """Raise `MessageFaultError` if the method is unknown, or the params are not as its schema says."""
    if request.method not in method_names():
        what = f"{printable(request.method[:100])}: no such method; known: {', '.join(method_names())}"
        raise MessageFaultError(what, id=request.id, kind="UnknownMethod")
    known = params_of(request.method)
    unknown = sorted(set(request.params) - set(known))
    if unknown:
        what = f"params: {printable(', '.join(unknown)[:200])}: not known by {request.method}"
        raise MessageFaultError(f"{what}; known: {', '.join(known) or 'none'}", id=request.id)
    try:
        check_complete({"params": request.params}, schema_of(request.method), path="")
    except FormatError as error:
        raise MessageFaultError(error.what, id=request.id) from None
