# SPDX-License-Identifier: MIT
"""Runs when FreeCAD starts, with a window or without: documents get their objects of this workbench back."""

from .document.restore import watch_documents

watch_documents()
