# SPDX-License-Identifier: MIT
"""The view providers of this workbench's objects."""

from __future__ import annotations

from typing import Any

from ..document.kinds import Kind, kind_of
from .base import RecordView
from .seams import SeamsView


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
