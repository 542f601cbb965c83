"""An oddity of a file or a result that does not stop the work, as data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Issue:
    """One oddity: a stable code for programs, a sentence for people, and what it concerns."""

    code: str  #: Stable, lower case with dashes: ``free-edges``.
    message: str  #: One sentence: what was found and what was done about it.
    ids: tuple[str, ...] = ()  #: Names of the faces, solids, points or seams that it concerns.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {"code": self.code, "message": self.message, "ids": list(self.ids)}
