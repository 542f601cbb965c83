"""Seams cut where they go through another solid: the free stretches and the stretches inside material as own seams."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam.judge.stations import Stretch, find_stretches
from wpcal.seam.options import SeamOptions
from wpcal.seam.path.build import with_frames
from wpcal.seam.path.cut import cut_run
from wpcal.seam.path.direction import Runs, precedes
from wpcal.seam.path.turning import face_free_space
from wpcal.seam.seam import NamedSolids, Seam, SeamPieces

FELT_CHORD_MM = 0.1
"""Chord error of the path along which material is felt, 1 mm out of the joint, whatever the frames have."""


def cut_at_material(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], options: SeamOptions) -> list[Seam]:
    """Cut seams at the solids that they go through.

    Returns: A seam that is free all along is the same object. The stretches of the others are seams of their own, in
    the order of the seam, with new frames; their lengths add up to its length. Those inside material name the solids
    (`Seam.inside`).
    """
    felt = seams
    if options.steps.chord_mm > FELT_CHORD_MM:
        finer = replace(options, steps=replace(options.steps, chord_mm=FELT_CHORD_MM))
        felt = [face_free_space(graph, trimmed, seam) for seam in with_frames(graph, seams, finer)]
    stretches_of = find_stretches(graph, trimmed, felt)
    cuts = [
        Cut(seam, stretches, _cut_reason(graph, seam, stretches))
        for seam, stretches in zip(seams, stretches_of, strict=True)
        if len(stretches) > 1
    ]
    cut = iter(cut_at(graph, trimmed, cuts, options))
    found = []
    for seam, stretches in zip(seams, stretches_of, strict=True):
        pieces = [(seam, stretches[0])] if len(stretches) == 1 else next(cut)
        found += [_inside(graph, own, stretch) for own, stretch in pieces]
    return found


def _cut_reason(graph: BrepGraph, seam: Seam, stretches: Sequence[Stretch]) -> str:
    solids = frozenset().union(*(stretch.solids for stretch in stretches))
    names = tuple(graph.solid_names[solid] for solid in sorted(solids))
    return NamedSolids(f"cut from a seam of {seam.length_mm:.1f} mm, which goes through {{}}", names)


def _inside(graph: BrepGraph, seam: Seam, stretch: Stretch) -> Seam:
    names = tuple(graph.solid_names[solid] for solid in sorted(stretch.solids))
    return replace(seam, inside=names) if names else seam


@dataclass(frozen=True, slots=True)
class Cut:
    """A seam and where it is cut."""

    seam: Seam
    #: From start to end. In a closed seam the last and the first are joined if both are free, or neither is.
    stretches: Sequence[Stretch]
    reason: str  #: Added to the reasons of each stretch.


def cut_at(
    graph: BrepGraph, trimmed: TrimmedFaces, cuts: Sequence[Cut], options: SeamOptions
) -> list[list[tuple[Seam, Stretch]]]:
    """Make stretches of n seams seams of their own, all at once, length n."""
    parts = [_parts(graph, cut) for cut in cuts]
    framed = with_frames(graph, [part for own in parts for part, _ in own], options)
    faced = iter([face_free_space(graph, trimmed, seam) for seam in framed])
    return [[(next(faced), stretch) for _, stretch in own] for own in parts]


def _parts(graph: BrepGraph, cut: Cut) -> list[tuple[Seam, Stretch]]:
    """Return the stretches of a seam as seams that still have the frames of the whole seam.

    A stretch on the bridge between two pieces has no edge, and is left out.
    """
    seam, stretches = cut.seam, list(cut.stretches)
    runs = [cut_run(graph, seam.pieces, stretch.low_mm, stretch.high_mm) for stretch in stretches]
    if seam.closed and bool(stretches[0].solids) == bool(stretches[-1].solids):
        runs[0] = SeamPieces.joined([runs.pop(), runs[0]])
        last = stretches.pop()
        stretches[0] = replace(stretches[0], solids=stretches[0].solids | last.solids)
    reasons = (*seam.reasons, cut.reason)
    with_edges = [(run, stretch) for run, stretch in zip(runs, stretches, strict=True) if len(run)]
    directed = _directed(graph, [run for run, _ in with_edges])
    return [
        (replace(seam, pieces=pieces, closed=False, reasons=reasons), stretch)
        for pieces, (_, stretch) in zip(directed, with_edges, strict=True)
    ]


def _directed(graph: BrepGraph, runs: list[SeamPieces]) -> list[SeamPieces]:
    """Return open runs that start at the end with the smaller (x, y, z)."""
    p0, p1 = Runs.of(runs).ends(graph)
    return [run.backwards() if flip else run for run, flip in zip(runs, precedes(p1, p0).tolist(), strict=True)]


def in_material_words(seam: Seam) -> str:
    """Say in which solids a stretch is, and where, for people."""
    return f"the wire would be inside {', '.join(seam.inside)}, {place_words(seam)}"


def place_words(seam: Seam) -> str:
    """Say where a seam begins and ends, and how long it is, for people."""
    first, last = (", ".join(f"{value + 0.0:.1f}" for value in p) for p in np.round(seam.frames.p[[0, -1]], 1))
    return f"from ({first}) to ({last}) mm in part coordinates"
