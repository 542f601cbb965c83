"""The one place that judges readings: nothing else lets a position become a row."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.core.rotations import quaternion_from_rotation
from wpcal.core.transform import RigidTransform
from wpcal.links.reading import LinkError, Reading, Setting

OLDEST_S = 0.5  #: Age of a position that is no longer used.
STILL_S = 0.2  #: Over at least this time the arm must have been where it is.
STILL_MM = 0.02  #: Within this distance of the tip: the resolution of most pendants is 0.01 mm.
STILL_RAD = 5e-4  #: And within this turn: three last digits of a pendant, 0.01 degrees each.
SAME_MM, SAME_RAD = 0.01, 1e-4  #: Two values of one tool or frame: controllers print 0.01 mm and 0.01 degrees or more.
FLANGE = ("0", "tool0")  #: Names of no tool.
FARTHEST_MM = 20_000.0  #: No arm on a rail reaches farther; a larger number is not a position.


class ArmMovesError(LinkError):
    """The arm has not stood still long enough yet."""


@dataclass(frozen=True, slots=True, eq=False)
class Accepted:
    """A position that may become a row."""

    reading: Reading
    T_base_tool: RigidTransform
    note: str  #: One line: tool and frame, and what was converted.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a page."""
        joints = self.reading.joints_rad
        return {
            "xyz_mm": [round(value, 4) + 0.0 for value in self.T_base_tool.t_mm.tolist()],
            "q_xyzw": quaternion_from_rotation(self.T_base_tool.R).tolist(),
            "tool": str(self.reading.tool),
            "frame": str(self.reading.frame),
            "joints_deg": None if joints is None else np.degrees(joints).tolist(),
            "note": self.note,
        }


@dataclass(slots=True, eq=False)
class RowJudge:
    """Accepts readings of one table: with the tool of its first row, in the base, of an arm that stands."""

    tool: str | None = None  #: `tool`, `frame`: what must be active.
    frame: str | None = None
    T_flange_tool: RigidTransform | None = None  #: The tool, if the controller has none active.
    _before: Reading | None = None  #: Of the row before.

    def accept(self, readings: Sequence[Reading]) -> Accepted:
        """Return the newest position if it may become a row.

        `readings`: In the order of time, of one connection.
        Raises `ArmMovesError` when the arm has not stood for `STILL_S` yet.
        Raises `LinkError` when the position is too old, or tool or frame are not as expected.
        """
        found = readings[-1]
        age = time.monotonic() - found.asked_s
        if age > OLDEST_S:
            raise LinkError(f"refused: the position is {age:.1f} s old, at most {OLDEST_S:g} s is used")
        if not float(np.abs(found.T_base_tool.t_mm).max()) <= FARTHEST_MM:
            raise LinkError("refused: the position is farther away than any arm reaches")
        _require(found.tool, self.tool, "tool")
        _require(found.frame, self.frame, "frame")
        self._require_same_tool(found)
        T_base_tool, note = self._with_tool(found)
        _require_still(readings)
        if self._before is not None and not _is_same(found.frame, self._before.frame):
            note += f"; the row before was shown in frame {self._before.frame}: both are in the base"
        self._before = found
        return Accepted(found, T_base_tool, note)

    def _require_same_tool(self, found: Reading) -> None:
        before = self._before
        if before is None or _is_same(found.tool, before.tool):
            return
        if found.tool.name != before.tool.name:
            what = f"tool {found.tool} is active, the row before was touched with tool {before.tool}"
        else:
            what = f"the values of tool {found.tool} have changed since the row before"
        raise LinkError(f"refused: {what}")

    def _with_tool(self, found: Reading) -> tuple[RigidTransform, str]:
        note = f"tool {found.tool}, frame {found.frame}"
        if not _is_flange(found.tool):
            return found.T_base_tool, note
        if self.T_flange_tool is None:
            raise LinkError(
                f"refused: tool {found.tool} is active, which is the flange; choose the tool on the pendant, or --tool"
            )
        T = found.T_base_tool
        flange = RigidTransform(T.R, T.t_mm, T.target, "flange")
        tool = RigidTransform(self.T_flange_tool.R, self.T_flange_tool.t_mm, "flange", "tool")
        return flange @ tool, f"{note}, with --tool from the flange"


def _require(found: Setting, expected: str | None, what: str) -> None:
    if expected is not None and found.name.lower() != expected.lower():
        raise LinkError(f"refused: {what} {found} is active, expected {what} {expected}")


def _is_flange(tool: Setting) -> bool:
    """Tell whether a tool is none: by its values, since the number can be that of another one, or by its name."""
    if tool.values is None:
        return tool.name in FLANGE
    none = RigidTransform.identity(target=tool.values.target, source=tool.values.source)
    return tool.values.is_close(none, atol_mm=SAME_MM, atol_rad=SAME_RAD)


def _is_same(one: Setting, other: Setting) -> bool:
    """Tell whether name and values are the same; what a controller does not tell is."""
    if one.name != other.name:
        return False
    if one.values is None or other.values is None:
        return True
    return one.values.is_close(other.values, atol_mm=SAME_MM, atol_rad=SAME_RAD)


def _require_still(readings: Sequence[Reading]) -> None:
    found = readings[-1]
    for reading in reversed(readings[:-1]):
        if not (_is_same(reading.tool, found.tool) and _is_same(reading.frame, found.frame)):
            raise ArmMovesError("refused: tool or frame were changed just now; once more")
        if not found.T_base_tool.is_close(reading.T_base_tool, atol_mm=STILL_MM, atol_rad=STILL_RAD):
            break
        if found.asked_s - reading.asked_s >= STILL_S:
            return
    raise ArmMovesError(f"refused: the arm has not stood still for {STILL_S:g} s")
