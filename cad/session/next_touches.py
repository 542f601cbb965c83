"""Which features to touch next on a part whose bodies may have moved: with zero touches of a body, too."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cad.session.part import PickPart
from cad.session.rows import Rows
from cad.session.touches import planned_touches
from cad.workpiece.advise_bodies import Advisable, advise_bodies
from cad.workpiece.bodies import BodiesOptions
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.taught.features import ReferenceFeature
from wpcal.touch.moved_advice import HowMany

FIRST_POINTS = 4  #: As many are suggested at first: they hold the whole part. Then one at a time.

SAME_MM = 1e-3  #: A feature this near to a touched point of the model is that point.


def next_for_bodies(
    part: PickPart,
    rows: Rows,
    named: tuple[Sequence[ReferenceFeature], Sequence[ReferenceFeature]],
    choice: BodiesOptions,
    *,
    teaching: TeachingError,
    ball_mm: float,
) -> dict[str, Any]:
    """Choose the features that lower the error of the worst seam most.

    Returns: As of `PickSession.suggest`, and ``touches``: for each feature its body, the seam that it serves, the error
    of this seam before and after, and a sentence.
    """
    have, others = named
    taken = {feature.name for feature in (*have, *others)}
    planned = planned_touches(part, rows, ball_mm)
    touched, points = (None, have) if planned is None else (planned[0], ())
    made = np.zeros((0, 3)) if touched is None else touched.p_base
    free = [
        item
        for item in part.touchables
        if item.feature.kind.is_point
        and item.feature.name not in taken
        and not (np.linalg.norm(made - item.feature.p_mm, axis=1) < SAME_MM).any()
    ]
    accepted = [seam for seam in part.seams if seam.accepted]
    found = advise_bodies(
        Advisable(part.workpiece, accepted, free, points),
        choice,
        teaching=teaching,
        seam_options=part.seam_options,
        touched=touched,
        how_many=HowMany(max(FIRST_POINTS - len(points) - len(made), 1)),
    )
    return {
        "features": [touch.name for touch in found.touches],
        "error_95_mm": found.error_95_mm,
        "seam": found.seam,
        "sigma_mm": teaching.per_axis_mm,
        "touches": [touch.to_record() for touch in found.touches],
    }
