# SPDX-License-Identifier: MIT
"""The table in the panel of taught points."""

from __future__ import annotations

from typing import Any, Callable, Mapping

from ..document.taught import COORDINATES, MODEL, TaughtModel
from ..qt import QtCore, gui, widgets
from ..words import translate

SHOWN = ("name", *COORDINATES, "use")
"""Columns of the document's table that are shown and typed into; before the residual and what was touched."""
RESIDUAL = len(SHOWN)
TOUCHED = RESIDUAL + 1
HEADERS = ("name", "X", "Y", "Z", "use", "off (mm)", "touched")
WRONG = "#f7c6cc"
UNUSED = "#8a94a0"


class TaughtTable:
    """Rows of a `TaughtModel` as cells."""

    def __init__(
        self,
        model: TaughtModel,
        typed: Callable[[int, str, str], None],
        chose: Callable[[], None],
        paste: Callable[[], None],
    ) -> None:
        self._model, self._typed = model, typed
        self._is_filling = False
        self.widget = widgets().QTableWidget(0, len(HEADERS))
        self.widget.setObjectName("wpcal_taught")
        self.widget.setHorizontalHeaderLabels([translate(name) for name in HEADERS])
        self.widget.setSelectionBehavior(widgets().QAbstractItemView.SelectRows)
        self.widget.verticalHeader().hide()
        self.widget.horizontalHeader().setStretchLastSection(True)
        self.widget.setMinimumHeight(220)
        self.widget.itemChanged.connect(self._item_changed)
        self.widget.itemSelectionChanged.connect(lambda: None if self._is_filling else chose())
        shortcut = gui().QKeySequence.Paste
        self._paste = _shortcut(shortcut, self.widget)
        self._paste.setContext(QtCore.Qt.WidgetShortcut)
        self._paste.activated.connect(paste)

    def fill(self) -> None:
        """Show the rows of the document; the chosen cell stays chosen."""
        place = (self.widget.currentRow(), self.widget.currentColumn())
        self._is_filling = True
        records = self._model.records()
        self.widget.setRowCount(len(records))
        for row, record in enumerate(records):
            cells = [record.get(name, "") for name in SHOWN]
            for column, text in enumerate([*cells, "", self._touched(record)]):
                self._set(row, column, text, is_grey=record.get("use") == "no")
        self._is_filling = False
        self.widget.resizeColumnsToContents()
        if 0 <= place[0] < len(records) and self.widget.currentRow() != place[0]:
            self.widget.setCurrentCell(*place)

    def chosen(self) -> list[int]:
        """Return the numbers of the chosen rows."""
        return sorted({index.row() for index in self.widget.selectedIndexes()})

    def edit(self, row: int) -> None:
        """Choose a row and begin with its first coordinate that is empty."""
        self.fill()
        empty = [SHOWN.index(name) for name in COORDINATES if not self._model.cell(row, name)]
        self.widget.setCurrentCell(row, empty[0] if empty else SHOWN.index(COORDINATES[0]))
        self.widget.setFocus()

    def show_residuals(self, distances: Mapping[int, float]) -> None:
        """Show how far each row is off, mm, by its number; and that nothing is wrong any more."""
        self._is_filling = True
        for row in range(self.widget.rowCount()):
            distance = distances.get(row)
            self.widget.item(row, RESIDUAL).setText("" if distance is None else f"{distance:.3f}")
            for column in range(self.widget.columnCount()):
                self.widget.item(row, column).setBackground(gui().QBrush())
        self._is_filling = False

    def mark_wrong(self, row: int, column: str, why: str) -> None:
        """Colour the cell that wpcal could not read."""
        item = self.widget.item(row, SHOWN.index(column) if column in SHOWN else TOUCHED)
        if item is not None:
            self._is_filling = True
            item.setBackground(gui().QBrush(gui().QColor(WRONG)))
            item.setToolTip(why)
            self._is_filling = False

    def _set(self, row: int, column: int, text: str, *, is_grey: bool) -> None:
        item = self.widget.item(row, column)
        if item is None:
            item = widgets().QTableWidgetItem()
            if column >= RESIDUAL:
                item.setFlags(QtCore.Qt.ItemIsEnabled | QtCore.Qt.ItemIsSelectable)
            self.widget.setItem(row, column, item)
        if column != RESIDUAL or not text:
            item.setText(text)
        item.setForeground(gui().QBrush(gui().QColor(UNUSED)) if is_grey else gui().QBrush())

    def _touched(self, record: Mapping[str, str]) -> str:
        feature = self._model.features.get(record.get("feature", "")) or self._model.features.get(record["name"])
        if feature is not None:
            return f"{feature['name']}: {feature['touch']}"
        place = ", ".join(record.get(name, "") for name in MODEL)
        return f"{record.get('kind') or 'point'} at {place}" if place.strip(", ") else ""

    def _item_changed(self, item: Any) -> None:
        if not self._is_filling and item.column() < RESIDUAL:
            self._typed(item.row(), SHOWN[item.column()], item.text().strip())


def _shortcut(keys: Any, parent: Any) -> Any:
    """Return a shortcut; Qt 6 has the class in QtGui, Qt 5 among the widgets."""
    made = getattr(gui(), "QShortcut", None) or widgets().QShortcut
    return made(gui().QKeySequence(keys), parent)
