# SPDX-License-Identifier: MIT
"""The commands of the workbench. Each opens a task panel; the panel's module is imported when it is used.

To add a command: a line in `COMMANDS`, an icon `resources/icons/<name>.svg`, and the panel's class.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any, NamedTuple

import FreeCAD
import FreeCADGui

from . import icon
from .words import translate


class PanelCommand(NamedTuple):
    """A command that opens a task panel."""

    name: str  #: As FreeCAD knows it; also the name of its icon.
    text: str  #: In the menu, and when the pointer rests on the button.
    tip: str
    module: str  #: Module in `panels`, and the class in it.
    panel: str

    def GetResources(self) -> dict[str, str]:
        """Return icon and texts."""
        return {"Pixmap": icon(self.name), "MenuText": translate(self.text), "ToolTip": translate(self.tip)}

    def IsActive(self) -> bool:
        """Tell whether there is a document."""
        return FreeCAD.ActiveDocument is not None

    def Activated(self, _index: int = 0) -> None:
        """Open the panel."""
        self.open(FreeCAD.ActiveDocument)

    def open(self, document: Any) -> Any:
        """Open the panel for a document and return it."""
        from .panels.base import show_panel

        module = import_module(f"{__package__}.panels.{self.module}")
        return show_panel(getattr(module, self.panel)(document))


COMMANDS: tuple[PanelCommand, ...] = (
    PanelCommand(
        "WpCal_FeaturesAndSeams",
        "Features and seams",
        "Find what can be touched and what can be welded, and decide about the seams",
        "features_and_seams",
        "FeaturesAndSeamsPanel",
    ),
    PanelCommand(
        "WpCal_TaughtPoints",
        "Taught points and touches",
        "Click what was touched, type or paste what the robot shows, and see the fit",
        "taught_points",
        "TaughtPointsPanel",
    ),
    PanelCommand(
        "WpCal_Calibrate",
        "Calibrate",
        "Fit the taught points, show the errors, place the part, and write the result folder",
        "calibrate",
        "CalibratePanel",
    ),
    PanelCommand("WpCal_Export", "Export", "Write robot programs and other formats", "export_programs", "ExportPanel"),
    PanelCommand(
        "WpCal_TouchPlan", "Touch plan", "Plan the touches of the wire that locate the part", "plans", "TouchPlanPanel"
    ),
    PanelCommand(
        "WpCal_WeldPlan", "Weld plan", "Plan how the robot welds all seams in its cell", "plans", "WeldPlanPanel"
    ),
)


def register() -> tuple[str, ...]:
    """Add the commands to FreeCAD and return their names, in the order of the toolbar."""
    for command in COMMANDS:
        FreeCADGui.addCommand(command.name, command)
    return tuple(command.name for command in COMMANDS)
