"""KUKA: variables over KUKAVARPROXY or the C3 bridge, port 7000.

A request is a number, a length, the function and the name of a variable. Only function 0, to read, is implemented.
``$POS_ACT`` is the tip of ``$TOOL`` in ``$BASE``; with ``$BASE`` it becomes the position in the world.

The results of a touch program are its own variables. The bridge answers them while the program is selected, also when
it has ended. What is read is put into the data list that was written with the plan, as the controller does it.
"""

from __future__ import annotations

import re
import struct
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from wpcal.core.transform import RigidTransform
from wpcal.robot.links.reading import Address, Credentials, LinkError, Reading, Setting, numbers, pose, setting_name
from wpcal.robot.links.wire import Wire

PORT = 7000
READ = 0  #: The function; 1 would write.
DONE = b"\x00\x01\x01"  #: Behind an answer that is one.
STRUCTURE = re.compile(r"\s*\{\s*(?:\w+\s*:)?([^{}]*)\}\s*")
FIELD = re.compile(r"\s*([A-Z]\d*)\s+(\S+)\s*")
PLAN = 'WPPLAN[]="'
RESULT = re.compile(r"^(DECL \w+ (WP(?:PART|TOOL|COUNT|[OR]_\w+))=)[^\r\n]*|^(WPPLAN\[\])=[^\r\n]*", re.MULTILINE)
"""What holds a result in the data list of a touch program: the outcome and the place of a search, tool and frame."""
CONNECTIONS = 4  #: The bridge takes ten clients.


class KukaLink:
    """One controller. The bridge answers one request at a time per connection, so there are a few of these."""

    def __init__(self, address: Address) -> None:
        self._wires = [Wire(address.host, address.port or PORT)]
        with suppress(LinkError):
            while len(self._wires) < CONNECTIONS:
                self._wires.append(Wire(address.host, address.port or PORT))
        self._number = 0

    def read(self) -> Reading:
        """Return the position in the world."""
        asked = time.monotonic()
        first = self._values(("$BASE", "$TOOL", "$ACT_TOOL", "$ACT_BASE"))
        then = self._values(("$POS_ACT", "$AXIS_ACT", "$IPO_MODE"))
        last = self._values(("$BASE", "$TOOL"))
        if any(first[name] != last[name] for name in last):
            raise LinkError("$BASE or $TOOL changed while the position was read; once more")
        if setting_name(then["$IPO_MODE"]) == "#TCP":
            raise LinkError("a fixed tool is active ($IPO_MODE is #TCP): the position is that of the part")
        base = _frame(first["$BASE"], "base", "shown")
        tool = Setting(setting_name(first["$ACT_TOOL"]), _frame(first["$TOOL"], "flange", "tool"))
        axes = _fields(then["$AXIS_ACT"])
        joints = np.radians(numbers([axes.get(f"A{row}", "") for row in range(1, 7)]))
        position, shown = base @ _frame(then["$POS_ACT"], "shown", "tool"), _fields(then["$POS_ACT"])
        posture = ", ".join(f"{key} {setting_name(shown[key])}" for key in "ST" if key in shown)
        return Reading(position, tool, Setting(setting_name(first["$ACT_BASE"]), base), joints, asked, posture)

    def results(self, plan: Path) -> dict[str, bytes]:
        """Return the data list of the touch program with what its variables hold now."""
        folder = plan if plan.is_dir() else plan.parent
        texts = {each: each.read_bytes().decode("latin-1") for each in folder.glob("*.dat")}
        lists = [each for each, text in texts.items() if PLAN in text]
        if len(lists) != 1:
            raise LinkError(
                f"{folder}: {len(lists)} data lists of touch programs, expected the one written with the plan"
            )
        text = texts[lists[0]]
        names = [found[2] or found[3] for found in RESULT.finditer(text)]
        values = self._values(names)
        if self._values(names) != values:
            raise LinkError(
                "the results changed while they were read: does the touch program run? Once more at its end"
            )
        values = {name: re.sub(r"\{\s*\w+\s*:", "{", value.strip()) for name, value in values.items()}
        if not "".join(values.values()).isprintable():
            raise LinkError("a result is answered with text that is not printable")
        text = RESULT.sub(lambda found: f"{found[1] or 'WPPLAN[]='}{values[found[2] or found[3]]}", text)
        return {lists[0].name: text.encode("latin-1")}

    def close(self) -> None:
        """End the connections."""
        for wire in self._wires:
            wire.close()

    def _values(self, names: Sequence[str]) -> dict[str, str]:
        """Return the texts of variables."""
        found: dict[str, str] = {}
        for start in range(0, len(names), len(self._wires)):
            sent = list(zip(names[start:], self._wires, strict=False))
            numbered = [(name, wire, self._send(wire, name)) for name, wire in sent]
            found |= {name: _answer(wire, name, number) for name, wire, number in numbered}
        return found

    def _send(self, wire: Wire, name: str) -> int:
        self._number = self._number % 65_535 + 1
        text = name.encode("ascii")
        wire.begin()
        wire.send(struct.pack("!HHBH", self._number, len(text) + 3, READ, len(text)) + text)
        return self._number


def _answer(wire: Wire, name: str, number: int) -> str:
    answered, length = struct.unpack("!HH", wire.exact(4))
    body = wire.exact(length)
    if answered != number or length < 6 or body[0] != READ:
        raise LinkError(f"{wire.where}: does not answer as KUKAVARPROXY")
    (count,) = struct.unpack("!H", body[1:3])
    if count + 6 != length or body[-3:] != DONE:
        raise LinkError(f"{name} is not answered; is a tool chosen, and the program selected?")
    return body[3:-3].decode("latin-1")


def _frame(text: str, target: str, source: str) -> RigidTransform:
    """Return the transform of ``{E6POS: X 1.0, Y 2.0, Z 3.0, A 0.0, B 0.0, C 0.0, …}``."""
    values = _fields(text)
    if not set("XYZABC") <= set(values):
        raise LinkError(f"expected X, Y, Z, A, B, C in the answer, got {text[:60]!r}")
    return pose([values[key] for key in "XYZCBA"], target=target, source=source)


def _fields(text: str) -> dict[str, str]:
    """Return the fields of a structure, every character of which is understood."""
    body = STRUCTURE.fullmatch(text)
    cells = [FIELD.fullmatch(cell) for cell in (body[1] if body else "").split(",")]
    values = {cell[1]: cell[2] for cell in cells if cell is not None}
    if len(values) < len(cells):
        raise LinkError(f"the answer is not a structure of numbers: {text[:60]!r}")
    return values


def open_kuka(address: Address, credentials: Credentials) -> KukaLink:
    """Return the open link."""
    return KukaLink(address)
