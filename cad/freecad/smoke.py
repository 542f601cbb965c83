# SPDX-License-Identifier: MIT
"""Try the workbench in this FreeCAD: `freecad Mod/WpCal/smoke.py`, or `freecadcmd Mod/WpCal/smoke.py` without a window.

A tee of two boxes is made in a new document, wpcal finds its features and seams, five made-up touches calibrate it, a
robot program is written, and with a window every panel is opened once. Each step prints one line. The last line says
whether everything worked; send all lines with a report of a fault. Nothing is left behind except the open document.
"""

from __future__ import annotations

import platform
import shutil
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Any, Callable, Iterator

import FreeCAD

if "__file__" in globals() and str(Path(__file__).resolve().parent) not in sys.path:
    sys.path.append(str(Path(__file__).resolve().parent))

from freecad.wpcal_wb.client import find_executable, how_to_install
from freecad.wpcal_wb.document.calibration import fit_params, keep_fit
from freecad.wpcal_wb.document.kinds import Kind, make_object, set_data, transaction
from freecad.wpcal_wb.document.placed import placed_part
from freecad.wpcal_wb.document.session import session_of, stop_sessions
from freecad.wpcal_wb.document.shown import Shown
from freecad.wpcal_wb.qt import QtCore, wait_until

PLATE_MM, WEB_MM = (200.0, 120.0, 10.0), (150.0, 8.0, 80.0)
NEAR_MM = 1e-3  #: The touches are exact to 0.0001 mm, so the pose must come out as it was made up.
TOUCHES = 5
PANEL_S = 60.0


class Smoke:
    """The steps, in their order; each returns what its line says."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.document = FreeCAD.newDocument("WpCalSmoke")
        self.document.UndoMode = 1  # without a window FreeCAD keeps no steps of Undo
        turn = FreeCAD.Rotation(FreeCAD.Vector(0.1, -0.2, 1.0), 31.0)
        self.pose = FreeCAD.Placement(FreeCAD.Vector(812.0, -240.0, 155.0), turn)
        self.fit: dict[str, Any] = {}
        self.features: list[dict[str, Any]] = []

    def steps(self) -> Iterator[tuple[str, Callable[[], str]]]:
        """Yield the name of every step and its function."""
        yield "FreeCAD, Python, Qt", self.versions
        yield "wpcal is found", self.executable
        yield "a part is made", self.part
        yield "features and seams are found", self.seams
        yield "touches calibrate the part", self.calibrate
        yield "the part is placed, and Undo takes it back", self.place
        yield "result folder and robot program are written", self.export
        yield "the document keeps its data", self.reopen
        if FreeCAD.GuiUp:
            yield "the panels open", self.panels

    def versions(self) -> str:
        """Name the versions."""
        freecad = ".".join(FreeCAD.Version()[:3])
        return f"{freecad}, {platform.python_version()}, {QtCore.qVersion()}, {platform.platform()}"

    def executable(self) -> str:
        """Start wpcal and ask for its version."""
        found = find_executable()
        if found is None:
            raise RuntimeError(how_to_install())
        hello = session_of(self.document).client.call("hello").wait(60)
        return f"{hello['wpcal']}, protocol {hello['protocol']}, {' '.join(found.command)}"

    def part(self) -> str:
        """Make two boxes."""
        for name, size, place in (("Plate", PLATE_MM, (0.0, 0.0, 0.0)), ("Web", WEB_MM, (25.0, 56.0, PLATE_MM[2]))):
            box = self.document.addObject("Part::Box", name)
            box.Length, box.Width, box.Height = size
            box.Placement.Base = FreeCAD.Vector(*place)
        self.document.recompute()
        return f"{len(self.document.Objects)} boxes"

    def seams(self) -> str:
        """Find features and seams."""
        session = session_of(self.document)
        self.features = session.open().wait(300)["features"]
        seams = session.ask("seams").wait(300)["seams"]
        accepted = [seam["name"] for seam in seams if seam["accepted"]]
        if not accepted:
            raise RuntimeError("no seam of the tee was accepted")
        return f"{len(self.features)} features, seams {', '.join(accepted)}"

    def calibrate(self) -> str:
        """Touch corners of the part at a made-up pose, and fit."""
        corners = [feature for feature in self.features if feature["kind"] == "vertex"]
        far = sorted(corners, key=lambda each: each["p_mm"])
        chosen = [far[round(number * (len(far) - 1) / (TOUCHES - 1))] for number in range(TOUCHES)]
        rows = []
        for feature in chosen:
            place = self.pose.multVec(FreeCAD.Vector(*feature["p_mm"]))
            rows.append([feature["name"], *(f"{value:.4f}" for value in place)])
        with transaction(self.document, "Take touches"):
            taught = make_object(self.document, Kind.TAUGHT)
            set_data(taught, "Table", {"columns": ["name", "x_mm", "y_mm", "z_mm"], "rows": rows})
        params = {**fit_params(self.document, {"sigma_mm": 0.1}), "frames": True}
        self.fit = session_of(self.document).ask("calibrate", params).wait(300)
        return f"{self.fit['record']['verdict']}: {self.fit['record']['judgement']['sentence']}"

    def place(self) -> str:
        """Place the part, compare with the pose, undo, redo."""
        session = session_of(self.document)
        with transaction(self.document, "Calibrate"):
            keep_fit(session, self.fit, Shown(datums="ends"))
        part = placed_part(self.document)
        off = (part.Placement.Base - self.pose.Base).Length
        if off > NEAR_MM:
            raise RuntimeError(f"the part is {off:g} mm from where it was put")
        count = len(part.Group)
        self.document.undo()
        if placed_part(self.document) is not None:
            raise RuntimeError("Undo did not take the placed part back")
        self.document.redo()
        return f"{off:.2g} mm off, {count} objects in it"

    def export(self) -> str:
        """Write the result folder and an ABB program."""
        session, out = session_of(self.document), self.folder / "result"
        table = str(self.folder / "taught.csv")
        saved = session.ask("save", {**fit_params(self.document), "table": table, "out": str(out)}).wait(300)
        params = {"folder": str(out), "formats": ["rapid"]}
        written = session.client.call("export", params).wait(300)["files"]["rapid"]
        return f"{len(saved['files'])} files, {Path(written[0]).name}"

    def reopen(self) -> str:
        """Save, close and open the document."""
        file = str(self.folder / "smoke.FCStd")
        self.document.saveAs(file)
        FreeCAD.closeDocument(self.document.Name)
        self.document = FreeCAD.openDocument(file)
        if not fit_params(self.document)["taught"]["rows"] or placed_part(self.document) is None:
            raise RuntimeError("taught points or the placed part were lost")
        return f"{Path(file).stat().st_size} bytes"

    def panels(self) -> str:
        """Open every panel and wait until it has its answers."""
        from freecad.wpcal_wb.commands import COMMANDS

        for command in COMMANDS:
            panel = command.open(self.document)
            if not wait_until(lambda panel=panel: not panel.is_busy, PANEL_S):
                raise RuntimeError(f"{command.text} did not get its answers in {PANEL_S:g} s")
            panel.reject()
        return ", ".join(command.text for command in COMMANDS)


def run() -> None:
    """Run the steps until one fails, and print a line for each."""
    folder = Path(tempfile.mkdtemp(prefix="wpcal-smoke-"))
    lines: list[str] = []
    try:
        for name, step in Smoke(folder).steps():
            lines.append(f"FAILED  {name}")
            lines[-1] = f"ok      {name}: {step()}"
        lines.append("wpcal smoke test: everything worked")
    except Exception:
        lines += [traceback.format_exc(), "wpcal smoke test: FAILED"]
    finally:
        stop_sessions()
        shutil.rmtree(str(folder), ignore_errors=True)
    FreeCAD.Console.PrintMessage("\n".join(["", *lines, ""]))


run()
