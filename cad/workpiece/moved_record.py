"""What ``calibration.json`` says of bodies that moved: their motions, and the error and the gap of every seam."""

from __future__ import annotations

from typing import Any

import numpy as np

from cad.workpiece.bodies import PartBodies
from cad.workpiece.moved_bodies import MovedWorkpiece, meeting_points
from wpcal.brep.graph import BrepGraph
from wpcal.calibrate.errors.of_bodies import MeetingErrors, gap_errors_mm
from wpcal.seam.path.moved import MovedSeam


def bodies_record(moved: MovedWorkpiece, graph: BrepGraph) -> dict[str, Any]:
    """Return the field ``bodies`` of ``calibration.json``: the terminal, the report and the picker show it."""
    seams = [
        _seam_record(moved, seam, error)
        for seam, error in zip(moved.seams, moved.errors, strict=True)
        if seam.seam.accepted
    ]
    record = moved.bodies.to_record()
    for row, solids in zip(record["bodies"], _solids_of_each(moved.part, graph), strict=True):
        row["solids"] = solids
    return {**record, "gap_limit_mm": moved.gap_limit_mm, "seams": seams}


def _solids_of_each(part: PartBodies, graph: BrepGraph) -> list[list[str]]:
    """Return the names of the solids that move with each body; none for a member of a solid."""
    solids: list[list[str]] = [[] for _ in part.bodies.names]
    for number, name in enumerate(graph.solid_names):
        own = np.unique(part.face_body[graph.face_solid == number])
        if len(own) == 1 and own[0] >= 0:
            solids[int(own[0])].append(name)
    return solids


def _seam_record(moved: MovedWorkpiece, seam: MovedSeam, error: MeetingErrors) -> dict[str, Any]:
    """Return the largest values along a seam; both parts of the error are those of the frame with the largest error."""
    own = moved.bodies_of_seam(seam)
    worst = int(error.total_mm.argmax())
    return {
        "seam": seam.seam.name,
        "bodies": own,
        "never_touched": [name for name in own if name in moved.bodies.untouched],
        "u95_mm": float(error.total_mm[worst]),
        "u95_across_mm": float(error.across_mm.max()),
        "u95_placing_mm": float(error.placing_mm[worst]),
        "u95_unseen_mm": float(error.unseen_mm[worst]),
        "gap_min_mm": float(seam.gap_mm.min()),
        "gap_max_mm": float(seam.gap_mm.max()),
        "gap_u95_mm": float(gap_errors_mm(moved.bodies.fit, meeting_points(seam)).max()),
    }
