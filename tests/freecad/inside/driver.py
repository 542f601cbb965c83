"""Play a file of steps inside FreeCAD; started by `tests/freecad/window.py`.

A file of steps has a generator function `steps(window)`. Between two of its `yield`s FreeCAD's event loop runs:

* `yield 0.2` waits so many seconds,
* `yield condition` waits until the function `condition` returns something true.

The first exception anywhere ends the run; so does a condition that stays false for `WAIT_S`.
"""

import json
import os
import runpy
import subprocess
import sys
import time
import traceback
from pathlib import Path

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

WAIT_S = 60
POLL_MS = 20
SETTLE_S = 0.15  #: The 3-D view needs a moment after the pointer came before it knows what is under it.

SHOWN_DOCKS = ("Combo View", "Model", "Tasks")
"""FreeCAD 0.20 has tree and task panel in one dock, FreeCAD 1 in two; a first start shows a Python console, too."""
DOCK_PX = 400  #: A width at which a task panel shows its tables, and the 3-D view has enough room.


class Window:
    """FreeCAD's window as the steps use it."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.main = FreeCADGui.getMainWindow()
        self.facts = {}
        self.last_said = ""
        for dock in self.main.findChildren(QtGui.QDockWidget):
            dock.setVisible(dock.objectName() in SHOWN_DOCKS)
            if dock.isVisible():
                self.main.resizeDocks([dock], [DOCK_PX], QtCore.Qt.Horizontal)

    def say(self, text):
        """Name the step that runs now, for the message if it fails."""
        self.last_said = text
        print(f"step: {text}", flush=True)

    def view(self):
        return FreeCADGui.ActiveDocument.ActiveView

    def canvas(self):
        """Return the widget in which the active 3-D view draws."""
        found = [
            each
            for each in self.main.findChildren(QtGui.QWidget)
            if each.metaObject().className() == "SIM::Coin3D::Quarter::QuarterWidget" and each.isVisible()
        ]
        assert len(found) == 1, f"{len(found)} 3-D views are visible, expected one"
        return found[0]

    def pixel(self, place):
        """Return the pixel of the screen at which a place of the document (mm) is drawn."""
        x, y = self.view().getPointOnScreen(FreeCAD.Vector(*place))
        canvas = self.canvas()
        corner = canvas.mapToGlobal(QtCore.QPoint(0, 0))
        return corner.x() + x, corner.y() + canvas.height() - 1 - y

    def click(self, place):
        """Click with the mouse where a place of the document (mm) is drawn; use with `yield from`."""
        yield from self.click_pixel(*self.pixel(place))

    def click_widget(self, widget):
        """Click with the mouse in the middle of a widget; use with `yield from`."""
        yield SETTLE_S  # a panel that was just filled is laid out first
        assert widget.isVisible(), f"{widget.objectName() or widget} is not visible"
        middle = widget.mapToGlobal(widget.rect().center())
        yield from self.click_pixel(middle.x(), middle.y())

    def click_pixel(self, x, y):
        yield from self.tool("xdotool", "mousemove", str(x - 1), str(y))
        yield from self.tool("xdotool", "mousemove", str(x), str(y))
        yield SETTLE_S
        yield from self.tool("xdotool", "click", "1")
        yield SETTLE_S

    def tool(self, *arguments):
        """Run a program while FreeCAD's event loop runs; use with `yield from`."""
        process = subprocess.Popen(arguments)
        yield lambda: process.poll() is not None
        assert process.returncode == 0, f"{' '.join(arguments)} ended with code {process.returncode}"

    def shot(self, name):
        """Photograph the screen into `<name>.png`; use with `yield from`."""
        target = self.folder / f"{name}.png"
        yield SETTLE_S
        yield from self.tool("import", "-window", "root", "+dither", "-colors", "160", "-depth", "8", f"PNG8:{target}")

    def find(self, kind, name):
        """Return the visible widget of a class with an object name."""
        found = [each for each in self.main.findChildren(kind, name) if each.isVisible()]
        assert len(found) == 1, f"{len(found)} visible widgets are named {name}, expected one"
        return found[0]


class Player:
    """Runs the generator of the steps, one `yield` after another, from a timer."""

    def __init__(self, window, steps, result):
        self.window, self.steps, self.result = window, steps, Path(result)
        self.until, self.waits_since, self.ended = None, 0.0, False
        self.timer = QtCore.QTimer()
        self.timer.setSingleShot(True)
        self.timer.timeout.connect(self.turn)
        sys.excepthook = self.failed  # it also keeps the player, when the names of this script are gone

    def turn(self):
        if self.ended:
            return
        try:
            self.advance()
        except StopIteration:
            self.end(None)
        except BaseException:
            self.failed(*sys.exc_info())
        if not self.ended:
            self.timer.start(POLL_MS)

    def advance(self):
        if self.until is not None and not self.until():
            if time.monotonic() - self.waits_since > WAIT_S:
                raise TimeoutError(f"waited {WAIT_S} s in vain")
            return
        wanted = next(self.steps)
        self.waits_since = time.monotonic()
        if callable(wanted):
            self.until = wanted
        else:
            ready = self.waits_since + wanted
            self.until = lambda: time.monotonic() >= ready

    def failed(self, kind, error, trace):
        text = "".join(traceback.format_exception(kind, error, trace))
        self.end(f"in the step '{self.window.last_said}': {text}")

    def end(self, fault):
        if self.ended:
            return
        self.ended = True
        if fault is not None:
            subprocess.run(["import", "-window", "root", str(self.window.folder / "fault.png")], check=False)
        self.result.write_text(json.dumps({"fault": fault, "facts": self.window.facts}), encoding="utf-8")
        for name in list(FreeCAD.listDocuments()):
            FreeCAD.closeDocument(name)
        QtGui.QApplication.instance().exit(0 if fault is None else 1)


def play():
    window = Window(os.environ["WPCAL_STEPS_FOLDER"])
    Player(window, read_steps(window), os.environ["WPCAL_STEPS_RESULT"]).turn()


def read_steps(window):
    yield from runpy.run_path(os.environ["WPCAL_STEPS"])["steps"](window)


QtCore.QTimer.singleShot(0, play)
