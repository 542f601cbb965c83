# SPDX-License-Identifier: MIT
"""The panel *Features and seams*: what wpcal finds on the part, and what the user decides about the seams."""

from __future__ import annotations

from typing import Any

import FreeCADGui

from ..client import Failure
from ..document.export import part_objects
from ..document.kinds import Kind
from ..document.picks import Pick, edge_points, in_part, picks_of
from ..document.seams import ADDED_EDGES, Seam, SeamModel
from ..qt import QtCore, widgets
from ..words import translate
from .base import TaskPanel
from .option_form import OptionForm
from .watching import DocumentWatch, SelectionWatch
from .widgets import button, folded, view_of

COLUMNS = ("weld", "joint", "mm", "sure", "reason")
FIRST_OPTIONS = {
    "gap_mm": "Largest gap (mm)",
    "concave": "Concave edges",
    "weld": "Always weld",
    "not": "Never weld",
    "torch": "Torch",
}
"""Options of the search that are shown before the others."""
LEFT_OUT = (ADDED_EDGES, "edge", "marked", "seams", "xmcf", "png", "json", "out", "force", "no_cache", "solid")
"""The panel itself has the edges and the decisions; the others write files."""


class FeaturesAndSeamsPanel(TaskPanel):
    """Finds features and seams; the list ticks, reverses and rejects."""

    title = "Features and seams"

    def build(self) -> None:
        """Make the widgets, and search if the document has no seams of the part as it is."""
        self.model = SeamModel(self.session)
        self._is_filling = False
        self._shown: list[Seam] = []
        self.body.addWidget(self._part_box())
        self.body.addWidget(self._view_box())
        self.body.addWidget(self._list())
        self.body.addLayout(self._buttons())
        self.options = OptionForm(first=FIRST_OPTIONS, left_out=LEFT_OUT)
        self.body.addWidget(folded(translate("Options of the search"), self.options.widget))
        self._documents = DocumentWatch(self.document, (Kind.SEAMS,), self.refresh)
        self._clicks = SelectionWatch(self.document, self.picked)
        self.ask_plain("options", {"method": "seams"}, self._options_known)
        self.refresh()
        if not self.model.seams or self.model.is_stale:
            self.find()

    def closed(self) -> None:
        """Hear no more of FreeCAD, and take the marks away."""
        self._documents.stop()
        self._clicks.stop()
        self._mark([])

    # -- searching --------------------------------------------------------------------------------------------------

    def find(self) -> None:
        """Open the part, show its features, and find its seams."""
        self.model.forget_pending()
        self.open_part(self._opened)

    def _opened(self, opened: dict[str, Any]) -> None:
        self.model.take_features(opened)
        if self.model.decisions:
            self.ask("seams", {"options": self.model.options}, self._decide_again)
        else:
            self._ask_seams(translate("Find seams"))

    def _decide_again(self, result: dict[str, Any]) -> None:
        """Keep the decisions that still fit their seam, and say which do not."""
        dropped = self.model.drop_unfitting(result["seams"])
        text = translate("The part has changed: what was decided about {names} does not fit any more.")
        self._ask_seams(translate("Find seams"), text.format(names=", ".join(dropped)) if dropped else "")

    def forget_decisions(self) -> None:
        """Leave every seam to wpcal again."""
        self.model.forget_decisions()
        self._ask_seams(translate("Forget the decisions"))

    def _ask_seams(self, text: str, said: str = "") -> None:
        """Ask for the seams with the decisions so far; only the newest answer is kept."""
        self._round = getattr(self, "_round", 0) + 1
        now = self._round

        def take(result: dict[str, Any]) -> None:
            if now == self._round:
                self.model.take_seams(result, text)
                self.say("\n".join([said, *map(str, result.get("notes", []))]).strip())

        self.ask("seams", self.model.request(), take)

    def failed(self, failure: Failure) -> None:
        """Show why, and show the list as the document has it."""
        self.model.forget_pending()
        self.refresh()
        super().failed(failure)

    def _options_known(self, answer: dict[str, Any]) -> None:
        self.options.fill(answer["options"])
        self.options.set_values(self.model.options)
        self.options.changed = self._options_changed

    def _options_changed(self) -> None:
        kept = {name: value for name, value in self.model.options.items() if name == ADDED_EDGES}
        try:
            given = self.options.values()
        except ValueError as error:  # the text is no number
            self.say(str(error), is_error=True)
            return
        self.model.choose_options({**kept, **given})
        self._ask_seams(translate("Change the options of the search"))

    # -- the part ---------------------------------------------------------------------------------------------------

    def _part_box(self) -> Any:
        box = widgets().QGroupBox(translate("Part"))
        layout = widgets().QGridLayout(box)
        self.part_label = widgets().QLabel()
        self.part_label.setWordWrap(True)
        layout.addWidget(self.part_label, 0, 0, 1, 2)
        layout.addWidget(button(translate("Selection"), self.use_selection, translate("The selected objects")), 1, 0)
        layout.addWidget(button(translate("Whole document"), self.use_document), 1, 1)
        return box

    def use_selection(self) -> None:
        """Take the selected objects for the part."""
        chosen = [one.Object for one in FreeCADGui.Selection.getSelectionEx(self.document.Name)]
        try:
            objects = part_objects(self.document, chosen) if chosen else []
        except ValueError as error:
            self.say(str(error), is_error=True)
            return
        if not objects:
            self.say(translate("Select objects in the tree or in the 3-D view first."), is_error=True)
            return
        self.model.use_objects(objects)
        self.find()

    def use_document(self) -> None:
        """Take every visible object for the part."""
        self.model.use_objects([])
        self.find()

    # -- the view ---------------------------------------------------------------------------------------------------

    def _view_box(self) -> Any:
        box = widgets().QWidget()
        layout = widgets().QHBoxLayout(box)
        layout.setContentsMargins(0, 0, 0, 0)
        self.boxes = {}
        for name, text, is_on in (
            ("features", translate("Features"), True),
            ("refused", translate("Refused"), True),
            ("frames", translate("Frames"), False),
        ):
            self.boxes[name] = widgets().QCheckBox(text)
            self.boxes[name].setChecked(is_on)
            self.boxes[name].toggled.connect(lambda _: self.refresh())
            layout.addWidget(self.boxes[name])
        return box

    def _view(self) -> Any:
        return view_of(self.model.object)

    def _show_in_view(self) -> None:
        view = self._view()
        if view is not None:
            view.show(**{name: box.isChecked() for name, box in self.boxes.items()})

    def _mark(self, names: list[str]) -> None:
        view = self._view()
        if view is not None:
            view.choose(names)

    # -- the list ---------------------------------------------------------------------------------------------------

    def _list(self) -> Any:
        self.table = widgets().QTableWidget(0, len(COLUMNS))
        self.table.setObjectName("wpcal_seams")
        self.table.setHorizontalHeaderLabels([translate(name) for name in COLUMNS])
        self.table.setSelectionBehavior(widgets().QAbstractItemView.SelectRows)
        self.table.setEditTriggers(widgets().QAbstractItemView.NoEditTriggers)
        self.table.verticalHeader().hide()
        self.table.horizontalHeader().setStretchLastSection(True)
        self.table.setMinimumHeight(200)
        self.table.itemChanged.connect(self._ticked)
        self.table.itemSelectionChanged.connect(lambda: self._mark([seam["name"] for seam in self.chosen()]))
        return self.table

    def refresh(self) -> None:
        """Show the document's seams, the accepted ones first: after an answer, after Undo, after anybody's change."""
        chosen = {seam["name"] for seam in self.chosen()}
        shown = [seam for seam in self.model.seams if seam["accepted"] or self.boxes["refused"].isChecked()]
        self._shown = sorted(shown, key=lambda seam: (not seam["accepted"], -seam["confidence"]))
        self._is_filling = True
        self.table.setRowCount(len(self._shown))
        for row, seam in enumerate(self._shown):
            self._fill_row(row, seam)
        self._is_filling = False
        self.table.resizeColumnsToContents()
        self._choose_rows(chosen)
        self._show_part()
        self._show_in_view()

    def _fill_row(self, row: int, seam: Seam) -> None:
        turned = " ⇄" if self.model.edit_of(seam).get("reverse") else ""
        tick = widgets().QTableWidgetItem(seam["name"] + turned)
        tick.setFlags(QtCore.Qt.ItemIsUserCheckable | QtCore.Qt.ItemIsEnabled | QtCore.Qt.ItemIsSelectable)
        tick.setCheckState(QtCore.Qt.Checked if seam["accepted"] else QtCore.Qt.Unchecked)
        tick.setData(QtCore.Qt.UserRole, seam["name"])
        self.table.setItem(row, 0, tick)
        why = seam["against"] or seam["reasons"]
        cells = (
            f"{seam['joint']} {seam['weld']}",
            f"{seam['length_mm']:.1f}",
            f"{seam['confidence']:.0%}",
            why[0] if why else "",
        )
        for column, text in enumerate(cells, 1):
            item = widgets().QTableWidgetItem(text)
            item.setToolTip("\n".join([*seam["against"], *seam["reasons"]]))
            self.table.setItem(row, column, item)

    def _show_part(self) -> None:
        objects = list(self.model.object.Objects) if self.model.object is not None else []
        names = ", ".join(obj.Label for obj in objects) if objects else translate("whole document")
        accepted = [seam for seam in self.model.seams if seam["accepted"]]
        length = sum(seam["length_mm"] for seam in accepted)
        text = translate("{names}: {features} features, {seams} of {all} seams, {mm:.0f} mm")
        counts = {"features": len(self.model.features), "seams": len(accepted), "all": len(self.model.seams)}
        self.part_label.setText(text.format(names=names, mm=length, **counts))

    def chosen(self) -> list[Seam]:
        """Return the seams of the selected rows."""
        rows = sorted({index.row() for index in self.table.selectedIndexes()})
        return [self._shown[row] for row in rows if row < len(self._shown)]

    def _choose_rows(self, names: set[str]) -> None:
        self.table.clearSelection()
        for row, seam in enumerate(self._shown):
            if seam["name"] in names:
                last = self.table.columnCount() - 1
                self.table.setRangeSelected(widgets().QTableWidgetSelectionRange(row, 0, row, last), True)

    # -- deciding ---------------------------------------------------------------------------------------------------

    def _buttons(self) -> Any:
        layout = widgets().QGridLayout()
        buttons = (
            ("Weld", self.weld_chosen, "Weld the chosen seams"),
            ("Reject", self.reject_chosen, "Do not weld the chosen seams"),
            ("Reverse", self.reverse_chosen, "Weld the chosen seams in the other direction"),
            ("Add the edge", self.add_selected_edge, "Take the edge selected in the 3-D view for a seam"),
            ("Undo", self.document.undo, "Take the last change back"),
            ("Search again", self.find, "Write the part anew and search"),
            ("Forget the decisions", self.forget_decisions, "Leave every seam to wpcal again; forget added edges, too"),
        )
        for number, (text, method, tip) in enumerate(buttons):
            layout.addWidget(button(translate(text), method, translate(tip)), number // 2, number % 2)
        return layout

    def _ticked(self, item: Any) -> None:
        if self._is_filling or item.column() != 0:
            return
        seam = next(one for one in self.model.seams if one["name"] == item.data(QtCore.Qt.UserRole))
        self.model.weld(seam, item.checkState() == QtCore.Qt.Checked)
        self._ask_seams(translate("Tick a seam"))

    def weld_chosen(self) -> None:
        """Weld the seams of the selected rows."""
        self._decide(translate("Weld seams"), lambda seam: self.model.weld(seam, True))

    def reject_chosen(self) -> None:
        """Reject the seams of the selected rows."""
        self._decide(translate("Reject seams"), lambda seam: self.model.weld(seam, False))

    def reverse_chosen(self) -> None:
        """Reverse the seams of the selected rows."""
        self._decide(translate("Reverse seams"), self.model.reverse)

    def _decide(self, text: str, decide: Any) -> None:
        chosen = self.chosen()
        if not chosen:
            self.say(translate("Choose seams in the list, or click them in the 3-D view."), is_error=True)
            return
        for seam in chosen:
            decide(seam)
        self._ask_seams(text)

    def add_selected_edge(self) -> None:
        """Weld the edges that are selected in the 3-D view."""
        picks = picks_of(FreeCADGui.Selection.getSelectionEx(self.document.Name, 0))
        edges = [pick for pick in picks if pick.shape is not None and pick.shape.ShapeType == "Edge"]
        if not edges or self.model.object is None:
            self.say(translate("Click an edge of the part first."), is_error=True)
            return
        said = []
        for pick in edges:
            points = edge_points(pick.shape, pick.point, self.model.object.PartFrame)
            seam = self.model.seam_on_edge(points)
            if seam is not None:
                self.model.weld(seam, True)
                said.append(translate("{name} lies on this edge: it is welded.").format(name=seam["name"]))
            else:
                self.model.add_edge(points[0])
                said.append(translate("No candidate lies on this edge: it is added to the seams."))
        self._ask_seams(translate("Add an edge"), "\n".join(said))

    # -- clicks -----------------------------------------------------------------------------------------------------

    def picked(self) -> None:
        """Choose the rows of the seams that were clicked in the 3-D view."""
        names: set[str] = set()
        for pick in picks_of(FreeCADGui.Selection.getSelectionEx(self.document.Name, 0)):
            names |= self._seams_of(pick)
        if names:
            self._choose_rows(names)

    def _seams_of(self, pick: Pick) -> set[str]:
        if self.model.object is None:
            return set()
        if pick.shape is None:
            return {pick.name} if pick.object == self.model.object else set()
        frame = self.model.object.PartFrame
        seam = None
        if pick.shape.ShapeType == "Edge":
            seam = self.model.seam_on_edge(edge_points(pick.shape, pick.point, frame))
        elif pick.point is not None:
            seam = self.model.seam_near(in_part(pick.point, frame))
        return {seam["name"]} if seam else set()
