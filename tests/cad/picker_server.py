"""A picker's server in a thread of the test, and ways to talk to it."""

import http.client
import json
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
import uvicorn

from cad.pick import patience
from cad.pick.draft import Keyed
from cad.pick.server import PickServer
from cad.pick.shared_table import SharedTable
from cad.session.part import PickPart
from cad.session.rows import Rows
from cad.session.session import PickSession

JSON = "application/json"
PAGE = "<!DOCTYPE html>the page"
WHOLE_REQUEST_S = 1.0  #: Instead of 20 s.
TIMEOUT_S = 60


class Running:
    """A server in a thread."""

    def __init__(self, part: PickPart, out: Path) -> None:
        self.session, self.table = PickSession(part), SharedTable(out, part, start=Keyed.of_rows(Rows()))
        self.server = PickServer(self.session, self.table, PAGE)
        place = urlsplit(self.server.url)
        self.host, self.port, self.path = place.netloc, place.port or 0, place.path
        self.origin = f"http://{self.host}"

    def ask(
        self, method: str, path: str, headers: dict[str, str], body: Any = None
    ) -> tuple[int, bytes, http.client.HTTPMessage]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=TIMEOUT_S)
        try:
            connection.request(method, path, None if body is None else json.dumps(body), headers)
            answer = connection.getresponse()
            return answer.status, answer.read(), answer.headers
        finally:
            connection.close()

    def post(self, name: str, body: Any, **headers: str) -> tuple[int, Any]:
        given = {"Origin": self.origin, "Content-Type": JSON} | {key.replace("_", "-"): v for key, v in headers.items()}
        status, text, _ = self.ask("POST", self.path + name, given, body)
        return status, json.loads(text) if status == 200 else text

    def send(self, data: bytes, *, is_whole: bool = False) -> bytes:
        """Send bytes and return all that comes back; unless they are whole requests, say that no more follow."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=TIMEOUT_S) as connection:
            got = bytearray()
            try:
                connection.sendall(data)
                if not is_whole:
                    connection.shutdown(socket.SHUT_WR)
                while chunk := connection.recv(65536):
                    got += chunk
            except OSError:
                pass  # the server closed what it did not want to read to its end
            return bytes(got)


@contextmanager
def serving(part: PickPart, out: Path) -> Iterator[Running]:
    """Yield a server that answers, and end it."""
    found = Running(part, out)
    ended: list[uvicorn.Server] = []
    plain = uvicorn.Server.run

    def run(self: uvicorn.Server, sockets: list[socket.socket] | None = None) -> None:
        ended.append(self)
        plain(self, sockets)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(uvicorn.Server, "run", run)
        patch.setattr(patience, "SECONDS_FOR_A_REQUEST", WHOLE_REQUEST_S)
        thread = threading.Thread(target=found.server.run)
        thread.start()
        yield found
        ended[0].should_exit = True
        thread.join(timeout=30)
        assert not thread.is_alive()
