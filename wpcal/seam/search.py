"""The seams of a whole part: every search, once for each group of solids that the part holds several times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.repeats import Firsts, copy_added_edges, find_copies
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, IntArray
from wpcal.core.issue import Issue
from wpcal.seam.copies import CopiedSeams, renumbered
from wpcal.seam.detect import find_seam_candidates, judge_candidates
from wpcal.seam.find.bead import add_beads
from wpcal.seam.find.bead_bodies import without_beads
from wpcal.seam.find.covered import count_solids
from wpcal.seam.find.flare_grooves import FlareGrooves, add_grooves
from wpcal.seam.find.interpenetration import interpenetrating_solids
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.find.marked import MarkedEdges
from wpcal.seam.member.members import are_inside_one
from wpcal.seam.member.one_piece import are_welded_corners
from wpcal.seam.member.said import said_about
from wpcal.seam.options import ConcaveEdges, SeamOptions
from wpcal.seam.path.turning import OPPOSED_REASON
from wpcal.seam.seam import Seam, SeamPieces

Cross: TypeAlias = Callable[[BrepGraph, IntArray], tuple[BrepGraph, SeamPieces | None, tuple[Issue, ...]]]
"""Adds the curves in which pairs of solids meet to a graph: the wider graph, the pieces, and the pairs that failed. The
faces of the pieces have the numbers of the whole part. It is also asked about no pair: nothing is added then."""
Mark: TypeAlias = Callable[[BrepGraph], tuple[BrepGraph, MarkedEdges]]
"""Adds the edges that a person marked to a graph."""


WIRE_ROOM_MM = 10.0
"""Solids farther from a group than the wire is long, and this, are not met where its seams are found."""


@dataclass(frozen=True, slots=True, eq=False)
class PartCandidates:
    """What may be a seam of a part, before anything is judged."""

    trimmed: TrimmedFaces  #: Without beads, its graph with the edges that were added.
    found: CopiedSeams
    issues: tuple[Issue, ...]  #: Pairs of solids that could not be crossed.

    def judged(self, options: SeamOptions) -> tuple[Seam, ...]:
        """Return the seams as `detect_seams` returns them."""
        return judge_candidates(self.trimmed.graph, self.found, options, trimmed=self.trimmed)


@dataclass(frozen=True, slots=True, eq=False)
class _Added:
    """A graph with edges for what is not an edge of the part, and their pieces."""

    graph: BrepGraph
    sections: SeamPieces | None
    beads: JoinedPieces
    flares: FlareGrooves
    issues: tuple[Issue, ...]

    @property
    def pieces(self) -> SeamPieces:
        parts = [self.beads.pieces, self.flares.joined.pieces]
        return SeamPieces.joined(parts if self.sections is None else [self.sections, *parts])

    def find(self, trimmed: TrimmedFaces, options: SeamOptions, marked: MarkedEdges | None = None) -> list[Seam]:
        return find_seam_candidates(
            trimmed, options, sections=self.sections, beads=self.beads, flares=self.flares, marked=marked
        )


def find_part_candidates(
    graph: BrepGraph, trimmed: TrimmedFaces, options: SeamOptions, *, cross: Cross, mark: Mark | None = None
) -> PartCandidates:
    """Find what may be a seam of a part."""
    is_plain = mark is None and not options.judging.members
    once = _once_per_group(graph, trimmed, options, cross) if is_plain else None
    trimmed = without_beads(graph, trimmed)
    if once is not None:
        wide, found = once
        return PartCandidates(trimmed.with_graph(wide), found, ())
    added, marked = _add(graph, trimmed, options, cross), None
    wide = added.graph
    if mark is not None:
        wide, marked = mark(wide)
    trimmed = trimmed.with_graph(wide)
    return PartCandidates(trimmed, CopiedSeams(tuple(added.find(trimmed, options, marked))), added.issues)


def _once_per_group(
    graph: BrepGraph, trimmed: TrimmedFaces, options: SeamOptions, cross: Cross
) -> tuple[BrepGraph, CopiedSeams] | None:
    """Find the candidates of the first of equal groups, and copy them to the others; None if each needs its own search.

    Where the faces of a seam are opposed, its free side depends on the whole part; and a pair that cannot be crossed
    is told of by its own name.
    """
    copies = find_copies(graph, trimmed, within_mm=options.reach.torch.wires_mm[-1] + WIRE_ROOM_MM)
    if not copies:
        return None
    firsts = Firsts.of(graph, copies)

    def cross_firsts(part: BrepGraph, pairs: IntArray) -> tuple[BrepGraph, SeamPieces | None, tuple[Issue, ...]]:
        wider, own, issues = cross(part, pairs)
        if own is None:
            return part, None, issues
        wall, base = (np.searchsorted(firsts.faces, faces) for faces in (own.wall, own.base))
        return wider, replace(own, wall=wall, base=base), issues

    own = without_beads(firsts.graph, TrimmedFaces.of(firsts.graph))
    added = _add(firsts.graph, own, options, cross_firsts)
    found = added.find(own.with_graph(added.graph), options)
    if added.issues or any(text.startswith(OPPOSED_REASON) for seam in found for text in seam.reasons):
        return None
    pieces, known = added.pieces, firsts.graph.edge_count
    solid = np.full(added.graph.edge_count - known, -1)
    new = np.flatnonzero(pieces.edge >= known)
    solid[pieces.edge[new] - known] = added.graph.face_solid[pieces.wall[new]]
    wide, edges, copies = copy_added_edges(graph, firsts, added.graph, solid, copies)
    return wide, CopiedSeams.of(wide, [renumbered(seam, firsts.faces, edges) for seam in found], copies)


def _add(graph: BrepGraph, trimmed: TrimmedFaces, options: SeamOptions, cross: Cross) -> _Added:
    """Add the curves in which solids cross, those beside beads, and those in flare grooves."""
    pairs = interpenetrating_solids(graph, trimmed)
    pairs = pairs[count_solids(graph, trimmed, pairs).all(axis=1)]
    graph, sections, issues = cross(graph, pairs)
    trimmed = trimmed if sections is None else trimmed.with_graph(graph)
    said, gap_mm = said_about(graph, trimmed, options.judging), options.gap_for(graph)

    def may(wall: IntArray, base: IntArray) -> BoolArray:
        return are_welded_corners(graph, trimmed, wall, base, gap_mm) | said.are_joints(wall, base)

    graph, beads = add_beads(graph, trimmed, options, may)

    def are_two(wall: IntArray, base: IntArray) -> BoolArray:
        return may(wall, base) & ~are_inside_one(graph, trimmed, wall, base)

    graph, flares = add_grooves(graph, trimmed, options, None if options.concave is ConcaveEdges.NEVER else are_two)
    return _Added(graph, sections, beads, flares, issues)
