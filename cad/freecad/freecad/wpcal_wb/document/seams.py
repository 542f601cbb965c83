# SPDX-License-Identifier: MIT
"""Features and seams of a document, and what the user decided about the seams.

What wpcal found and what the user decided are properties of one object. Every action of the user is one step of Undo:
wpcal is asked first, and its answer is written together with the decision.
"""

from __future__ import annotations

import json
import math
from typing import Any, Dict, Sequence, Tuple

from ..words import translate
from .export import is_same_placement
from .kinds import Kind, data_of, ensure_object, object_of, set_data, transaction
from .session import Session

Seam = Dict[str, Any]
Vector = Tuple[float, float, float]

SAME_EDGE_MM = 0.05  #: An edge is where a seam was found if its points around the picked one are this near to the seam.
SAME_CANDIDATE_MM = 0.1  #: As wpcal recognises a candidate (`SAME_PLACE_MM` of its seam edits).
NEAR_SHARE = 0.015
"""A click on a face is meant for a seam within this share of the size of all seams: some pixels of the view."""
ADDED_EDGES = "add_edge"  #: The option of the search with the edges that the user added.
LARGEST_TURN = math.radians(40)  #: Frames stand so close that a curve turns less than this between two of them.


class SeamModel:
    """The seams of a document."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._decisions: list[dict[str, Any]] | None = None
        self._options: dict[str, Any] | None = None

    # -- what is there ----------------------------------------------------------------------------------------------

    @property
    def object(self) -> Any:
        """The object of the document; None before the first search."""
        return object_of(self.session.document, Kind.SEAMS)

    @property
    def features(self) -> list[dict[str, Any]]:
        """The reference features, the easiest to touch first."""
        return list(self._data("Features") or [])

    @property
    def seams(self) -> list[Seam]:
        """The candidates, with their frames in the coordinates of the part."""
        return list((self._data("Seams") or {}).get("seams", []))

    @property
    def decisions(self) -> list[dict[str, Any]]:
        """What the user decided: candidates with edits, as wpcal takes them."""
        return self._decisions if self._decisions is not None else self._data("Edits") or []

    @property
    def options(self) -> dict[str, Any]:
        """Options of the search, as `wpcal seams` has them."""
        return self._options if self._options is not None else self._data("SeamOptions") or {}

    @property
    def is_stale(self) -> bool:
        """Whether the part was changed or moved after the seams were found. True also if it cannot be written now."""
        if self.object is None:
            return False
        try:
            part = self.session.write_part()
        except ValueError:
            return True
        return bool(part.hash != self.object.PartHash) or not is_same_placement(part.frame, self.object.PartFrame)

    def _data(self, name: str) -> Any:
        return None if self.object is None else data_of(self.object, name)

    # -- searching --------------------------------------------------------------------------------------------------

    def use_objects(self, objects: Sequence[Any]) -> None:
        """Take these objects for the part; none means the whole document."""
        with transaction(self.session.document, translate("Choose the part")):
            seams = ensure_object(self.session.document, Kind.SEAMS)
            if list(seams.Objects) != list(objects):
                seams.Objects = list(objects)

    def take_features(self, opened: dict[str, Any]) -> None:
        """Keep the features of a part that wpcal has opened."""
        part = self.session.part
        with transaction(self.session.document, translate("Find features")):
            seams = ensure_object(self.session.document, Kind.SEAMS)
            set_data(seams, "Features", opened["features"])
            if part is not None:
                seams.PartFrame = part.frame

    def request(self) -> dict[str, Any]:
        """Return the parameters of `seams`, and of other questions that depend on the seams."""
        return {"options": self.options, "decisions": self.decisions}

    def take_seams(self, result: dict[str, Any], text: str) -> None:
        """Keep the seams that wpcal found, together with the decisions that led to them: one step of Undo."""
        part = self.session.part
        with transaction(self.session.document, text):
            obj = ensure_object(self.session.document, Kind.SEAMS)
            set_data(obj, "Edits", self.decisions)
            set_data(obj, "SeamOptions", self.options)
            set_data(obj, "Seams", {name: result[name] for name in ("seams", "members", "notes") if name in result})
            if part is not None:
                obj.PartFrame = part.frame
                obj.PartHash = part.hash
        self.forget_pending()

    def forget_pending(self) -> None:
        """Forget decisions that wpcal has not answered: the document has the last word."""
        self._decisions = self._options = None

    def choose_options(self, options: dict[str, Any]) -> None:
        """Search with other options; they are kept when wpcal has answered (`take_seams`)."""
        self._options = {name: value for name, value in options.items() if value not in (None, "", [], False)}

    def drop_unfitting(self, candidates: Sequence[Seam]) -> list[str]:
        """Forget decisions about seams that the part does not have any more, and return their names."""
        fitting = [one for one in self.decisions if any(_is_same(one, seam) for seam in candidates)]
        dropped = [one["candidate"]["name"] for one in self.decisions if one not in fitting]
        self._decisions = fitting
        return dropped

    def forget_decisions(self) -> None:
        """Forget every decision and every named edge; kept when wpcal has answered (`take_seams`)."""
        self._decisions = []
        self._options = {name: value for name, value in self.options.items() if name != ADDED_EDGES}

    # -- deciding ---------------------------------------------------------------------------------------------------

    def edit_of(self, seam: Seam) -> dict[str, Any]:
        """Return what the user decided about a seam; empty if nothing."""
        key = _key(seam)
        return next((dict(one["edit"]) for one in self.decisions if _key(one) == key), {})

    def decide(self, seam: Seam, **changes: Any) -> None:
        """Change decisions about a seam: `accept`, `reject`, `reverse`, `name`. None and False take one back.

        They are kept in the document when wpcal has answered (`take_seams`).
        """
        edit = {**self.edit_of(seam), **changes}
        if changes.get("accept"):
            edit["reject"] = None
        if changes.get("reject"):
            edit["accept"] = None
        edit = {name: value for name, value in edit.items() if value}
        others = [one for one in self.decisions if _key(one) != _key(seam)]
        self._decisions = [*others, {"candidate": seam["candidate"], "edit": edit}] if edit else others

    def weld(self, seam: Seam, is_welded: bool) -> None:
        """Tick a seam or take its tick away."""
        self.decide(seam, **({"accept": True} if is_welded else {"reject": True}))

    def reverse(self, seam: Seam) -> None:
        """Weld a seam in the other direction."""
        self.decide(seam, reverse=not self.edit_of(seam).get("reverse"))

    def seam_on_edge(self, points: Sequence[Vector]) -> Seam | None:
        """Return the candidate along an edge, given by a few points of the edge around the picked one, in the part."""
        for seam in self.seams:
            path = seam["frames"]["p"]
            if all(distance_to_path(point, path) <= SAME_EDGE_MM + _sag(path) for point in points):
                return seam
        return None

    def seam_near(self, point: Vector) -> Seam | None:
        """Return the seam nearest to a place where a face was clicked; None if the click was not meant for a seam.

        A seam on two objects cannot be clicked itself: FreeCAD takes the face before it.
        """
        near = [(distance_to_path(point, seam["frames"]["p"]), number) for number, seam in enumerate(self.seams)]
        if not near:
            return None
        distance, number = min(near)
        corners = [one for seam in self.seams for one in seam["frames"]["p"]]
        size = math.dist(*(tuple(pick(column) for column in zip(*corners)) for pick in (min, max)))
        return self.seams[number] if distance <= NEAR_SHARE * size else None

    def add_edge(self, middle: Vector) -> None:
        """Take an edge, given by a point on it, for a seam beside those that are found."""
        named, place = self.options.get(ADDED_EDGES) or [], ",".join(f"{x:.4f}" for x in middle)
        self._options = {**self.options, ADDED_EDGES: [*named, *([] if place in named else [place])]}


def distance_to_path(point: Sequence[float], path: Sequence[Sequence[float]]) -> float:
    """Return the distance of a point to a polyline, mm."""
    if len(path) == 1:
        return math.dist(point, path[0])
    return min(_distance_to_segment(point, a, b) for a, b in zip(path, path[1:]))


def _distance_to_segment(point: Sequence[float], a: Sequence[float], b: Sequence[float]) -> float:
    along = [y - x for x, y in zip(a, b)]
    whole = sum(x * x for x in along)
    share = sum((p - x) * d for p, x, d in zip(point, a, along)) / whole if whole else 0.0
    share = min(1.0, max(0.0, share))
    return math.dist(point, [x + share * d for x, d in zip(a, along)])


def _sag(path: Sequence[Sequence[float]]) -> float:
    """Return how far a curve can leave the chords between its points, mm: by its turn from chord to chord.

    A larger turn is a corner, not a curve.
    """
    largest = 0.0
    for a, b, c in zip(path, path[1:], path[2:]):
        first, second = math.dist(a, b), math.dist(b, c)
        if first and second:
            cosine = sum((y - x) * (z - y) for x, y, z in zip(a, b, c)) / (first * second)
            turn = math.acos(max(-1.0, min(1.0, cosine)))
            if turn < LARGEST_TURN:
                largest = max(largest, max(first, second) * math.tan(turn / 4) / 2)
    return largest


def _is_same(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Tell whether two records are about one candidate, as wpcal judges it: by start, middle and length."""
    a, b = one["candidate"], other["candidate"]
    places = [math.dist(a[name], b[name]) for name in ("start_part_mm", "middle_part_mm")]
    return bool(max(*places, abs(a["length_mm"] - b["length_mm"])) <= SAME_CANDIDATE_MM)


def _key(record: dict[str, Any]) -> str:
    return json.dumps(record["candidate"], sort_keys=True)
