# SPDX-License-Identifier: MIT
"""The panels *Touch plan* and *Weld plan*."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import Any, Mapping

from ..document.calibration import seam_params
from ..qt import widgets
from ..words import translate
from .base import TaskPanel
from .folders import FolderLine, show_file
from .option_form import OptionForm

OWN_OPTIONS = ("part", "out", "force", "json", "no_cache", "seams", "result", "check")


class PlanPanel(TaskPanel):
    """A form, a folder, a button; then a page and what the plan says of itself.

    A subclass names the method, and the options that are shown at once.
    """

    method = ""
    first: Mapping[str, str] = MappingProxyType({})
    page = ""
    folder_name = ""

    def build(self) -> None:
        """Make the widgets and ask for the options."""
        self.build_inputs()
        self.options = OptionForm(first=self.first, left_out=OWN_OPTIONS)
        self.folder = FolderLine(self.document, default=self.folder_name)
        self.replace = widgets().QCheckBox(translate("Replace an existing plan"))
        self.plan_button = widgets().QPushButton(translate("Plan"))
        self.plan_button.setObjectName("wpcal_plan")
        self.plan_button.clicked.connect(self.plan)
        self.page_button = widgets().QPushButton(translate("Open the page of the plan"))
        self.page_button.clicked.connect(lambda: show_file(str(Path(self.folder.path()) / self.page)))
        self.page_button.setEnabled(False)
        self.body.addWidget(self.options.widget)
        self.body.addWidget(widgets().QLabel(translate("Folder for the plan")))
        for widget in (self.folder.widget, self.replace, self.plan_button, self.page_button):
            self.body.addWidget(widget)
        self.ask_plain("options", {"method": self.method}, lambda answer: self.options.fill(answer["options"]))

    def build_inputs(self) -> None:
        """Make the widgets above the options."""

    def plan(self) -> None:
        """Compute the plan and write its folder."""
        try:
            options = {**self.options.values(), **({"force": True} if self.replace.isChecked() else {})}
            params = {"out": self.folder.path(), **self.inputs(options)}
        except ValueError as error:
            self.say(str(error), is_error=True)
            return
        self.send(params)

    def inputs(self, options: dict[str, Any]) -> dict[str, Any]:
        """Return what the method is asked, without the folder of the plan."""
        raise NotImplementedError

    def send(self, params: dict[str, Any]) -> None:
        """Ask wpcal for the plan."""
        self.ask_plain(self.method, params, self.planned)

    def planned(self, answer: dict[str, Any]) -> None:
        """Say what the plan promises."""
        self.page_button.setEnabled((Path(self.folder.path()) / self.page).is_file())
        self.say(self.summary(answer))

    def summary(self, answer: dict[str, Any]) -> str:
        """Return what the plan promises, for the message line."""
        raise NotImplementedError


class TouchPlanPanel(PlanPanel):
    """Plans the touches of the wire that locate the part."""

    title = "Touch plan"
    method = "touches"
    first = MappingProxyType(
        {
            "touches": "Number of searches",
            "pattern": "Pattern",
            "uncertainty_mm": "The part is off by (mm)",
            "uncertainty_deg": "The part is turned by (deg)",
            "wire_diameter_mm": "Wire (mm)",
            "nominal": "Place in the base",
            "arm": "Arm",
            "cell": "Cell (file)",
        }
    )
    page = "touches.html"
    folder_name = "touches"

    def inputs(self, options: dict[str, Any]) -> dict[str, Any]:
        """Return options and decisions about the seams."""
        return seam_params(self.document, options)

    def send(self, params: dict[str, Any]) -> None:
        """Ask about the part of the document."""
        self.ask(self.method, params, self.planned)

    def summary(self, answer: dict[str, Any]) -> str:
        """Return the number of searches and the error that they promise."""
        predicted = answer["predicted"]
        text = translate(
            "{count} searches. The seams will be within {error:.2f} mm (95 %), the worst is {seam}. "
            "Export writes the robot program from this folder."
        )
        found = text.format(count=len(answer["searches"]), error=predicted["error_95_mm"], seam=predicted["seam"])
        return "\n".join([found, *map(str, answer.get("notes") or ())])


class WeldPlanPanel(PlanPanel):
    """Plans how one robot welds all seams, or two robots one after another."""

    title = "Weld plan"
    method = "plan"
    first = MappingProxyType(
        {"only": "Seams (W1,W5-W8)", "position": "Weld position", "order": "Order", "prefer": "Two robots: prefer"}
    )
    page = "plan.html"
    folder_name = "plan"

    def build_inputs(self) -> None:
        """Ask for the cell and the result folder."""
        self.cell = widgets().QLineEdit()
        self.cell.setObjectName("wpcal_cell")
        self.cell.setPlaceholderText("cell.json")
        choose = widgets().QPushButton("…")
        choose.clicked.connect(self._choose_cell)
        line = widgets().QHBoxLayout()
        line.addWidget(self.cell, 1)
        line.addWidget(choose)
        self.result = FolderLine(self.document)
        self.body.addWidget(widgets().QLabel(translate("File of the cell (wpcal cell new writes one)")))
        self.body.addLayout(line)
        self.body.addWidget(widgets().QLabel(translate("Result folder of the calibration")))
        self.body.addWidget(self.result.widget)

    def inputs(self, options: dict[str, Any]) -> dict[str, Any]:
        """Return cell, result folder and options. Raises `ValueError` if no cell is named."""
        cell = self.cell.text().strip()
        if not cell:
            raise ValueError(translate("Name the file of the cell."))
        return {"folder": self.result.path(), "cell": str(Path(cell).expanduser().absolute()), "options": options}

    def summary(self, answer: dict[str, Any]) -> str:
        """Return how many seams are planned, how long they take, and which cannot be welded."""
        lines = [translate("The plan is in {folder}.").format(folder=self.folder.path())]
        if "time_s" in answer and "unwelded" in answer:
            text = translate("{count} seams in {seconds:.0f} s.")
            lines.append(text.format(count=len(answer["seams"]), seconds=answer["time_s"]))
            lines += [f"{each['seam']}: {each['why']}" for each in answer["unwelded"]]
        return "\n".join(lines)

    def _choose_cell(self) -> None:
        title, kinds = translate("File of the cell"), translate("Cells (*.json)")
        found = widgets().QFileDialog.getOpenFileName(self.form, title, self.cell.text(), kinds)[0]
        if found:
            self.cell.setText(found)
