"""The whole job on the tee, as a person does it: open, find seams, touch, calibrate, write the robot program.

The button of the first panel and the first corner are clicked with the mouse, and the first coordinates are typed with
keys; the rest goes through FreeCAD's selection and the panels. The pictures are those of docs/how-to/freecad.md.
"""

import csv
import os
from pathlib import Path

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

FIXTURE = Path(os.environ["WPCAL_TEE"])
OFF = 5  #: The column of the residuals in the panel of taught points.
TOLERANCE_MM = "0.4"  #: Another one than wpcal's own; the document keeps it.
MOST_UNDONE = 4  #: Calibrate, two tolerances, and the coordinate systems.


def read_rows():
    """Return the taught points of the fixture."""
    with (FIXTURE / "taught.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def open_panel(name, document):
    from freecad.wpcal_wb.commands import COMMANDS

    return next(one for one in COMMANDS if one.name == name).open(document)


def toolbar_button(window, text):
    """Return the button of a command in the toolbar of the workbench."""
    bar = next(each for each in window.main.findChildren(QtGui.QToolBar) if each.windowTitle() == "wpcal")
    action = next(each for each in bar.actions() if each.text().replace("&", "") == text)
    return bar.widgetForAction(action)


def state_of_model(document):
    """Return what must not change: the user's objects with their places and visibility."""
    return [
        (obj.Name, obj.Label, tuple(obj.Placement.toMatrix().A), obj.ViewObject.Visibility)
        for obj in document.Objects
        if obj.TypeId.startswith("Part::")
    ]


def steps(window):
    window.say("open the part")
    FreeCADGui.activateWorkbench("WpCalWorkbench")
    import ImportGui

    document = FreeCAD.newDocument("tee")
    ImportGui.insert(str(FIXTURE / "tee.step"), document.Name)
    document.saveAs(str(window.folder / "tee.FCStd"))
    window.view().viewIsometric()
    window.view().fitAll()
    before = state_of_model(document)
    yield 0.3
    yield from features_and_seams(window, document)
    yield from taught_points(window, document)
    if "WPCAL_ONLY_TOUCHES" in os.environ:
        return
    yield from preferences(window)
    yield from calibrate(window, document)
    assert state_of_model(document) == before, "the user's model was changed"
    yield from export(window, document)
    yield from touch_plan(window, document)
    yield from reopen(window, document)


def preferences(window):
    window.say("preferences")
    from freecad.wpcal_wb.preferences import PreferencePage

    page = PreferencePage()
    page.loadSettings()
    page.form.show()
    page.find()
    yield lambda: page.answer.text().endswith("answers.")
    window.facts["found"] = page.edit.text()
    page.edit.setText("/nowhere/wpcal")
    page.test()
    yield lambda: "cannot be started" in page.answer.text()
    window.facts["missing"] = page.answer.text()
    page.form.close()


def features_and_seams(window, document):
    window.say("features and seams")
    yield from window.click_widget(toolbar_button(window, "Features and seams"))
    yield FreeCADGui.Control.activeDialog
    table = window.find(QtGui.QTableWidget, "wpcal_seams")
    yield lambda: table.rowCount() > 0
    window.facts["seams"] = [table.item(row, 0).text() for row in range(table.rowCount())]
    yield 0.3
    yield from window.shot("freecad-seams")
    FreeCADGui.Control.closeDialog()


def taught_points(window, document):
    window.say("touch the first corner with the mouse")
    panel = open_panel("WpCal_TaughtPoints", document)
    features = panel.model.features
    rows = read_rows()
    first = rows[0]
    yield from window.click(features[first["name"]]["p_mm"])
    yield lambda: len(panel.model.rows) == 1
    assert panel.model.records()[0]["feature"] == first["name"], panel.model.records()
    window.say("type its coordinates")
    table = panel.table.widget
    for name in ("x_mm", "y_mm", "z_mm"):
        yield from window.tool("xdotool", "type", "--delay", "5", "--", first[name])
        yield from window.tool("xdotool", "key", "Tab")
        yield lambda name=name: panel.model.cell(0, name) == first[name]
    window.say("touch the other features")
    for number, row in enumerate(rows[1:], 1):
        FreeCADGui.Selection.clearSelection()
        FreeCADGui.Selection.addSelection(panel.seams.object, row["name"])
        yield lambda number=number: len(panel.model.rows) == number + 1
        for name in ("x_mm", "y_mm", "z_mm", "use"):
            panel.model.change({(number, name): row[name]}, "Type")
        yield 0
    yield lambda: not panel.is_busy and all(table.item(row, OFF).text() for row in range(len(rows)))
    window.facts["summary"] = panel.summary.text()
    window.facts["residuals"] = [table.item(row, OFF).text() for row in range(table.rowCount())]
    yield from window.shot("freecad-touches")
    panel.reject()


def calibrate(window, document):
    window.say("calibrate")
    panel = open_panel("WpCal_Calibrate", document)
    yield lambda: panel.fit is not None and not panel.is_busy
    window.facts["verdict"] = panel.verdict.text()
    window.facts["pose"] = panel.fit["T_base_part"]
    yield from window.shot("freecad-calibrate")
    window.say("another tolerance")
    yield from set_option(panel, "tolerance_mm", "0.2")
    window.facts["verdict for 0.2 mm"] = panel.verdict.text()
    yield from set_option(panel, "tolerance_mm", TOLERANCE_MM)
    panel.datums.setCurrentIndex(panel.datums.findData("ends"))
    window.view().fitAll()
    yield 0.3
    yield from window.shot("freecad-placed")
    window.say("undo and redo")
    names = [obj.Name for obj in document.Objects]
    undone = 0
    while any(obj.TypeId == "App::Part" for obj in document.Objects) and undone < MOST_UNDONE:
        document.undo()
        undone += 1
    window.facts["undone"] = undone
    for _ in range(undone):
        document.redo()
    window.facts["redone"] = [obj.Name for obj in document.Objects] == names
    window.say("save")
    panel.save()
    yield lambda: not panel.is_busy
    window.facts["result"] = panel.folder.path()
    panel.save()
    yield lambda: not panel.is_busy
    window.facts["saved again"] = panel.message.text()
    window.say("plates that may have moved")
    for is_asked in (True, False):
        before = panel.fit
        panel.options.field("bodies").setChecked(is_asked)
        yield lambda before=before: panel.fit is not before and not panel.is_busy
        window.facts["plates" if is_asked else "plates again"] = panel.notes.text()
    panel.reject()


def set_option(panel, name, text):
    """Type an option of a panel and wait for the fit; use with `yield from`."""
    before = panel.fit
    field = panel.options.field(name)
    field.setText(text)
    field.editingFinished.emit()
    yield lambda: panel.fit is not before and not panel.is_busy


def export(window, document):
    window.say("export")
    panel = open_panel("WpCal_Export", document)
    yield lambda: not panel.is_busy
    for row in range(panel.formats.count()):
        item = panel.formats.item(row)
        if item.data(QtCore.Qt.UserRole) in ("rapid", "krl"):
            item.setCheckState(QtCore.Qt.Checked)
    panel.options.field("speed_mm_s").setText("-3")
    panel.export()
    yield lambda: not panel.is_busy
    window.facts["wrong speed"] = panel.message.text()
    panel.options.field("speed_mm_s").setText("6")
    yield from window.click_widget(window.find(QtGui.QPushButton, "wpcal_export"))
    yield lambda: panel.files.count() > 0 and not panel.is_busy
    window.facts["programs"] = [panel.files.item(row).toolTip() for row in range(panel.files.count())]
    yield from window.shot("freecad-export")
    panel.reject()


def touch_plan(window, document):
    window.say("touch plan")
    panel = open_panel("WpCal_TouchPlan", document)
    yield lambda: not panel.is_busy
    panel.options.field("touches").setText("6")
    panel.plan()
    yield lambda: not panel.is_busy
    window.facts["touches"] = panel.message.text()
    window.facts["touch_folder"] = panel.folder.path()
    panel.reject()


def reopen(window, document):
    window.say("save and open again")
    document.save()
    path, name = document.FileName, document.Name
    FreeCAD.closeDocument(name)
    document = FreeCAD.openDocument(path)
    yield 0.5
    window.facts["kept"] = sorted(obj.Name for obj in document.Objects if hasattr(obj, "WpCalKind"))
    panel = open_panel("WpCal_Calibrate", document)
    yield lambda: panel.fit is not None and not panel.is_busy
    window.facts["verdict again"] = panel.verdict.text()
    window.facts["tolerance again"] = panel.options.field("tolerance_mm").text()
    panel.reject()
