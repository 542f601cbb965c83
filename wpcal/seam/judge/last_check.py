"""The last look at accepted seams before they are written: no frame may point into material.

It rests on nothing that decided before: the start of the wire at every frame is asked for the solids around it. This
holds for marked seams and for what a person's edit made of a candidate, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.judge.evidence import weighed
from wpcal.seam.judge.leans import back_directions
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.options import SeamOptions
from wpcal.seam.rules import Rule
from wpcal.seam.seam import Seam, SeamFrames

OFF_END_MM = 0.01  #: The ends are asked this far from the end: a seam may end on the face of a solid.


def refuse_frames_in_material(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], options: SeamOptions
) -> tuple[Seam, ...]:
    """Return seams of which no accepted one points into material: those that do are refused, with the place."""
    rows = [row for row, seam in enumerate(seams) if seam.accepted and len(seam.frames) > 1]
    if not rows:
        return tuple(seams)
    owner, every = _wire_starts([seams[row] for row in rows])
    point, solid = find_solids_around(ExactMaterial(graph, trimmed), every)
    found = list(seams)
    for number in np.unique(owner[point]).tolist():
        own = owner[point] == number
        names = tuple(graph.solid_names[one] for one in np.unique(solid[own]).tolist())
        place = ", ".join(f"{value + 0.0:.1f}" for value in np.round(every[point[own][0]], 1))
        text = f"the wire would point into {', '.join(names)} at ({place}) mm in part coordinates"
        seam = replace(seams[rows[number]], inside=names, reachable=False)
        found[rows[number]] = weighed(
            seam, (*seam.findings, Rule.IN_MATERIAL.found(text)), options.judging.level
        )  # fmt: skip
    return tuple(found)


def _wire_starts(seams: Sequence[Seam]) -> tuple[IntArray, FloatArray]:
    """Return where the wire comes out of the joint at every frame, shape (n, 3), those of the ends a little inward.

    The first is the number of the seam of each, shape (n,).
    """
    counts = np.array([len(seam.frames) for seam in seams])
    frames = SeamFrames.joined([seam.frames for seam in seams])
    lean = [np.zeros((len(seam.frames), 2)) if seam.lean_rad is None else seam.lean_rad for seam in seams]
    start = np.repeat([start_mm(seam) for seam in seams], counts)
    q = frames.p + start[:, None] * back_directions(frames.R, np.nan_to_num(np.concatenate(lean)))
    is_open = np.array([not seam.closed for seam in seams])
    last = np.cumsum(counts) - 1
    inward = q.copy()
    first, last = (last - counts + 1)[is_open], last[is_open]
    for end, inner in ((first, first + 1), (last, last - 1)):
        share = OFF_END_MM / np.maximum(np.abs(frames.s_mm[inner] - frames.s_mm[end]), OFF_END_MM)
        inward[end] = q[end] + np.minimum(share, 0.5)[:, None] * (q[inner] - q[end])
    return np.repeat(np.arange(len(seams)), counts), inward
