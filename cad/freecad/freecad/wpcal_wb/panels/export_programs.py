# SPDX-License-Identifier: MIT
"""The panel *Export*: robot programs and other formats from a result folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..qt import QtCore, widgets
from ..words import translate
from .base import TaskPanel
from .folders import FolderLine, show_file
from .option_form import OptionForm

FIRST_OPTIONS = {
    "only": "Seams (W1,W5-W8)",
    "speed_mm_s": "Welding speed (mm/s)",
    "program_name": "Program",
    "tool_name": "Tool (name)",
    "tool_number": "Tool (number)",
}
OPEN_FORMATS = ("compas", "csv", "dxf", "glb", "json", "ros", "tesseract")
"""The programs of controllers come before these in the list."""
OWN_OPTIONS = ("folder", "format", "formats", "out", "force", "json", "write_templates", "write_setup")


class ExportPanel(TaskPanel):
    """Writes the calibrated seams, or the searches of a touch plan, in the formats of `wpcal export`."""

    title = "Export"

    def build(self) -> None:
        """Make the widgets and ask which formats there are."""
        self.folder = FolderLine(self.document)
        self.formats = widgets().QListWidget()
        self.formats.setObjectName("wpcal_formats")
        self.formats.setMinimumHeight(150)
        self.options = OptionForm(first=FIRST_OPTIONS, left_out=OWN_OPTIONS)
        self.replace = widgets().QCheckBox(translate("Replace what an earlier export wrote"))
        self.replace.setObjectName("wpcal_replace")
        self.export_button = widgets().QPushButton(translate("Export"))
        self.export_button.setObjectName("wpcal_export")
        self.export_button.clicked.connect(self.export)
        self.files = widgets().QListWidget()
        self.files.setObjectName("wpcal_files")
        self.files.setToolTip(translate("Double-click opens the file."))
        self.files.itemDoubleClicked.connect(lambda item: show_file(item.data(QtCore.Qt.UserRole)))
        self.files.hide()
        self.body.addWidget(widgets().QLabel(translate("Result folder, or folder of a touch plan")))
        for widget in (self.folder.widget, self.formats, self.options.widget, self.replace, self.export_button):
            self.body.addWidget(widget)
        self.body.addWidget(self.files)
        self.ask_plain("formats", {}, self._formats_known)
        self.ask_plain("options", {"method": "export"}, lambda answer: self.options.fill(answer["options"]))

    def chosen(self) -> list[str]:
        """Return the names of the ticked formats."""
        items = [self.formats.item(row) for row in range(self.formats.count())]
        return [item.data(QtCore.Qt.UserRole) for item in items if item.checkState() == QtCore.Qt.Checked]

    def export(self) -> None:
        """Write the programs."""
        try:
            options = {**self.options.values(), **({"force": True} if self.replace.isChecked() else {})}
            params = {"folder": self.folder.path(), "formats": self.chosen(), "options": options}
        except ValueError as error:
            self.say(str(error), is_error=True)
            return
        if not params["formats"]:
            self.say(translate("Tick a format first."), is_error=True)
            return
        self.files.hide()
        self.ask_plain("export", params, self._exported)

    def _formats_known(self, answer: dict[str, Any]) -> None:
        self.formats.clear()
        for each in sorted(answer["formats"], key=lambda each: (each["name"] in OPEN_FORMATS, each["title"])):
            name, _, what = each["title"].partition(":")
            item = widgets().QListWidgetItem(f"{name} – {what.strip()}" if what else name)
            item.setToolTip(", ".join([each["name"], *each["brands"]]))
            item.setData(QtCore.Qt.UserRole, each["name"])
            item.setFlags(QtCore.Qt.ItemIsUserCheckable | QtCore.Qt.ItemIsEnabled | QtCore.Qt.ItemIsSelectable)
            item.setCheckState(QtCore.Qt.Unchecked)
            self.formats.addItem(item)

    def _exported(self, answer: dict[str, Any]) -> None:
        self.files.clear()
        for paths in answer["files"].values():
            for path in paths:
                item = widgets().QListWidgetItem(f"{Path(path).parent.name}/{Path(path).name}")
                item.setData(QtCore.Qt.UserRole, path)
                item.setToolTip(path)
                self.files.addItem(item)
        self.files.show()
        self.say(_summary(answer), is_error=answer.get("verdict") not in (None, "PASS"))


def _summary(answer: dict[str, Any]) -> str:
    """Return what was written and what was not checked."""
    count = sum(len(paths) for paths in answer["files"].values())
    lines = [translate("{count} files written.").format(count=count)]
    verdict = answer.get("verdict")
    if verdict not in (None, "PASS"):
        text = translate("The verdict of the calibration is {verdict}; the files say so.")
        lines.insert(0, text.format(verdict=verdict))
    lines += [str(each) for each in answer.get("checked") or ()]
    lines += [str(answer["not_checked"])] if answer.get("not_checked") else []
    return "\n".join(lines)
