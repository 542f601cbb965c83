"""The bodies of a part as the record that a person edits: ``bodies.json``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.bodies import BODIES_SCHEMA, BodiesOptions, find_bodies
from cad.workpiece.workpiece import open_workpiece
from wpcal.core.errors import blamed_on
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress

DIGITS = 3  #: Micrometres: centre and size are for a person to recognise a body by.


def list_bodies(
    step: Path, *, cache: AnswerCache = NO_CACHE, progress: Progress = no_progress
) -> tuple[dict[str, Any], tuple[Issue, ...]]:
    """Return the record of the bodies of a STEP file, and what is odd in it. Of the schema ``wpcal/bodies/1``.

    `cache`, `progress`: As in `open_workpiece`.
    Raises `InputError` when the file cannot be read, or the part is one body.
    """
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    with blamed_on(str(step)):
        found = find_bodies(workpiece.trimmed, BodiesOptions())
    low, high = workpiece.trimmed.face_box
    rows = []
    for number, name in enumerate(found.bodies.names):
        faces = np.flatnonzero(found.face_body == number)
        size = high[faces].max(axis=0) - low[faces].min(axis=0)
        tolerance = found.bodies.tolerances[number]
        rows.append(
            {
                "name": name,
                "solids": [name],
                "tack_mm": tolerance.mm,
                "tack_mrad": tolerance.mrad,
                "faces": len(faces),
                "centre_mm": np.round(found.bodies.centroid_part[number], DIGITS).tolist(),
                "size_mm": np.round(size, DIGITS).tolist(),
            }
        )
    return {"schema": BODIES_SCHEMA, "bodies": rows}, workpiece.issues
