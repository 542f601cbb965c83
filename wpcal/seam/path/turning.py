"""How far frames turn along a seam: more points where they turn fast, and no flips where normals are opposed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.brep.curves import cumulative_length
from wpcal.brep.graph import BrepGraph
from wpcal.brep.rays import START_MM, is_blocked
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.path.discretise import Stations
from wpcal.seam.path.frames import seam_frames
from wpcal.seam.seam import Seam, SeamFrames, SeamPieces

MOST_ROUNDS = 8
"""Bisections of a step: a frame that still turns too far over 1/256 of it turns at a point, not along the seam."""
OPPOSED_RAD = np.pi - np.radians(0.1)
"""Two normals at a larger angle are opposed: their sum is shorter than 1/500, and its direction is round-off."""
OPPOSED_REASON = "the faces are opposed"
"""How a reason about opposed normals begins."""


def limit_turn(
    graph: BrepGraph, pieces: SeamPieces, stations: Stations, turn_rad: float
) -> tuple[Stations, SeamFrames]:
    """Add points where the frame turns by more than a limit between neighbours.

    Parameters
    ----------
    graph : BrepGraph
    pieces : SeamPieces
        Of all runs.
    stations : Stations
    turn_rad : float
        Largest angle of the rotation between neighbouring frames, rad.

    Returns
    -------
    stations : Stations
    frames : SeamFrames
        At these stations.

    Notes
    -----
    At a kink between two pieces the frame turns at one point, and more points do not help. So the turn is measured from
    a station to the end of its own piece.
    """
    frames = seam_frames(graph, pieces, stations)
    for _ in range(MOST_ROUNDS):
        here, t_end, s_end = _steps(graph, pieces, stations)
        ends = Stations(stations.start, stations.piece[here], t_end, s_end)
        turn = rotation_angles(frames.R[here], seam_frames(graph, pieces, ends).R)
        wide = turn > turn_rad
        if not wide.any():
            break
        stations = _halved(graph, pieces, stations, here[wide], t_end[wide])
        frames = seam_frames(graph, pieces, stations)
    return stations, frames


def rotation_angles(R0: FloatArray, R1: FloatArray) -> FloatArray:
    """Return the angles of the rotations from one set of frames to another.

    They follow from the chord, ``|R1 - R0|_F = 2 sqrt(2) sin(angle / 2)``, which is exact for small angles; the trace
    is not.

    Parameters
    ----------
    R0, R1 : ndarray, shape (n, 3, 3)

    Returns
    -------
    ndarray, shape (n,)
        rad.
    """
    chord = np.linalg.norm(R1 - R0, axis=(1, 2)) / (2.0 * np.sqrt(2.0))
    return np.asarray(2.0 * np.arcsin(np.clip(chord, 0.0, 1.0)), dtype=np.float64)


def _steps(graph: BrepGraph, pieces: SeamPieces, stations: Stations) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return all stations but the last of each run, and where on their own piece the step after each of them ends."""
    last = np.zeros(len(stations.t), dtype=bool)
    last[stations.start[1:] - 1] = True
    here = np.flatnonzero(~last)
    same = stations.piece[here + 1] == stations.piece[here]
    t_end = np.where(same, stations.t[here + 1], pieces.t1[stations.piece[here]])
    return here, t_end, stations.s_mm[here + 1]


def _halved(graph: BrepGraph, pieces: SeamPieces, stations: Stations, rows: IntArray, t_end: FloatArray) -> Stations:
    """Put a station in the middle, by parameter, of the steps after `rows`."""
    t = (stations.t[rows] + t_end) / 2
    edge = pieces.edge[stations.piece[rows]]
    ds = [
        abs(cumulative_length(graph, int(e), np.array([a, b]))[-1])
        for e, a, b in zip(edge, stations.t[rows], t, strict=True)
    ]
    s = stations.s_mm[rows] + np.array(ds)
    start = stations.start + np.searchsorted(rows, stations.start)
    piece = np.insert(stations.piece, rows + 1, stations.piece[rows])
    return Stations(start, piece, _inserted(stations.t, rows, t), _inserted(stations.s_mm, rows, s))


def _inserted(values: FloatArray, rows: IntArray, more: FloatArray) -> FloatArray:
    return np.asarray(np.insert(values, rows + 1, more), dtype=np.float64)


def face_free_space(graph: BrepGraph, trimmed: TrimmedFaces, seam: Seam) -> Seam:
    """Turn z towards free space where the normals of the two faces are opposed, and add a reason that says so.

    There is no bisector then, but there are two directions normal to x and to the normals. The direction in which more
    rays leave the part is taken for the whole seam, so the frame does not flip. If both are equal, z points up.

    Parameters
    ----------
    graph, trimmed :
        The part.
    seam : Seam
        With frames in `part`.
    """
    frames = seam.frames
    opposed = frames.angle_rad > OPPOSED_RAD
    if not opposed.any():
        return seam
    x, normal = frames.R[:, :, 0], frames.R[:, :, 2]
    side = np.cross(normal, x)
    free = [_free_count(graph, trimmed, frames.p[opposed], way[opposed]) for way in (side, -side)]
    up = float(side[opposed, 2].sum())
    z = np.where(opposed[:, None], side if (free[0], up) >= (free[1], -up) else -side, normal)
    R = np.stack([x, np.cross(z, x), z], axis=2)
    reason = f"{OPPOSED_REASON} at {opposed.sum()} of {len(frames)} points: z points to the free side there"
    others = tuple(text for text in seam.reasons if not text.startswith(OPPOSED_REASON))
    return replace(seam, frames=replace(frames, R=R), reasons=(*others, reason))


def _free_count(graph: BrepGraph, trimmed: TrimmedFaces, p: FloatArray, z: FloatArray) -> int:
    return int((~is_blocked(graph, trimmed, p + START_MM * z, z)).sum())
