# SPDX-License-Identifier: MIT
"""The panel *Taught points and touches*: clicks become rows, and every row that is filled is fitted at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import FreeCADGui

from ..client import Failure
from ..document.calibration import fit_options, fit_params, seam_params
from ..document.kinds import Kind
from ..document.pasted import pasted_points
from ..document.picks import Pick, feature_under, picks_of, touch_of
from ..document.seams import SeamModel
from ..document.taught import COORDINATES, TaughtModel
from ..qt import QtCore, application, widgets
from ..words import translate
from .base import TaskPanel
from .taught_table import TaughtTable
from .watching import DocumentWatch, SelectionWatch
from .widgets import button, view_of

REFIT_AFTER_MS = 30  #: Changes within this time are fitted together. A cell changes once, when it is left.
FILES = "Tables and robot programs (*.csv *.tsv *.txt *.xlsx *.mod *.dat *.src *.ls *.jbi *.as *.urp *.script);;* (*)"


class TaughtPointsPanel(TaskPanel):
    """Fills the table of taught points and shows what it is worth."""

    title = "Taught points and touches"

    def build(self) -> None:
        """Make the widgets; the part is opened if the document does not have its features yet."""
        self.model = TaughtModel(self.session)
        self.seams = SeamModel(self.session)
        self._fit: Any = None
        self._has_failed = False
        self._refit = QtCore.QTimer()
        self._refit.setSingleShot(True)
        self._refit.timeout.connect(self.refit)
        self.clicks_add = widgets().QCheckBox(translate("A click on the part adds a row"))
        self.clicks_add.setChecked(True)
        self.body.addWidget(self.clicks_add)
        self.table = TaughtTable(self.model, self._typed, self._chose, self.paste)
        self.body.addWidget(self.table.widget)
        self.summary = widgets().QLabel()
        self.summary.setObjectName("wpcal_fit")
        self.summary.setWordWrap(True)
        self.body.addWidget(self.summary)
        self.body.addLayout(self._buttons())
        self._documents = DocumentWatch(self.document, (Kind.TAUGHT,), self.refresh)
        self._clicks = SelectionWatch(self.document, self.picked)
        self.refresh()
        if not self.seams.features or self.seams.is_stale:
            self.open_part(self._opened)

    def closed(self) -> None:
        """Hear no more of FreeCAD, and take the marks away."""
        self._refit.stop()
        self._documents.stop()
        self._clicks.stop()
        self._mark([])
        self._show_residuals([])

    def _opened(self, opened: dict[str, Any]) -> None:
        self.seams.take_features(opened)
        self.refresh()

    def _buttons(self) -> Any:
        layout = widgets().QGridLayout()
        buttons = (
            ("Open file…", self.open_file, "Rows from a table or a controller's program"),
            ("Paste", self.paste, "Points from the clipboard, one per line, from the chosen row on"),
            ("Suggest next", self.suggest, "The feature whose touch lowers the error of the seams most"),
            ("Fit / check / leave out", self.use_otherwise, "Use the chosen rows otherwise"),
            ("Remove", self.remove, "Remove the chosen rows"),
            ("Undo", self.document.undo, "Take the last change back"),
        )
        for number, (text, method, tip) in enumerate(buttons):
            layout.addWidget(button(translate(text), method, translate(tip)), number // 2, number % 2)
        return layout

    # -- rows -------------------------------------------------------------------------------------------------------

    def refresh(self) -> None:
        """Show the document's rows: after a click, after Undo, after anybody's change. A fit follows."""
        self.table.fill()
        self._refit.start(REFIT_AFTER_MS)

    def _typed(self, row: int, column: str, text: str) -> None:
        if text != self.model.cell(row, column):
            self.model.change({(row, column): text}, translate("Type a point"))

    def _chose(self) -> None:
        names = []
        for row in self.table.chosen():
            record = self.model.records()[row]
            names.append(record.get("feature") or record.get("name", ""))
        self._mark(names)

    def remove(self) -> None:
        """Remove the chosen rows."""
        if self.table.chosen():
            self.model.remove(self.table.chosen())

    def use_otherwise(self) -> None:
        """Fit, check or leave out the chosen rows."""
        if self.table.chosen():
            self.model.next_use(self.table.chosen())

    def paste(self) -> None:
        """Take points from the clipboard: a table with a header, or coordinates one per line."""
        self.paste_text(application().clipboard().text())

    def paste_text(self, text: str) -> None:
        """Take points from a text."""
        if "x_mm" in text.split("\n", 1)[0]:
            self.ask("read_taught", {"path": "pasted.csv", "text": text}, self._read)
            return
        try:
            points = pasted_points(text)
        except ValueError as error:
            self.say(str(error), is_error=True)
            return
        chosen = self.table.chosen()
        self.model.put_points(chosen[0] if chosen else len(self.model.rows), points)

    def open_file(self) -> None:
        """Ask for a file and take its rows."""
        title = translate("Taught points")
        path = widgets().QFileDialog.getOpenFileName(self.form, title, "", FILES)[0]
        if path:
            self.read_file(Path(path))

    def read_file(self, path: Path) -> None:
        """Take the rows of a table or a controller's program; those of the document are replaced."""
        self.ask("read_taught", {"path": str(path)}, self._read)

    def _read(self, result: dict[str, Any]) -> None:
        self.model.write(result["columns"], result["rows"], translate("Read taught points"))
        notes = [*map(str, result.get("left_out", [])), *map(str, result.get("notes", []))]
        self.say("\n".join(notes))

    # -- clicks -----------------------------------------------------------------------------------------------------

    def picked(self) -> None:
        """Make a row of what was clicked last."""
        picks = picks_of(FreeCADGui.Selection.getSelectionEx(self.document.Name, 0))
        seams = self.seams.object
        if picks and seams is not None and self.clicks_add.isChecked():
            self._take(picks[-1], seams)

    def _take(self, pick: Pick, seams: Any) -> None:
        if pick.shape is None:
            if pick.object == seams and pick.name in self.model.features:
                self.table.edit(self.model.add_feature(pick.name))
            return
        touch = touch_of(pick, seams.PartFrame)
        name = self.model.feature_at(touch.place) if touch.kind == "" else None
        if name is None and pick.point is not None:
            view = FreeCADGui.getDocument(self.document.Name).ActiveView
            on_screen = view.getPointOnScreen
            name = feature_under(pick.point, self.model.features.values(), seams.PartFrame, on_screen)
        if name is not None:
            self.table.edit(self.model.add_feature(name))
        elif touch.normal is None:
            self.table.edit(self.model.add_place(touch.place, touch.kind))
        else:
            self.ask("touch_at", {"p_mm": touch.place, "normal": touch.normal}, self._touched, quiet=True)

    def _touched(self, found: dict[str, Any]) -> None:
        self.table.edit(self.model.add_place(found["p_mm"], found["kind"]))

    # -- the fit ----------------------------------------------------------------------------------------------------

    def refit(self) -> None:
        """Fit the complete rows. A fit that is not answered yet is given up: only the newest rows count."""
        if self._fit is not None and not self._fit.is_done:
            self._fit.cancel()
        self._fit = None
        complete = [row for row, record in enumerate(self.model.records()) if all(record[name] for name in COORDINATES)]
        if not complete:
            self.summary.setText(translate("Click corners, holes, edges or faces; then type what the robot shows."))
            self._show_residuals([])
            return
        params = fit_params(self.document)
        self._fit = self.ask("calibrate", params, self._fitted, quiet=True)

    def _fitted(self, fit: dict[str, Any]) -> None:
        points = fit["points"]
        self.table.show_residuals({one["row"]: one["distance_mm"] for one in points if one["row"] is not None})
        self._show_residuals(points)
        judgement = fit["record"]["judgement"]
        worst = next((one for one in fit["u95_mm"] if one["seam"] == judgement["seam"]), None)
        lines = [f"{judgement['kind']}: {judgement['sentence']}"]
        if worst is not None:
            text = translate("largest 95 % error of a seam: {mm:.2f} mm at {name}")
            lines.append(text.format(mm=worst["max_mm"], name=worst["seam"]))
        self.summary.setText("\n".join([*lines, *map(str, fit["notes"])]))
        if self._has_failed:
            self.say("")
        self._has_failed = False

    def failed(self, failure: Failure) -> None:
        """Show why there is no fit, at the cell if wpcal names one. A fit that was given up is no failure."""
        if failure.is_cancelled:
            return
        self._has_failed = True
        self.table.show_residuals({})
        self._show_residuals([])
        self.summary.setText("")
        row, column = failure.data.get("row"), failure.data.get("column")
        if row is not None:
            self.table.mark_wrong(int(row), str(column or "name"), failure.message)
        super().failed(failure)

    def _show_residuals(self, points: list[dict[str, Any]]) -> None:
        view = view_of(self.model.object)
        if view is not None:
            view.show_residuals(points)

    # -- what to touch next -----------------------------------------------------------------------------------------

    def suggest(self) -> None:
        """Ask which features to touch next, and add rows for them."""
        params = seam_params(self.document, fit_options(self.document))
        self.ask("suggest", {"taught": self.model.request(), **params}, self._suggested)

    def _suggested(self, answer: dict[str, Any]) -> None:
        names = [name for name in answer["features"] if self.model.row_of_feature(name) is None]
        if not names:
            self.say(translate("No further touch lowers the error of the seams."))
            return
        row = self.model.add([{"name": name, "feature": name} for name in names], translate("Suggest next"))
        self.table.edit(row)
        error = answer.get("error_95_mm")
        if error is not None:
            text = translate("Touch {names}: the largest 95 % error is then {mm:.2f} mm, at {seam}.")
            self.say(text.format(names=", ".join(names), mm=error, seam=answer["seam"]))

    def _mark(self, names: list[str]) -> None:
        view = view_of(self.seams.object)
        if view is not None:
            view.choose(names)
