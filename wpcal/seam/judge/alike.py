"""Seams of one shape with the same solids around them: a torch is felt at one of them, for all.

Two seams are alike if their frames are the same but for a motion without a turn, and if the room through which their
torches go is. What is in that room: solids that the part holds several times, by shape and place; of any other solid
the faces, and a plane without an end there counts by its height only, so pads along a plate are alike.
"""

from __future__ import annotations

import hashlib
from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wpcal.brep.boxes import PAIRS, BoxTree
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.mesh import usual_deflection_mm
from wpcal.brep.repeats import solid_shapes
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray, blocks
from wpcal.core.motion import APPROACH_MM
from wpcal.core.process import give_memory_back
from wpcal.seam.judge.torch_poses import FeltPoses

SAME_PLACE_MM = 1e-6  #: What is around two seams lies in the same way if places agree within this.
WIDER = 0.03
"""Share of a torch's length by which its room is wider than the leans at its corners: between two it swings out."""
BULGE_MM = 2.0  #: Between two stations the end of the torch swings out by less.
SLABS = 8  #: Boxes of a room: near the tip it is narrow.
STEEP_RAD = 1.5  #: Leans count as less than a right angle.
OUT_MM = 2.0  #: Where the torch begins is felt a little behind the tip.


@dataclass(frozen=True, slots=True, eq=False)
class Alike:
    """Which of n seams are felt for others."""

    first: IntArray  #: shape (n,). The seam that is felt for each one, or itself.
    solids: dict[int, dict[int, int]]  #: The solid beside a seam, by the one beside its first; by seam.


def find_alike(graph: BrepGraph, trimmed: TrimmedFaces, poses: FeltPoses, leans_rad: FloatArray) -> Alike:
    """Find the seams at which a torch meets the same things.

    `poses`: The straight torch at all stations of the seams; `leans_rad`, shape (k, 2): all its work and travel angles.
    """
    give_memory_back()  # feeling takes much, and so do the rooms
    first = np.flatnonzero(np.diff(poses.owner, prepend=-1))
    kinds = [rows for rows in _same_runs(poses, first) if len(rows) > 1]
    found = Alike(np.arange(len(first)), {})
    if not kinds:
        return found
    rows = np.concatenate(kinds)
    kind = np.repeat(np.arange(len(kinds)), [len(own) for own in kinds])
    ends = np.append(first, len(poses))
    rooms = [_room(graph, poses.select(slice(ends[own[0]], ends[own[0] + 1])), leans_rad) for own in kinds]
    slabs = [np.array(corners) for corners in zip(*rooms, strict=True)]
    places = _Places(trimmed, poses.p[first[rows]], poses.R[first[rows]], slabs, kind)
    may = ~places.hold_curved()
    rows, kind = rows[may], kind[may]
    places = _Places(trimmed, poses.p[first[rows]], poses.R[first[rows]], slabs, kind)
    known: dict[tuple[int, bytes], int] = {}
    beside = []
    for number, (what, solids) in enumerate(places.surroundings()):
        beside.append(solids)
        other = known.setdefault((int(kind[number]), what), number)
        if other != number:
            found.first[rows[number]] = rows[other]
            found.solids[int(rows[number])] = dict(zip(beside[other], solids, strict=True))
    give_memory_back()
    return found


def _same_runs(poses: FeltPoses, first: IntArray) -> list[IntArray]:
    """Return the seams whose stations are the same but for a motion, shape (k,) each."""
    counts = np.diff(first, append=len(poses))
    off = poses.p - np.repeat(poses.p[first], counts, axis=0)
    rest = np.stack([poses.start_mm, poses.more_mm, poses.wire_mm], axis=1)
    columns = _rounded(np.concatenate([off, poses.R.reshape(-1, 9), rest], axis=1))
    like = defaultdict(list)
    for row, (a, b) in enumerate(pairwise([*first.tolist(), len(poses)])):
        like[_digest(columns[a:b])].append(row)
    return [np.array(rows) for rows in like.values()]


def _rounded(values: FloatArray) -> FloatArray:
    """Count in steps of `SAME_PLACE_MM`, in the same array; no zero is negative."""
    values /= SAME_PLACE_MM
    np.round(values, out=values)
    values += 0.0
    return values


def _digest(*rows: NDArray[Any]) -> bytes:
    """Return a key of rows of arrays that stands for all their bytes, which would take much memory."""
    return hashlib.blake2b(b"".join(each.tobytes() for each in rows), digest_size=16).digest()


def _room(graph: BrepGraph, run: FeltPoses, leans_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the corners (k, 3) of boxes through which a torch goes along a seam, in its first frame, mm."""
    torch, far_mm = run.torch, float(run.wire_mm.max()) + run.torch.length_mm - run.torch.wire_mm + APPROACH_MM
    wide = max(2.0 * torch.mouth_mm, 2.0 * torch.nozzle_radius_mm) + usual_deflection_mm(graph.size_mm) + BULGE_MM
    end = far_mm * np.arange(1, SLABS + 1) / SLABS
    low, high = np.full((SLABS, 3), -far_mm), np.full((SLABS, 3), far_mm)
    if torch.neck is None:
        work, travel = np.minimum(np.abs([leans_rad.min(axis=0), leans_rad.max(axis=0)]), STEEP_RAD).T
        beside = [np.minimum(end[:, None] * np.tan(travel) / np.cos(work.max()), far_mm * np.sin(travel))]
        beside += [np.minimum(end[:, None] * np.tan(work), far_mm * np.sin(work))]
        low[:, :2], high[:, :2] = -np.stack(beside, axis=1)[..., 1], np.stack(beside, axis=1)[..., 0]
        low[:, 2], high[:, 2] = end - end[0], end
    grow = wide + WIDER * end[:, None]
    sides = np.stack([low - grow, high + grow])
    corners = np.stack([sides[pick, :, range(3)].T for pick in product((0, 1), repeat=3)], axis=1)
    placed = (run.p - run.p[0])[:, None, None] + np.einsum("nij,ckj->ncki", run.R, corners)
    own = (placed @ run.R[0]).transpose(1, 0, 2, 3).reshape(SLABS, -1, 3)
    return own.min(axis=1) - OUT_MM, own.max(axis=1) + OUT_MM


class _Places:
    """What is in the rooms of seams: rows of a seam, a code of what it is, and its place; and the solid of each."""

    def __init__(
        self, trimmed: TrimmedFaces, p: FloatArray, R: FloatArray, slabs: list[FloatArray], kind: IntArray
    ) -> None:
        self.graph, self.trimmed, self.p = trimmed.graph, trimmed, p
        self.axes, self.kind, self.slabs = R, kind, slabs
        low, high = slabs[0].min(axis=1)[kind], slabs[1].max(axis=1)[kind]
        self.middle = p + np.einsum("nij,nj->ni", R, (low + high) / 2.0)
        reach = np.einsum("nij,nj->ni", np.abs(R), (high - low) / 2.0)
        self.low, self.high = self.middle - reach, self.middle + reach
        self.shape = solid_shapes(self.graph, self.trimmed)
        self.is_lone = np.bincount(self.shape, minlength=len(self.shape))[self.shape] == 1

    def hold_curved(self) -> BoolArray:
        """Tell which rooms hold a curved face of a lone solid: only a seam at the same place would be alike."""
        is_curved = self.is_lone[self.graph.face_solid] & (self.graph.face_kind != SurfaceKind.PLANE)
        return np.isin(np.arange(len(self.p)), self._near(*self.trimmed.face_box, is_curved)[0])

    def surroundings(self) -> list[tuple[bytes, list[int]]]:
        """Return a key of what is around each seam, equal for equal rooms, and the solids there in order."""
        near, copy = self._near(*self.trimmed.solid_boxes, ~self.is_lone)
        copies = near, self.shape[copy], self.trimmed.solid_boxes[0][copy] - self.p[near], copy
        parts = [copies, self._faces()]
        row, code, place, solid = (np.concatenate(column) for column in zip(*parts, strict=True))
        order = np.lexsort((solid, *_rounded(place).T, code, row))
        code, place, solid = code[order], place[order], solid[order]
        ends = np.searchsorted(row[order], np.arange(len(self.p) + 1)).tolist()
        return [(_digest(code[a:b], place[a:b]), solid[a:b].tolist()) for a, b in pairwise(ends)]

    def _faces(self) -> tuple[IntArray, IntArray, FloatArray, IntArray]:
        """Return the faces of solids that the part holds once, and the pieces of the boundaries of planes."""
        graph, trimmed = self.graph, self.trimmed
        row, face = self._near(*trimmed.face_box, self.is_lone[graph.face_solid])
        place = graph.face_frame[face, 0] - self.p[row]
        is_plane = graph.face_kind[face] == SurfaceKind.PLANE
        at, piece, of_piece, ends = self._ends(np.unique(face[is_plane]))
        plane = np.flatnonzero(is_plane)
        normal = graph.face_frame[face[plane], 3]
        place[plane, 1:], place[plane, 0] = 0.0, np.einsum("ki,ki->k", normal, place[plane])
        is_there, on = self._crossed(row[plane], normal, place[plane, 0])
        has_end = np.isin(row * graph.face_count + face, at * graph.face_count + of_piece)[plane]
        asked = np.flatnonzero(is_there & ~has_end)
        own = face[plane[asked]]
        is_there[asked] = trimmed.contains(own, project_to_faces(graph, own, on[asked]).uv)
        kept = np.ones(len(row), dtype=bool)
        kept[plane] = is_there
        row, face, place = row[kept], face[kept], place[kept]
        code = np.concatenate([face, graph.face_count + piece]) + len(self.is_lone)
        solid = graph.face_solid[np.concatenate([face, of_piece])]
        return np.concatenate([row, at]), code, np.concatenate([place, ends]), solid

    def _ends(self, faces: IntArray) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
        """Return the pieces of boundary of `faces`, shape (f,), in rooms: rows, pieces, their faces and places.

        A line that goes on beyond the room has only a place beside itself.
        """
        graph, trimmed = self.graph, self.trimmed
        face = np.repeat(np.arange(graph.face_count), np.diff(trimmed.start))
        p0, p1 = trimmed.p0, trimmed.p1
        row, piece = self._near(np.minimum(p0, p1), np.maximum(p0, p1), np.isin(face, faces))
        p0, p1 = p0[piece], p1[piece]
        place, way = p0 - self.p[row], p1 - p0
        low, high = self.low[row], self.high[row]
        goes_on = ~np.any([((low <= p) & (p <= high)).all(axis=1) for p in (p0, p1)], axis=0)
        goes_on &= graph.edge_kind[trimmed.piece_edge[piece]] == CurveKind.LINE
        along = np.einsum("ki,ki->k", place, way) / np.einsum("ki,ki->k", way, way)
        return row, piece, face[piece], place - np.where(goes_on, along, 0.0)[:, None] * way

    def _crossed(self, row: IntArray, normal: FloatArray, height: FloatArray) -> tuple[BoolArray, FloatArray]:
        """Tell which planes go through rooms, and return a place of each plane in its room; shapes (k,) and (k, 3).

        `height`: shape (k,). Of the planes above the starts of the seams of `row`, mm.
        """
        axes, kind = self.axes[row], self.kind[row]
        own = np.einsum("kij,ki->kj", axes, normal)
        met, on = np.zeros(len(row), dtype=bool), np.zeros((len(row), 3))
        for first, last in zip(*(ends.transpose(1, 0, 2) for ends in self.slabs), strict=True):
            middle, half = (first + last)[kind] / 2.0, (last - first)[kind] / 2.0
            above = height - np.einsum("ki,ki->k", own, middle)
            reach = np.einsum("ki,ki->k", np.abs(own), half)
            new = ~met & (np.abs(above) <= reach)
            on[new] = (middle + (above / reach)[:, None] * np.sign(own) * half)[new]
            met |= new
        return met, self.p[row] + np.einsum("kij,kj->ki", axes, on)

    def _near(self, low: FloatArray, high: FloatArray, are_asked: BoolArray) -> tuple[IntArray, IntArray]:
        """Return pairs of a room and one of the asked boxes with these corners, shape (k, 3), that may meet it."""
        asked = np.flatnonzero(are_asked)
        row, own = BoxTree.of(low[asked], high[asked]).meeting(self.low, self.high)
        box = asked[own]
        met = np.concatenate(
            [self._met(row[some], low[box[some]], high[box[some]]) for some in blocks(len(row), PAIRS)]
        )
        return row[met], box[met]

    def _met(self, row: IntArray, low: FloatArray, high: FloatArray) -> BoolArray:
        """Tell which boxes may be in the rooms of `row`, shape (k,)."""
        middle, half = (low + high) / 2.0 - self.p[row], (high - low) / 2.0
        axes, met = self.axes[row], np.zeros(len(row), dtype=bool)
        at, reach = np.einsum("mij,mi->mj", axes, middle), np.einsum("mij,mi->mj", np.abs(axes), half)
        for first, last in zip(*(ends.transpose(1, 0, 2) for ends in self.slabs), strict=True):
            met |= ((at - reach <= last[self.kind[row]]) & (at + reach >= first[self.kind[row]])).all(axis=1)
        return met
