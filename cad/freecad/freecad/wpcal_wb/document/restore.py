# SPDX-License-Identifier: MIT
"""Brings the objects of this workbench back to life in documents that are opened."""

from __future__ import annotations

from typing import Any

import FreeCAD

from .kinds import attach_proxies


class _Restorer:
    """A document observer of FreeCAD."""

    def slotActivateDocument(self, document: Any) -> None:
        """Give the objects back what a FreeCAD without the workbench dropped when it saved the document.

        FreeCAD activates a document as the last step of opening it. Version 0.20 tells of no earlier moment at which
        all properties are read.
        """
        attach_proxies(document)


_WATCHING: list[_Restorer] = []


def watch_documents() -> None:
    """Watch from now on; a second call changes nothing."""
    if not _WATCHING:
        _WATCHING.append(_Restorer())
        FreeCAD.addDocumentObserver(_WATCHING[0])
