"""By which place a seam is recognised, and which seam of today is which weld of a file.

Numbers of seams change with the part and with options. A weld in a file therefore holds the place of its seam on the
part: start, middle and length.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.seam.seam import Seam

SAME_MM = 0.1  #: Two places are one if start, middle and length agree within this, as for decisions about seams.
MOVED_SHARE = 0.1
"""A seam of the same name is the same one if its middle moved, and its length changed, by at most this share of the
length: a part that was changed a little."""
MOVED_LEAST_MM = 2.0  #: The least of these limits, for short seams.


@dataclass(frozen=True, slots=True)
class SeamPlace:
    """Where a seam is, in coordinates of the part."""

    #: `start_mm`, `middle_mm`: Points at the start and at half the length.
    start_mm: tuple[float, float, float]
    middle_mm: tuple[float, float, float]
    length_mm: float

    def to_record(self) -> dict[str, Any]:
        """Return the place as JSON holds it."""
        start, middle = list(self.start_mm), list(self.middle_mm)
        return {"start_part_mm": start, "middle_part_mm": middle, "length_mm": self.length_mm}

    @classmethod
    def from_record(cls, record: dict[str, Any]) -> SeamPlace:
        """Return the place that a record holds, whose types were checked."""
        x, y, z = (float(v) for v in record["start_part_mm"])
        u, v, w = (float(v) for v in record["middle_part_mm"])
        return cls((x, y, z), (u, v, w), float(record["length_mm"]))

    @property
    def is_straight(self) -> bool:
        """Tell whether its middle is half its length away from its start."""
        half = float(np.linalg.norm(self._middle - np.array(self.start_mm)))
        return abs(half - self.length_mm / 2.0) <= SAME_MM

    def is_same(self, other: SeamPlace) -> bool:
        """Tell whether two places are one, welded in either direction."""
        off_mm = abs(self.length_mm - other.length_mm)
        return bool(off_mm <= SAME_MM and np.linalg.norm(self._middle - other._middle) <= SAME_MM)

    def moved_mm(self, other: SeamPlace) -> float | None:
        """Return by how much a seam has moved or changed; None if it is too much for the same seam."""
        off = max(float(np.linalg.norm(self._middle - other._middle)), abs(self.length_mm - other.length_mm))
        return off if off <= max(MOVED_SHARE * self.length_mm, MOVED_LEAST_MM) else None

    @property
    def _middle(self) -> FloatArray:
        return np.array(self.middle_mm)


def place_of(seam: Seam, T_part_frame: RigidTransform) -> SeamPlace:
    """Return the place of a seam."""
    s, p = seam.frames.s_mm, T_part_frame.apply(seam.frames.p)
    middle = [float(np.interp(seam.length_mm / 2.0, s, p[:, axis])) for axis in range(3)]
    return SeamPlace(_xyz(p[0].tolist()), _xyz(middle), seam.length_mm)


def _xyz(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (round(value, 6) for value in values)
    return x, y, z


@dataclass(frozen=True, slots=True)
class StatedWeld:
    """What a person stated about one weld in a file."""

    name: str  #: Of the seam.
    place: SeamPlace | None  #: None in a file that was written by hand.
    user: Mapping[str, Any]  #: Names of values and values as JSON holds them; null for none.
    #: Values that another file stated, with its name.
    files: Mapping[str, tuple[Any, str]] = field(default_factory=dict)
    given_back: tuple[str, ...] = ()  #: Names of values that go back to the rules, for `wpcal.weld.merge`.

    @property
    def is_telling(self) -> bool:
        """Whether a person or a file stated a value."""
        return bool(self.user or self.files)


@dataclass(frozen=True, slots=True)
class Paired:
    """Which weld of a file belongs to which seam."""

    welds: dict[str, StatedWeld]  #: By the name of the seam, with its name and place of today.
    notes: tuple[str, ...]  #: What is not obvious, one line each.
    left: tuple[StatedWeld, ...]  #: Welds without a seam.


def pair(stated: Sequence[StatedWeld], now: Sequence[tuple[str, SeamPlace]]) -> Paired:
    """Find the seam of every weld in a file: first by place, then by name."""
    welds: dict[str, StatedWeld] = {}
    notes: list[str] = []
    free = list(stated)
    for note_of in (_at_its_place_and_name, _at_its_place, _of_its_name):  # both rims of a hole are at one place
        for name, place in now:
            tried = ((row, note_of(weld, name, place)) for row, weld in enumerate(free) if name not in welds)
            row, note = next((each for each in tried if each[1] is not None), (None, None))
            if row is None:
                continue
            weld = free.pop(row)
            welds[name] = replace(weld, name=name, place=place)
            if note and weld.is_telling:
                notes.append(f"{name} {note} and keeps its values")
    return Paired(welds, tuple(notes), tuple(free))


def _at_its_place_and_name(weld: StatedWeld, name: str, place: SeamPlace) -> str | None:
    return "" if weld.name == name and _at_its_place(weld, name, place) else None


def _at_its_place(weld: StatedWeld, name: str, place: SeamPlace) -> str | None:
    return f"is at the place of {weld.name}" if weld.place is not None and weld.place.is_same(place) else None


def _of_its_name(weld: StatedWeld, name: str, place: SeamPlace) -> str | None:
    moved_mm = 0.0 if weld.place is None else weld.place.moved_mm(place)
    if weld.name != name or moved_mm is None:
        return None
    return f"has changed by {moved_mm:.1f} mm" if moved_mm > 0.0 else ""
