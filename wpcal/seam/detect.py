"""The weld seams of a part: contacts between solids and concave edges inside them, named, in order, with frames."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
from scipy.spatial import cKDTree

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, IntArray
from wpcal.seam.chain import chain_pieces, groups, rounded
from wpcal.seam.concave import find_concave_edges, looks_machined
from wpcal.seam.contact import find_contacts
from wpcal.seam.direction import Runs, directed_runs
from wpcal.seam.discretise import StepOptions, discretise, run_lengths
from wpcal.seam.frames import seam_frames
from wpcal.seam.joint import JoinedPieces, join_contacts
from wpcal.seam.reach import LEAST_FREE, free_share
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType

LARGEST_GAP_MM = 0.5
"""A gap that a fillet of usual size bridges."""
GAP_SHARE = 2.5e-3
"""On parts smaller than 200 mm the gap is this share of the diagonal: 0.5 mm would join everything on a small part."""
REACH_STATIONS = 5
"""Places along a seam at which its reach is felt."""
FULL_TURN_SIN = 1e-6
"""A loop whose end meets its start this nearly is closed."""


class ConcaveEdges(Enum):
    """Whether concave edges inside one solid are taken as seams."""

    ALWAYS = "always"
    NEVER = "never"
    AUTO = "auto"


@dataclass(frozen=True, slots=True)
class SeamOptions:
    """How seams are found and cut into frames.

    Parameters
    ----------
    gap_mm : float, optional
        Largest gap between members; by default 0.5 mm, on parts smaller than 200 mm 0.25 % of their diagonal.
    concave : ConcaveEdges
        `AUTO` takes concave edges of solids that touch no other solid and do not look machined
        (`concave.looks_machined`).
    split_rad : float
        A seam ends where its direction turns by more, rad.
    steps : StepOptions
    """

    gap_mm: float | None = None
    concave: ConcaveEdges = ConcaveEdges.AUTO
    split_rad: float = float(np.radians(30.0))
    steps: StepOptions = field(default_factory=StepOptions)

    def gap_for(self, graph: BrepGraph) -> float:
        """Return the gap to use on a part, mm."""
        return min(LARGEST_GAP_MM, GAP_SHARE * graph.size_mm) if self.gap_mm is None else self.gap_mm


def detect_seams(
    graph: BrepGraph,
    options: SeamOptions | None = None,
    *,
    trimmed: TrimmedFaces | None = None,
    sections: SeamPieces | None = None,
) -> tuple[Seam, ...]:
    """Find the weld seams of a part.

    Parameters
    ----------
    graph : BrepGraph
    options : SeamOptions, optional
    trimmed : TrimmedFaces, optional
        Of the same graph, where a caller has it already.
    sections : SeamPieces, optional
        Curves in which solids that run into each other meet; a CAD kernel computes them.

    Returns
    -------
    tuple of Seam
        Named ``W1``, ``W2``, … by the place of their start (x, then y, then z), with frames in `part`; the same at
        every run. Seams that no torch reaches are there, too, and not accepted.
    """
    options = options or SeamOptions()
    trimmed = trimmed or TrimmedFaces.of(graph)
    gap_mm = options.gap_for(graph)
    joined = join_contacts(graph, trimmed, find_contacts(graph, trimmed, gap_mm=gap_mm), gap_mm=gap_mm)
    joined = _without_twins(graph, joined, gap_mm)
    found = _seams(graph, trimmed, joined, options, "contact of two solids")
    if sections is not None and len(sections):
        n = len(sections)
        crossing = JoinedPieces(sections, (JointType.TEE,) * n, (WeldType.FILLET,) * n)
        found += _seams(graph, trimmed, crossing, options, "section of two solids that run into each other")
    if options.concave is not ConcaveEdges.NEVER:
        concave = _wanted_concave(graph, find_concave_edges(graph), joined, options.concave)
        found += _seams(graph, trimmed, concave, options, "concave edge inside one solid")
    found.sort(key=lambda seam: (rounded(np.round(seam.frames.p[0], 3)), rounded(np.round(seam.frames.p[-1], 3))))
    return tuple(replace(seam, name=f"W{number}") for number, seam in enumerate(found, 1))


def _pick(joined: JoinedPieces, rows: IntArray) -> JoinedPieces:
    joints, welds = [joined.joint[i] for i in rows], [joined.weld[i] for i in rows]
    return JoinedPieces(joined.pieces.select(rows), tuple(joints), tuple(welds))


def _without_twins(graph: BrepGraph, joined: JoinedPieces, gap_mm: float) -> JoinedPieces:
    """Keep one of the pieces that both members claim (edge of A on B, edge of B on A), the fillet before the groove."""
    pieces = joined.pieces
    groove = np.array([weld is not WeldType.FILLET for weld in joined.weld], dtype=bool)
    rank = np.empty(len(pieces), dtype=np.int64)
    rank[np.lexsort((np.arange(len(pieces)), pieces.gap_mm[:, 1], groove))] = np.arange(len(pieces))
    twins = _twins(graph, pieces, near=3.0 * gap_mm)
    better, worse = np.where((rank[twins[:, 0]] < rank[twins[:, 1]])[:, None], twins, twins[:, ::-1]).T
    kept = np.ones(len(pieces), dtype=bool)
    for row in np.lexsort((rank[worse], rank[better])):
        if kept[better[row]]:
            kept[worse[row]] = False
    return _pick(joined, np.flatnonzero(kept))


def _twins(graph: BrepGraph, pieces: SeamPieces, *, near: float) -> IntArray:
    """Return pairs of pieces between the same solids whose middles and ends lie nearer than `near`; shape (k, 2)."""
    if len(pieces) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    start, middle, end = (
        evaluate_edges(graph, pieces.edge, t)[0] for t in (pieces.t0, (pieces.t0 + pieces.t1) / 2, pieces.t1)
    )
    solids = np.sort(np.stack([graph.face_solid[pieces.wall], graph.face_solid[pieces.base]], axis=1), axis=1)
    pairs = cKDTree(middle).query_pairs(near, output_type="ndarray").astype(np.int64)
    i, j = pairs[:, 0], pairs[:, 1]
    along = np.maximum(np.linalg.norm(start[i] - start[j], axis=1), np.linalg.norm(end[i] - end[j], axis=1))
    against = np.maximum(np.linalg.norm(start[i] - end[j], axis=1), np.linalg.norm(end[i] - start[j], axis=1))
    same = (solids[i] == solids[j]).all(axis=1) & (np.minimum(along, against) <= near)
    return np.asarray(pairs[same], dtype=np.int64)


def _wanted_concave(
    graph: BrepGraph, concave: JoinedPieces, contacts: JoinedPieces, choice: ConcaveEdges
) -> JoinedPieces:
    if choice is ConcaveEdges.ALWAYS:
        return concave
    touching = set(graph.face_solid[np.concatenate([contacts.pieces.wall, contacts.pieces.base])].tolist())
    wanted = [solid not in touching and not looks_machined(graph, solid) for solid in range(len(graph.solid_names))]
    solid_of = graph.face_solid[concave.pieces.wall]
    return _pick(concave, np.flatnonzero(np.array(wanted, dtype=bool)[solid_of]))


def _seams(
    graph: BrepGraph, trimmed: TrimmedFaces, joined: JoinedPieces, options: SeamOptions, reason: str
) -> list[Seam]:
    pieces = joined.pieces
    if len(pieces) == 0:
        return []
    solids = np.sort(np.stack([graph.face_solid[pieces.wall], graph.face_solid[pieces.base]], axis=1), axis=1)
    keys = [(*pair, joint, weld) for pair, joint, weld in zip(solids.tolist(), joined.joint, joined.weld, strict=True)]
    chains = chain_pieces(graph, pieces, groups(keys), split_rad=options.split_rad)
    runs = directed_runs(graph, pieces, chains)
    closed = np.array([chain.closed for chain in chains]) | _meet_themselves(graph, runs)
    stations = discretise(graph, runs, options.steps)
    frames, lengths = seam_frames(graph, runs.pieces, stations), run_lengths(graph, runs)
    seams = []
    for number, chain in enumerate(chains):
        row, loop = int(chain.rows[0]), bool(closed[number])
        own = frames.rows(*stations.start[number : number + 2])
        names = tuple(graph.solid_names[i] for i in dict.fromkeys(solids[row].tolist()))
        seams.append(
            Seam(
                name="",
                joint=joined.joint[row],
                weld=joined.weld[row],
                solids=names,
                pieces=runs.run(number),
                closed=loop,
                length_mm=float(lengths[number]),
                reachable=True,
                accepted=True,
                reasons=(reason,),
                frames=_closed(own) if loop else own,
            )
        )
    return _with_reach(graph, trimmed, seams)


def _meet_themselves(graph: BrepGraph, runs: Runs) -> BoolArray:
    p0, p1 = runs.ends(graph)
    return np.asarray(np.linalg.norm(p1 - p0, axis=1) <= FULL_TURN_SIN, dtype=bool)


def _closed(frames: SeamFrames) -> SeamFrames:
    """Let the last frame of a loop equal the first to the bit."""
    p, R, angle = frames.p.copy(), frames.R.copy(), frames.angle_rad.copy()
    p[-1], R[-1], angle[-1] = p[0], R[0], angle[0]
    return SeamFrames(frames.s_mm, p, R, angle, frames.frame)


def _with_reach(graph: BrepGraph, trimmed: TrimmedFaces, seams: list[Seam]) -> list[Seam]:
    at = [np.unique(np.linspace(0, len(seam.frames) - 1, REACH_STATIONS + 2).astype(int)[1:-1]) for seam in seams]
    p = np.concatenate([seam.frames.p[rows] for seam, rows in zip(seams, at, strict=True)])
    R = np.concatenate([seam.frames.R[rows] for seam, rows in zip(seams, at, strict=True)])
    shares = np.split(free_share(graph, trimmed, p, R), np.cumsum([len(rows) for rows in at])[:-1])
    judged = []
    for seam, share in zip(seams, shares, strict=True):
        free = bool(np.median(share) >= LEAST_FREE)
        reason = f"{np.median(share):.0%} of the rays out of the joint are free"
        judged.append(replace(seam, reachable=free, accepted=free, reasons=(*seam.reasons, reason)))
    return judged
