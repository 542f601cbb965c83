# SPDX-License-Identifier: MIT
"""A line with a result folder, and pages of a result folder in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..document.kinds import Kind, ensure_object, object_of
from ..qt import QtCore, gui, widgets
from ..words import translate
from .base import TaskPanel


class FolderLine:
    """The result folder of a document: a line of text and a button that asks for it."""

    def __init__(self, document: Any, *, default: str = "result") -> None:
        self._document = document
        self.widget = widgets().QWidget()
        line = widgets().QHBoxLayout(self.widget)
        line.setContentsMargins(0, 0, 0, 0)
        self.edit = widgets().QLineEdit(result_folder(document, default))
        self.edit.setObjectName(f"wpcal_folder_{default}")
        button = widgets().QPushButton("…")
        button.clicked.connect(self._choose)
        line.addWidget(self.edit, 1)
        line.addWidget(button)

    def path(self) -> str:
        """Return the folder. Raises `ValueError` if none is named."""
        text = self.edit.text().strip()
        if not text:
            raise ValueError(translate("Name the folder for the result."))
        return str(Path(text).expanduser().absolute())

    def keep(self) -> None:
        """Keep the folder in the calibration of the document. Call it inside a `transaction`."""
        ensure_object(self._document, Kind.CALIBRATION).ResultFolder = self.path()

    def _choose(self) -> None:
        title = translate("Folder for the result")
        found = widgets().QFileDialog.getExistingDirectory(self.widget, title, self.edit.text())
        if found:
            self.edit.setText(found)


def result_folder(document: Any, name: str = "result") -> str:
    """Return the result folder that the document names, else one beside its file."""
    calibration = object_of(document, Kind.CALIBRATION)
    if calibration is not None and calibration.ResultFolder:
        kept = Path(calibration.ResultFolder)
        return str(kept if name == "result" else kept.with_name(f"{kept.name}-{name}"))
    file = Path(document.FileName) if document.FileName else None
    return str(file.with_name(f"{file.stem}-{name}")) if file is not None else ""


def open_page(panel: TaskPanel, folder: str) -> None:
    """Open the page of a result folder in the browser; wpcal writes it first."""

    def show(answer: Any) -> None:
        show_file(answer["path"])

    panel.ask_plain("page", {"folder": folder}, show)


def show_file(path: str) -> None:
    """Open a file in the program that the desktop has for it."""
    gui().QDesktopServices.openUrl(QtCore.QUrl.fromLocalFile(path))
