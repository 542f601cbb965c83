"""How the torch leans at every station of a seam so that it meets nothing: straight where it can, tilted where it must.

Straight means along z of the seam's frame. Where a wall or a gusset is in the way of the nozzle, welders tilt the torch
along the seam or across it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.judge.torch_poses import TorchPoses, are_steps_clear, find_solids_met
from wpcal.seam.seam import Seam
from wpcal.seam.torch import USUAL_TORCH

WORK_DEG = (0.0, 15.0, -15.0)
"""Across the seam welders tilt the torch by about 15 degrees before they call a joint unreachable."""
TRAVEL_DEG = (0.0, 20.0, -20.0, 35.0, -35.0)
"""Along the seam 20 degrees are usual. At the end of a seam against a wall the torch leans more: with a nozzle of 22 mm
and a stick-out of 20 mm only 29 degrees reach into the corner, and 35 degrees with a nozzle of 28 mm."""
LEANS_RAD = np.radians(
    sorted(
        ((work, travel) for work in WORK_DEG for travel in TRAVEL_DEG),
        key=lambda lean: (abs(lean[0]) + abs(lean[1]), -lean[1], -lean[0]),
    )
)
"""Work and travel angles that are tried, the smallest first; shape (15, 2)."""
SMALL_LEANS = 5
"""So many leans are straight or tilted one way, by 20 degrees at most. The others are for the ends of a seam: what is
reached only with them from end to end is behind something."""
TIERS = (slice(1, SMALL_LEANS), slice(SMALL_LEANS, len(LEANS_RAD)))
"""Larger leans are tried only where none of the smaller ones is free, and not on a seam on which none of them is."""
STEP_MM = 1.0
"""Step of dense stations: where a free stretch begins or ends is known to this."""
BETWEEN_MM = 2.0
"""Between two stations the torch is felt at this step: less than the thinnest sheet that is welded as a rib."""
TO_OTHER_SIDE_DEG = 36.0
"""A lean that changes by more goes from one side to the other, past whatever stands between."""
TURN_STEP_DEG = 2.5
"""Where the torch goes to the other side, it is felt at this step, however near the stations are."""
APPROACH_MM = 50.0
"""At the ends of a seam the torch comes and goes along the wire by so much, so it is felt that much farther out."""
FELT_WITHIN_MM = USUAL_TORCH.length_mm + APPROACH_MM + 2.0 * USUAL_TORCH.nozzle_radius_mm
"""What is farther from a solid than this in x, y or z is not met by a torch at its seams."""


@dataclass(frozen=True, slots=True, eq=False)
class Felt:
    """What a torch meets along one seam of n stations.

    Parameters
    ----------
    lean_rad : ndarray, shape (n, 2)
        Work and travel angle with which the torch meets nothing; NaN at a station where it always does.
    solid : ndarray of int, shape (n,)
        The solid that a torch meets at a station without a lean; -1 at the others.
    solid_after : ndarray of int, shape (n - 1,)
        The solid that it meets on its way to the next station; -1 if none.
    """

    lean_rad: FloatArray
    solid: IntArray
    solid_after: IntArray

    @property
    def is_free(self) -> bool:
        """Whether the torch gets along the whole seam."""
        return not self.solids

    @property
    def is_held(self) -> bool:
        """Whether the torch meets a solid at every station."""
        return bool((self.solid >= 0).all())

    @property
    def turns_into_a_solid(self) -> bool:
        """Whether the torch meets a solid while it changes its lean."""
        turns = (np.diff(self.lean_rad, axis=0) != 0).any(axis=1)
        return bool((turns & (self.solid_after >= 0)).any())

    @property
    def solids(self) -> frozenset[int]:
        """All solids that a torch meets whatever its lean."""
        found = np.concatenate([self.solid, self.solid_after])
        return frozenset(found[found >= 0].tolist())


def back_directions(R: FloatArray, lean_rad: FloatArray) -> FloatArray:
    """Return the directions from the tip along the wire to a torch that leans.

    Parameters
    ----------
    R : ndarray, shape (n, 3, 3)
        Seam frames.
    lean_rad : ndarray, shape (n, 2) or (2,)
        Work and travel angle.

    Returns
    -------
    ndarray, shape (n, 3)
        In the frame of `R`.
    """
    work, travel = np.moveaxis(np.asarray(lean_rad), -1, 0)
    back = np.stack([-np.sin(travel), -np.cos(travel) * np.sin(work), np.cos(travel) * np.cos(work)], axis=-1)
    return np.asarray(np.einsum("nij,nj->ni", R, np.broadcast_to(back, (len(R), 3))), dtype=np.float64)


def feel_seams(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], *, is_dense: bool = False) -> list[Felt]:
    """Find how a torch leans at every station of seams, and where it meets a solid whatever its lean.

    Parameters
    ----------
    graph, trimmed :
        The part.
    seams : sequence of Seam
        With frames in `part`.
    is_dense : bool
        Whether the stations are so near to each other that each may become the end of a seam: the torch is then felt on
        its approach everywhere, and between stations only where its lean goes to the other side.

    Returns
    -------
    list of Felt
        One per seam. A seam is reached nowhere if none of the small leans (`SMALL_LEANS`) is free at any station.
    """
    if not seams:
        return []
    own, R = _straight(seams, is_dense=is_dense), np.concatenate([seam.frames.R for seam in seams])
    solid = find_solids_met(graph, trimmed, own)
    free = np.zeros((len(own), len(LEANS_RAD)), dtype=bool)
    free[:, 0] = solid < 0
    cuts = np.cumsum([len(seam.frames) for seam in seams])[:-1]
    for tier in TIERS:
        is_felt = ~free.any(axis=1)
        if tier.start >= SMALL_LEANS and not is_dense:
            has_small = np.array([rows.any() for rows in np.split(free, cuts)])
            is_felt &= has_small[own.owner]
        rows = np.flatnonzero(is_felt)
        if len(rows):
            free[rows, tier] = _is_free(graph, trimmed, own.select(rows), R[rows], LEANS_RAD[tier])
    chosen = np.concatenate([_chosen(rows) for rows in np.split(free, cuts)])
    lean = np.where(chosen[:, None] < 0, np.nan, LEANS_RAD[chosen])
    solid = np.where(chosen < 0, solid, -1)
    after = _solids_between(graph, trimmed, own, R, lean, is_dense=is_dense)
    columns = zip(np.split(lean, cuts), np.split(solid, cuts), np.split(after, cuts), strict=True)
    return [Felt(leans, at, between[:-1]) for leans, at, between in columns]


def _is_free(graph: BrepGraph, trimmed: TrimmedFaces, own: TorchPoses, R: FloatArray, leans: FloatArray) -> BoolArray:
    """Tell with which leans the torch meets nothing; shape (n, k)."""
    n, k = len(own), len(leans)
    owner = np.add.outer(np.arange(k) * (own.owner[-1] + 1), own.owner).ravel()
    back = np.concatenate([back_directions(R, lean) for lean in leans])
    p, frames = np.tile(own.p, (k, 1)), np.tile(R, (k, 1, 1))
    poses = TorchPoses(owner, p, back, frames, np.tile(own.start_mm, k), np.tile(own.end_mm, k))
    return np.asarray(find_solids_met(graph, trimmed, poses).reshape(k, n).T < 0, dtype=bool)


def _straight(seams: Sequence[Seam], *, is_dense: bool) -> TorchPoses:
    """Return the straight torch at all stations of seams."""
    counts = [len(seam.frames) for seam in seams]
    end = np.full(sum(counts), USUAL_TORCH.length_mm)
    last = np.cumsum(counts) - 1
    end[slice(None) if is_dense else np.concatenate([last, last - np.array(counts) + 1])] += APPROACH_MM
    p = np.concatenate([seam.frames.p for seam in seams])
    R = np.concatenate([seam.frames.R for seam in seams])
    start = np.repeat([start_mm(seam) for seam in seams], counts)
    return TorchPoses(np.repeat(np.arange(len(seams)), counts), p, R[:, :, 2], R, start, end)


def _chosen(free: BoolArray) -> IntArray:
    """Choose a lean per station, -1 where none is free: small leans, and small changes from station to station."""
    chosen = np.where(free.any(axis=1), 0, -1)
    held = np.flatnonzero(~free[:, 0] & free.any(axis=1))
    for run in np.split(held, np.flatnonzero(np.diff(held) > 1) + 1):
        if len(run) == 0:
            continue
        size = np.abs(LEANS_RAD).sum(axis=1)
        change = np.abs(LEANS_RAD[:, None] - LEANS_RAD).sum(axis=2)
        cost = np.where(free[run[0]], size, np.inf)
        came = []
        for row in run[1:].tolist():
            total = cost[:, None] + change
            came.append(total.argmin(axis=0))
            cost = np.where(free[row], total.min(axis=0) + size, np.inf)
        best = int(np.argmin(cost))
        for row, before in zip(run[:0:-1].tolist(), reversed(came), strict=True):
            chosen[row] = best
            best = int(before[best])
        chosen[run[0]] = best
    return chosen


def _solids_between(
    graph: BrepGraph, trimmed: TrimmedFaces, own: TorchPoses, R: FloatArray, lean_rad: FloatArray, *, is_dense: bool
) -> IntArray:
    """Return the solid that the torch meets between each station and the next, -1 for none; shape (n,).

    Between stations that are near to each other it is felt only where it goes to the other side.
    """
    n = len(own)
    back = back_directions(R, np.nan_to_num(lean_rad))
    end_mm = np.minimum(own.end_mm, USUAL_TORCH.length_mm)
    leant = TorchPoses(own.owner, own.p, back, own.R, own.start_mm, end_mm)
    after = np.full(n, -1)
    held = ~np.isnan(lean_rad[:, 0])
    joined = np.append((own.owner[1:] == own.owner[:-1]) & held[1:] & held[:-1], False)
    step = np.linalg.norm(np.diff(own.p, axis=0, append=own.p[-1:]), axis=1)
    turn_deg = np.degrees(np.abs(np.diff(np.nan_to_num(lean_rad), axis=0, append=0)).max(axis=1))
    far = np.zeros(n, dtype=bool) if is_dense else step > BETWEEN_MM
    rows = np.flatnonzero(joined & (far | (turn_deg > TO_OTHER_SIDE_DEG)) & ~are_steps_clear(graph, trimmed, leant))
    counts = np.ceil(np.maximum(step[rows] / BETWEEN_MM, turn_deg[rows] / TURN_STEP_DEG)).astype(int) - 1
    at = np.repeat(rows, counts)
    number = np.arange(len(at)) - np.repeat(np.cumsum(counts) - counts, counts) + 1
    share = (number / np.repeat(counts + 1, counts))[:, None]
    p = own.p[at] + share * (own.p[at + 1] - own.p[at])
    way = back[at] + share * (back[at + 1] - back[at])
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    between = TorchPoses(own.owner[at], p, way, own.R[at], leant.start_mm[at], leant.end_mm[at])
    met = find_solids_met(graph, trimmed, between, is_between=True)
    bad = np.flatnonzero(met >= 0)
    after[at[bad]] = met[bad]
    return after


def with_leans(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam]) -> tuple[Seam, ...]:
    """Return seams of which all that are accepted have the torch's leans."""
    rows = [row for row, seam in enumerate(seams) if seam.accepted and seam.lean_rad is None]
    found = dict(zip(rows, feel_seams(graph, trimmed, [seams[row] for row in rows]), strict=True))
    return tuple(
        replace(seam, lean_rad=found[row].lean_rad) if row in found else seam for row, seam in enumerate(seams)
    )
