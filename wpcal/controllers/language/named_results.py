"""Results of touch programs that a controller stores in variables with names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from wpcal.taught.programs import ProgramPoint, ProgramPoints
from wpcal.touch.searches.results import StoredValues, parsed_number


@dataclass(frozen=True, slots=True)
class ResultNames:
    """How a program names what it stores, lower case."""

    plan: str  #: The fingerprint.
    tool: str
    count: str
    outcome: str  #: Before the name of a search.
    place: str  #: The same.
    frame: str  #: The place of the part.

    def stored(self, values: Mapping[str, str], read: ProgramPoints, path: str) -> StoredValues:
        """Return what a file stores: its values by their names as written, and its points and frames."""
        texts = {name.lower(): text for name, text in values.items()}
        stored = StoredValues(fingerprint=texts.get(self.plan, ""), tool=texts.get(self.tool, ""))
        for name, text in values.items():
            own = name.lower()
            if own.startswith(self.outcome):
                stored.outcomes[own.removeprefix(self.outcome).upper()] = parsed_number(text, name, path)
            elif own == self.count:
                stored.count = parsed_number(text, name, path)
        for point in read.points:
            own = point.name.lower()
            if own == self.frame:
                stored.T_base_part = point.T_frame_tool.relabelled(target="base", source="frame")
            elif own.startswith(self.place):
                self._take(stored, own.removeprefix(self.place).upper(), point)
        for name, T in read.frames.items():
            if name.lower() == self.frame:
                stored.T_base_part = T
        return stored

    @staticmethod
    def _take(stored: StoredValues, search: str, point: ProgramPoint) -> None:
        if point.fault is None:
            stored.places[search] = point.T_frame_tool
        else:
            stored.faults[search] = point.fault
