# SPDX-License-Identifier: MIT
"""The drawing of taught points: a ring where each was touched, and its residual as an arrow."""

from __future__ import annotations

from typing import Any, Sequence

import FreeCAD
from pivy import coin

from ..document.kinds import Kind, object_of
from ..document.session import session_of
from ..document.taught import TaughtModel
from . import seam_nodes as nodes
from .base import RecordView
from .colours import RESIDUAL, unit
from .lines import arrows_node, fitting_factor, in_front

TAUGHT = unit((27, 127, 75))


class TaughtView(RecordView):
    """The view provider of `Kind.TAUGHT`."""

    icon_name = "WpCal_TaughtPoints"
    mode = "Points"

    def attach(self, view: Any) -> None:
        """Make the nodes once."""
        self._object = view.Object
        self._rings = coin.SoSeparator()
        self._arrows = coin.SoSeparator()
        root = coin.SoSeparator()
        style = coin.SoPickStyle()
        style.style = coin.SoPickStyle.UNPICKABLE  # clicks are meant for what lies below
        for child in (style, in_front(), self._rings, self._arrows):
            root.addChild(child)
        view.addDisplayMode(root, self.mode)
        self._draw()

    def updateData(self, obj: Any, name: str) -> None:
        """Draw anew what has changed, also after Undo. The residuals of earlier rows are gone."""
        if name == "Table" and hasattr(self, "_rings"):
            self._object = obj
            self._draw()

    def show_residuals(self, points: Sequence[dict[str, Any]]) -> None:
        """Draw residuals, enlarged so that the largest is well seen; an empty list takes them away."""
        self._arrows.removeAllChildren()
        known = [one for one in points if one.get("p_part_mm") and one.get("residual_part_mm")]
        if not known:
            return
        self._arrows.addChild(nodes.transform(self._frame()))
        places = [one["p_part_mm"] for one in known]
        factor = fitting_factor(max(one["distance_mm"] for one in known), nodes.size_mm([places]) / 2)
        vectors = [one["residual_part_mm"] for one in known]
        self._arrows.addChild(arrows_node(places, vectors, factor=factor, colour=unit(RESIDUAL)))

    def _frame(self) -> Any:
        seams = object_of(self._object.Document, Kind.SEAMS)
        return seams.PartFrame if seams is not None else FreeCAD.Placement()

    def _draw(self) -> None:
        self._rings.removeAllChildren()
        self._arrows.removeAllChildren()
        model = TaughtModel(session_of(self._object.Document))
        places = [place for place in map(model.place_of, model.records()) if place is not None]
        if places:
            self._rings.addChild(nodes.transform(self._frame()))
            marker = coin.SoMarkerSet.CIRCLE_LINE_9_9
            self._rings.addChild(nodes.markers(places, [TAUGHT] * len(places), marker))
