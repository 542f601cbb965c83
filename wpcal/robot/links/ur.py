"""Universal Robots: RTDE, port 30004 (protocol version 2): a stream of packages with the position of the tool.

Only the requests that set up and start the stream are implemented; there is no input recipe, so nothing can be written.
The position is that of the active TCP in the base. `tcp_offset` tells the TCP on controllers that know this output
(PolyScope 3.12.3 and 5.5.1, and later); others do not tell which tool is active.

A touch program writes its results into the log, and the controller sends every line of the log to the primary interface
while it is written. Port 30011 has this interface without the way in: nothing that a client sends there is read.
"""

from __future__ import annotations

import re
import struct
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.robot.links.reading import Address, Credentials, LinkError, Reading, Setting
from wpcal.robot.links.wire import ANSWER_S, Wire

PORT, MESSAGES = 30004, 30011
VERSION, OUTPUTS, START, TEXT, DATA = b"VOSMU"
OUTPUT_NAMES = ("timestamp", "actual_TCP_pose", "actual_q", "tcp_offset")
TYPES = {"timestamp": "DOUBLE", "actual_TCP_pose": "VECTOR6D", "actual_q": "VECTOR6D", "tcp_offset": "VECTOR6D"}
HERTZ = 25.0  #: Positions per second.
MOST_PACKAGES = 10_000  #: In one answer, before the link is given up.
ROBOT_MESSAGE, LOG_TEXT = 20, 0  #: The type of a package of the primary interface, and of the message in it.
MOST_PACKAGE = 100_000  #: Bytes of a package of the primary interface; those of a controller have about 1 kB.
RESULT = re.compile(r"\bwpcal [0-9a-f]{8} (\w+)")
DRIFT = 1e-4  #: How much faster our clock may run than the controller's: quartz is ten times better.


class UrLink:
    """The stream of one controller."""

    def __init__(self, address: Address) -> None:
        self._address = address
        self._opened: Wire | None = None
        self._way_s = ANSWER_S  # the quickest way of a question and its answer
        self._offset_s: float | None = None  # of our clock less the controller's, with the quickest way of a package
        self._last_s = -np.inf

    @property
    def _wire(self) -> Wire:
        return self._opened or self._connect(PORT)

    def _connect(self, usual: int) -> Wire:
        self._opened = Wire(self._address.host, self._address.port or usual)
        self._where = self._opened.where
        return self._opened

    def read(self) -> Reading:
        """Return the newest position."""
        if self._opened is None:
            self._names, self._recipe = self._started()
            return self._package()  # at once: when it came tells how far the clocks are apart
        asked = time.monotonic()
        self._wire.begin()
        for _ in range(MOST_PACKAGES):
            reading = self._package()
            if reading.asked_s >= asked - self._way_s - 1.0 / HERTZ:
                return reading
        raise LinkError(f"{self._where}: only old positions arrive")

    def results(self, plan: Path) -> dict[str, bytes]:
        """Wait for a run of the touch program, and return its lines of the log."""
        wire, lines = self._connect(MESSAGES), list[str]()
        sys.stderr.write(f"{wire.where}: connected; start the touch program now (Ctrl-C ends)\n")
        while True:
            text = self._log_line(wire)
            found = RESULT.search(text)
            if found is not None and (lines or found[1] == "begin"):
                lines = [text] if found[1] == "begin" else [*lines, text]
                if found[1] == "end":
                    return {"touch.log": "\n".join([*lines, ""]).encode()}

    def _log_line(self, wire: Wire) -> str:
        """Return the text of the next package; empty if it has no line of the log."""
        wire.begin()
        size, kind = struct.unpack("!iB", wire.exact(5))
        if not 5 <= size <= MOST_PACKAGE:
            raise LinkError(f"{wire.where}: does not answer as the primary interface")
        body = wire.exact(size - 5)  # time, source, type, and the text
        is_text = kind == ROBOT_MESSAGE and len(body) >= 10 and body[9] == LOG_TEXT
        return body[10:].decode("utf-8", "replace").strip("\0\r\n") if is_text else ""

    def close(self) -> None:
        """End the stream."""
        if self._opened is not None:
            self._opened.close()

    def _started(self) -> tuple[tuple[str, ...], int]:
        """Start the stream; return its names and the number of its recipe."""
        if self._ask(VERSION, struct.pack("!H", 2)) != b"\x01":
            raise LinkError(f"{self._where}: does not speak RTDE version 2")
        for names in (OUTPUT_NAMES, OUTPUT_NAMES[:-1]):
            recipe = self._set_up(names)
            if recipe is not None:
                break
        else:
            raise LinkError(f"{self._where}: RTDE without {', '.join(names)}")
        if self._ask(START, b"") != b"\x01":
            raise LinkError(f"{self._where}: RTDE does not start")
        return names, recipe

    def _set_up(self, names: Sequence[str]) -> int | None:
        """Return the number of the recipe; None if one of its names is not known."""
        answer = self._ask(OUTPUTS, struct.pack("!d", HERTZ) + ",".join(names).encode("ascii"))
        types = answer[1:].decode("ascii", "replace").split(",")
        if types == [TYPES[name] for name in names] and answer[0]:
            return answer[0]
        if "NOT_FOUND" in types or "IN_USE" in types:
            return None
        raise LinkError(f"{self._where}: RTDE answered types {types[:6]}, expected numbers and vectors of six")

    def _ask(self, kind: int, data: bytes) -> bytes:
        began = time.monotonic()
        self._wire.begin()
        self._wire.send(struct.pack("!HB", len(data) + 3, kind) + data)
        found, answer = self._message()
        while found == TEXT:
            found, answer = self._message()
        if found != kind or not answer:
            raise LinkError(f"{self._where}: does not answer as RTDE")
        self._way_s = min(self._way_s, time.monotonic() - began)
        return answer

    def _message(self) -> tuple[int, bytes]:
        size, kind = struct.unpack("!HB", self._wire.exact(3))
        if size < 3:
            raise LinkError(f"{self._where}: does not answer as RTDE")
        return kind, self._wire.exact(size - 3)

    def _offset_at(self, sent: float) -> float:
        """Return how far our clock is ahead of the robot's: the least that was seen, and what clocks drift since."""
        offset = time.monotonic() - sent
        return offset if self._offset_s is None else min(offset, self._offset_s + DRIFT * (sent - self._last_s))

    def _package(self) -> Reading:
        kind, data = self._message()
        while kind == TEXT:
            kind, data = self._message()
        count = 1 + 6 * (len(self._names) - 1)
        if kind != DATA or len(data) != 1 + 8 * count or data[0] != self._recipe:
            raise LinkError(f"{self._where}: a package of {len(data)} bytes, expected {1 + 8 * count} of the recipe")
        values = np.array(struct.unpack(f"!{count}d", data[1:]))
        if not np.abs(values).max() <= 1e9:  # nor is NaN
            raise LinkError(f"{self._where}: a package with numbers that are none")
        sent, position, joints = float(values[0]), values[1:7], values[7:13]
        if sent <= self._last_s:
            raise LinkError(f"{self._where}: the clock of the positions stands")
        self._offset_s, self._last_s = self._offset_at(sent), sent
        tool = None if len(self._names) == 3 else _transform(values[13:19], "flange", "tool")
        name = "" if tool is None or np.any(values[13:19]) else "0"
        asked = sent + self._offset_s - self._way_s
        return Reading(_transform(position, "base", "tool"), Setting(name, tool), Setting("base"), joints, asked)


def _transform(values: FloatArray, target: str, source: str) -> RigidTransform:
    """Return the transform of x, y, z in m and a rotation vector in rad."""
    return RigidTransform(Rotation.from_rotvec(values[3:]).as_matrix(), values[:3] * 1000.0, target, source)


def open_ur(address: Address, credentials: Credentials) -> UrLink:
    """Return the open link."""
    return UrLink(address)
