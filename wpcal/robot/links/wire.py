"""Bytes to and from a controller, every answer within one time limit and one size: TCP, and GET over HTTP."""

from __future__ import annotations

import base64
import hashlib
import os
import re
import socket
import ssl
import time
from collections.abc import Callable
from contextlib import suppress

from wpcal.robot.links.reading import Credentials, LinkError

ANSWER_S = 1.0
"""Time limit of a connection and of every whole answer, s: twice the age at which a position is no longer used."""
MOST_BYTES = 4_000_000  #: Largest answer: a file with all position registers has 100 kB.
MOST_HEAD = 65_536  #: Largest head of an answer, and longest line.
CHALLENGE = re.compile(r'(\w+)=(?:"([^"]*)"|([^\s,]+))')


class Wire:
    """A TCP connection. Every method keeps to the time limit since `begin`, however slowly bytes come."""

    def __init__(self, host: str, port: int, *, secure: ssl.SSLContext | None = None) -> None:
        self.where = f"{host}:{port}"
        self._buffer = bytearray()
        self._end = time.monotonic() + ANSWER_S
        self._socket: socket.socket | None = None
        try:
            self._socket = socket.create_connection((host, port), timeout=ANSWER_S)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if secure is not None:
                self._socket = secure.wrap_socket(self._socket, server_hostname=host)
        except (OSError, UnicodeError) as error:
            raise self._failed(error, "no connection") from None

    def begin(self) -> None:
        """Start the time limit of the next answer."""
        self._end = time.monotonic() + ANSWER_S

    def send(self, data: bytes) -> None:
        """Send a request."""
        try:
            self._open().sendall(data)
        except OSError as error:
            raise self._failed(error, "the request was not sent") from None

    def exact(self, count: int) -> bytes:
        """Return the next `count` bytes."""
        while len(self._buffer) < count:
            if not self._more():
                raise LinkError(f"{self.where}: the answer ends after {len(self._buffer)} of {count} bytes")
        return self._cut(count)

    def until(self, end: bytes) -> bytes:
        """Return the bytes up to and with `end`, at most `MOST_HEAD`."""
        while (found := self._buffer.find(end)) < 0:
            if len(self._buffer) > MOST_HEAD:
                raise LinkError(f"{self.where}: the answer has a line that does not end")
            if not self._more():
                raise LinkError(f"{self.where}: the answer ends before its end")
        return self._cut(found + len(end))

    def rest(self) -> bytes:
        """Return all bytes until the other side closes, at most `MOST_BYTES`."""
        while self._more():
            if len(self._buffer) > MOST_BYTES:
                raise LinkError(f"{self.where}: the answer is larger than {MOST_BYTES // 1_000_000} MB")
        return self._cut(len(self._buffer))

    def certificate(self) -> str:
        """Return the SHA-256 of the other side's certificate."""
        found = self._open()
        raw = found.getpeercert(binary_form=True) if isinstance(found, ssl.SSLSocket) else None
        return hashlib.sha256(raw or b"").hexdigest()

    def close(self) -> None:
        """End the connection."""
        if self._socket is not None:
            with suppress(OSError):
                self._socket.close()
            self._socket = None

    def _open(self) -> socket.socket:
        left = self._end - time.monotonic()
        if self._socket is None or left <= 0.0:
            self.close()
            raise LinkError(f"{self.where}: no whole answer within {ANSWER_S:g} s")
        self._socket.settimeout(left)
        return self._socket

    def _more(self) -> bool:
        try:
            data = self._open().recv(65_536)
        except TimeoutError:
            self.close()
            raise LinkError(f"{self.where}: no whole answer within {ANSWER_S:g} s") from None
        except OSError as error:
            raise self._failed(error, "the answer was cut") from None
        self._buffer += data
        return bool(data)

    def _cut(self, count: int) -> bytes:
        found = bytes(self._buffer[:count])
        del self._buffer[:count]
        return found

    def _failed(self, error: Exception, what: str) -> LinkError:
        self.close()
        return LinkError(f"{self.where}: {what}: {getattr(error, 'strerror', None) or error}")


class Web:
    """GET requests to one host over a connection that is kept, with the authentication that the host asks for."""

    def __init__(
        self, host: str, port: int, credentials: Credentials, *, accept: str = "*/*", only_digest: bool = False
    ) -> None:
        self._host, self._port, self.accept, self._only_digest = host, port, accept, only_digest
        self._credentials = credentials
        self._secure: ssl.SSLContext | None = None
        self._check: Callable[[str], None] = lambda _: None
        self._wire: Wire | None = None
        self._challenge: dict[str, str] | None = None
        self._count = 0
        self.cookies: dict[str, str] = {}
        self._path, self._is_old = "/", False

    def use_tls(self, check: Callable[[str], None]) -> None:
        """Encrypt; `check` gets the certificate's SHA-256 at every connection before anything is sent.

        Controllers come with certificates that no authority signed: what tells them apart is the hash.
        """
        self._secure = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        self._secure.check_hostname, self._secure.verify_mode = False, ssl.CERT_NONE
        self._check = check

    @property
    def is_open(self) -> bool:
        """Whether there is a connection."""
        return self._wire is not None

    def get(self, path: str) -> bytes | None:
        """Return the body at a path; None if there is none (404).

        Raises `LinkError` when the host does not answer in time, refuses, or does not speak HTTP.
        """
        self.ask(path)
        return self.answer()

    def ask(self, path: str) -> None:
        """Send a request, the answer of which is read by `answer`."""
        self._path, self._is_old = path, self._wire is not None
        try:
            self._send()
        except LinkError:
            self.close()
            if not self._is_old:
                raise

    def answer(self) -> bytes | None:
        """Return what `get` returns, for the request sent before."""
        status, headers, body = self._answered()
        if status == 401:
            asked = headers.get("www-authenticate", "")
            self._challenge = {key.lower(): a or b for key, a, b in CHALLENGE.findall(asked)}
            self._challenge["scheme"] = asked.strip().partition(" ")[0].lower()
            self.ask(self._path)
            status, headers, body = self._answered()
        if status == 401:
            raise LinkError(f"{self._host} refuses user and password")
        if status not in (200, 404):
            raise LinkError(f"{self._host}: HTTP status {status}, expected 200")
        return body if status == 200 else None

    def close(self) -> None:
        """End the connection."""
        if self._wire is not None:
            self._wire.close()
            self._wire = None

    def _answered(self) -> tuple[int, dict[str, str], bytes]:
        try:
            return self._receive()
        except LinkError:
            self.close()
            if not self._is_old:
                raise
        self._is_old = False
        self._send()  # once more: the host may close a connection that was idle
        return self._receive()

    def _send(self) -> None:
        if self._wire is None:
            self._wire = Wire(self._host, self._port, secure=self._secure)
            if self._secure is not None:
                self._check(self._wire.certificate())
        lines = [f"GET {self._path} HTTP/1.1", f"Host: {self._host}:{self._port}", f"Accept: {self.accept}"]
        if self.cookies:
            lines.append("Cookie: " + "; ".join(f"{name}={value}" for name, value in self.cookies.items()))
        if self._challenge is not None:
            lines.append(f"Authorization: {self._authorization(self._path)}")
        self._wire.begin()
        self._wire.send("\r\n".join([*lines, "Cache-Control: no-cache", "", ""]).encode("ascii", "replace"))

    def _receive(self) -> tuple[int, dict[str, str], bytes]:
        wire = self._wire
        if wire is None:
            raise LinkError(f"{self._host}: the connection was closed")
        head = wire.until(b"\r\n\r\n").decode("latin-1").split("\r\n")
        first = re.match(r"HTTP/1\.([01]) (\d{3})\b", head[0])
        if first is None:
            raise LinkError(f"{wire.where}: does not answer in HTTP")
        headers = {}
        for line in head[1:]:
            name, _, value = line.partition(":")
            headers[name.strip().lower()] = value.strip()
            if name.lower() == "set-cookie":
                key, _, text = value.partition(";")[0].strip().partition("=")
                self.cookies[key] = text
        body = self._body(wire, headers)
        if first[1] == "0" or "close" in headers.get("connection", "").lower():
            self.close()
        return int(first[2]), headers, body

    def _body(self, wire: Wire, headers: dict[str, str]) -> bytes:
        if "chunked" in headers.get("transfer-encoding", "").lower():
            return _chunks(wire)
        length = headers.get("content-length")
        if length is None:
            body = wire.rest()
            self.close()
            return body
        if not length.isdecimal() or int(length[:9]) > MOST_BYTES or len(length) > 9:
            raise LinkError(f"{wire.where}: an answer of {length[:20]!r} bytes, expected at most {MOST_BYTES}")
        return wire.exact(int(length))

    def _authorization(self, path: str) -> str:
        asked = self._challenge or {}
        if asked.get("scheme") != "digest":
            if self._only_digest:
                raise LinkError(f"{self._host} asks for the password in plain text; expected a digest")
            user, password = self._credentials(self._host)
            return "Basic " + base64.b64encode(f"{user}:{password}".encode()).decode("ascii")
        user, password = self._credentials(self._host)
        self._count += 1
        realm, nonce = asked.get("realm", ""), asked.get("nonce", "")
        count, own = f"{self._count:08x}", os.urandom(8).hex()
        who, what = _md5(f"{user}:{realm}:{password}"), _md5(f"GET:{path}")
        with_quality = "auth" in asked.get("qop", "")
        middle = f"{nonce}:{count}:{own}:auth" if with_quality else nonce
        words = {"username": user, "realm": realm, "nonce": nonce, "uri": path}
        words |= {"response": _md5(f"{who}:{middle}:{what}")}
        words |= {"opaque": asked["opaque"]} if "opaque" in asked else {}
        text = ", ".join(f'{key}="{value}"' for key, value in words.items())
        return f"Digest {text}" + (f', qop=auth, nc={count}, cnonce="{own}"' if with_quality else "")


def _md5(text: str) -> str:
    return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()  # what these controllers ask for


def _chunks(wire: Wire) -> bytes:
    body = bytearray()
    while True:
        size = wire.until(b"\r\n").partition(b";")[0].strip()
        if not re.fullmatch(rb"[0-9a-fA-F]{1,7}", size) or len(body) + int(size, 16) > MOST_BYTES:
            raise LinkError(f"{wire.where}: the answer is not HTTP, or larger than {MOST_BYTES // 1_000_000} MB")
        if int(size, 16) == 0:
            wire.until(b"\r\n")
            return bytes(body)
        body += wire.exact(int(size, 16))
        wire.exact(2)
