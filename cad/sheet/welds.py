"""Welds on a sheet: the list for the shop floor, with the symbols of ISO 2553."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cad.sheet.draw import SheetRow, Strokes
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import read_json
from wpcal.weld.place import SeamPlace
from wpcal.weld.record import WELDS_SCHEMA
from wpcal.weld.values import WeldKind, WeldValues, describe_weld, values_from_record

RIGHT_ARC = ((0.9, 1.0), (0.65, 0.75), (0.58, 0.5), (0.65, 0.25), (0.9, 0.0))
SYMBOLS: Mapping[WeldKind, Strokes] = {
    WeldKind.FILLET: (((0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.0, 0.0)),),
    WeldKind.SQUARE: (((0.3, 0.0), (0.3, 1.0)), ((0.7, 0.0), (0.7, 1.0))),
    WeldKind.SINGLE_V: (((0.0, 1.0), (0.5, 0.0), (1.0, 1.0)),),
    WeldKind.SINGLE_BEVEL: (((0.3, 1.0), (0.3, 0.0), (0.9, 1.0)),),
    WeldKind.DOUBLE_V: (((0.0, 0.0), (1.0, 1.0)), ((0.0, 1.0), (1.0, 0.0))),
    WeldKind.DOUBLE_BEVEL: (((0.3, 0.0), (0.3, 1.0)), ((0.9, 1.0), (0.3, 0.5), (0.9, 0.0))),
    WeldKind.FLARE_V: (RIGHT_ARC, tuple((1.0 - x, y) for x, y in RIGHT_ARC)),
    WeldKind.FLARE_BEVEL: (((0.3, 0.0), (0.3, 1.0)), RIGHT_ARC),
}
"""Each kind of weld as it stands on a reference line (ISO 2553, table 1), drawn: fonts have few of these signs."""


@dataclass(frozen=True, slots=True)
class ListedWeld:
    """One weld of the list."""

    name: str  #: Of its seam.
    place: SeamPlace
    values: WeldValues
    welded_mm: float  #: Length of all its stretches.

    def row(self, number: int) -> SheetRow:
        """Return its line of the table."""
        v = self.values
        cells = (describe_weld(v), f"{self.welded_mm:.0f}", "" if v.thickness_mm is None else f"{v.thickness_mm:g}",
                 "" if v.passes is None else str(v.passes))  # fmt: skip
        symbol = () if v.weld is None else SYMBOLS[v.weld]
        return SheetRow(str(number), self.name, cells, start=self._straight_start, symbol=symbol)

    def to_record(self) -> dict[str, Any]:
        """Return the weld as the record of a sheet holds it."""
        words = describe_weld(self.values)
        return {"name": self.name, "p_mm": list(self.place.middle_mm), "welded_mm": self.welded_mm, "words": words}

    @property
    def _straight_start(self) -> tuple[float, float, float] | None:
        """Where the arrow along the weld begins; None at a bent weld, whose chord would run beside it."""
        return self.place.start_mm if self.place.is_straight else None


def read_listed_welds(path: Path) -> tuple[ListedWeld, ...]:
    """Read the welds of a ``welds.json``, in its order.

    Raises `InputError` if the file cannot be opened, or holds no weld.
    Raises `FormatError` if it is not such a record, or a weld was written by hand and has no place.
    """
    found = []
    for number, entry in enumerate(read_json(path, schema=WELDS_SCHEMA).get("welds", [])):
        name = entry.get("name", f"welds[{number}]")
        missing = [key for key in ("name", "place", "stretches_mm") if entry.get(key) is None]
        if missing:
            what = f"weld {name}: has no {missing[0]}; wpcal welds DIR -o {path.name} adds what is missing"
            raise FormatError(what, path=str(path))
        values = values_from_record(entry.get("values", {}), what=f"{path}: weld {name}")
        welded_mm = float(sum(end - start for start, end in entry["stretches_mm"]))
        found.append(ListedWeld(name, SeamPlace.from_record(entry["place"]), values, welded_mm))
    if not found:
        raise InputError(f"{path}: holds no weld")
    return tuple(found)
