# SPDX-License-Identifier: MIT
"""The view providers of this workbench's objects."""

from __future__ import annotations

from typing import Any

from ..document.calibration import kept_fit_of, shown_of
from ..document.kinds import Kind, kind_of
from .base import RecordView
from .seams import SeamsView
from .taught import TaughtView


class CalibrationView(RecordView):
    """A calibration: seams in the colours of their errors, residuals, seam frames."""

    icon_name = "WpCal_Calibrate"
    mode = "Errors"

    def attach(self, view: Any) -> None:
        """Make the node that the drawing is put into."""
        from pivy import coin

        self.root = coin.SoSeparator()
        view.addDisplayMode(self.root, self.mode)
        self.updateData(view.Object, "Calibration")

    def updateData(self, obj: Any, name: str) -> None:
        """Draw again what has changed."""
        if name not in ("Calibration", "Shown", "PartFrame"):
            return
        from .calibration import calibration_node

        self.root.removeAllChildren()
        fit = kept_fit_of(obj)
        if fit is not None:
            self.root.addChild(calibration_node(fit, obj.PartFrame, shown_of(obj)))


VIEWS: dict[Kind, type[RecordView]] = {
    Kind.SEAMS: SeamsView,
    Kind.TAUGHT: TaughtView,
    Kind.CALIBRATION: CalibrationView,
}


def attach_view(obj: Any) -> None:
    """Give an object of this workbench its view provider."""
    kind = kind_of(obj)
    view = getattr(obj, "ViewObject", None)
    if kind is not None and view is not None and not isinstance(getattr(view, "Proxy", None), VIEWS[kind]):
        VIEWS[kind](view)
