"""The messages of the protocol as lines of JSON: requests are read strictly, answers are written in ASCII."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass
from typing import Any, Never, TypeAlias

from wpcal.core.wording import printable

PROTOCOL = 1  #: Version of the protocol; a change that an older client cannot take has another number.
LONGEST_ID = 200
LARGEST_ID = 2**53  #: Every language reads whole numbers up to this one exactly.
MOST_DEEP = "too many lists or objects in one another"

_COUNT = re.compile(r"(?<![\w.])(\d{1,15}) of (\d{1,15})(?![\w.])")

Id: TypeAlias = int | str


@dataclass(frozen=True, slots=True)
class Request:
    """What a client asks."""

    id: Id
    method: str
    params: dict[str, Any]


class MessageFaultError(Exception):
    """A line is not a request."""

    def __init__(self, what: str, *, id: Id | None = None, kind: str = "ProtocolError") -> None:  # noqa: A002
        super().__init__(what)
        self.id, self.kind = id, kind


def read_request(line: bytes) -> Request:
    """Return the request on a line. Raises `MessageFaultError` if there is none."""
    value = _parse(line)
    if not isinstance(value, dict):
        raise MessageFaultError(f"expected a JSON object with id and method, got {_kind(value)}")
    found = value.get("id")
    if not is_id(found):
        what = "no id" if "id" not in value else f"the id {printable(repr(found)[:LONGEST_ID])}"
        raise MessageFaultError(f"expected a whole number or a text as id, got {what}")
    request_id: Id = found  # type: ignore[assignment]
    unknown = sorted(set(value) - {"id", "method", "params", "jsonrpc"})  # of JSON-RPC 2.0: clients send its version
    if unknown:
        what = printable(", ".join(unknown)[:LONGEST_ID])
        raise MessageFaultError(f"unknown fields of a request: {what}; known: id, method, params", id=request_id)
    method, params = value.get("method"), value.get("params", {})
    if not isinstance(method, str):
        raise MessageFaultError("expected the name of a method as text", id=request_id)
    if not isinstance(params, dict):
        raise MessageFaultError(f"expected params as an object, got {_kind(params)}", id=request_id)
    return Request(request_id, method, params)


def is_id(value: object) -> bool:
    """Tell whether a value can be the id of a request."""
    if isinstance(value, str):
        return 0 < len(value) <= LONGEST_ID
    return isinstance(value, int) and not isinstance(value, bool) and abs(value) <= LARGEST_ID


def _parse(line: bytes) -> Any:
    try:
        value = json.loads(line.decode("utf-8"), parse_constant=_refuse_constant, parse_float=_finite)
        if b"\\u" in line:
            json.dumps(value, ensure_ascii=False).encode("utf-8")  # half of a character has no UTF-8
    except UnicodeDecodeError:
        raise MessageFaultError("the line is not UTF-8 text") from None
    except UnicodeEncodeError:
        raise MessageFaultError("a text holds half of a character (a lone surrogate)") from None
    except json.JSONDecodeError as error:
        raise MessageFaultError(f"the line is not JSON: {error.msg} at character {error.pos + 1}") from None
    except RecursionError:
        raise MessageFaultError(f"the line has {MOST_DEEP}") from None
    except ValueError:  # Python refuses to convert it
        raise MessageFaultError("the line holds a whole number of thousands of digits") from None
    return value


def _refuse_constant(name: str) -> Never:
    raise MessageFaultError(f"{name} is not a JSON number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise MessageFaultError(f"the number {text[:LONGEST_ID]} is too large")
    return value


def _kind(value: object) -> str:
    words = {dict: "an object", list: "a list", str: "a text", bool: "true or false", type(None): "null"}
    return words.get(type(value), "a number")


def to_line(message: dict[str, Any]) -> bytes:
    """Return a message as a line."""
    return json.dumps(message, allow_nan=False, separators=(",", ":"), default=_plain).encode("ascii") + b"\n"


def _plain(value: Any) -> Any:
    """Return an array of NumPy as lists, and its numbers as numbers."""
    return value.tolist()


def result_line(request_id: Id, result: dict[str, Any]) -> bytes:
    """Return the line that answers a request."""
    return to_line({"id": request_id, "result": result})


def error_line(request_id: Id | None, kind: str, message: str, **more: Any) -> bytes:
    """Return the line that says why a request has no result."""
    text = printable(" ".join(message.split()))
    error = {"kind": kind, "code": kind, "message": text, "hint": None, **more}
    return to_line({"id": request_id, "error": error})


def progress_line(request_id: Id, text: str) -> bytes:
    """Return the line that says what is being done. Of a text with ``3 of 10`` the numbers are told, too."""
    counted = _COUNT.search(text)
    done, of = (None, None) if counted is None else map(int, counted.groups())
    shown = printable(" ".join(text.split()))
    return to_line({"id": request_id, "progress": {"text": shown, "done": done, "of": of}})
