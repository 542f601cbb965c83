"""The features from which a set is chosen: the easiest to touch that leave a choice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.taught.features.reference import ReferenceFeature
from wpcal.taught.features.touchable import Ease, Touchable
from wpcal.taught.match.places import Places
from wpcal.touch.advise.design import farthest_rows

MOST_PLACES = 400
"""Of larger parts this many features are judged, far from one another: the best sets lie at the outside."""
ON_A_LINE = 1e-3
"""Points whose second spread is a smaller share of the first leave the rotation about their line to chance."""


def easiest_places(candidates: Sequence[Touchable], have: Sequence[ReferenceFeature], points: int) -> Places:
    """Take the easiest features that leave a choice: harder ones only if these are too few or on one line.

    Raises
    ------
    GeometryError : When all features are too few or on one line.
    """
    for ease in Ease:
        places = _places_up_to(ease, candidates, have)
        if len(places.p) >= points and fills_a_plane(places.p):
            return places if len(places.p) <= MOST_PLACES else _farthest(places, have)
    raise GeometryError(
        f"{points} points are asked for, and the part has {len(places.p)} places to touch that are not on one line"
    )


def fills_a_plane(p: FloatArray) -> bool:
    """Tell whether points, shape (n, 3), mm, fix a rotation."""
    if len(p) < 3:
        return False
    spread = np.linalg.svd(p - p.mean(axis=0), compute_uv=False)
    return bool(spread[1] > ON_A_LINE * spread[0])


def _places_up_to(ease: Ease, candidates: Sequence[Touchable], have: Sequence[ReferenceFeature]) -> Places:
    names = {feature.name for feature in have}
    return Places.of([*have, *(c.feature for c in candidates if c.ease <= ease and c.feature.name not in names)])


def _farthest(places: Places, have: Sequence[ReferenceFeature]) -> Places:
    kept = {places.names[k] for k in farthest_rows(places.p, MOST_PLACES)}
    kept |= {places.names[places.holding(feature.name)] for feature in have}
    return Places.of([feature for group in places.features if group[0].name in kept for feature in group])
