"""Short runs across the end of a plate, beside a long seam along it: nobody strikes an arc only for them.

A welder goes on round the corner (a *wrap*, an end return), or stops at the end of the plate. Such a run belongs to the
long seam. What tells it from a short weld is the plate: the run is as long as the plate is thick beside the long seam,
and the plate reaches farther up than that. The end of a tube is open behind the long seam, and a bar that lies flat is
not as high as it is wide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.surfaces import part_across, project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import near_pairs
from wpcal.seam.judge.evidence import weighed
from wpcal.seam.limits import LEAST_CANDIDATE_MM, LEAST_CHANGE_MM, Level
from wpcal.seam.path.cut import places_at
from wpcal.seam.path.direction import Runs
from wpcal.seam.rules import Rule
from wpcal.seam.seam import Seam

MOST_END_MM = 16.0
"""A longer run is a weld by itself. AWS D1.1 counts a fillet weld if it is at least four times as long as its leg, and
most robot welds have legs of 4 mm."""
MOST_END_SHARE = 0.5
"""A run that is longer than this share of the seam beside it is a side of the member, not its end."""
ACROSS_COS = 0.7
"""The run goes along the thickness of the plate if the cosine between the two is above this (45 degrees): plates lean,
and are cut at an angle."""
PLACES = np.array([1.0, 2.0])  #: Where along the long seam the thickness is felt: from its end, in lengths of the run.
INSIDE, OUTSIDE = 0.5, 1.25
"""How deep behind the long seam there is material, and none any more, in lengths of the run."""
LEAST_TURN = 0.35
"""The two faces of a joint face the same way if the sine of the angle between them is below this (20 degrees)."""
LOW, HIGH = 0.15, 1.0
"""How far up the plate this is felt, in lengths of the run: near the joint, and as high as the plate is thick."""


def find_short_ends(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam]) -> IntArray:
    """Find the seams that go across the end of a plate beside a longer one.

    Returns shape (n,). The row of the seam that each one is the end of: an accepted one if there is one, of these the
    longest; -1 for every other seam.
    """
    owner = np.full(len(seams), -1)
    short, beside, end = _pairs(seams)
    kept = _is_across_a_plate(graph, trimmed, seams, short, beside, end)
    ranked = sorted(
        zip(short[kept].tolist(), beside[kept].tolist(), strict=True),
        key=lambda pair: (seams[pair[1]].accepted, seams[pair[1]].length_mm, -pair[1]),
    )
    for row, other in ranked:
        owner[row] = other
    return owner


def with_short_ends(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], level: Level) -> list[Seam]:
    """Return named seams of which those across the end of a plate say whose wraps they are (`Seam.wrap_of`)."""
    owner = find_short_ends(graph, trimmed, seams)
    told = list(seams)
    for row in np.flatnonzero(owner >= 0).tolist():
        seam, of = seams[row], seams[owner[row]].name
        words = f"the short end of {of}: welded with it (--wrap), or left open"
        told[row] = weighed(replace(seam, wrap_of=of), (*seam.findings, Rule.SHORT_END.found(words)), level)
    return told


def _pairs(seams: Sequence[Seam]) -> tuple[IntArray, IntArray, IntArray]:
    """Return pairs of a short and a long seam whose ends are near, and which end of the long one it is (0 or 1)."""
    none = np.zeros(0, dtype=np.int64)
    rows = np.array([row for row, seam in enumerate(seams) if not (seam.closed or seam.inside)], dtype=np.int64)
    if len(rows) == 0:
        return none, none, none
    ends = np.concatenate([seams[row].frames.p[[0, -1]] for row in rows.tolist()])
    near = near_pairs(ends, LEAST_CHANGE_MM)
    near = np.concatenate([near, near[:, ::-1]])
    short, beside = rows[near[:, 0] // 2], rows[near[:, 1] // 2]
    length = np.array([seam.length_mm for seam in seams])
    _, group = np.unique([" + ".join(sorted(seam.solids)) for seam in seams], return_inverse=True)
    marked = np.array([seam.source.is_chosen for seam in seams], dtype=bool)
    fits = (length[short] <= MOST_END_MM) & (length[short] <= MOST_END_SHARE * length[beside])
    fits &= (group[short] == group[beside]) & ~marked[short]
    return short[fits], beside[fits], near[fits, 1] % 2


def _is_across_a_plate(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], short: IntArray, beside: IntArray, end: IntArray
) -> BoolArray:
    """Tell in which pairs the short seam is as long as the plate is thick along the long one; shape (k,)."""
    fits = np.zeros(len(short), dtype=bool)
    if len(short) == 0:
        return fits
    length = np.array([seam.length_mm for seam in seams])
    pair, p, inward, up = _views(graph, seams, short, beside, end, length)
    depth = np.array([[INSIDE, LOW], [OUTSIDE, LOW], [INSIDE, HIGH]]) * length[short][pair, None, None]
    depth = depth[:, None, ..., None]
    q = p[:, :, None] + depth[..., 0, :] * inward[:, :, None] + depth[..., 1, :] * up[:, :, None]
    point, solid = find_solids_around(ExactMaterial(graph, trimmed), q.reshape(-1, 3))
    number = {name: solid for solid, name in enumerate(graph.solid_names)}
    own = np.array([[number[name] for name in (seams[row].solids * 2)[:2]] for row in short.tolist()])[pair]
    inside = np.zeros((2, *q.shape[:3]), dtype=bool)  # of either solid
    for k in (0, 1):
        inside[k].ravel()[point[own[point // (q.shape[1] * q.shape[2]), k] == solid]] = True
    holds = (inside[..., 0] & ~inside[..., 1] & inside[..., 2]).all(axis=2).any(axis=0)
    fits[pair[holds]] = True
    return fits


def _views(
    graph: BrepGraph, seams: Sequence[Seam], short: IntArray, beside: IntArray, end: IntArray, length: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Return how plates may stand along seams: the pairs, shape (v,), places, directions into them, and up along them.

    The last three have the shape (v, places, 3). Either face of the joint may be that of the plate. Where both face the
    same way, as in a butt joint, the plate lies on either side.
    """
    long, run = np.unique(beside, return_inverse=True)
    runs, total = Runs.of([seams[row].pieces for row in long.tolist()]), length[beside][:, None]
    s = np.minimum(PLACES * length[short][:, None], total / 2)
    s = np.where(end[:, None] == 1, total - s, s)
    row, t = places_at(graph, runs, np.repeat(run, len(PLACES)), s.ravel())
    pieces, shape = runs.pieces, (-1, len(PLACES), 3)
    across = np.array([seams[one].frames.p[-1] - seams[one].frames.p[0] for one in short.tolist()])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), LEAST_CANDIDATE_MM)
    pair = np.flatnonzero(((pieces.wall[row] >= 0) & (pieces.base[row] >= 0)).reshape(s.shape).all(axis=1))
    kept = (pair[:, None] * len(PLACES) + np.arange(len(PLACES))).ravel()
    p, slope = evaluate_edges(graph, pieces.edge[row[kept]], t[kept])
    normals = [project_to_faces(graph, face[row[kept]], p).normal for face in (pieces.wall, pieces.base)]
    own, other = np.concatenate(normals), np.concatenate(normals[::-1])
    up = part_across(other, own)
    turn, side = np.linalg.norm(up, axis=1, keepdims=True), np.cross(own, np.tile(slope, (2, 1)))
    turns = (turn > LEAST_TURN).reshape(-1, len(PLACES)).all(axis=1)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.where(turns[:, None, None], (up / np.maximum(turn, LEAST_TURN)).reshape(shape), side.reshape(shape))
    pair, p, inward = np.tile(pair, 2), np.tile(p, (2, 1)).reshape(shape), -own.reshape(shape)
    is_across = (np.abs(np.einsum("kpi,ki->kp", inward, across[pair])) >= ACROSS_COS).all(axis=1)
    one, back = np.flatnonzero(is_across), np.flatnonzero(is_across & ~turns)
    rows = np.concatenate([one, back])
    return pair[rows], p[rows], inward[rows], np.concatenate([up[one], -up[back]])
