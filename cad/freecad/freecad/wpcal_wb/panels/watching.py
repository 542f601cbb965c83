# SPDX-License-Identifier: MIT
"""What a panel hears of FreeCAD while it is open: changes of its document, Undo, and clicks in the 3-D view."""

from __future__ import annotations

from typing import Any, Callable

import FreeCAD
import FreeCADGui

from ..document.kinds import Kind, kind_of
from ..qt import QtCore


class DocumentWatch:
    """Calls `changed` once after changes of objects of some kinds, whoever made them. A document observer."""

    def __init__(self, document: Any, kinds: tuple[Kind, ...], changed: Callable[[], None]) -> None:
        self._name = document.Name
        self._kinds = kinds
        self._soon = QtCore.QTimer()
        self._soon.setSingleShot(True)
        self._soon.timeout.connect(changed)
        FreeCAD.addDocumentObserver(self)

    def stop(self) -> None:
        """Hear no more."""
        self._soon.stop()
        FreeCAD.removeDocumentObserver(self)

    def slotChangedObject(self, obj: Any, _name: str) -> None:
        """Hear of a changed property."""
        self._hear(obj)

    def slotDeletedObject(self, obj: Any) -> None:
        """Hear of a deleted object."""
        self._hear(obj)

    def slotUndoDocument(self, document: Any) -> None:
        """Hear of Undo, which can bring an object back."""
        if document.Name == self._name:
            self._soon.start(0)

    def slotRedoDocument(self, document: Any) -> None:
        """Hear of Redo."""
        self.slotUndoDocument(document)

    def _hear(self, obj: Any) -> None:
        if obj.Document.Name == self._name and kind_of(obj) in self._kinds:
            self._soon.start(0)


class SelectionWatch:
    """Calls `picked` once after clicks in the 3-D view or the tree. A selection observer."""

    def __init__(self, document: Any, picked: Callable[[], None]) -> None:
        self._name = document.Name
        self._soon = QtCore.QTimer()
        self._soon.setSingleShot(True)
        self._soon.timeout.connect(picked)
        FreeCADGui.Selection.addObserver(self)

    def stop(self) -> None:
        """Hear no more."""
        self._soon.stop()
        FreeCADGui.Selection.removeObserver(self)

    def addSelection(self, document: str, _obj: str, _element: str, _point: Any) -> None:
        """Hear of a click."""
        if document == self._name:
            self._soon.start(0)
