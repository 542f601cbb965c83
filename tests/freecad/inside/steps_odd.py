"""Odd orders in FreeCAD's window: no solid, no wpcal, Undo, containers, and a document that is closed under a panel."""

import FreeCAD
import FreeCADGui
from freecad.wpcal_wb.client import executable
from freecad.wpcal_wb.commands import COMMANDS
from freecad.wpcal_wb.document.session import stop_sessions


def panel_of(name, document):
    return next(one for one in COMMANDS if one.name == name).open(document)


def tee():
    document = FreeCAD.newDocument("tee")
    for name, size, place in (("Base", (200, 120, 10), (0, 0, 0)), ("Web", (150, 8, 80), (25, 56, 10))):
        box = document.addObject("Part::Box", name)
        box.Length, box.Width, box.Height = size
        box.Placement.Base = FreeCAD.Vector(*place)
    document.recompute()
    return document


def fit(window):
    window.view().viewIsometric()
    FreeCADGui.SendMsgToActiveView("ViewFit")


def no_panel():
    return not FreeCADGui.Control.activeDialog()


def steps(window):
    yield from without_solid(window)
    document = tee()
    fit(window)
    yield from without_wpcal(window, document)
    yield from decisions(window, document)
    yield from turned_container(window, document)
    window.say("the document is closed while a panel is open")
    FreeCAD.closeDocument("tee")
    yield no_panel
    panel = panel_of("WpCal_FeaturesAndSeams", tee())
    yield lambda: panel.table.rowCount() == 4
    window.say("an option that is no number")
    field = panel.options.field("min_length_mm")
    field.setText("abc")
    field.editingFinished.emit()
    yield panel.message.isVisible
    window.facts["no number"] = panel.message.text()
    panel.reject()


def without_solid(window):
    window.say("a document without a solid")
    empty = FreeCAD.newDocument("empty")
    panel = panel_of("WpCal_FeaturesAndSeams", empty)
    yield panel.message.isVisible
    window.facts["empty"] = panel.message.text()
    FreeCAD.closeDocument("empty")
    yield 0.3
    window.facts["closed with its document"] = no_panel()


def without_wpcal(window, document):
    window.say("an executable that is not there")
    stop_sessions()
    executable.set_preferred("/nowhere/wpcal")
    panel = panel_of("WpCal_FeaturesAndSeams", document)
    yield panel.message.isVisible
    window.facts["missing"] = panel.message.text()
    executable.set_preferred("")
    panel.find()
    yield lambda: panel.table.rowCount() == 4
    yield 0.3
    panel.reject()


def decisions(window, document):
    panel = panel_of("WpCal_FeaturesAndSeams", document)
    yield 0.3
    window.say("a click beside a seam, and Undo while the panel is open")
    FreeCADGui.Selection.clearSelection()
    yield from window.click((45, 56, 10))
    yield panel.chosen
    window.facts["clicked"] = [seam["name"] for seam in panel.chosen()]
    start = panel.chosen()[0]["frames"]["p"][0]
    panel.reverse_chosen()
    yield lambda: panel.chosen()[0]["frames"]["p"][0] != start
    FreeCADGui.runCommand("Std_Undo")
    yield lambda: panel.chosen()[0]["frames"]["p"][0] == start

    window.say("the object of the seams is deleted, and comes back")
    document.removeObject(panel.model.object.Name)
    yield lambda: panel.table.rowCount() == 0
    document.undo()
    yield lambda: panel.table.rowCount() == 4

    window.say("the part is changed under a decision")
    panel._choose_rows({"W2"})
    panel.reverse_chosen()
    yield lambda: panel.model.object.Edits not in ("", "[]")
    document.getObject("Web").Length = 140
    document.recompute()
    panel.find()
    yield lambda: "W2" in panel.message.text()
    window.facts["changed"] = panel.message.text()
    yield lambda: panel.model.object.Edits == "[]"
    panel.reject()


def turned_container(window, document):
    window.say("parts of a container that was turned")
    part = document.addObject("App::Part", "Part")
    for name in ("Base", "Web"):
        part.addObject(document.getObject(name))
    part.Placement = FreeCAD.Placement(FreeCAD.Vector(500, 0, 0), FreeCAD.Rotation(FreeCAD.Vector(0, 0, 1), 90))
    document.recompute()
    panel = panel_of("WpCal_FeaturesAndSeams", document)
    FreeCADGui.Selection.clearSelection()
    for name in ("Base", "Web"):
        FreeCADGui.Selection.addSelection("tee", "Part", f"{name}.")
    panel.use_selection()
    yield lambda: not panel.model.is_stale and panel.table.rowCount() == 4
    window.facts["start in the part"] = panel.model.seams[1]["candidate"]["start_part_mm"]
    fit(window)
    panel.reject()
    panel = panel_of("WpCal_TaughtPoints", document)
    yield 0.5
    FreeCADGui.Selection.clearSelection()
    yield from window.click((500, 200, 10))  # the corner 200, 0, 10 of the part
    yield lambda: panel.model.rows
    place = panel.model.place_of(panel.model.records()[0])
    window.facts["corner"] = place
