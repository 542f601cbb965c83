# SPDX-License-Identifier: MIT
"""The view providers of this workbench's objects."""

from __future__ import annotations

from typing import Any

from .. import icon
from ..document.kinds import Kind, kind_of


class RecordView:
    """The view provider of an object: its icon in the tree and its drawing."""

    icon_name = "WpCal"

    def __init__(self, view: Any) -> None:
        view.Proxy = self

    def getIcon(self) -> str:
        """Return the icon in the tree."""
        return icon(self.icon_name)

    def dumps(self) -> None:
        """Save nothing (FreeCAD 1.0 and later)."""

    def loads(self, state: object) -> None:
        """Restore nothing (FreeCAD 1.0 and later)."""

    def __getstate__(self) -> None:
        """Save nothing (FreeCAD 0.20)."""

    def __setstate__(self, state: object) -> None:
        """Restore nothing (FreeCAD 0.20)."""


class SeamsView(RecordView):
    """Seams and features."""

    icon_name = "WpCal_FeaturesAndSeams"


class TaughtView(RecordView):
    """Taught points."""

    icon_name = "WpCal_TaughtPoints"


class CalibrationView(RecordView):
    """A calibration."""

    icon_name = "WpCal_Calibrate"


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
