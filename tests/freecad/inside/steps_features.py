"""How long a person waits for the features of a part with 300 faces, and for its seams: first with a cold wpcal."""

import time

import FreeCAD
import FreeCADGui
from PySide import QtCore

WEBS = 49
THINKING_S = 3.0  #: Between choosing the workbench and clicking its first button.


def make_part(document):
    """Make a plate with 49 webs on it: 50 boxes, 300 faces."""
    plate = document.addObject("Part::Box", "Plate")
    plate.Length, plate.Width, plate.Height = 1000, 400, 10
    for number in range(WEBS):
        web = document.addObject("Part::Box", f"Web{number}")
        web.Length, web.Width, web.Height = 8, 300, 60
        web.Placement.Base = FreeCAD.Vector(10 + 20 * number, 50, 10)
    document.recompute()


def open_and_wait(window, document, name):
    """Open the panel, and note when features and seams are shown; use with `yield from`."""
    from freecad.wpcal_wb.commands import COMMANDS

    command = next(one for one in COMMANDS if one.name == "WpCal_FeaturesAndSeams")
    start = time.monotonic()
    panel = command.open(document)
    times = {"panel": time.monotonic() - start}
    longest = [0.0]
    last = [time.monotonic()]

    def beat():
        longest[0] = max(longest[0], time.monotonic() - last[0])
        last[0] = time.monotonic()

    pulse = QtCore.QTimer()
    pulse.timeout.connect(beat)
    pulse.start(10)
    yield lambda: panel.model.features
    times["features"] = time.monotonic() - start
    yield lambda: panel.model.seams and not panel.is_busy
    times["seams"] = time.monotonic() - start
    pulse.stop()
    times["longest_standstill"] = longest[0]
    window.facts[name] = {
        **{what: round(seconds, 2) for what, seconds in times.items()},
        "features_found": len(panel.model.features),
        "seams_found": len(panel.model.seams),
        "message": panel.message.text(),
    }
    return panel


def steps(window):
    from freecad.wpcal_wb.document.session import stop_sessions

    window.say("make the part")
    document = FreeCAD.newDocument("webs")
    make_part(document)
    window.view().viewIsometric()
    window.view().fitAll()
    yield 0.5
    window.say("features and seams, wpcal not started yet")
    panel = yield from open_and_wait(window, document, "cold")
    panel.reject()
    window.say("features and seams, the workbench was chosen before")
    FreeCADGui.activateWorkbench("PartWorkbench")
    stop_sessions()
    document.removeObject("WpCalSeams")
    FreeCADGui.activateWorkbench("WpCalWorkbench")
    yield THINKING_S
    panel = yield from open_and_wait(window, document, "workbench chosen")
    yield from window.shot("webs")
    window.say("again after a change")
    panel.reject()
    document.removeObject("WpCalSeams")
    document.getObject("Web3").Height = 70
    document.recompute()
    yield 0.2
    yield from open_and_wait(window, document, "after a change")
