"""Choose among the features of a part: by kind, size, solid and place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.taught.features.reference import FeatureKind, ReferenceFeature

Condition: TypeAlias = Callable[[ReferenceFeature], bool]


def choose_features(
    features: Sequence[ReferenceFeature],
    *,
    kinds: Sequence[FeatureKind] = (),
    solid: str | None = None,
    min_diameter_mm: float | None = None,
    near: ArrayLike | None = None,
) -> tuple[ReferenceFeature, ...]:
    """Return the features that meet every given condition.

    `near`: shape (3,). A place in `part`, mm: the nearest features come first. By default the order is kept.
    Raises `InputError` if no solid has the name, or `near` is not three finite numbers.
    """
    conditions = _conditions(features, kinds, solid, min_diameter_mm)
    chosen = [feature for feature in features if all(holds(feature) for holds in conditions)]
    if near is not None:
        place = _place(near)
        chosen.sort(key=lambda feature: float(np.linalg.norm(feature.p_mm - place)))
    return tuple(chosen)


def _conditions(
    features: Sequence[ReferenceFeature], kinds: Sequence[FeatureKind], solid: str | None, min_diameter_mm: float | None
) -> list[Condition]:
    conditions: list[Condition] = []
    if kinds:
        conditions.append(lambda feature: feature.kind in kinds)
    if solid is not None:
        if not any(fnmatchcase(feature.solid, solid) for feature in features):
            names = sorted({feature.solid for feature in features})
            raise InputError(f"no solid is called {solid!r}; the part has {', '.join(names) or 'none'}")
        conditions.append(lambda feature: fnmatchcase(feature.solid, solid))
    if min_diameter_mm is not None:
        conditions.append(lambda feature: (feature.diameter_mm or 0.0) >= min_diameter_mm)
    return conditions


def _place(near: ArrayLike) -> FloatArray:
    place = np.asarray(near, dtype=np.float64)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise InputError("a place is three finite numbers x,y,z in mm")
    return place
