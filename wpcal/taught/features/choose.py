"""Choose among the features of a part: by kind, size, solid and place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_numbers
from wpcal.core.options import opt
from wpcal.taught.features.reference import FeatureKind, ReferenceFeature


def _place(text: str) -> tuple[float, ...]:
    try:
        x, y, z = parse_numbers(text)
    except ValueError:
        raise InputError(f"--near: expected x,y,z in mm, got {text!r}") from None
    return x, y, z


@dataclass(frozen=True, slots=True, kw_only=True)
class FeatureChoice:
    """Conditions on features; all hold together."""

    kinds: tuple[FeatureKind, ...] = opt((), "Only these kinds of features.", "--kind", many=True)
    solid: str | None = opt(None, "Only on this solid; * matches any characters.", metavar="NAME")
    min_diameter_mm: float | None = opt(None, "Only round features at least this large.")
    near: tuple[float, ...] | None = opt(
        None, "List the features nearest to this point of the part first.", metavar="X,Y,Z", read=_place
    )

    def holds(self, feature: ReferenceFeature) -> bool:
        """Tell whether a feature is of the kind, on the solid and of the size; `near` decides only on the order."""
        return (
            (not self.kinds or feature.kind in self.kinds)
            and (self.solid is None or fnmatchcase(feature.solid, self.solid))
            and (self.min_diameter_mm is None or (feature.diameter_mm or 0.0) >= self.min_diameter_mm)
        )


def choose_features(features: Sequence[ReferenceFeature], choice: FeatureChoice) -> tuple[ReferenceFeature, ...]:
    """Return the features that meet every given condition; the nearest to `FeatureChoice.near` come first.

    Raises `InputError` if no solid has the name, or the place is not three finite numbers.
    """
    if choice.solid is not None and not any(fnmatchcase(feature.solid, choice.solid) for feature in features):
        names = sorted({feature.solid for feature in features})
        raise InputError(f"no solid is called {choice.solid!r}; the part has {', '.join(names) or 'none'}")
    chosen = [feature for feature in features if choice.holds(feature)]
    if choice.near is not None:
        place = np.asarray(choice.near, dtype=np.float64)
        if place.shape != (3,) or not np.isfinite(place).all():
            raise InputError("a place is three finite numbers x,y,z in mm")
        chosen.sort(key=lambda feature: float(np.linalg.norm(feature.p_mm - place)))
    return tuple(chosen)
