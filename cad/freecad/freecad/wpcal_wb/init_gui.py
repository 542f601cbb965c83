# SPDX-License-Identifier: MIT
"""Registers the workbench. FreeCAD imports this module when it starts with a window."""

from __future__ import annotations

from typing import Any

import FreeCAD
import FreeCADGui

from . import RESOURCES, icon
from .document.restore import watch_documents
from .document.session import start_client
from .preferences import PreferencePage
from .words import translate


class WpCalWorkbench(FreeCADGui.Workbench):
    """The workbench: its commands are made when it is chosen for the first time."""

    MenuText = "wpcal"
    ToolTip = translate("Weld seams, taught points and calibration of a real part")
    Icon = icon("WpCal")

    def GetClassName(self) -> str:
        """Say that the workbench is written in Python."""
        return "Gui::PythonWorkbench"

    def Initialize(self) -> None:
        """Make toolbar and menu."""
        from .commands import register

        names = list(register())
        self.appendToolbar("wpcal", names)
        self.appendMenu("wpcal", names)

    def Activated(self) -> None:
        """Start wpcal when the workbench is chosen."""
        start_client()

    def ContextMenu(self, _recipient: Any) -> None:
        """Add nothing to the context menus."""


FreeCADGui.addLanguagePath(str(RESOURCES / "translations"))
FreeCADGui.updateLocale()
FreeCADGui.addIconPath(str(RESOURCES / "icons"))
FreeCADGui.addPreferencePage(PreferencePage, "wpcal")
FreeCADGui.addWorkbench(WpCalWorkbench())
watch_documents()
FreeCAD.Console.PrintLog("wpcal: the workbench is ready\n")
