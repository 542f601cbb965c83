"""Choose among the features of a part: by kind, size, solid and place."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.errors import InputError
from wpcal.features.reference import FeatureKind, ReferenceFeature


def choose_features(
    features: Sequence[ReferenceFeature],
    *,
    kinds: Sequence[FeatureKind] = (),
    solid: str | None = None,
    min_diameter_mm: float | None = None,
    near: ArrayLike | None = None,
) -> tuple[ReferenceFeature, ...]:
    """Return the features that fit every given condition.

    Parameters
    ----------
    features : sequence of ReferenceFeature
    kinds : sequence of FeatureKind
        Only these; empty for all.
    solid : str, optional
        Name of the solid; ``*`` and ``?`` stand for any characters and any one.
    min_diameter_mm : float, optional
        Only round features at least this large.
    near : array_like, shape (3,), optional
        A place in `part`, mm: the nearest features come first. Without it the order stays.

    Returns
    -------
    tuple of ReferenceFeature

    Raises
    ------
    InputError
        When a solid's name fits none, or `near` is not three finite numbers.
    """
    if solid is not None and not any(fnmatchcase(feature.solid, solid) for feature in features):
        names = sorted({feature.solid for feature in features})
        raise InputError(f"no solid is called {solid!r}; the part has {', '.join(names) or 'none'}")
    chosen = [
        feature
        for feature in features
        if (not kinds or feature.kind in kinds)
        and (solid is None or fnmatchcase(feature.solid, solid))
        and (min_diameter_mm is None or (feature.diameter_mm or 0.0) >= min_diameter_mm)
    ]
    if near is not None:
        place = np.asarray(near, dtype=np.float64)
        if place.shape != (3,) or not np.isfinite(place).all():
            raise InputError("a place is three numbers x,y,z in mm")
        chosen.sort(key=lambda feature: float(np.linalg.norm(feature.p_mm - place)))
    return tuple(chosen)
