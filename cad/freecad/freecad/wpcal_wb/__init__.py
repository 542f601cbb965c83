# SPDX-License-Identifier: MIT
"""The wpcal workbench for FreeCAD: features, seams, taught points and calibration of a weldment.

Runs in FreeCAD's own Python (3.8 or later) and imports only FreeCAD, Qt, Coin and the standard library. The work is
done by a child process, `wpcal rpc`. A second CAD kernel in FreeCAD's process would not work.
"""

from pathlib import Path

RESOURCES = Path(__file__).resolve().parent / "resources"
PREFERENCES = "User parameter:BaseApp/Preferences/Mod/WpCal"
"""The group of FreeCAD's parameters in which the preferences of the workbench are kept."""


def icon(name: str) -> str:
    """Return the path of an icon of this workbench, by its name without suffix."""
    return str(RESOURCES / "icons" / f"{name}.svg")
