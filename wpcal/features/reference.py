"""`ReferenceFeature`: a point of the part that a person can find and touch, with a name he can say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from enum import Enum
from typing import Any

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError

FEATURES_SCHEMA = "wpcal/features/1"


class FeatureKind(Enum):
    """Kinds of reference features; the value is the letter that their names begin with."""

    VERTEX = "V"
    CIRCLE = "C"
    HOLE = "H"
    SPHERE = "S"
    EDGE_MIDPOINT = "M"

    @property
    def word(self) -> str:
        """The kind in words, as in JSON."""
        return self.name.lower()


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceFeature:
    """One thing that can be taught.

    Parameters
    ----------
    name : str
        Kind's letter and number; numbered within the kind by position.
    kind : FeatureKind
    p_mm : ndarray, shape (3,)
        The point in `part`, mm: of a circle, hole or sphere the centre.
    direction : ndarray, shape (3,), or None
        Unit axis in `part`: of a hole out of its entry, of a circle along its axis, of an edge along it.
    diameter_mm : float or None
    solid : str
        Name of the solid it is on.
    """

    name: str
    kind: FeatureKind
    p_mm: FloatArray
    direction: FloatArray | None
    diameter_mm: float | None
    solid: str

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "name": self.name,
            "kind": self.kind.word,
            "p_mm": self.p_mm.tolist(),
            "direction": None if self.direction is None else self.direction.tolist(),
            "diameter_mm": self.diameter_mm,
            "solid": self.solid,
        }


def features_record(features: Sequence[ReferenceFeature]) -> dict[str, Any]:
    """Return the record of ``wpcal features --json``."""
    return {"schema": FEATURES_SCHEMA, "features": [feature.to_record() for feature in features]}


def feature_named(features: Sequence[ReferenceFeature], name: str) -> ReferenceFeature:
    """Return the feature of a name, whatever its letters' case.

    Raises
    ------
    InputError
        When there is none; with the nearest names.
    """
    by_name = {feature.name.lower(): feature for feature in features}
    found = by_name.get(name.strip().lower())
    if found is None:
        near = [by_name[n].name for n in get_close_matches(name.strip().lower(), by_name, n=3, cutoff=0.3)]
        hint = f"; near: {', '.join(near)}" if near else ""
        raise InputError(f"the part has no feature {name!r}{hint}; `wpcal features` lists them")
    return found
