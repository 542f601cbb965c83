"""By which place a seam is recognised, and which seam of today is which weld of a file.

Numbers of seams change with the part and with options. A weld in a file therefore holds the place of its seam on the
part: start, middle and length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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
class Paired:
    """Which weld of a file belongs to which seam."""

    rows: dict[str, int]  #: By the name of the seam: row of the weld.
    notes: tuple[str, ...]  #: What is not obvious, one line each.
    left: tuple[int, ...]  #: Rows of welds without a seam.


def pair(
    old: Sequence[tuple[str, SeamPlace | None]], now: Sequence[tuple[str, SeamPlace]], *, worth_telling: Sequence[bool]
) -> Paired:
    """Find the seam of every weld in a file: first by place, then by name."""
    rows: dict[str, int] = {}
    notes: list[str] = []
    free = dict.fromkeys(range(len(old)))
    for must_have_name in (True, False):  # both rims of a hole are at one place
        for name, place in now:
            is_it = (row for row in free if _is_at(old[row], name if must_have_name else None, place))
            row = None if name in rows else next(is_it, None)
            if row is None:
                continue
            rows[name] = row
            del free[row]
            if old[row][0] != name and worth_telling[row]:
                notes.append(f"{name} is at the place of {old[row][0]} and keeps its values")
    for name, place in now:
        row = None if name in rows else next((row for row in free if old[row][0] == name), None)
        own = None if row is None else old[row][1]
        moved = 0.0 if own is None else own.moved_mm(place)
        if row is None or moved is None:
            continue
        rows[name] = row
        del free[row]
        if moved > 0.0 and worth_telling[row]:
            notes.append(f"{name} has changed by {moved:.1f} mm and keeps its values")
    return Paired(rows, tuple(notes), tuple(free))


def _is_at(weld: tuple[str, SeamPlace | None], name: str | None, place: SeamPlace) -> bool:
    """Tell whether a weld of a file is at a place, and has a name if one is asked for."""
    return weld[1] is not None and weld[1].is_same(place) and name in (None, weld[0])
