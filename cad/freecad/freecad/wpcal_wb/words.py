# SPDX-License-Identifier: MIT
"""Texts of the workbench in the language of FreeCAD."""

from __future__ import annotations

import FreeCAD

CONTEXT = "WpCal"  #: The context of these texts in the translation files.


def translate(text: str) -> str:
    """Return a text in the language of FreeCAD; the text itself if it is not translated."""
    return str(FreeCAD.Qt.translate(CONTEXT, text))
