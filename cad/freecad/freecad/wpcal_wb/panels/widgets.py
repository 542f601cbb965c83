# SPDX-License-Identifier: MIT
"""Small things that the panels share: buttons, a fold, and what draws an object."""

from __future__ import annotations

from typing import Any, Callable

from ..qt import widgets


def view_of(obj: Any) -> Any:
    """Return what draws an object; None without an object, and while FreeCAD closes its document."""
    try:
        return None if obj is None else obj.ViewObject.Proxy
    except NameError:  # the document is closed: its window went first
        return None


def button(text: str, method: Callable[[], Any], tip: str = "") -> Any:
    """Return a button that calls a method without arguments."""
    made = widgets().QPushButton(text)
    made.setToolTip(tip)
    made.clicked.connect(lambda *_: method())
    return made


def folded(title: str, inner: Any) -> Any:
    """Return a widget below a box that shows and hides it; hidden at first."""
    outer = widgets().QWidget()
    layout = widgets().QVBoxLayout(outer)
    layout.setContentsMargins(0, 0, 0, 0)
    box = widgets().QCheckBox(title)
    box.toggled.connect(inner.setVisible)
    inner.hide()
    layout.addWidget(box)
    layout.addWidget(inner)
    return outer
