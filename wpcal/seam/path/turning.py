"""How far frames turn along a seam: more points where they turn fast, and no flips where normals are opposed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.hits import START_MM, is_blocked
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.path.discretise import Stations, lengths_between
from wpcal.seam.path.frames import seam_frames
from wpcal.seam.seam import Seam, SeamFrames, SeamPieces

MOST_ROUNDS = 8
"""Bisections of a step: a frame that still turns too far over 1/256 of it turns at a point, not along the seam."""
OPPOSED_RAD = np.pi - np.radians(0.1)
"""Two normals at a larger angle are opposed: their sum is shorter than 1/500, and its direction is round-off."""
OPPOSED_REASON = "the faces are opposed"  #: How a reason about opposed normals begins.


def limit_turn(
    graph: BrepGraph, pieces: SeamPieces, stations: Stations, turn_rad: float
) -> tuple[Stations, SeamFrames]:
    """Add points where the frame turns by more than a limit between neighbours.

    `turn_rad`: Largest angle of the rotation between neighbouring frames, rad.
    Returns `frames`: SeamFrames. At these stations.

    At a kink between two pieces the frame turns at one point, and more points do not help. So the turn is measured from
    a station to the end of its own piece.
    """
    frames = seam_frames(graph, pieces, stations)
    here = _steps(stations)
    for _ in range(MOST_ROUNDS):
        t_end, R_end = _ends(graph, pieces, stations, frames, here)
        wide = rotation_angles(frames.R[here], R_end) > turn_rad
        if not wide.any():
            break
        rows = here[wide]
        stations, frames = _halved(graph, pieces, stations, frames, rows, t_end[wide])
        first = rows + np.arange(len(rows))
        here = np.stack([first, first + 1], axis=1).ravel()  # the other steps were seen to turn little
    return stations, frames


def rotation_angles(R0: FloatArray, R1: FloatArray) -> FloatArray:
    """Return the angles of the rotations from one set of frames to another, shape (n,), rad.

    They follow from the chord, ``|R1 - R0|_F = 2 sqrt(2) sin(angle / 2)``, which is exact for small angles; the trace
    is not.

    `R0`, `R1`: ndarray, shape (n, 3, 3).
    """
    chord = np.linalg.norm(R1 - R0, axis=(1, 2)) / (2.0 * np.sqrt(2.0))
    return np.asarray(2.0 * np.arcsin(np.clip(chord, 0.0, 1.0)), dtype=np.float64)


def _steps(stations: Stations) -> IntArray:
    """Return all stations but the last of each run: a step begins at each."""
    begins = np.ones(len(stations.t), dtype=bool)
    begins[stations.start[1:] - 1] = False
    return np.flatnonzero(begins)


def _ends(
    graph: BrepGraph, pieces: SeamPieces, stations: Stations, frames: SeamFrames, here: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return where the steps after these stations end on their own pieces, and the rotations of the frames there."""
    t_end, R_end = stations.t[here + 1], frames.R[here + 1]
    leaves = np.flatnonzero(stations.piece[here + 1] != stations.piece[here])
    rows = here[leaves]
    t_end[leaves] = pieces.t1[stations.piece[rows]]
    ends = Stations(np.array([0, len(rows)]), stations.piece[rows], t_end[leaves], stations.s_mm[rows + 1])
    R_end[leaves] = seam_frames(graph, pieces, ends).R
    return t_end, R_end


def _halved(
    graph: BrepGraph, pieces: SeamPieces, stations: Stations, frames: SeamFrames, rows: IntArray, t_end: FloatArray
) -> tuple[Stations, SeamFrames]:
    """Put a station in the middle, by parameter, of the steps after `rows`."""
    t0, t, piece = stations.t[rows], (stations.t[rows] + t_end) / 2, stations.piece[rows]
    s = stations.s_mm[rows] + lengths_between(graph, pieces.edge[piece], t0, t)
    own = seam_frames(graph, pieces, Stations(np.array([0, len(rows)]), piece, t, s))
    columns = [(stations.piece, piece), (stations.t, t), (stations.s_mm, s)]
    columns += [(frames.p, own.p), (frames.R, own.R), (frames.angle_rad, own.angle_rad)]
    all_piece, all_t, all_s, p, R, angle = (np.insert(old, rows + 1, new, axis=0) for old, new in columns)
    start = stations.start + np.searchsorted(rows, stations.start)
    return Stations(start, all_piece, all_t, all_s), SeamFrames(all_s, p, R, angle)


def face_free_space(graph: BrepGraph, trimmed: TrimmedFaces, seam: Seam) -> Seam:
    """Turn z towards free space where the normals of the two faces are opposed, and add a reason that says so.

    There is no bisector then, but there are two directions normal to x and to the normals. The direction in which more
    rays leave the part is taken for the whole seam, so the frame does not flip. If both are equal, z points up.
    """
    frames = seam.frames
    opposed = frames.angle_rad > OPPOSED_RAD
    if not opposed.any():
        return seam
    x, normal = frames.R[:, :, 0], frames.R[:, :, 2]
    side, p = np.cross(normal, x), frames.p[opposed]
    ways = (side[opposed], -side[opposed])
    free = [int((~is_blocked(trimmed, p + START_MM * way, way)).sum()) for way in ways]
    up = float(side[opposed, 2].sum())
    z = np.where(opposed[:, None], side if (free[0], up) >= (free[1], -up) else -side, normal)
    R = np.stack([x, np.cross(z, x), z], axis=2)
    reason = f"{OPPOSED_REASON} at {opposed.sum()} of {len(frames)} points: z points to the free side there"
    others = tuple(text for text in seam.reasons if not text.startswith(OPPOSED_REASON))
    return replace(seam, frames=replace(frames, R=R), reasons=(*others, reason))
