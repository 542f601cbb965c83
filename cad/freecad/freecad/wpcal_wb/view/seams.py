# SPDX-License-Identifier: MIT
"""The drawing of features and seams: markers that can be picked, coloured lines, arrows in the direction of travel."""

from __future__ import annotations

from typing import Any, Sequence

from pivy import coin

from ..document.kinds import data_of
from . import seam_nodes as nodes
from .base import RecordView

REDRAWN_BY = ("Features", "Seams", "PartFrame")
"""Properties of the object that are drawn."""
SHARP = "sharp"
"""A feature that is easy to touch, as wpcal says it."""


class SeamsView(RecordView):
    """The view provider of `Kind.SEAMS`.

    The names of features and seams are the elements of the object: a click on a marker selects `V3`.
    """

    icon_name = "WpCal_FeaturesAndSeams"

    def attach(self, view: Any) -> None:
        """Make the nodes once; `_draw` fills them."""
        self._object = view.Object
        self._seams: list[dict[str, Any]] = []
        self._features: list[dict[str, Any]] = []
        self._chosen: list[str] = []
        self._u95: dict[str, Sequence[nodes.Colour]] = {}
        self.shows_features = True
        self.shows_refused = True
        self.shows_frames = False
        self._drawn = coin.SoSeparator()
        self._overlay = coin.SoSeparator()
        root = coin.SoSeparator()
        root.addChild(self._drawn)
        root.addChild(self._overlay)
        view.addDisplayMode(root, "Seams")
        self._draw()

    def getDisplayModes(self, _view: Any) -> list[str]:
        """Return the only way of drawing."""
        return ["Seams"]

    def getDefaultDisplayMode(self) -> str:
        """Return the only way of drawing."""
        return "Seams"

    def setDisplayMode(self, mode: str) -> str:
        """Take a mode as it is."""
        return mode

    def updateData(self, obj: Any, name: str) -> None:
        """Draw anew what has changed, also after Undo."""
        if name in REDRAWN_BY and hasattr(self, "_drawn"):
            self._object = obj
            self._draw()

    # -- what the panel asks for ------------------------------------------------------------------------------------

    def show(self, *, features: bool, refused: bool, frames: bool) -> None:
        """Choose what is drawn beside the accepted seams."""
        self.shows_features, self.shows_refused, self.shows_frames = features, refused, frames
        self._draw()

    def choose(self, names: Sequence[str]) -> None:
        """Mark seams and features over the others."""
        self._chosen = list(names)
        self._draw_overlay()

    def colour_frames(self, colours: dict[str, Sequence[nodes.Colour]]) -> None:
        """Give seams one colour per frame, for values along them; an empty dictionary takes the colours away."""
        self._u95 = dict(colours)
        self._draw()

    # -- picking ----------------------------------------------------------------------------------------------------

    def useNewSelectionModel(self) -> bool:
        """Tell FreeCAD to ask `getElementPicked`."""
        return True

    def getElementPicked(self, picked: Any) -> str:
        """Return the name of the feature or seam that was clicked; empty if it was nothing of ours."""
        path = picked.getPath()
        tail = path.getTail()
        detail = picked.getDetail()
        for node, names in self._picked:
            if tail == node and detail is not None:
                index = _index(detail)
                return names[index] if 0 <= index < len(names) else ""
        return ""

    def getSelectionShape(self, _name: str) -> None:
        """Return no shape: features and seams are no geometry of the model."""

    # -- drawing ----------------------------------------------------------------------------------------------------

    def _draw(self) -> None:
        self._seams = (data_of(self._object, "Seams") or {}).get("seams", [])
        self._features = data_of(self._object, "Features") or []
        self._picked: list[Any] = []
        self._drawn.removeAllChildren()
        self._drawn.addChild(nodes.transform(self._object.PartFrame))
        shown = [seam for seam in self._seams if seam["accepted"] or self.shows_refused]
        plain = [seam for seam in shown if seam["name"] not in self._u95]
        paths = [seam["frames"]["p"] for seam in plain]
        colours = [nodes.ACCEPTED if seam["accepted"] else nodes.REFUSED for seam in plain]
        self._add(nodes.path_lines(paths, colours), [seam["name"] for seam in plain])
        valued = [seam for seam in shown if seam["name"] in self._u95]
        if valued:
            rows = [self._u95[seam["name"]] for seam in valued]
            drawn = nodes.segment_lines([seam["frames"]["p"] for seam in valued], rows, 2 * nodes.LINE_PX)
            self._add(drawn, [seam["name"] for seam in valued])
        self._drawn.addChild(nodes.arrows(self._with_colours(shown), self._arrow_mm()))
        if self.shows_frames:
            frames = [seam["frames"] for seam in shown if seam["accepted"]]
            self._drawn.addChild(nodes.frame_axes(frames, self._arrow_mm()))
        if self.shows_features:
            shades = [nodes.EASY if one["ease"] == SHARP else nodes.HARD for one in self._features]
            drawn = nodes.markers([one["p_mm"] for one in self._features], shades)
            self._add(drawn, [one["name"] for one in self._features])
        self._draw_overlay()

    def _add(self, drawn: Any, names: list[str]) -> None:
        self._drawn.addChild(drawn)
        self._picked.append((drawn.getChild(drawn.getNumChildren() - 1), names))

    def _with_colours(self, seams: Sequence[dict[str, Any]]) -> list[Any]:
        return [(seam["frames"], nodes.ACCEPTED if seam["accepted"] else nodes.REFUSED) for seam in seams]

    def _arrow_mm(self) -> float:
        points = [one["p_mm"] for one in self._features]
        return nodes.ARROW_SHARE * nodes.size_mm([*(seam["frames"]["p"] for seam in self._seams), points])

    def _draw_overlay(self) -> None:
        self._overlay.removeAllChildren()
        style = coin.SoPickStyle()
        style.style = coin.SoPickStyle.UNPICKABLE
        self._overlay.addChild(style)
        self._overlay.addChild(nodes.transform(self._object.PartFrame))
        chosen = [seam for seam in self._seams if seam["name"] in self._chosen]
        if chosen:
            paths = [seam["frames"]["p"] for seam in chosen]
            self._overlay.addChild(nodes.path_lines(paths, [nodes.CHOSEN] * len(paths), 2 * nodes.LINE_PX))
            self._overlay.addChild(
                nodes.arrows([(seam["frames"], nodes.CHOSEN) for seam in chosen], 1.5 * self._arrow_mm())
            )
        points = [one["p_mm"] for one in self._features if one["name"] in self._chosen]
        if points:
            marker = coin.SoMarkerSet.CIRCLE_FILLED_9_9
            self._overlay.addChild(nodes.markers(points, [nodes.CHOSEN] * len(points), marker))


def _index(detail: Any) -> int:
    """Return which line or marker of its set a detail is about."""
    for name, getter in (("SoPointDetail", "getCoordinateIndex"), ("SoLineDetail", "getLineIndex")):
        if detail.isOfType(getattr(coin, name).getClassTypeId()):
            return int(getattr(coin.cast(detail, name), getter)())
    return -1
