"""FANUC: the page ``curpos.dg`` of the controller's web server, and its files, over HTTP or FTP.

The page tells the position in the world (which is user frame 0), the numbers of user frame and tool, and the joints. It
does not tell their values, and its clock has whole minutes.
"""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from wpcal.robot.links.reading import Address, Credentials, LinkError, Reading, Setting, numbers, pose, setting_name
from wpcal.robot.links.wire import Web, Wire

HTTP, FTP = 80, 21
PAGE = "curpos.dg"
RESULTS = ("posreg.va", "numreg.va")
GROUP = re.compile(r"^Group #:\s*(\d+)\s*$", re.MULTILINE)
SETTINGS = re.compile(r"^Frame #:\s*(\S+)\s+Tool #:\s*(\S+)\s*$", re.MULTILINE)
JOINT = re.compile(r"^Joint\s+(\d+):\s*(\S+)\s*$", re.MULTILINE)
WORLD = "CURRENT WORLD POSITION:"
CONFIGURATION = re.compile(r"^CFG: *(.{1,40})$", re.MULTILINE)
COORDINATE = re.compile(r"^([XYZWPR]):\s*(\S+)\s*$", re.MULTILINE)
PASSIVE = re.compile(r"\((\d+),(\d+),(\d+),(\d+),(\d+),(\d+)\)")
REPLY = re.compile(r"(\d{3}) (.*)")


def reading_of_page(text: str, asked_s: float, *, group: str = "1") -> Reading:
    """Return the position of a motion group in the text of ``curpos.dg``.

    Raises `LinkError` when the page does not hold it.
    """
    text = text.replace("\r\n", "\n")
    blocks = GROUP.split(text)
    body = dict(zip(blocks[1::2], blocks[2::2], strict=True)).get(group)
    if body is None or blocks[1::2].count(group) != 1:
        raise LinkError(f"{PAGE}: without a position of group {group}")
    before, found, world = body.partition(WORLD)
    settings = SETTINGS.findall(before)
    if not found or len(settings) != 1:
        raise LinkError(f"{PAGE}: without {WORLD} or its frame and tool")
    joints = numbers([value for _, value in JOINT.findall(before)])
    frame, tool = settings[0]
    configuration = CONFIGURATION.search(world)
    return Reading(
        pose(_coordinates(world)),
        Setting(setting_name(tool)),
        Setting(setting_name(frame)),
        np.radians(joints),
        asked_s,
        "" if configuration is None else setting_name(configuration[1]),
    )


class _HttpFiles:
    """Files of the device MD: over HTTP."""

    def __init__(self, address: Address, credentials: Credentials) -> None:
        self._web = Web(address.host, address.port or HTTP, credentials)
        self.close = self._web.close

    def get(self, name: str) -> bytes | None:
        """Return a file; None if there is none."""
        return self._web.get(f"/MD/{name.upper()}")


class _FtpFiles:
    """Files of the device MD: over FTP, passive mode."""

    def __init__(self, address: Address, credentials: Credentials) -> None:
        self._host = address.host
        self._wire = Wire(address.host, address.port or FTP)
        try:
            self._reply(("220",))
            if (
                self._ask("USER anonymous", "230", "331")[0] == "331"
                and self._ask("PASS guest", "230", "530")[0] == "530"
            ):
                user, password = credentials(address.host)
                self._ask(f"USER {user}", "230", "331")
                self._ask(f"PASS {password}", "230")
            self._ask("TYPE I", "200")
            self._send("PASV")  # for the next file: its answer is there when a key asks for it
        except LinkError:
            self.close()
            raise

    def get(self, name: str) -> bytes | None:
        """Return a file; None if there is none."""
        self._wire.begin()
        found = PASSIVE.search(self._reply(("227",))[1])
        if found is None:
            raise LinkError(f"{self._host}: answers PASV without a port")
        data = Wire(self._host, int(found[5]) * 256 + int(found[6]))  # the host of the reply is not used
        try:
            is_there = self._ask(f"RETR MD:{name.upper()}", "125", "150", "550")[0] != "550"
            body = data.rest() if is_there else None
        finally:
            data.close()
        self._send("PASV")
        if is_there:
            self._reply(("226", "250"))
        return body

    def close(self) -> None:
        """End the connection."""
        self._wire.close()

    def _ask(self, line: str, *expected: str) -> tuple[str, str]:
        self._wire.begin()
        self._send(line)
        return self._reply(expected)

    def _send(self, line: str) -> None:
        self._wire.send(line.encode("utf-8", "replace").replace(b"\n", b"").replace(b"\r", b"") + b"\r\n")

    def _reply(self, expected: Sequence[str]) -> tuple[str, str]:
        while True:
            found = REPLY.match(self._wire.until(b"\n").decode("latin-1"))
            if found is not None:  # other lines are those of a longer reply
                break
        if found[1] not in expected:
            raise LinkError(f"{self._host}: FTP reply {found[1]}, expected {' or '.join(expected)}")
        return found[1], found[2]


class FanucLink:
    """One controller."""

    def __init__(self, files: _HttpFiles | _FtpFiles, group: str) -> None:
        self._files, self._group = files, group

    def read(self) -> Reading:
        """Return the position."""
        asked = time.monotonic()
        page = self._files.get(PAGE)
        if page is None:
            raise LinkError(f"the controller has no {PAGE}; is its web server on?")
        return reading_of_page(page.decode("latin-1"), asked, group=self._group)

    def results(self, plan: Path) -> dict[str, bytes]:
        """Return the position registers and the registers."""
        found = {name: self._files.get(name) for name in RESULTS}
        missing = [name for name, body in found.items() if body is None]
        if missing:
            raise LinkError(f"the controller has no {' and no '.join(missing)}")
        return {name: body for name, body in found.items() if body is not None}

    def close(self) -> None:
        """End the connection."""
        self._files.close()


def open_http(address: Address, credentials: Credentials) -> FanucLink:
    """Return the link over HTTP."""
    return FanucLink(_HttpFiles(address, credentials), address.unit or "1")


def open_ftp(address: Address, credentials: Credentials) -> FanucLink:
    """Return the link over FTP, for controllers whose web server is off."""
    return FanucLink(_FtpFiles(address, credentials), address.unit or "1")


def _coordinates(world: str) -> list[str]:
    cells = COORDINATE.findall(world)
    names = "".join(key for key, _ in cells)
    if names != "XYZWPR":
        raise LinkError(f"{PAGE}: expected X, Y, Z, W, P, R in the world, got {' '.join(names) or 'none'}")
    return [value for _, value in cells]
