# SPDX-License-Identifier: MIT
"""The panel *Calibrate*: verdict, errors in colours, residuals, the part where it is, the result folder."""

from __future__ import annotations

from typing import Any, Mapping

from ..client import Failure
from ..document.calibration import (
    fit_options,
    fit_params,
    keep_fit,
    keep_options,
    kept_fit_of,
    moves_in,
    seam_params,
    shown_of,
)
from ..document.kinds import Kind, object_of, transaction
from ..document.shown import Shown
from ..qt import QtCore, widgets
from ..view.calibration import arrow_factor
from ..view.colours import BEYOND, UNKNOWN, css, legend_style, unit
from ..view.lines import FACTORS
from ..words import translate
from .base import TaskPanel
from .folders import FolderLine, open_page
from .option_form import OptionForm

REFIT_AFTER_MS = 250  #: A change of an option starts a fit when nothing else was changed for this long.
COLOURS = {"PASS": "#1b7f4b", "FAIL": "#b00020"}
UNCERTAIN = "#b36b00"
FIRST_OPTIONS = {
    "tolerance_mm": "Tolerance (mm)",
    "sigma_mm": "Teaching error (mm per axis)",
    "criterion": "Criterion",
    "bodies": "Plates may have moved",
}


class CalibratePanel(TaskPanel):
    """Fits the taught points and shows what comes of it."""

    title = "Calibrate"

    def build(self) -> None:
        """Make the widgets; the fit starts at once."""
        self.fit: dict[str, Any] | None = kept_fit_of(object_of(self.document, Kind.CALIBRATION))
        self._is_fitting = False
        self._refit: Any = QtCore.QTimer()
        self._refit.setSingleShot(True)
        self._refit.timeout.connect(self.calibrate)
        self.body.addWidget(self._verdict())
        self.body.addWidget(self._table())
        self.body.addWidget(self._view_box())
        if self.fit is not None:
            self._show_fit()
        self.options = OptionForm(
            first=FIRST_OPTIONS, switches=("bodies",), left_out=("out", "force", "json", "no_cache", "seams")
        )
        self.options.changed = lambda: self._refit.start(REFIT_AFTER_MS)
        self.body.addWidget(self.options.widget)
        self.body.addWidget(self._result_box())
        self.ask_plain("options", {"method": "calibrate"}, self._options_known)
        self.calibrate()

    def closed(self) -> None:
        """Start no further fit."""
        self._refit.stop()

    # -- the fit ----------------------------------------------------------------------------------------------------

    def calibrate(self) -> None:
        """Fit the points of the document with the options of the panel."""
        try:
            options = self._options()
            params = fit_params(self.document, options)
        except ValueError as error:
            self.say(str(error), is_error=True)
            return
        self._is_fitting = True
        self.ask("calibrate", {**params, "frames": True}, lambda fit: self._fitted(fit, options))

    def _options(self) -> dict[str, Any] | None:
        """Return the options of the form; None before wpcal has said which there are."""
        return self.options.values() if self.options.is_filled else None

    def _options_known(self, answer: dict[str, Any]) -> None:
        self.options.fill(answer["options"])
        self.options.set_values(seam_params(self.document, fit_options(self.document))["options"])

    def _fitted(self, fit: dict[str, Any], options: dict[str, Any] | None) -> None:
        self._is_fitting = False
        self.fit = fit
        self._show_fit()
        self._keep(options)

    def failed(self, failure: Failure) -> None:
        """Show why there is no fit, and no longer the verdict of an earlier one."""
        was_fitting, self._is_fitting = self._is_fitting, False
        if was_fitting and not failure.is_cancelled:
            self.fit = None
            self.verdict.setText("–")
            self.verdict.setStyleSheet("font-size: 20pt")
            self.sentence.setText("")
            self.notes.setText("")
            self.residuals.setRowCount(0)
        super().failed(failure)

    def _keep(self, options: dict[str, Any] | None = None) -> None:
        if self.fit is None:
            return
        shown = Shown(
            factor=float(self.factor.currentData()),
            frames=self.frames_box.isChecked(),
            on_model=self.model_box.isChecked(),
            at_pose=self.pose_box.isChecked(),
            datums=self.datums.currentData(),
        )
        try:
            with transaction(self.document, translate("Calibrate")):
                keep_fit(self.session, self.fit, shown)
                if options is not None:
                    keep_options(self.document, options)
        except ValueError as error:
            self.say(str(error), is_error=True)

    # -- verdict and residuals --------------------------------------------------------------------------------------

    def _verdict(self) -> Any:
        box = widgets().QWidget()
        layout = widgets().QVBoxLayout(box)
        layout.setContentsMargins(0, 0, 0, 0)
        self.verdict = widgets().QLabel("…")
        self.verdict.setObjectName("wpcal_verdict")
        self.sentence, self.notes = _text_label(), _text_label()
        for widget in (self.verdict, self.sentence, self.notes):
            layout.addWidget(widget)
        return box

    def _table(self) -> Any:
        self.residuals = widgets().QTableWidget(0, 6)
        self.residuals.setObjectName("wpcal_residuals")
        names = [translate("point"), "dx", "dy", "dz", translate("off (mm)"), translate("use")]
        self.residuals.setHorizontalHeaderLabels(names)
        self.residuals.setEditTriggers(widgets().QAbstractItemView.NoEditTriggers)
        self.residuals.verticalHeader().hide()
        self.residuals.setMinimumHeight(120)
        return self.residuals

    def _show_fit(self) -> None:
        fit = self.fit or {}
        record = fit["record"]
        verdict = str(record["verdict"])
        self.verdict.setText(verdict)
        colour = COLOURS.get(verdict, UNCERTAIN)
        self.verdict.setStyleSheet(f"font-size: 20pt; font-weight: bold; color: {colour}")
        self.sentence.setText(str(record["judgement"]["sentence"]))
        lines = [
            *_about_plates(self.session, fit),
            *map(str, fit.get("notes") or ()),
            *map(str, fit.get("steps") or ()),
        ]
        self.notes.setText(self.worded("\n".join(lines)))
        self.notes.setVisible(bool(lines))
        points = fit["points"]
        self.residuals.setRowCount(len(points))
        for row, point in enumerate(points):
            cells = [
                point["name"],
                *(f"{value:.3f}" for value in point["residual_mm"]),
                f"{point['distance_mm']:.3f}",
                point["use"],
            ]
            for column, text in enumerate(cells):
                self.residuals.setItem(row, column, widgets().QTableWidgetItem(text))
        self.residuals.resizeColumnsToContents()
        self.factor.setItemText(0, translate("as fits (× {factor})").format(factor=arrow_factor(fit)))
        tolerance = record["tolerance_mm"]
        self.legend_high.setText(translate("{mm:g} mm").format(mm=tolerance))

    # -- what is drawn ----------------------------------------------------------------------------------------------

    def _view_box(self) -> Any:
        box = widgets().QGroupBox(translate("In the 3-D view"))
        layout = widgets().QFormLayout(box)
        layout.setRowWrapPolicy(widgets().QFormLayout.WrapLongRows)
        layout.addRow(widgets().QLabel(translate("95 % error of the seams")))
        layout.addRow(self._legend())
        self.factor = widgets().QComboBox()
        self.factor.addItem(translate("as fits"), 0)
        for factor in FACTORS:
            self.factor.addItem(f"× {factor}", factor)
        self.model_box, self.pose_box = widgets().QCheckBox(), widgets().QCheckBox()
        self.frames_box, self.datums = widgets().QCheckBox(), widgets().QComboBox()
        for text, choice in (("none", ""), ("first and last of each seam", "ends"), ("every frame", "all")):
            self.datums.addItem(translate(text), choice)
        shown = shown_of(object_of(self.document, Kind.CALIBRATION))
        self.factor.setCurrentIndex(max(self.factor.findData(int(shown.factor)), 0))
        self.datums.setCurrentIndex(max(self.datums.findData(shown.datums), 0))
        self.frames_box.setChecked(shown.frames)
        self.model_box.setChecked(shown.on_model)
        self.pose_box.setChecked(shown.at_pose)
        layout.addRow(translate("Residuals drawn longer"), self.factor)
        layout.addRow(translate("On the model"), self.model_box)
        layout.addRow(translate("Part in the robot's base"), self.pose_box)
        layout.addRow(translate("Seam frames"), self.frames_box)
        layout.addRow(translate("Coordinate systems"), self.datums)
        for name in ("factor", "model_box", "pose_box", "frames_box", "datums"):
            getattr(self, name).setObjectName(f"wpcal_{name}")
        for each in (self.model_box, self.pose_box, self.frames_box):
            each.toggled.connect(lambda _on: self._keep())
        for each in (self.factor, self.datums):
            each.setSizeAdjustPolicy(widgets().QComboBox.AdjustToMinimumContentsLengthWithIcon)
            each.currentIndexChanged.connect(lambda _index: self._keep())
        self.pose_box.toggled.connect(self.datums.setEnabled)
        self.datums.setEnabled(self.pose_box.isChecked())
        return box

    def _legend(self) -> Any:
        box = widgets().QWidget()
        line = widgets().QHBoxLayout(box)
        line.setContentsMargins(0, 0, 0, 0)
        bar = widgets().QLabel()
        bar.setMinimumSize(60, 12)
        bar.setStyleSheet(legend_style())
        self.legend_high = widgets().QLabel()
        line.addWidget(widgets().QLabel("0"))
        line.addWidget(bar, 1)
        line.addWidget(self.legend_high)
        for colour, text in ((BEYOND, "more"), (UNKNOWN, "refused")):
            label = widgets().QLabel(f"■ {translate(text)}")
            label.setStyleSheet(f"color: {css(unit(colour))}")
            line.addWidget(label)
        return box

    # -- the result folder ------------------------------------------------------------------------------------------

    def _result_box(self) -> Any:
        box = widgets().QGroupBox(translate("Result folder"))
        layout = widgets().QVBoxLayout(box)
        self.folder = FolderLine(self.document)
        self.replace = widgets().QCheckBox(translate("Replace an existing result"))
        buttons = widgets().QHBoxLayout()
        self.save_button = widgets().QPushButton(translate("Save"))
        self.save_button.setObjectName("wpcal_save")
        self.report_button = widgets().QPushButton(translate("Open the report"))
        self.save_button.clicked.connect(self.save)
        self.report_button.clicked.connect(lambda: open_page(self, self.folder.path()))
        for button in (self.save_button, self.report_button):
            buttons.addWidget(button)
        for each in (self.folder.widget, self.replace):
            layout.addWidget(each)
        layout.addLayout(buttons)
        return box

    def save(self) -> None:
        """Write the result folder, as `wpcal calibrate` does."""
        try:
            params = fit_params(self.document, self._options())
            folder = self.folder.path()
        except ValueError as error:
            self.say(str(error), is_error=True)
            return
        options = {**params["options"], **({"force": True} if self.replace.isChecked() else {})}
        table = f"{folder}.taught.csv"
        self.ask("save", {**params, "options": options, "table": table, "out": folder}, self._saved)

    def _saved(self, answer: dict[str, Any]) -> None:
        with transaction(self.document, translate("Save the result")):
            self.folder.keep()
        message = translate("{count} files written to {folder}.")
        self.say(message.format(count=len(answer["files"]), folder=self.folder.path()))


def _about_plates(session: Any, fit: Mapping[str, Any]) -> list[str]:
    """Return what is said of plates that may have moved, and where they are drawn."""
    bodies = fit["record"].get("bodies")
    if not bodies:
        return []
    lines = [
        str(bodies["sentence"]),
        translate("The part in the robot's base has each plate where it is; the model stays as it is."),
    ]
    unknown = [name for name, solids in moves_in(session, fit).items() if solids is None]
    if unknown:
        labels = ", ".join(session.document.getObject(name).Label for name in unknown)
        text = translate("Shown without the motions of its plates: {labels}. The moved STEP file has them.")
        lines.append(text.format(labels=labels))
    return lines


def _text_label() -> Any:
    label = widgets().QLabel()
    label.setWordWrap(True)
    label.setTextFormat(QtCore.Qt.PlainText)
    label.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
    return label
