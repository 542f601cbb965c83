"""Where the picker's page is: on this machine only, or at one address of this machine in a network."""

from __future__ import annotations

import ipaddress
import os
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from html import escape
from pathlib import Path

from wpcal.core.errors import ErrorCode, InputError

LOCAL = "127.0.0.1"
HTTP_PORT = 80  #: Browsers leave this port out of the header ``Host``.
ELSEWHERE = ("192.0.2.1", 9)
"""An address for documentation (RFC 5737). Connecting a datagram socket sends nothing; it shows this machine's own
address on the way out."""

NETWORK_WARNING = (
    "warning: every device in this network that knows the address can see the part, and can change and save the table "
    "and the seams; nothing is encrypted. Show the address and its QR code to nobody else; Ctrl-C closes the page"
)
BLOCKS = {(True, True): "█", (True, False): "▀", (False, True): "▄", (False, False): " "}
REDIRECT = '<!DOCTYPE html><meta charset="utf-8"><meta http-equiv="refresh" content="0; url={url}"><title>wpcal</title>'


@dataclass(frozen=True, slots=True)
class Listening:
    """A socket that listens, and how browsers may call it."""

    socket: socket.socket
    hosts: tuple[str, ...]  #: The values of the header ``Host`` that are this server; the first is part of the address.
    is_local: bool  #: Whether only this machine reaches it.


def listen(host: str, port: int) -> Listening:
    """Listen at one address of this machine.

    Raises `InputError` when the host is not one address of this machine, or the port cannot be opened.
    """
    family, address = _resolved(host)
    # With the protocol given, asyncio sends at once. Otherwise every answer waits 40 ms for a fuller packet.
    listening = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((address, port))
        listening.listen()  # so that a browser that connects before the server runs waits
    except (OSError, OverflowError) as error:
        listening.close()
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        where = f"port {port}" if host == LOCAL else f"{host}, port {port}"
        raise InputError(f"{where}: {reason}", code=ErrorCode.PORT_UNUSABLE) from None
    bound = int(listening.getsockname()[1])
    names = dict.fromkeys(f"[{name}]" if ":" in name else name.lower() for name in (host, address))
    hosts = [f"{name}:{bound}" for name in names] + ([*names] if bound == HTTP_PORT else [])
    return Listening(listening, tuple(hosts), ipaddress.ip_address(address).is_loopback)


def _resolved(host: str) -> tuple[socket.AddressFamily, str]:
    """Return the one address that a host means."""
    try:
        family, *_, place = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)[0]
    except (OSError, ValueError):  # UnicodeError is a ValueError
        raise InputError(
            f"--host {ascii(host)[1:-1]}: is not known as an address of this machine{_example()}"
        ) from None
    address = str(place[0])
    if ipaddress.ip_address(address.partition("%")[0]).is_unspecified:
        raise InputError(f"--host {host}: stands for all addresses; give the one that the tablet reaches{_example()}")
    return family, address


def _example() -> str:
    """Return the address of this machine in its network, in words, if it has one."""
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.connect(ELSEWHERE)
            return f", such as {probe.getsockname()[0]}"
    except OSError:
        return ""


def qr_code(url: str) -> str:
    """Return the QR code of an address as lines of half blocks, dark on light, with the quiet zone around it.

    Every character stands for two modules, one above the other. A light module is drawn, a dark one is left out, as
    terminals are dark; on a light terminal the colours are exchanged, which the cameras of tablets read as well.
    """
    import segno

    light = [[not module for module in row] for row in segno.make(url, error="l", micro=False).matrix_iter(border=4)]
    if len(light) % 2:
        light.append([False] * len(light[0]))
    pairs = zip(light[::2], light[1::2], strict=True)
    lines = ["".join(BLOCKS[above, below] for above, below in zip(*pair, strict=True)) for pair in pairs]
    return "\n".join(lines) + "\n"


@contextmanager
def opening_file(url: str) -> Iterator[Path]:
    """Yield a file that leads a browser to an address. Only this user can read it, and it is removed in the end.

    The address contains the token; as an argument of the browser every user of this machine would see it.
    """
    with tempfile.TemporaryDirectory(prefix="wpcal-pick-") as folder:
        path = Path(folder) / "open.html"
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            file.write(REDIRECT.format(url=escape(url)))
        yield path
