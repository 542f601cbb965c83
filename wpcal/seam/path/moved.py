"""Seams of bodies that moved: where two moved faces meet, and the gap that opened between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.meeting import MovedFaces, meet_moved
from wpcal.brep.nearest_on_edges import project_to_edges
from wpcal.brep.surfaces import project_to_faces, unit
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.path.direction import Runs
from wpcal.seam.path.discretise import run_lengths
from wpcal.seam.path.frames import frames_from_normals
from wpcal.seam.seam import Seam, SeamFrames, SeamPieces

LEAST_SIN = 0.02
"""Faces nearer to parallel than 1 degree do not fix the place where they meet; the seam then goes with both bodies."""
MOST_PAIRS = 200_000  #: Frames and pieces that are compared at once: 50 MB.


class BodyMoves(Protocol):
    """Where bodies are, within `part`."""

    def moves_at(self, body: IntArray, p_part: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return from the model to where bodies are at points of them.

        Returns tuple of ndarray, shapes (n, 3, 3) and (n, 3). Turn and shift of the cross-section of each point; mm.

        `body`: ndarray of int, shape (n,). -1: a face that does not move.
        `p_part`: shape (n, 3). In the model, mm.
        """


@dataclass(frozen=True, slots=True, eq=False)
class MovedSeam:
    """A seam after its bodies moved, with what its error depends on."""

    seam: Seam  #: With moved frames, in `part`.
    #: `wall_body`, `base_body`: shape (n,). The bodies of the two faces at every frame; -1: a face that did not move.
    wall_body: IntArray
    base_body: IntArray
    #: `n_wall`, `n_base`: shape (n, 3). Outward normals of the moved faces, in `part`.
    n_wall: FloatArray
    n_base: FloatArray
    #: shape (n, 3). The travel as it turned with the wall: each point lies in the plane across it that goes with the
    #: wall.
    x_wall: FloatArray
    is_met: BoolArray  #: shape (n,). Whether the faces fix the place across the seam.
    #: shape (n,). Between the edge of the one body and the face of the other, mm; negative: they overlap.
    gap_mm: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class StillSeams:
    """Seams of a part before its bodies move, with all that does not depend on the motions: n frames of all seams."""

    graph: BrepGraph
    seams: tuple[Seam, ...]  #: In `part`.
    start: IntArray  #: shape (seams + 1,). The frames of seam i are ``start[i]:start[i + 1]``.
    frames: SeamFrames  #: Of all seams.
    piece: IntArray  #: shape (n,). The piece of the own seam on whose edge each frame lies.
    #: `faces`, `bodies`: shape (2, n). Wall and base at every frame, and their bodies; -1: no body.
    faces: IntArray
    bodies: IntArray
    edge_mm: FloatArray  #: shape (n, 3). Where the edge of the wall is.
    met_mm: FloatArray  #: shape (n, 3). Where the faces of the model meet; NaN where they do not fix the place.

    @classmethod
    def of(cls, graph: BrepGraph, seams: Sequence[Seam], face_body: IntArray) -> StillSeams:
        """Prepare seams; `face_body`, of shape (F,), is the body of every face, -1: it does not move."""
        start = np.concatenate([[0], np.cumsum([len(seam.frames) for seam in seams], dtype=np.int64)])
        frames = SeamFrames.joined([seam.frames for seam in seams])
        piece = _piece_of_each(graph, seams)
        first = np.cumsum([0, *(len(seam.pieces) for seam in seams)])[:-1]
        pieces = SeamPieces.joined([seam.pieces for seam in seams]).select(piece + np.repeat(first, np.diff(start)))
        faces = np.stack([pieces.wall, pieces.base])
        faces = np.where(faces >= 0, faces, faces[::-1])  # a missing face goes with the other
        bodies = np.where(faces >= 0, face_body[faces], -1)
        p, x = frames.p, frames.R[:, :, 0]
        still = [MovedFaces(face, np.tile(np.eye(3), (len(p), 1, 1)), np.zeros((len(p), 3))) for face in faces]
        met = meet_moved(graph, still[0], still[1], p, x, least_sin=LEAST_SIN)
        edge, _ = project_to_edges(graph, pieces.edge, p)
        return cls(graph, tuple(seams), start, frames, piece, faces, bodies, edge, met)

    def moved(self, moves: BodyMoves) -> list[MovedSeam]:
        """Return the seams where their moved faces meet: see `moved_seams`."""
        graph, p, x = self.graph, self.frames.p, self.frames.R[:, :, 0]
        now = [MovedFaces(face, *moves.moves_at(body, p)) for face, body in zip(self.faces, self.bodies, strict=True)]
        with_each = [np.einsum("nij,nj->ni", each.R, p) + each.t for each in now]
        x_each = [np.einsum("nij,nj->ni", each.R, x) for each in now]
        met = meet_moved(graph, now[0], now[1], with_each[0], x_each[0], least_sin=LEAST_SIN)
        is_met = np.asarray(np.isfinite(met + self.met_mm).all(axis=1))
        met_still = np.where(is_met[:, None], self.met_mm, p)
        met = np.where(is_met[:, None], met, (with_each[0] + with_each[1]) / 2.0)

        n_still = [project_to_faces(graph, face, met_still).normal for face in self.faces]
        n_now = [face.feet(graph, met)[1] for face in now]
        x_still = np.where(is_met[:, None], _crossing(n_still, x), x)
        x_now = np.where(is_met[:, None], _crossing(n_now, x_each[0]), unit(x_each[0] + x_each[1]))
        turn = frames_from_normals(x_now, *n_now) @ frames_from_normals(x_still, *n_still).transpose(0, 2, 1)
        # a point that the model has off its faces (root gap, bridge) keeps its place beside them
        moved = met + np.einsum("nij,nj->ni", turn, p - met_still)
        angle = np.arccos(np.clip(np.einsum("ni,ni->n", *n_now), -1.0, 1.0))
        frames = SeamFrames(self.frames.s_mm, moved, turn @ self.frames.R, angle, self.frames.frame)
        edge = np.einsum("nij,nj->ni", now[0].R, self.edge_mm) + now[0].t
        foot, normal = now[1].feet(graph, edge)
        gap = np.einsum("ni,ni->n", edge - foot, normal)
        columns = (*self.bodies, *n_now, x_each[0], is_met, gap)
        found = []
        ends = zip(self.start[:-1].tolist(), self.start[1:].tolist(), strict=True)
        for seam, own in zip(self.seams, [slice(*pair) for pair in ends], strict=True):
            moved_seam = _with_frames(seam, frames.select(own), self.piece[own], gap[own])
            found.append(MovedSeam(moved_seam, *(column[own] for column in columns)))
        return found


def moved_seams(graph: BrepGraph, seams: Sequence[Seam], face_body: IntArray, moves: BodyMoves) -> list[MovedSeam]:
    """Return seams where their moved faces meet.

    A point of a seam lies on an edge of the wall; it stays in the plane that goes with this edge, so that the ends of
    the seam follow the ends of the plate. In this plane it lies where the moved wall and the moved base meet: by
    Newton's method on the surfaces, exact for all that the part has.

    `face_body`: shape (F,). The body of every face; -1: it does not move.

    All frames of all seams are moved at once. Where the same seams are moved again and again, `StillSeams` keeps what
    the motions do not change.
    """
    return StillSeams.of(graph, seams, face_body).moved(moves) if seams else []


def _with_frames(seam: Seam, frames: SeamFrames, piece: IntArray, gap: FloatArray) -> Seam:
    """Return one seam with its moved frames, whose lengths are still those of the model."""
    frames = replace(frames, s_mm=_lengths(seam.frames, frames.p))
    pieces = replace(seam.pieces, gap_mm=_gaps_of_pieces(piece, gap, len(seam.pieces)))
    return replace(seam, frames=frames, pieces=pieces, length_mm=float(frames.s_mm[-1]))


def _lengths(frames: SeamFrames, moved: FloatArray) -> FloatArray:
    """Return the length from the start of the seam to each moved frame, shape (n,): arcs stretch as their chords do."""
    before, after = (np.linalg.norm(np.diff(p, axis=0), axis=1) for p in (frames.p, moved))
    steps = np.where(before > 0.0, np.diff(frames.s_mm) * after / np.where(before > 0.0, before, 1.0), after)
    return np.concatenate([frames.s_mm[:1], frames.s_mm[0] + np.cumsum(steps)])


def _gaps_of_pieces(piece: IntArray, gap: FloatArray, count: int) -> FloatArray:
    """Return the least, mean and largest gap of every piece, shape (k, 3); of one without a frame, those of all."""
    own = [gap[piece == k] if (piece == k).any() else gap for k in range(count)]
    return np.array([(each.min(), each.mean(), each.max()) for each in own])


def _crossing(normals: Sequence[FloatArray], x: FloatArray) -> FloatArray:
    """Return the unit tangents of the curve in which two surfaces cross, in the sense of x, shape (n, 3)."""
    along = np.cross(normals[0], normals[1])
    return unit(np.where((np.einsum("ni,ni->n", along, x) < 0.0)[:, None], -along, along))


def _piece_of_each(graph: BrepGraph, seams: Sequence[Seam]) -> IntArray:
    """Return the piece of its seam on whose edge each frame lies, shape (n,) of all frames."""
    found = [np.zeros(len(seam.frames), dtype=np.int64) for seam in seams]
    several = [i for i, seam in enumerate(seams) if len(seam.pieces) > 1]
    pairs = np.cumsum([len(seams[i].frames) * len(seams[i].pieces) for i in several])
    for block in np.split(several, np.flatnonzero(np.diff(pairs // MOST_PAIRS)) + 1):
        for i, piece in zip(block.tolist(), _nearest_pieces(graph, [seams[i] for i in block.tolist()]), strict=True):
            found[i] = piece
    return np.concatenate(found)


def _nearest_pieces(graph: BrepGraph, seams: Sequence[Seam]) -> list[IntArray]:
    """Return the same for each of a few seams: every frame is compared with all pieces of its own seam."""
    if not seams:
        return []
    frames, count = (
        [len(each) for each in column] for column in zip(*((s.frames, s.pieces) for s in seams), strict=True)
    )
    pieces = SeamPieces.joined([seam.pieces for seam in seams])
    start = np.cumsum([0, *count])
    each = np.concatenate(
        [np.tile(np.arange(a, a + k), n) for a, k, n in zip(start[:-1].tolist(), count, frames, strict=True)]
    )
    at = np.concatenate([np.repeat(seam.frames.p, k, axis=0) for seam, k in zip(seams, count, strict=True)])
    foot, _ = project_to_edges(graph, pieces.edge[each], at)  # of the whole line or circle, also beyond its ends
    ends = [evaluate_edges(graph, pieces.edge, t)[0] for t in (pieces.t0, pieces.t1)]
    way = sum(np.linalg.norm(foot - end[each], axis=1) for end in ends)
    length = run_lengths(graph, Runs(pieces, np.arange(len(pieces) + 1)))
    away = np.linalg.norm(foot - at, axis=1) + np.maximum(way - length[each], 0.0)
    cuts = np.cumsum([n * k for n, k in zip(frames, count, strict=True)])[:-1]
    return [
        np.asarray(np.argmin(own.reshape(-1, k), axis=1)) for own, k in zip(np.split(away, cuts), count, strict=True)
    ]
