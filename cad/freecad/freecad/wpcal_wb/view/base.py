# SPDX-License-Identifier: MIT
"""What all view providers of the workbench have in common."""

from __future__ import annotations

from typing import Any

from .. import icon


class RecordView:
    """The view provider of an object: its icon in the tree and its drawing."""

    icon_name = "WpCal"
    mode = ""  #: The only way of drawing.

    def __init__(self, view: Any) -> None:
        view.Proxy = self

    def getIcon(self) -> str:
        """Return the icon in the tree."""
        return icon(self.icon_name)

    def getDisplayModes(self, _view: Any) -> list[str]:
        """Return the only way of drawing."""
        return [self.mode]

    def getDefaultDisplayMode(self) -> str:
        """Return the only way of drawing."""
        return self.mode

    def setDisplayMode(self, mode: str) -> str:
        """Take a mode as it is."""
        return mode

    def dumps(self) -> None:
        """Save nothing (FreeCAD 1.0 and later)."""

    def loads(self, state: object) -> None:
        """Restore nothing (FreeCAD 1.0 and later)."""

    def __getstate__(self) -> None:
        """Save nothing (FreeCAD 0.20)."""

    def __setstate__(self, state: object) -> None:
        """Restore nothing (FreeCAD 0.20)."""
