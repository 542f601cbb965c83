# SPDX-License-Identifier: MIT
"""Qt as FreeCAD 0.20 to 1.1 offer it: `PySide` stands for PySide2 or PySide6, and 0.20 has the widgets in QtGui."""

from __future__ import annotations

from typing import Any, Callable

from PySide import QtCore

__all__ = ["QtCore", "application", "gui", "number_of", "wait_until", "widgets"]


def gui() -> Any:
    """Return the module with fonts, colours and icons. `freecadcmd` on a server may not have it."""
    from PySide import QtGui

    return QtGui


def widgets() -> Any:
    """Return the module with the widgets."""
    try:
        from PySide import QtWidgets
    except ImportError:  # FreeCAD 0.20
        from PySide import QtGui as QtWidgets
    return QtWidgets


def application() -> Any:
    """Return Qt's application; without a window (`freecadcmd`) there is none yet, and one without window is made."""
    return QtCore.QCoreApplication.instance() or QtCore.QCoreApplication([])


def number_of(flag: Any) -> int:
    """Return a flag as a number: an enumeration of Qt 6 is none by itself."""
    try:
        return int(flag)
    except TypeError:
        return int(flag.value)


def wait_until(is_done: Callable[[], bool], seconds: float) -> bool:
    """Let Qt work until something is done, at most this long; return whether it is done. For scripts and tests."""
    application()
    loop = QtCore.QEventLoop()
    clock = QtCore.QTimer()
    clock.setSingleShot(True)
    clock.start(int(seconds * 1000))
    while not is_done() and clock.isActive():
        loop.processEvents(QtCore.QEventLoop.WaitForMoreEvents)
    return is_done()
