"""How long after an edit the new residuals are shown, beside what the fit itself takes in wpcal's process."""

import csv
import os
import statistics
import time
from pathlib import Path

import FreeCAD
import FreeCADGui

FIXTURE = Path(os.environ["WPCAL_TEE"])
EDITS = 15


def steps(window):
    import ImportGui
    from freecad.wpcal_wb.commands import COMMANDS
    from freecad.wpcal_wb.document.calibration import fit_params
    from freecad.wpcal_wb.document.kinds import Kind, make_object, set_data, transaction

    window.say("open the part")
    FreeCADGui.activateWorkbench("WpCalWorkbench")
    document = FreeCAD.newDocument("tee")
    ImportGui.insert(str(FIXTURE / "tee.step"), document.Name)
    with (FIXTURE / "taught.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    panels = {command.name: command for command in COMMANDS}
    panel = panels["WpCal_FeaturesAndSeams"].open(document)
    yield lambda: panel.model.seams and not panel.is_busy
    panel.reject()
    with transaction(document, "rows"):
        set_data(make_object(document, Kind.TAUGHT), "Table", {"columns": header, "rows": rows})
    panel = panels["WpCal_TaughtPoints"].open(document)
    yield lambda: panel.summary.text().startswith("PASS")
    window.say("edit a coordinate")
    edits, bare = [], []
    for number in range(EDITS):
        panel.summary.setText("")
        start = time.monotonic()
        panel.model.change({(0, "x_mm"): f"{812.29 + 0.001 * number:.3f}"}, "Type")
        while not panel.summary.text():
            FreeCADGui.updateGui()
        edits.append(time.monotonic() - start)
        yield 0.05
        start = time.monotonic()
        panel.session.ask("calibrate", fit_params(document)).wait(30)
        bare.append(time.monotonic() - start)
        yield 0.05
    window.facts["from the edit to the residuals, s"] = round(statistics.median(edits), 4)
    window.facts["question and answer alone, s"] = round(statistics.median(bare), 4)
    panel.reject()
