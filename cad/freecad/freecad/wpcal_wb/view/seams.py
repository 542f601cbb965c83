# SPDX-License-Identifier: MIT
"""The drawing of features and seams: markers that can be picked, coloured lines, arrows in the direction of travel."""

from __future__ import annotations

from typing import Any, Sequence

from pivy import coin

from ..document.kinds import data_of
from . import seam_nodes as nodes
from .base import RecordView
from .colours import Colour
from .lines import Path, in_front, paths_node, triads_node

REDRAWN_BY = ("Features", "Seams", "PartFrame")  #: Properties of the object that are drawn.
LINE_PX = 4.0  #: Width of a seam on the screen.
GETTERS = (("SoPointDetail", "getCoordinateIndex"), ("SoLineDetail", "getPartIndex"), ("SoFaceDetail", "getFaceIndex"))
"""Which line, triangle or marker of its node was clicked, by the class of the detail."""
SHARP = "sharp"  #: A feature that is easy to touch, as wpcal says it.


class SeamsView(RecordView):
    """The view provider of `Kind.SEAMS`.

    The names of features and seams are the elements of the object: a click on a marker selects `V3`.
    """

    icon_name = "WpCal_FeaturesAndSeams"
    mode = "Seams"

    def attach(self, view: Any) -> None:
        """Make the nodes once; `_draw` fills them."""
        self._object = view.Object
        self._seams: list[dict[str, Any]] = []
        self._features: list[dict[str, Any]] = []
        self._chosen: list[str] = []
        self.shows_features = True
        self.shows_refused = True
        self.shows_frames = False
        self._drawn = coin.SoSeparator()
        self._overlay = coin.SoSeparator()
        root = coin.SoSeparator()
        root.addChild(in_front())
        root.addChild(self._drawn)
        root.addChild(self._overlay)
        view.addDisplayMode(root, self.mode)
        self._draw()

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
        if shown:
            self._add(paths_node([_path(seam, _colour(seam)) for seam in shown], width=LINE_PX), shown)
            arrows, owners = nodes.arrows([(seam["frames"], _colour(seam)) for seam in shown], self._arrow_mm())
            self._add(arrows, [shown[owner] for owner in owners])
        if self.shows_frames:
            frames = [seam["frames"] for seam in shown if seam["accepted"]]
            poses = [pose for one in frames for pose in zip(one["p"], one["R"])]
            self._drawn.addChild(triads_node(poses, length=self._arrow_mm()))
        if self.shows_features and self._features:
            shades = [nodes.EASY if one["ease"] == SHARP else nodes.HARD for one in self._features]
            self._add(nodes.markers([one["p_mm"] for one in self._features], shades), self._features)
        self._draw_overlay()

    def _add(self, drawn: Any, records: Sequence[dict[str, Any]]) -> None:
        self._drawn.addChild(drawn)
        self._picked.append((drawn.getChild(drawn.getNumChildren() - 1), [one["name"] for one in records]))

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
            paths = [_path(seam, nodes.CHOSEN) for seam in chosen]
            self._overlay.addChild(paths_node(paths, width=2 * LINE_PX))
            marked = [(seam["frames"], nodes.CHOSEN) for seam in chosen]
            self._overlay.addChild(nodes.arrows(marked, 1.5 * self._arrow_mm())[0])
        points = [one["p_mm"] for one in self._features if one["name"] in self._chosen]
        if points:
            marker = coin.SoMarkerSet.CIRCLE_FILLED_9_9
            self._overlay.addChild(nodes.markers(points, [nodes.CHOSEN] * len(points), marker))


def _path(seam: dict[str, Any], colour: Colour) -> Path:
    points = seam["frames"]["p"]
    return points, [colour] * len(points)


def _colour(seam: dict[str, Any]) -> Colour:
    return nodes.ACCEPTED if seam["accepted"] else nodes.REFUSED


def _index(detail: Any) -> int:
    """Return which line or marker of its set a detail is about."""
    for name, getter in GETTERS:
        if detail.isOfType(getattr(coin, name).getClassTypeId()):
            return int(getattr(coin.cast(detail, name), getter)())
    return -1
