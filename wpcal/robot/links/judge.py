"""The one place that judges readings: nothing else lets a position become a row."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from wpcal.core.readings import KeptReading, six_of
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.links.reading import LinkError, Reading, Setting

OLDEST_S = 0.5  #: Age of a position that is no longer used.
STILL_S = 0.2  #: Over at least this time the arm must have been where it is.
STILL_MM = 0.02  #: Within this distance of the tip: the resolution of most pendants is 0.01 mm.
STILL_RAD = 5e-4  #: And within this turn: three last digits of a pendant, 0.01 degrees each.
SAME_MM, SAME_RAD = 0.01, 1e-4  #: Two values of one tool or frame: controllers print 0.01 mm and 0.01 degrees or more.
MODEL_MM, MODEL_RAD = 1.0, 5e-3  #: Joints printed with 0.01 degrees leave 0.5 mm at 2 m; other arms differ by more.
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
    still_s: float  #: For how long the arm had stood there.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a page."""
        return {
            "xyz_mm": [round(value, 4) + 0.0 for value in self.T_base_tool.t_mm.tolist()],
            "note": self.note,
            "reading": self.kept().to_text(),
        }

    def kept(self) -> KeptReading:
        """Return what the row keeps of the reading."""
        read, joints = self.reading, self.reading.joints_rad
        at = datetime.now(UTC) - timedelta(seconds=time.monotonic() - read.asked_s)
        return KeptReading(
            T_base_tool=six_of(self.T_base_tool) or [],
            tool=read.tool.name,
            frame=read.frame.name,
            T_flange_tool=six_of(read.tool.values),
            T_base_frame=six_of(read.frame.values),
            joints_deg=None if joints is None else np.degrees(joints).round(4).tolist(),
            configuration=read.configuration,
            read_utc=at.isoformat(timespec="milliseconds"),
            still_s=round(self.still_s, 3),
        )


@dataclass(slots=True, eq=False)
class RowJudge:
    """Accepts readings of one table: with the tool of its first row, in the base, of an arm that stands."""

    tool: str | None = None  #: `tool`, `frame`: what must be active.
    frame: str | None = None
    T_flange_tool: RigidTransform | None = None  #: The tool, if the controller has none active or tells no values.
    arm: Arm | None = None  #: The model of the robot, to which joints and positions must belong.
    _before: Reading | None = None  #: Of the row before.
    _T_base_model: RigidTransform | None = None  #: Where the model stands, by the first row.

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
        is_known = found.tool.values is not None and not _is_flange(found.tool)
        used = found.tool if is_known else Setting(found.tool.name, self.T_flange_tool)
        T_base_model = self._place_of_model(found, T_base_tool, used)
        still_s = _still_s(readings)
        if self._before is not None and not _is_same(found.frame, self._before.frame):
            note += f"; the row before was shown in frame {self._before.frame}: both are in the base"
        self._before, self._T_base_model = found, T_base_model
        return Accepted(replace(found, tool=used), T_base_tool, note, still_s)

    def _require_same_tool(self, found: Reading) -> None:
        before = self._before
        if before is None or _is_same(found.tool, before.tool):
            return
        if found.tool.name != before.tool.name:
            what = f"tool {found.tool} is active, the row before was touched with tool {before.tool}"
        else:
            what = f"the values of tool {found.tool} have changed since the row before"
        raise LinkError(f"refused: {what}")

    def _place_of_model(self, found: Reading, T_base_tool: RigidTransform, tool: Setting) -> RigidTransform | None:
        """Return where the model of the arm must stand for joints and position to belong together."""
        if self.arm is None or found.joints_rad is None:
            return None
        if tool.values is None:
            raise LinkError(f"refused: the robot does not tell the values of tool {tool}; arm= needs --tool then")
        joints = found.joints_rad[: len(self.arm.chain)]
        flange = RigidTransform.from_matrix(self.arm.forward(joints[None])[0], target="model", source="flange")
        T = T_base_tool @ (flange @ tool.values.relabelled(target="flange", source="tool")).inverse()
        before = self._T_base_model or T
        if not T.is_close(before, atol_mm=MODEL_MM, atol_rad=MODEL_RAD):
            off = float(np.linalg.norm((before.inverse() @ T_base_tool).t_mm - (T.inverse() @ T_base_tool).t_mm))
            raise LinkError(f"refused: joints and position are {off:.1f} mm apart by the model of the arm")
        return before

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


def _still_s(readings: Sequence[Reading]) -> float:
    """Return for how long the arm has been where it is. Raises `ArmMovesError` when that is less than `STILL_S`."""
    found, still_s, is_changed = readings[-1], 0.0, False
    for reading in reversed(readings[:-1]):
        is_changed = not (_is_same(reading.tool, found.tool) and _is_same(reading.frame, found.frame))
        if is_changed or not found.T_base_tool.is_close(reading.T_base_tool, atol_mm=STILL_MM, atol_rad=STILL_RAD):
            break
        still_s = found.asked_s - reading.asked_s
    if still_s >= STILL_S:
        return still_s
    if is_changed:
        raise ArmMovesError("refused: tool or frame were changed just now; once more")
    raise ArmMovesError(f"refused: the arm has not stood still for {STILL_S:g} s")
