"""A server for one page and one person: at a secret address, on this machine only unless another host is given.

Any page in the same browser can send requests to a port of this machine. If its owner points a name at 127.0.0.1, such
requests even look like the server's own. Therefore:

* the address contains a random token;
* the header ``Host`` must be exactly an address served, which a page under another name cannot send;
* a request that changes something must come from that address (``Origin``) and be JSON, which no form can send;
* no other page may embed or read this page.
"""

from __future__ import annotations

import base64
import binascii
import json
import logging
import math
import os
import secrets
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

import numpy as np
import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Receive, Scope, Send

from cad.pick.address import LOCAL, Listening, listen
from cad.pick.draft import Keyed
from cad.pick.patience import ImpatientProtocol
from cad.pick.shared_seams import SharedSeams
from cad.pick.shared_table import FileChangedError, SharedTable
from cad.session.rows import Rows
from cad.session.session import PickSession, fault_record
from cad.workpiece.moving import MovingChoice
from wpcal.cli.signals import ENDING
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError, WpcalError, fault_words
from wpcal.robot.links.watch import Watch

LARGEST_BYTES = 8_000_000  #: Largest request: the longest list of points accepted, in base64.
TOKEN_BYTES = 18  #: 144 bits cannot be guessed.
INTERNAL = "internal"  #: Code of a defect of wpcal: any exception that is not a `WpcalError`.
SECONDS_TO_END = 2  #: Time for requests in progress when the server is told to end.
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}

_log = logging.getLogger("wpcal.pick")


class PickServer:
    """A page and a session at an address. The address is known at once; it answers after `run` is called.

    `at`: By default a free port, which only this machine reaches.
    """

    def __init__(
        self,
        session: PickSession,
        table: SharedTable,
        page: str,
        *,
        seams: SharedSeams | None = None,
        at: Listening | None = None,
        watch: Watch | None = None,
    ) -> None:
        listening = at or listen(LOCAL, 0)
        self._socket, self.is_local = listening.socket, listening.is_local
        token = secrets.token_urlsafe(TOKEN_BYTES)
        self.url = f"http://{listening.hosts[0]}/{token}/"
        guard = Guard(
            build_app(session, table, seams or SharedSeams(session), page, token=token, watch=watch),
            hosts=listening.hosts,
            token=token,
        )
        self._server = uvicorn.Server(
            uvicorn.Config(
                guard,
                lifespan="off",
                ws="none",
                http=ImpatientProtocol,
                access_log=False,
                server_header=False,
                log_level="error" if os.environ.get("WPCAL_DEBUG") else "critical",
                timeout_graceful_shutdown=SECONDS_TO_END,
            )
        )

    def run(self) -> None:
        """Answer requests until Ctrl-C."""
        try:
            self._server.run(sockets=[self._socket])
        finally:
            self._socket.close()

    @contextmanager
    def ended_by_signals(self) -> Iterator[None]:
        """Let Ctrl-C, SIGTERM and a closed terminal end the server, also one that starts later within this context.

        uvicorn handles the first two only, and only while it serves: before, a signal would interrupt its start at
        any line. A signal other than Ctrl-C is passed on at the end of the context.
        """
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        received = list[int]()

        def end(number: int, _: FrameType | None) -> None:
            received.append(number)
            self._server.should_exit = True

        handlers = {number: signal.getsignal(number) for number in ENDING}
        for number, handler in handlers.items():
            if handler is not signal.SIG_IGN:
                signal.signal(number, end)
        try:
            yield
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
        for number in received:
            if number != signal.SIGINT:
                signal.raise_signal(number)


class Guard:
    """Passes requests of the page itself on, and refuses all others."""

    def __init__(self, app: ASGIApp, *, hosts: tuple[str, ...], token: str) -> None:
        self._app = app
        self._hosts = hosts
        self._token = token.encode("ascii")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request, or refuse it."""
        if scope["type"] != "http":
            return
        refusal = self._refusal(Request(scope))
        await (self._app if refusal is None else refusal)(scope, receive, send)

    def _refusal(self, request: Request) -> Response | None:
        first = str(request.scope["path"]).removeprefix("/").partition("/")[0].encode("utf-8", "replace")
        if request.headers.getlist("host") not in [[host] for host in self._hosts]:
            return PlainTextResponse("not this server's address", 421, HEADERS)
        if not secrets.compare_digest(first, self._token):
            return PlainTextResponse("not found; the whole address is shown in the terminal", 404, HEADERS)
        if request.method != "POST":
            return None
        if request.headers.getlist("origin") != [f"http://{request.headers['host']}"]:
            return PlainTextResponse("not from this server's page", 403, HEADERS)
        if request.headers.get("content-type", "").partition(";")[0].strip().lower() != "application/json":
            return PlainTextResponse("expected JSON", 415, HEADERS)
        return None


def build_app(
    session: PickSession, table: SharedTable, seams: SharedSeams, page: str, *, token: str, watch: Watch | None = None
) -> Starlette:
    """Return the application: ``GET /token/`` is the page; the actions take JSON by ``POST``.

    ``fit``, ``suggest``, ``promise``, ``touch`` and ``read`` are answered by the session. ``table``, ``keep``,
    ``save``, ``open`` and ``moving`` concern the table that all windows share, ``seams``, ``decide``, ``solid`` and
    ``outline`` their decisions about seams and members, and the borders of these. ``robot`` reads the position of a
    robot. Answers are ``{"answer": …}`` or ``{"fault": …}``, a record of `cad.session.session.fault_record`.
    """

    async def show(_: Request) -> Response:
        return HTMLResponse(page, headers=HEADERS)

    def rows_action(act: Callable[[Rows], dict[str, Any]]) -> Callable[[Any], dict[str, Any]]:
        def run(record: Any) -> dict[str, Any]:
            rows = Rows.from_record(record)
            try:
                return {"answer": act(rows)}
            except WpcalError as error:
                return {"fault": fault_record(error, rows)}

        return run

    def read(record: Any) -> dict[str, Any]:
        rows, left_out = session.read(**_file_of(record))
        return {"answer": {**rows.to_record(), "left_out": left_out}}

    by_rows = {"fit": session.fit, "suggest": session.suggest, "promise": session.promise}
    actions = {
        **{name: rows_action(act) for name, act in by_rows.items()},
        "read": read,
        "touch": lambda record: {"answer": session.touch(_vector(record, "p"), _vector(record, "normal"))},
        "table": lambda record: {"answer": table.changes_since(_field(record, "revision", int, -1))},
        "keep": lambda record: {"answer": table.keep(**_change_of(record))},
        "save": lambda record: _save(table, record),
        "moving": lambda record: {"answer": _choose(session, table, record)},
        "open": lambda record: {"answer": table.open_file()},
        **({} if watch is None else {"robot": lambda record: {"answer": watch.take().to_record()}}),
        "seams": lambda record: {"answer": seams.changes_since(_field(record, "revision", int))},
        "decide": lambda record: {
            "answer": seams.decide(_field(record, "decisions", list), revision=_field(record, "revision", int))
        },
        "solid": lambda record: {
            "answer": seams.say(
                *(_field(record, key, str) for key in ("solid", "said")), revision=_field(record, "revision", int)
            )
        },
        "outline": lambda record: {"answer": seams.outline(_field(record, "solid", str))},
    }
    routes = [Route(f"/{token}/{name}", _endpoint(action), methods=["POST"]) for name, action in actions.items()]
    return Starlette(routes=[Route(f"/{token}/", show), *routes])


def _choose(session: PickSession, table: SharedTable, record: Any) -> dict[str, Any]:
    moving = MovingChoice.from_record(record)
    session.choose(moving)
    return table.choose(moving)


def _save(table: SharedTable, record: Any) -> dict[str, Any]:
    click: dict[str, Any] = {
        "revision": _field(record, "revision", int),
        "shown": _field(record, "shown", int),
        "window": _field(record, "window", str),
        "consent": _texts(record, "consent"),
        "name": _field(record, "name", str, ""),
        "replaces": _field(record, "replaces", str, ""),
    }
    try:
        return {"answer": table.save(**click)}
    except FileChangedError as error:
        return {"fault": {**fault_record(error), "sha256": error.sha256}}
    except WpcalError as error:
        return {"fault": fault_record(error, table.rows)}


def _change_of(record: Any) -> dict[str, Any]:
    """Return a changed table with its window and the revision on which it is based."""
    return {
        "revision": _field(record, "revision", int),
        "window": _field(record, "window", str),
        "number": _field(record, "number", int),
        "table": Keyed.from_record(_field(record, "table", dict)),
        "conflicts": _texts(record, "conflicts"),
    }


def _field(record: Any, name: str, kind: type, default: Any = None) -> Any:
    """Return one value of a request."""
    value = record.get(name, default) if isinstance(record, dict) else None
    if type(value) is not kind:
        raise InputError(f"expected {name} as {kind.__name__}, got {type(value).__name__}")
    return value


def _vector(record: Any, name: str) -> FloatArray:
    """Return three finite numbers of a request, shape (3,)."""
    values = _field(record, name, list)
    if len(values) != 3 or not all(type(v) in (int, float) and math.isfinite(v) for v in values):
        raise InputError(f"expected {name} as three numbers")
    return np.array(values, dtype=np.float64)


def _texts(record: Any, name: str) -> tuple[str, ...]:
    """Return a list of texts of a request; empty if it is not there."""
    values = _field(record, name, list, [])
    if not all(isinstance(value, str) for value in values):
        raise InputError(f"expected {name} as a list of texts")
    return tuple(values)


def _endpoint(action: Callable[[Any], dict[str, Any]]) -> Callable[[Request], Any]:
    """Answer a request with what the action returns for its JSON. Any error is one line for the page."""

    async def endpoint(request: Request) -> Response:
        try:
            record = await _json_of(request)
            answer = await run_in_threadpool(action, record)
        except ClientDisconnect:
            raise
        except WpcalError as error:
            answer = {"fault": fault_record(error)}
        except Exception as error:  # the outermost handler of a request: the page must learn of every exception
            _log.error("a request to the picker failed: %r", error, exc_info=bool(os.environ.get("WPCAL_DEBUG")))
            answer = {"fault": {"message": fault_words(error), "code": INTERNAL, "row": None, "column": None}}
        return JSONResponse(answer, headers=HEADERS)

    return endpoint


async def _json_of(request: Request) -> Any:
    """Read the body, up to `LARGEST_BYTES`."""
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > LARGEST_BYTES:
            raise InputError(f"expected at most {LARGEST_BYTES // 1_000_000} MB")
    try:
        record = json.loads(body.decode("utf-8"))
        if b"\\ud" in body.lower():  # half of a surrogate pair cannot be written to a file or an answer
            json.dumps(record, ensure_ascii=False).encode("utf-8")
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON of Unicode text: {error}") from None
    return record


def _file_of(record: Any) -> dict[str, Any]:
    """Return the bytes, the name and the user frame of a file that was dropped on the page."""
    try:
        name, uframe = record["name"], record.get("uframe", "")
        raw = base64.b64decode(record["base64"], validate=True)
    except (KeyError, TypeError, AttributeError, binascii.Error, ValueError) as error:
        raise InputError(f"expected a file's name and its bytes: {type(error).__name__} {error}") from None
    if not isinstance(name, str) or not isinstance(uframe, str) or not name:
        raise InputError("expected a file's name as text")
    return {"raw": raw, "name": name, "uframe": uframe}
