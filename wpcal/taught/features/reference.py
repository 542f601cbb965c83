"""`ReferenceFeature`: a place on the part that a person can find and touch, with a short name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from enum import Enum
from typing import Any

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.issue import Issue

FEATURES_SCHEMA = "wpcal/features/1"


class Touch(Enum):
    """How a feature is touched; the value is shown to people."""

    CORNER = "tip in corner"
    EDGE = "tip on edge"
    RIM = "rim"
    WALL = "wall"
    FACE = "face"
    THREE_FACES = "its three faces"


class FeatureKind(Enum):
    """Kinds of reference features; the value is the first letter of their names."""

    VERTEX = "V"
    CIRCLE = "C"
    HOLE = "H"
    SPHERE = "S"
    EDGE_MIDPOINT = "M"
    BOSS = "B"
    SLOT = "L"
    VIRTUAL_CORNER = "X"
    EDGE_END = "E"
    PLANE = "P"
    AXIS = "A"

    @property
    def word(self) -> str:
        """The kind in words, as in JSON."""
        return self.name.lower()

    @property
    def touch(self) -> Touch:
        """How a feature of this kind is touched."""
        return _TOUCH[self]

    @property
    def is_point(self) -> bool:
        """Whether one touch of a tip, or a tip centred by eye, can take its point."""
        return self in POINT_KINDS


_TOUCH = {
    FeatureKind.VERTEX: Touch.CORNER,
    FeatureKind.CIRCLE: Touch.RIM,
    FeatureKind.HOLE: Touch.RIM,
    FeatureKind.SPHERE: Touch.FACE,
    FeatureKind.EDGE_MIDPOINT: Touch.EDGE,
    FeatureKind.BOSS: Touch.RIM,
    FeatureKind.SLOT: Touch.WALL,
    FeatureKind.VIRTUAL_CORNER: Touch.THREE_FACES,
    FeatureKind.EDGE_END: Touch.EDGE,
    FeatureKind.PLANE: Touch.FACE,
    FeatureKind.AXIS: Touch.WALL,
}
POINT_KINDS = (
    FeatureKind.VERTEX,
    FeatureKind.CIRCLE,
    FeatureKind.HOLE,
    FeatureKind.SPHERE,
    FeatureKind.EDGE_MIDPOINT,
    FeatureKind.BOSS,
    FeatureKind.EDGE_END,
)
"""Kinds to which a taught point without a name may belong. Datum planes and axes are not points; the middle of a slot
and a virtual corner are in the air."""


@dataclass(frozen=True, slots=True)
class HoleStep:
    """One diameter of a hole."""

    diameter_mm: float
    #: `from_mm`, `to_mm`: Where it begins and ends, measured from the entry of the hole.
    from_mm: float
    to_mm: float


class HoleForm(Enum):
    """What a hole looks like along its axis."""

    PLAIN = "plain"
    COUNTERSINK = "countersink"
    COUNTERBORE = "counterbore"  #: More than one diameter.


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceFeature:
    """One feature that can be taught."""

    name: str  #: The letter of its kind and a number, by position within the kind.
    kind: FeatureKind
    p_mm: FloatArray  #: shape (3,). Its point in `part`, mm; for a circle, hole or sphere, the centre.
    #: shape (3,). Unit vector in `part`: out of the entry of a hole, boss or slot; outward from a plane; along a
    #: circle's axis, an axis or an edge.
    direction: FloatArray | None
    diameter_mm: float | None  #: Of a slot, the width.
    solid: str  #: Name of the solid it is on.
    #: The faces of the `BrepGraph` to touch: of a hole or boss, the wall of `diameter_mm`; of a slot, its two round and
    #: two flat walls; of a plane or axis, all faces on it; of a virtual corner, the planes.
    faces: tuple[int, ...] = ()
    #: Of a midpoint, the length of the edge; of a boss or axis, the length along the axis; of a slot, the largest.
    length_mm: float | None = None
    depth_mm: float | None = None  #: Of a hole or slot, from its entry to its end, without the point of a drill.
    area_mm2: float | None = None  #: Of a plane; its curved borders are polylines with a sag of 0.01 mm.
    is_through: bool | None = None  #: Of a hole or slot: whether it is open at both ends.
    form: HoleForm | None = None
    steps: tuple[HoleStep, ...] = ()  #: The diameters of a hole from its entry.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file, without what does not apply to the kind."""
        record: dict[str, Any] = {
            "name": self.name,
            "kind": self.kind.word,
            "p_mm": self.p_mm.tolist(),
            "direction": None if self.direction is None else self.direction.tolist(),
            "diameter_mm": self.diameter_mm,
            "solid": self.solid,
            "touch": self.kind.touch.value,
            "faces": list(self.faces),
        }
        optional = {
            "length_mm": self.length_mm,
            "depth_mm": self.depth_mm,
            "area_mm2": self.area_mm2,
            "is_through": self.is_through,
            "form": None if self.form is None else self.form.value,
            "steps": [[step.diameter_mm, step.from_mm, step.to_mm] for step in self.steps] or None,
        }
        return record | {key: value for key, value in optional.items() if value is not None}


def features_record(
    features: Sequence[ReferenceFeature], ease: Mapping[str, str], issues: Sequence[Issue] = ()
) -> dict[str, Any]:
    """Return the record of ``wpcal features --json``. Of schema ``wpcal/features/1``."""
    records = [{**feature.to_record(), "ease": ease[feature.name]} for feature in features]
    return {"schema": FEATURES_SCHEMA, "features": records, "issues": [issue.to_record() for issue in issues]}


def feature_named(features: Sequence[ReferenceFeature], name: str) -> ReferenceFeature:
    """Return the feature with a name, in upper or lower case.

    Raises `InputError` if there is none. The message gives the nearest names.
    """
    exact = next((feature for feature in features if feature.name == name), None)
    if exact is not None:
        return exact
    by_name = {feature.name.lower(): feature for feature in features}
    found = by_name.get(name.strip().lower())
    if found is None:
        near = [by_name[n].name for n in get_close_matches(name.strip().lower(), by_name, n=3, cutoff=0.3)]
        hint = f"; near: {', '.join(near)}" if near else ""
        raise InputError(f"the part has no feature {name!r}{hint}; `wpcal features` lists them")
    return found


def point_named(features: Sequence[ReferenceFeature], name: str) -> FloatArray:
    """Return the point of the feature with a name, in `part`, mm.

    Raises `InputError` if there is none, or it is a plane or an axis, which one touch does not determine.
    """
    feature = feature_named(features, name)
    if feature.kind in (FeatureKind.PLANE, FeatureKind.AXIS):
        raise InputError(f"{feature.name} is a datum {feature.kind.word}, not a point; name a point of the part")
    return feature.p_mm
