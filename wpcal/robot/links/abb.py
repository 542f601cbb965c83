"""ABB: Robot Web Services 1 (IRC5: HTTP, digest) and 2 (OmniCore: HTTPS, basic), by GET only.

The position is asked for with the active tool, in ``wobj0``, which is the world.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from wpcal.core.rotations import rotation_from_quaternion
from wpcal.core.transform import RigidTransform
from wpcal.robot.links.reading import Address, Credentials, LinkError, Reading, Setting, numbers, setting_name
from wpcal.robot.links.wire import Web

HTTP, HTTPS = 80, 443
UNIT = "ROB_1"
RESULTS = "_touch_res.mod"  #: How the names of modules of results end, lower case.
CONFIGURATION = ("cf1", "cf4", "cf6", "cfx")
UNIT_LENGTH = 1e-3  #: A quaternion printed with six digits is nearer to length one.
JSON_2 = "application/hal+json;v=2.0"  #: What Robot Web Services 2 is asked to answer.


class AbbLink:
    """One controller, over two connections of one session."""

    def __init__(self, webs: tuple[Web, Web], address: Address, question: str) -> None:
        self._web, self._other = webs
        self._other.cookies = self._web.cookies
        self._question = question
        self._unit = quote(address.unit or UNIT, safe="")
        self._tool = ""

    def read(self) -> Reading:
        """Return the position in the world."""
        asked = time.monotonic()
        self._tool = self._tool or self._active()[0]
        place = f"/robtarget?tool={quote(self._tool, safe='')}&wobj=wobj0&coordinate=Wobj"
        self._web.ask(self._path(place))
        self._other.ask(self._path("/jointtarget"))
        target, joints = self._state(self._web, "q1"), self._state(self._other, "rax_1")
        used, (tool, frame) = self._tool, self._active()
        if used != tool:
            self._tool = tool
            raise LinkError("the tool changed while the position was read; once more")
        q = numbers([target.get(f"q{row}", "") for row in (2, 3, 4, 1)])
        if abs(float(np.linalg.norm(q)) - 1.0) > UNIT_LENGTH:
            raise LinkError("the controller answered a quaternion that is not of length 1")
        place_mm = numbers([target.get(key, "") for key in "xyz"])
        T = RigidTransform(rotation_from_quaternion(q), np.array(place_mm), "base", "tool")
        angles = numbers([joints.get(f"rax_{row}", "") for row in range(1, 7)])
        posture = ", ".join(f"{key} {setting_name(target[key])}" for key in CONFIGURATION if key in target)
        return Reading(T, Setting(tool), Setting(frame), np.radians(angles), asked, posture)

    def results(self, plan: Path) -> dict[str, bytes]:
        """Return the modules of results in the folder HOME:."""
        folder = "/fileservice/$HOME" if self._question else "/fileservice/HOME"
        listed = self._web.get(f"{folder}?{self._question}" if self._question else folder) or b"{}"
        self._web.accept = self._web.accept.replace("hal+json", "xhtml+xml")  # of which a file is neither
        names = {str(each.get("_title", "")) for each in _records_of(listed)}
        found = {name: self._web.get(f"{folder}/{quote(name)}") for name in names if name.lower().endswith(RESULTS)}
        if not found:
            raise LinkError(f"the folder HOME: has no module {RESULTS.strip('_')}; has the touch program run?")
        return {name: body for name, body in found.items() if body is not None}

    def close(self) -> None:
        """End the session, of which a controller has few, and the connection."""
        with suppress(LinkError):
            if self._web.is_open:
                self._web.get("/logout")
        self._web.close()
        self._other.close()

    def _path(self, where: str) -> str:
        path = f"/rw/motionsystem/mechunits/{self._unit}{where}"
        return path + (("&" if "?" in path else "?") + self._question if self._question else "")

    def _active(self) -> tuple[str, str]:
        """Return the names of the active tool and work object."""
        self._web.ask(self._path(""))
        found = self._state(self._web, "tool-name")
        tool = setting_name(found["tool-name"])
        if not tool:
            raise LinkError("the controller tells no active tool")
        return tool, setting_name(found.get("wobj-name", ""))

    def _state(self, web: Web, key: str) -> dict[str, str]:
        """Return the values of the object with a key, in the answer that comes."""
        body = web.answer()
        if body is None:
            raise LinkError(f"the controller has no mechanical unit {self._unit}")
        found = next((each for each in _records_of(body) if key in each), None)
        if found is None:
            raise LinkError(f"the controller answered without {key}")
        return {name: str(value) for name, value in found.items() if isinstance(value, str | int | float)}


def _records_of(body: bytes) -> list[dict[str, Any]]:
    """Return every object within a JSON text."""
    try:
        return list(_records(json.loads(body)))
    except (ValueError, RecursionError):
        raise LinkError("the controller does not answer in JSON") from None


def _records(value: Any) -> Iterator[dict[str, Any]]:
    """Return every object within a JSON value, from the outside."""
    if isinstance(value, dict):
        yield value
        value = list(value.values())
    for each in value if isinstance(value, list) else ():
        yield from _records(each)


def open_irc5(address: Address, credentials: Credentials) -> AbbLink:
    """Return the link to Robot Web Services 1."""
    port = address.port or HTTP
    webs = (
        Web(address.host, port, credentials, only_digest=True),
        Web(address.host, port, credentials, only_digest=True),
    )
    return AbbLink(webs, address, "json=1")


_PINNED: dict[str, str] = {}
"""Hashes of certificates by host: a connection that is opened again must meet the same controller."""


def open_omnicore(address: Address, credentials: Credentials) -> AbbLink:
    """Return the link to Robot Web Services 2. Its certificate is pinned at the first connection, and said."""
    port = address.port or HTTPS
    where = f"{address.host}:{port}"

    def check(found: str) -> None:
        pinned = (address.pin or _PINNED.get(where, "")).lower().replace(":", "")
        if pinned and pinned != found:
            raise LinkError(f"{where}: the certificate is not the pinned one: {found}")
        if not pinned:
            sys.stderr.write(f"{where}: certificate pinned for this run; to keep it, add ,pin={found} to the address\n")
        _PINNED[where] = found

    webs = Web(address.host, port, credentials, accept=JSON_2), Web(address.host, port, credentials, accept=JSON_2)
    for web in webs:
        web.use_tls(check)
    return AbbLink(webs, address, "")
