"""The weld seams of a part: all searches together, then paths with frames, then names and judgement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray
from wpcal.core.process import give_memory_back
from wpcal.seam.chain import rounded_places
from wpcal.seam.copies import CopiedSeams
from wpcal.seam.edit import candidates_of
from wpcal.seam.find.bead_bodies import as_drawn
from wpcal.seam.find.concave import find_concave_edges
from wpcal.seam.find.contact import candidate_pairs, find_edge_contacts
from wpcal.seam.find.covered import count_solids
from wpcal.seam.find.duplicates import sections_beside, without_duplicates
from wpcal.seam.find.flare_grooves import FlareGrooves
from wpcal.seam.find.flush_sides import find_flush_sides
from wpcal.seam.find.inner_joints import with_inner_joints
from wpcal.seam.find.joint import JoinedPieces, join_contacts
from wpcal.seam.find.line_contacts import find_line_gaps, with_line_contacts
from wpcal.seam.find.marked import MarkedEdges, in_words, take_marked
from wpcal.seam.find.play import with_play
from wpcal.seam.find.root_gaps import find_root_gaps, find_slits
from wpcal.seam.find.strips import drawn_beads, find_strips
from wpcal.seam.find.wide_gaps import find_wide_gaps
from wpcal.seam.judge.evidence import Judge, judge_seams
from wpcal.seam.judge.hiding import with_hiding
from wpcal.seam.judge.other_joints import doubt_what_fixes_bolts, doubt_what_is_buried, doubt_what_is_left
from wpcal.seam.judge.short_ends import with_short_ends
from wpcal.seam.judge.stretches import cut_at_material
from wpcal.seam.judge.unreached import cut_where_unreached, with_reach
from wpcal.seam.judge.wrapping import weld_round_corners
from wpcal.seam.limits import WIDE_GAPS
from wpcal.seam.member.mitred import find_mitres
from wpcal.seam.member.one_piece import are_welded_corners, are_weldments
from wpcal.seam.member.said import said_about
from wpcal.seam.options import ConcaveEdges, SeamOptions
from wpcal.seam.path.build import build_seams
from wpcal.seam.path.turning import face_free_space
from wpcal.seam.pieces import solids_of
from wpcal.seam.seam import JointType, Seam, SeamPieces, SeamSource, WeldType


def detect_seams(
    graph: BrepGraph,
    options: SeamOptions | None = None,
    *,
    trimmed: TrimmedFaces | None = None,
    sections: SeamPieces | None = None,
    beads: JoinedPieces | None = None,
    flares: FlareGrooves | None = None,
    marked: MarkedEdges | None = None,
) -> tuple[Seam, ...]:
    """Find the weld seams of a part.

    Returns tuple of Seam. Cut where they go through another solid. Named ``W1``, ``W2``, … by the place of their start
    (x, then y, then z), added edges last, with frames in `part`; the same in every run. Rejected candidates are
    included, with the reasons (`Seam.against`).
    """
    options = options or SeamOptions()
    trimmed = trimmed or TrimmedFaces.of(graph)
    options = with_play(graph, trimmed, options)
    found = find_seam_candidates(trimmed, options, sections=sections, beads=beads, flares=flares, marked=marked)
    return judge_candidates(graph, CopiedSeams(tuple(found)), options, trimmed=trimmed)


def find_seam_candidates(
    trimmed: TrimmedFaces,
    options: SeamOptions,
    *,
    sections: SeamPieces | None = None,
    beads: JoinedPieces | None = None,
    flares: FlareGrooves | None = None,
    marked: MarkedEdges | None = None,
) -> list[Seam]:
    """Find the candidates of a part, cut where they go through another solid; not judged yet, without names.

    Parameters and order of the searches as in `detect_seams`.
    """
    graph = trimmed.graph
    gap_mm = options.gap_for(graph)
    drawn = drawn_beads(graph, find_strips(graph, trimmed, min_length_mm=options.min_edge_mm))
    edge, face = candidate_pairs(graph, trimmed, gap_mm)
    is_search = marked is None or marked.is_added
    if is_search:
        solids = np.stack([graph.edge_solid[edge], graph.face_solid[face]], axis=1)
        counts = count_solids(graph, trimmed, solids).all(axis=1)
        edge, face = edge[counts], face[counts]
    touching = find_edge_contacts(graph, trimmed, gap_mm=gap_mm, pairs=(edge, face))
    joined = join_contacts(graph, trimmed, touching, gap_mm=gap_mm)
    joined = without_duplicates(graph, joined, gap_mm=gap_mm)
    joined = with_line_contacts(graph, trimmed, touching, joined, gap_mm=gap_mm)
    contacts, found = joined, []
    if marked is not None:
        chosen, labels, contacts = take_marked(graph, trimmed, joined, marked, gap_mm=gap_mm)
        found += _marked_seams(graph, chosen, labels, options, marked.source)
    found += build_seams(graph, contacts, options, SeamSource.CONTACT)
    if sections is not None:
        beside = sections_beside(graph, sections, joined, gap_mm=gap_mm)
        n = len(beside)
        crossing = JoinedPieces(beside, (JointType.TEE,) * n, (WeldType.FILLET,) * n)
        found += build_seams(graph, crossing, options, SeamSource.SECTION)
        flush = find_flush_sides(graph, trimmed, sections, gap_mm=gap_mm)
        found += build_seams(graph, flush, options, SeamSource.SECTION)
    if options.concave is not ConcaveEdges.NEVER:
        concave, mitres = _inside_solids(graph, trimmed, marked, options, drawn)
        concave = with_inner_joints(graph, trimmed, concave)
        found += build_seams(graph, concave, options, SeamSource.CONCAVE)
        found += build_seams(graph, mitres, options, SeamSource.MITRE)
    if beads is not None:
        found += build_seams(graph, with_inner_joints(graph, trimmed, beads), options, SeamSource.BEAD)
    if flares is not None:
        found += flares.measured(build_seams(graph, flares.joined, options, SeamSource.FLARE))
    if marked is not None and marked.is_added:
        found = [s for s in found if s.source.is_chosen or not np.isin(s.pieces.edge, marked.edge).all()]
    if is_search and options.gap_mm is None:
        found = _with_wide_gaps(graph, trimmed, joined, found, options)
    found = [s for s in found if s.source.is_chosen or count_solids(graph, trimmed, solids_of(graph, s.pieces)).all()]
    found = as_drawn(graph, trimmed, [face_free_space(graph, trimmed, seam) for seam in found], drawn)
    return cut_at_material(graph, trimmed, found, options)


def judge_candidates(
    graph: BrepGraph, found: CopiedSeams, options: SeamOptions, *, trimmed: TrimmedFaces
) -> tuple[Seam, ...]:
    """Judge candidates by what they are and by where a torch gets to them, and name them by their places."""
    has_marks = any(seam.source is SeamSource.MARKED for seam in found.seams)
    judge = Judge.of(graph, trimmed, options, has_marks=has_marks, like=found.alike)
    judged = _reached(graph, trimmed, found.seams, options, judge)
    judged = weld_round_corners(graph, trimmed, judged, options, judge)
    judged = _in_order(judged)
    candidates = candidates_of(graph, judged, [f"W{number}" for number in range(1, len(judged) + 1)])
    told = [
        replace(seam, name=found_as.name, candidate=found_as, reasons=tuple(str(text) for text in seam.reasons))
        for seam, found_as in zip(judged, candidates, strict=True)
    ]
    return tuple(with_short_ends(graph, trimmed, told, options.judging.level))


def _in_order(seams: list[Seam]) -> list[Seam]:
    """Sort seams by their places. An added edge without a contact comes last: the others keep their names."""
    is_more = [seam.source is SeamSource.ADDED and seam.joint is JointType.UNKNOWN for seam in seams]
    ends = np.array([seam.frames.p[[0, -1]] for seam in seams]).reshape(-1, 6)
    keys = list(zip(is_more, rounded_places(np.round(ends, 3)).tolist(), strict=True))
    return [seams[row] for row in sorted(range(len(seams)), key=keys.__getitem__)]


def _with_wide_gaps(
    graph: BrepGraph, trimmed: TrimmedFaces, joined: JoinedPieces, found: list[Seam], options: SeamOptions
) -> list[Seam]:
    """Add the seams at constant gaps above the usual one, beside which nothing else is, and at root gaps."""
    gap_mm = options.gap_for(graph)
    for times in (1.0, WIDE_GAPS):  # up to twice the usual gap, then up to twice that
        known = SeamPieces.joined([joined.pieces, *(seam.pieces for seam in found)])
        wide = find_wide_gaps(graph, trimmed, known, gap_mm=times * gap_mm, play=options.play or ())
        found = [*found, *build_seams(graph, wide, options, SeamSource.CONTACT)]
    known = SeamPieces.joined([joined.pieces, *(seam.pieces for seam in found)])
    roots = find_root_gaps(graph, trimmed, known, gap_mm=gap_mm)
    lines = find_line_gaps(graph, trimmed, SeamPieces.joined([known, roots.pieces]), gap_mm=gap_mm)
    return [*found, *(seam for own in (roots, lines) for seam in build_seams(graph, own, options, SeamSource.CONTACT))]


def _reached(
    graph: BrepGraph, trimmed: TrimmedFaces, found: Sequence[Seam], options: SeamOptions, judge: Judge
) -> list[Seam]:
    """Judge seams by where a torch gets to them, too; those that are welded otherwise are cut where none does."""
    seams = with_hiding(graph, trimmed, found, options.reach)
    judged = judge_seams(graph, trimmed, seams, options, judge)
    inside = [replace(seam, lean_rad=np.full((len(seam.frames), 2), np.nan)) for seam in judged if seam.inside]
    welded, others = (
        [seam for seam, own in zip(seams, judged, strict=True) if not own.inside and own.accepted == is_welded]
        for is_welded in (True, False)
    )
    give_memory_back()  # a large part takes most where torches are felt
    cut = [piece for pieces in cut_where_unreached(graph, trimmed, welded, options) for piece in pieces]
    give_memory_back()
    left = with_reach(graph, trimmed, others, options.reach)
    reached = [*with_hiding(graph, trimmed, cut, options.reach), *left]
    told = [*inside, *judge_seams(graph, trimmed, reached, options, judge)]
    told = doubt_what_is_buried(judge, doubt_what_fixes_bolts(judge, trimmed, told))
    return doubt_what_is_left(judge, told)


def _marked_seams(
    graph: BrepGraph, chosen: JoinedPieces, labels: tuple[str, ...], options: SeamOptions, source: SeamSource
) -> list[Seam]:
    """Build the seams of marked pieces; their reasons name the marks."""
    label_of = dict(zip(chosen.pieces.edge.tolist(), labels, strict=True))
    seams, gap_mm = build_seams(graph, chosen, options, source), options.gap_for(graph)
    told = [tuple(label_of[edge] for edge in seam.pieces.edge.tolist()) for seam in seams]
    return [
        replace(seam, reasons=in_words(graph, seam.pieces, own, gap_mm=gap_mm))
        for seam, own in zip(seams, told, strict=True)
    ]


def _inside_solids(
    graph: BrepGraph, trimmed: TrimmedFaces, marked: MarkedEdges | None, options: SeamOptions, drawn: BoolArray
) -> tuple[JoinedPieces, JoinedPieces]:
    """Return the concave edges inside solids that are candidates by themselves, and the mitres of tubes.

    `drawn`: shape (F,). The faces of modelled beads, whose edges are none.
    """
    concave = find_concave_edges(graph, but=drawn, min_length_mm=options.min_edge_mm)
    wall, base, gap_mm = concave.pieces.wall, concave.pieces.base, options.gap_for(graph)
    solids, own = np.unique(graph.face_solid[wall]), np.ones(len(wall), dtype=bool)
    if options.concave is ConcaveEdges.AUTO:
        solids = solids[are_weldments(graph, trimmed, solids, gap_mm)]
        own = are_welded_corners(graph, trimmed, wall, base, gap_mm)
        own |= said_about(graph, trimmed, options.judging).are_joints(wall, base)
    searched = np.isin(np.arange(len(graph.solid_names)), solids)
    mitres = find_mitres(graph, trimmed, solids)
    left_out = mitres.pieces.edge
    if marked is not None:
        mitres = mitres.select(np.flatnonzero(~np.isin(mitres.pieces.edge, marked.edge)))
        left_out = np.union1d(left_out, marked.edge)
    slits = find_slits(graph, trimmed, searched, gap_mm=gap_mm)
    slits = slits.select(np.flatnonzero(~np.isin(slits.pieces.edge, np.union1d(left_out, concave.pieces.edge))))
    concave = concave.select(np.flatnonzero(own & ~np.isin(concave.pieces.edge, left_out)))
    return JoinedPieces.together([concave, slits]), mitres
