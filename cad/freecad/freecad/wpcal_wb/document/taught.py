# SPDX-License-Identifier: MIT
"""The taught points of a document: the table that `wpcal calibrate` reads, while a person fills it.

Cells are texts, exactly as in the file. Every action of the user is one step of Undo.
"""

from __future__ import annotations

import math
from typing import Any, Mapping, Sequence

from ..words import translate
from .kinds import Kind, data_of, ensure_object, object_of, set_data, transaction
from .session import Session

COORDINATES = ("x_mm", "y_mm", "z_mm")
MODEL = ("model_x_mm", "model_y_mm", "model_z_mm")
FIRST_COLUMNS = ("name", *COORDINATES, "feature", "use")
USES = ("yes", "check", "no")  #: Fitted; not fitted, but tests the fit; left out.
SAME_PLACE_MM = 0.01
"""A vertex or the centre of a circle is a feature if they are this near: both come from the same STEP file."""
MODEL_DIGITS = 4  #: Decimals of mm of a place on the model.

Vector = Sequence[float]


class TaughtModel:
    """The taught points of a document."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._found: Any = None
        self._features: dict[str, dict[str, Any]] = {}

    # -- what is there ----------------------------------------------------------------------------------------------

    @property
    def object(self) -> Any:
        """The object of the document; None before the first row."""
        return object_of(self.session.document, Kind.TAUGHT)

    @property
    def columns(self) -> list[str]:
        """The names of the columns."""
        return list(self._table().get("columns", FIRST_COLUMNS))

    @property
    def rows(self) -> list[list[str]]:
        """The cells, row by row."""
        return [list(row) for row in self._table().get("rows", [])]

    def request(self) -> dict[str, Any]:
        """Return the table as wpcal takes it, without columns that a removed touch left empty."""
        columns, rows = self.columns, self.rows
        kept = [n for n, name in enumerate(columns) if name in FIRST_COLUMNS or any(row[n] for row in rows)]
        return {"columns": [columns[n] for n in kept], "rows": [[row[n] for n in kept] for row in rows]}

    def cell(self, row: int, column: str) -> str:
        """Return a cell; empty if the table has no such column."""
        columns = self.columns
        return self.rows[row][columns.index(column)] if column in columns else ""

    def records(self) -> list[dict[str, str]]:
        """Return the rows by the names of their columns."""
        columns = self.columns
        return [dict(zip(columns, row)) for row in self.rows]

    @property
    def features(self) -> dict[str, dict[str, Any]]:
        """The features of the part by their names."""
        seams = object_of(self.session.document, Kind.SEAMS)
        found = data_of(seams, "Features") if seams is not None else None
        if found is not self._found:
            self._found, self._features = found, {one["name"]: one for one in found or []}
        return self._features

    def place_of(self, record: Mapping[str, str]) -> tuple[float, ...] | None:
        """Return where a row was touched, in the part; None if it does not say."""
        features = self.features
        for name in (record.get("feature", ""), record.get("name", "")):
            if name in features:
                return tuple(features[name]["p_mm"])
        try:
            return tuple(float(record[name]) for name in MODEL)
        except (KeyError, ValueError):
            return None

    def _table(self) -> dict[str, Any]:
        return (data_of(self.object, "Table") if self.object is not None else None) or {}

    # -- changing ---------------------------------------------------------------------------------------------------

    def write(self, columns: Sequence[str], rows: Sequence[Sequence[str]], text: str) -> None:
        """Keep a whole table: one step of Undo called `text`."""
        with transaction(self.session.document, text):
            obj = ensure_object(self.session.document, Kind.TAUGHT)
            set_data(obj, "Table", {"columns": list(columns), "rows": [list(row) for row in rows]})

    def add(self, records: Sequence[Mapping[str, str]], text: str) -> int:
        """Add rows; columns that the table lacks are added. Return the number of the first of them."""
        columns = self.columns
        columns += [name for record in records for name in record if name not in columns]
        columns = list(dict.fromkeys(columns))
        old = [[record.get(name, "") for name in columns] for record in self.records()]
        new = [[str(record.get(name, "yes" if name == "use" else "")) for name in columns] for record in records]
        self.write(columns, [*old, *new], text)
        return len(old)

    def change(self, changes: Mapping[tuple[int, str], str], text: str) -> None:
        """Change cells, given by row and name of the column."""
        columns, rows = self.columns, self.rows
        for (row, column), value in changes.items():
            if column not in columns:
                columns.append(column)
                rows = [[*cells, ""] for cells in rows]
            rows[row][columns.index(column)] = value
        self.write(columns, rows, text)

    def remove(self, rows: Sequence[int]) -> None:
        """Remove rows."""
        kept = [row for number, row in enumerate(self.rows) if number not in set(rows)]
        self.write(self.columns, kept, translate("Remove rows"))

    def next_use(self, rows: Sequence[int]) -> None:
        """Go from fitted to check, from check to left out, and back to fitted."""
        use = self.cell(rows[0], "use") or USES[0]
        after = USES[(USES.index(use) + 1) % len(USES)] if use in USES else USES[0]
        self.change({(row, "use"): after for row in rows}, translate("Use rows otherwise"))

    def put_points(self, row: int, points: Sequence[Sequence[str]]) -> None:
        """Write what the robot shows into rows, from one on; rows that are missing are added."""
        missing = row + len(points) - len(self.rows)
        records = self.records() + [{"name": name, "use": "yes"} for name in self.free_names(max(0, missing))]
        for number, point in enumerate(points, row):
            records[number].update(zip(COORDINATES, point))
        columns = self.columns
        cells = [[record.get(name, "") for name in columns] for record in records]
        self.write(columns, cells, translate("Paste points"))

    def free_names(self, count: int) -> list[str]:
        """Return names of touches, T1 and so on, that no row has yet."""
        taken = {record.get("name") for record in self.records()}
        names: list[str] = []
        number = 1
        while len(names) < count:
            if f"T{number}" not in taken:
                names.append(f"T{number}")
            number += 1
        return names

    # -- what was clicked -------------------------------------------------------------------------------------------

    def row_of_feature(self, name: str) -> int | None:
        """Return the row of a feature; None if it has none."""
        for number, record in enumerate(self.records()):
            if name in (record.get("feature"), record.get("name")):
                return number
        return None

    def add_feature(self, name: str) -> int:
        """Return the row of a feature; it is added if there is none."""
        row = self.row_of_feature(name)
        if row is not None:
            return row
        return self.add([{"name": name, "feature": name}], translate("Add a point"))

    def feature_at(self, place: Vector) -> str | None:
        """Return the feature at a place of the part; None if there is none."""
        near = [(math.dist(one["p_mm"], place), name) for name, one in self.features.items()]
        distance, name = min(near, default=(math.inf, ""))
        return name if distance <= SAME_PLACE_MM else None

    def add_place(self, place: Vector, kind: str = "") -> int:
        """Add a row for a place on the model that has no name: a touch of an edge or a face, or a point."""
        model = dict(zip(MODEL, (f"{value:.{MODEL_DIGITS}f}" for value in place)))
        record = {"name": self.free_names(1)[0], **({"kind": kind} if kind else {}), **model}
        return self.add([record], translate("Add a touch"))
