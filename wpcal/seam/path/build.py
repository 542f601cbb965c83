"""From pieces of edges to seams: chained, directed, measured, with frames."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.chain import SAME_POINT_MM, Bridges, chain_pieces, groups
from wpcal.seam.find.duplicates import outward
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.limits import LEAST_CANDIDATE_MM
from wpcal.seam.options import SeamOptions
from wpcal.seam.path.corners import SHARP_RAD, turn_corners, turns
from wpcal.seam.path.cut import spans_of
from wpcal.seam.path.direction import Runs, directed_runs
from wpcal.seam.path.discretise import discretise, run_lengths
from wpcal.seam.path.turning import limit_turn
from wpcal.seam.pieces import solids_of
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, SeamSource

CLOSED_MM = 1e-6  #: A run whose end is this near to its start is closed.


def build_seams(graph: BrepGraph, joined: JoinedPieces, options: SeamOptions, source: SeamSource) -> list[Seam]:
    """Chain pieces between the same solids with the same weld into seams of at least `LEAST_CANDIDATE_MM`.

    Returns: list of Seam. Without names, not judged yet. The joint of a seam is the one with the largest share of its
    length.
    """
    pieces = joined.pieces
    if len(pieces) == 0:
        return []
    solids = solids_of(graph, pieces)
    keys = [(*pair, weld) for pair, weld in zip(solids.tolist(), joined.weld, strict=True)]
    bridges = None
    if source is SeamSource.CONTACT:  # contacts are joined across interruptions
        side = np.stack([outward(graph, pieces, t) for t in (pieces.t0, pieces.t1)], axis=1)
        bridges = Bridges(options.join_mm, options.gap_for(graph), side)
    chains = chain_pieces(graph, pieces, groups(keys), split_rad=options.split_rad, bridges=bridges)
    runs = directed_runs(graph, pieces, chains)
    frames, lengths, closed = measured(graph, runs, np.array([chain.closed for chain in chains], dtype=bool), options)
    of_piece = run_lengths(graph, Runs(pieces, np.arange(len(pieces) + 1)))
    seams = []
    for number, chain in enumerate(chains):
        row = int(chain.rows[0])
        if lengths[number] < LEAST_CANDIDATE_MM:
            continue
        seams.append(
            Seam(
                name="",
                joint=_longest_joint(joined, chain.rows, of_piece),
                weld=joined.weld[row],
                solids=tuple(graph.solid_names[i] for i in dict.fromkeys(solids[row].tolist()) if i >= 0),
                pieces=runs.run(number),
                closed=bool(closed[number]),
                length_mm=float(lengths[number]),
                reachable=True,
                accepted=True,
                reasons=_bridge_words(graph, runs.run(number)),
                frames=frames[number],
                source=source,
            )
        )
    return seams


def _bridge_words(graph: BrepGraph, run: SeamPieces) -> tuple[str, ...]:
    """Say where a seam was joined across interruptions, for people."""
    if len(run) == 1:
        return ()
    starts, ends = spans_of(graph, run)
    bridges = starts[1:] - ends[:-1]
    bridges = bridges[bridges > SAME_POINT_MM]  # pieces that meet are apart by round-off
    if len(bridges) == 0:
        return ()
    count = "an interruption" if len(bridges) == 1 else f"{len(bridges)} interruptions"
    return (f"joined in a straight line across {count} of up to {bridges.max():.1f} mm",)


def measured(
    graph: BrepGraph, runs: Runs, closed: BoolArray, options: SeamOptions
) -> tuple[list[SeamFrames], FloatArray, BoolArray]:
    """Return the frames and the length of every run, and whether it is closed.

    Returns `frames`: list of SeamFrames, length n.
    Returns `length_mm`: ndarray, shape (n,).
    Returns `closed`: ndarray of bool, shape (n,).

    `closed`: shape (n,). Runs that are known to be closed; those whose ends meet without a corner are closed as well.
    """
    p0, p1 = runs.ends(graph)
    apart = np.linalg.norm(p1 - p0, axis=1)
    met = np.flatnonzero(~closed & (apart <= CLOSED_MM))
    closed = closed & (apart <= SAME_POINT_MM)  # a bridge does not close a seam
    closed[met] = turns(graph, runs.pieces, runs.start[met + 1] - 1, runs.start[met]) <= SHARP_RAD
    stations = discretise(graph, runs, options.steps)
    stations, frames = limit_turn(graph, runs.pieces, stations, options.steps.turn_rad)
    stations, frames = turn_corners(graph, runs, stations, frames)
    own = [frames.select(slice(*ends)) for ends in pairwise(stations.start.tolist())]
    looped = [_closed(rows) if loop else rows for rows, loop in zip(own, closed.tolist(), strict=True)]
    return looped, run_lengths(graph, runs), closed


def with_frames(graph: BrepGraph, seams: Sequence[Seam], options: SeamOptions) -> list[Seam]:
    """Return seams with new lengths and frames, computed from their pieces, all at once."""
    if len(seams) == 0:
        return []
    runs = Runs.of([seam.pieces for seam in seams])
    frames, lengths, _ = measured(graph, runs, np.array([seam.closed for seam in seams]), options)
    return [
        replace(seam, length_mm=length, frames=own, lean_rad=None)
        for seam, length, own in zip(seams, lengths.tolist(), frames, strict=True)
    ]


def _longest_joint(joined: JoinedPieces, rows: IntArray, length_mm: FloatArray) -> JointType:
    shares: dict[JointType, float] = defaultdict(float)
    for row in rows.tolist():
        shares[joined.joint[row]] += float(length_mm[row])
    return max(shares, key=lambda joint: (shares[joint], joint.value))


def _closed(frames: SeamFrames) -> SeamFrames:
    """Make the last frame of a loop exactly equal to the first."""
    p, R, angle = frames.p.copy(), frames.R.copy(), frames.angle_rad.copy()
    p[-1], R[-1], angle[-1] = p[0], R[0], angle[0]
    return SeamFrames(frames.s_mm, p, R, angle, frames.frame)
