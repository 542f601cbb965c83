"""Seams cut where no torch gets to them: the stretches that it reaches, and those at which something is in its way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.judge.hiding import hiding_words
from wpcal.seam.judge.leans import STEP_MM, Felt, FeltAt, at_stations, feel_seams
from wpcal.seam.judge.other_torches import with_other_torches
from wpcal.seam.judge.stations import Stretch
from wpcal.seam.judge.stretches import FELT_CHORD_MM, Cut, cut_at, place_words
from wpcal.seam.judge.way_out import find_closed_in
from wpcal.seam.limits import LEAST_CANDIDATE_MM
from wpcal.seam.options import Reach, SeamOptions
from wpcal.seam.path.build import with_frames
from wpcal.seam.path.turning import face_free_space
from wpcal.seam.seam import NamedSolids, Seam

LEAST_REACHED = 0.5  #: Share of its length that a torch must reach of a seam at which it always leans.
FEW = 5  #: Stations at which a longer wire is tried first.
NO_WAY_OUT = "no way as wide as the nozzle leads from there out of the part"
ROUNDS = 3
"""A stretch gets frames of its own, which differ a little from those at which it was felt, so it is felt again. What is
still not free after this many rounds is refused."""


def cut_where_unreached(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], options: SeamOptions
) -> list[list[Seam]]:
    """Cut seams where no torch gets to them, whatever its lean.

    Returns: A seam that is free all along is one stretch. The torch's leans are in `Seam.lean_rad`; stretches that no
    torch reaches name the solids in its way (`Seam.blocked_by`). Cuts are within `STEP_MM`, on the free side. Where the
    torch reaches every station, but a bar across the joint lets it not pass, two stretches meet. With a chord error
    above `FELT_CHORD_MM` the seam itself is free; the chords between its stations need not be.
    """
    done: list[list[Seam]] = [[] for _ in seams]
    todo = list(enumerate(seams))
    for number in range(ROUNDS):
        felt_once = _felt_once(graph, trimmed, [seam for _, seam in todo], options, is_first=number == 0)
        rows, todo = [row for row, _ in todo], []
        for row, (known, again) in zip(rows, felt_once, strict=True):
            done[row] += known
            todo += [(row, piece) for piece in again]
    left = feel_seams(graph, trimmed, [seam for _, seam in todo], options.reach)
    for (row, seam), felt in zip(todo, left, strict=True):
        done[row].append(_whole(graph, seam, felt))
    found = [_or_nothing(graph, seam, pieces) for seam, pieces in zip(seams, done, strict=True)]
    found = with_other_torches(graph, trimmed, found, options.reach, least_mm=options.min_length_mm)
    return _with_way_out(graph, trimmed, found, options.reach)


def _felt_once(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], options: SeamOptions, *, is_first: bool
) -> list[tuple[list[Seam], list[Seam]]]:
    """Feel seams; return the stretches of each that are known, and those to feel again."""
    found = _felt(graph, trimmed, seams, options.reach, is_first=is_first)
    in_part = [(seam, felt) for seam, felt in found if not (felt.is_free or felt.is_held)]
    divided = iter(_divided(graph, trimmed, in_part, options))
    return [
        ([_whole(graph, seam, felt)], []) if felt.is_free or felt.is_held else next(divided) for seam, felt in found
    ]


def _whole(graph: BrepGraph, seam: Seam, felt: Felt) -> Seam:
    """Return a seam with its leans, or, if it is not free all along, as one that no torch reaches."""
    return felt.lay_on(seam) if felt.is_free else _blocked(graph, seam, felt.solids)


def _divided(
    graph: BrepGraph, trimmed: TrimmedFaces, in_part: Sequence[tuple[Seam, Felt]], options: SeamOptions
) -> list[tuple[list[Seam], list[Seam]]]:
    """Cut seams that a torch reaches in part; return the stretches that are known, and those to feel again, of each."""
    is_coarse = options.steps.chord_mm > FELT_CHORD_MM
    found: dict[int, tuple[list[Seam], list[Seam]]] = {}
    cuts: dict[int, tuple[Seam, Cut]] = {}
    finer = _felt_finer(graph, trimmed, in_part, options)
    for number, ((seam, felt), (dense, solid, after)) in enumerate(zip(in_part, finer, strict=True)):
        if is_coarse and (solid < 0).all() and (after < 0).all():
            found[number] = [felt.lay_on(seam)], []
        else:
            stretches, passed = _stretches(dense.frames.s_mm, solid, after)
            cuts[number] = dense, Cut(seam, stretches, _cut_reason(graph, seam, stretches, passed))
    for number, pieces in zip(cuts, _pieces(graph, trimmed, list(cuts.values()), options), strict=True):
        blocked = [piece for piece in pieces if piece.blocked_by]
        found[number] = blocked, [piece for piece in pieces if not piece.blocked_by]
    return [found[number] for number in range(len(in_part))]


def _with_way_out(graph: BrepGraph, trimmed: TrimmedFaces, found: list[list[Seam]], reach: Reach) -> list[list[Seam]]:
    """Refuse what a torch reaches from inside a closed room only."""
    free = [piece for pieces in found for piece in pieces if not piece.blocked_by]
    closed = {id(free[row]): solids for row, solids in find_closed_in(graph, trimmed, free, reach.torch).items()}
    return [
        [
            _blocked(graph, replace(piece, reasons=(*piece.reasons, NO_WAY_OUT)), closed[id(piece)])
            if id(piece) in closed
            else piece
            for piece in pieces
        ]
        for pieces in found
    ]


def _felt(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], reach: Reach, *, is_first: bool
) -> list[tuple[Seam, Felt]]:
    """Feel seams, those that are not free the first time also with more wire, and return them with that wire.

    A longer wire is taken if the seam is then free from end to end, or if the usual one reaches it nowhere: the
    operator sets one length for a seam. The shortest one that does is taken.
    """
    found = list(zip(seams, feel_seams(graph, trimmed, seams, reach), strict=True))
    wires = reach.torch.wires_mm[1:] if is_first else ()
    held = [row for row, (_, felt) in enumerate(found) if (felt.solid >= 0).any()] if wires else []
    rows = _helped(graph, trimmed, found, held, reach)
    for wire_mm in reversed(wires):  # where the longest one does not help, no other one does
        longer = [replace(seams[row], more_wire_mm=wire_mm - reach.torch.wire_mm) for row in rows]
        better = []
        for row, seam, felt in zip(rows, longer, feel_seams(graph, trimmed, longer, reach), strict=True):
            before = found[row][1]
            if felt.is_free or (before.is_held and not felt.is_held):
                found[row] = (seam, felt)
                better.append(row)
        rows = better
    return found


def _helped(
    graph: BrepGraph, trimmed: TrimmedFaces, found: Sequence[tuple[Seam, Felt]], rows: Sequence[int], reach: Reach
) -> list[int]:
    """Return the rows of seams that the longest wire may help: at a few of the stations that the usual one misses."""
    more_mm = reach.torch.wires_mm[-1] - reach.torch.wire_mm
    missed = [np.flatnonzero(found[row][1].solid >= 0) for row in rows]
    some = [
        replace(at_stations(found[row][0], own, FEW), more_wire_mm=more_mm)
        for row, own in zip(rows, missed, strict=True)
    ]
    felt = feel_seams(graph, trimmed, some, reach, FeltAt.SOME)
    return [
        row for row, one in zip(rows, felt, strict=True) if one.is_free or (found[row][1].is_held and not one.is_held)
    ]


def _or_nothing(graph: BrepGraph, seam: Seam, pieces: list[Seam]) -> list[Seam]:
    """Return the stretches of a seam, or all of it as one that no torch reaches.

    Where the torch can nowhere be straight, and leans to reach less than `LEAST_REACHED`, it only looks in from an end:
    into a tube, or under a cover.
    """
    free = [piece for piece in pieces if not piece.blocked_by]
    is_straight = any((piece.lean_rad == 0).all(axis=1).any() for piece in free if piece.lean_rad is not None)
    if not free or is_straight or sum(piece.length_mm for piece in free) >= LEAST_REACHED * seam.length_mm:
        return pieces
    number = {name: solid for solid, name in enumerate(graph.solid_names)}
    return [_blocked(graph, seam, frozenset(number[name] for piece in pieces for name in piece.blocked_by))]


def with_reach(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], reach: Reach) -> list[Seam]:
    """Return whole seams with the torch's leans; one that the torch reaches nowhere names the solids in its way."""
    found = []
    for seam, felt in zip(seams, feel_seams(graph, trimmed, seams, reach), strict=True):
        leant = felt.lay_on(seam)
        found.append(_blocked(graph, leant, felt.solids) if felt.is_held else leant)
    return found


def _felt_finer(
    graph: BrepGraph, trimmed: TrimmedFaces, held: Sequence[tuple[Seam, Felt]], options: SeamOptions
) -> list[tuple[Seam, IntArray, IntArray]]:
    """Return seams with dense stations, and what a torch meets there.

    At each station it is the solid that it meets whatever its lean, and after each station the solid that it meets
    while it changes its lean; -1 for none.

    Only the steps in which a free stretch begins or ends are felt again; where the torch cannot change its lean, the
    whole seam, since another station may be the better one for it.
    """
    dense = _dense(graph, trimmed, [seam for seam, _ in held], options)
    solids, unsure = [], []
    after = [np.full(len(fine.frames) - 1, -1) for fine in dense]
    for fine, (seam, felt) in zip(dense, held, strict=True):
        step = np.clip(np.searchsorted(seam.frames.s_mm, fine.frames.s_mm, side="right") - 1, 0, len(felt.solid) - 2)
        ends = felt.solid[:-1], felt.solid[1:]
        solids.append(np.maximum(*ends)[step])
        is_mixed = ((ends[0] < 0) != (ends[1] < 0)) | (felt.solid_after >= 0) | felt.turns_into_a_solid
        unsure.append(np.flatnonzero(is_mixed[step]))
    asked = [number for number, rows in enumerate(unsure) if len(rows)]
    parts = [replace(dense[number], frames=dense[number].frames.select(unsure[number])) for number in asked]
    for number, felt in zip(asked, feel_seams(graph, trimmed, parts, options.reach, FeltAt.DENSE), strict=True):
        solids[number][unsure[number]] = felt.solid
        if len(felt.solid) == len(solids[number]):
            after[number] = felt.solid_after
    return list(zip(dense, solids, after, strict=True))


def _dense(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], options: SeamOptions) -> list[Seam]:
    chord_mm, min_step_mm = min(options.steps.chord_mm, FELT_CHORD_MM), min(options.steps.min_step_mm, STEP_MM / 2)
    steps = replace(options.steps, chord_mm=chord_mm, max_step_mm=STEP_MM, min_step_mm=min_step_mm)
    finer = with_frames(graph, seams, replace(options, steps=steps))
    return [face_free_space(graph, trimmed, seam) for seam in finer]


def _pieces(
    graph: BrepGraph, trimmed: TrimmedFaces, cuts: Sequence[tuple[Seam, Cut]], options: SeamOptions
) -> list[list[Seam]]:
    """Return the free and the blocked stretches of seams that were felt at dense stations (the first of each pair)."""
    cut = iter(cut_at(graph, trimmed, [own for _, own in cuts if len(own.stretches) > 1], options))
    found = []
    for dense, own in cuts:
        if len(own.stretches) == 1:  # it is free at stations that are near to each other, or nowhere
            whole = own.stretches[0]
            found.append([_blocked(graph, own.seam, whole.solids) if whole.solids else dense])
        else:
            found.append([_blocked(graph, piece, at.solids) if at.solids else piece for piece, at in next(cut)])
    return found


def _stretches(s_mm: FloatArray, solid: IntArray, solid_after: IntArray) -> tuple[list[Stretch], frozenset[int]]:
    """Divide stations at these lengths into free and blocked stretches.

    Two free stretches meet where the torch cannot change its lean; the solids that keep it from that are returned, too.
    Near the ends of the seam that step is blocked instead.
    """
    turns = np.flatnonzero(solid_after >= 0)
    from_end = np.minimum(s_mm[turns] - s_mm[0], s_mm[-1] - s_mm[turns])
    solid = solid.copy()
    for row in turns[from_end < LEAST_CANDIDATE_MM].tolist():
        solid[row : row + 2] = solid_after[row]
    meets = turns[from_end >= LEAST_CANDIDATE_MM]
    is_free = (solid[:-1] < 0) & (solid[1:] < 0)
    changes = np.flatnonzero(np.diff(is_free)) + 1
    ends = sorted({0, *changes.tolist(), *meets.tolist(), len(s_mm) - 1})
    found: list[Stretch] = []
    for first, last in pairwise(ends):
        low, high = float(s_mm[first]), float(s_mm[last])
        is_short = is_free[first] and high - low < LEAST_CANDIDATE_MM and len(ends) > 2
        solids = _numbers(solid if is_short else solid[first : last + 1])
        if is_short and not solids:
            solids = _numbers(solid_after)
        meet = bool(first in meets and not solids)
        if found and bool(found[-1].solids) == bool(solids) and not meet:
            before = found.pop()
            low, solids = before.low_mm, before.solids | solids
        found.append(Stretch(low, high, solids))
    return found, _numbers(solid_after[meets])


def _numbers(solid: IntArray) -> frozenset[int]:
    return frozenset(solid[solid >= 0].tolist())


def _cut_reason(graph: BrepGraph, seam: Seam, stretches: Sequence[Stretch], passed: frozenset[int]) -> str:
    solids = frozenset().union(*(stretch.solids for stretch in stretches))
    held = [stretch for stretch in stretches if stretch.solids]
    lost = sum(stretch.high_mm - stretch.low_mm for stretch in held)
    places = ", ".join(f"{stretch.low_mm:.1f} to {stretch.high_mm:.1f}" for stretch in held)
    words = f"cut from a seam of {seam.length_mm:.1f} mm"
    if not solids:
        return NamedSolids(f"{words}: no torch passes {{}} without leaving it", _names(graph, passed))
    words = f"{words}, {lost:.1f} mm of which the torch does not reach ({places} mm from the start)"
    return NamedSolids(f"{words}: {{}} is in its way", _names(graph, solids))


def _names(graph: BrepGraph, solids: frozenset[int]) -> tuple[str, ...]:
    return tuple(graph.solid_names[solid] for solid in sorted(solids))


def _blocked(graph: BrepGraph, seam: Seam, solids: frozenset[int]) -> Seam:
    nowhere = np.full((len(seam.frames), 2), np.nan)
    return replace(seam, blocked_by=_names(graph, solids), lean_rad=nowhere, spin_rad=None, more_wire_mm=0.0)


def blocked_words(seam: Seam) -> str:
    """Say what is in the way of a torch at a stretch, and where, for people."""
    names = ", ".join(seam.blocked_by)
    other = seam.other_torch
    better = "" if other is None else f"; {other.name} does, with {other.wire_mm:g} mm of wire (--torch {other.name})"
    words = f"the torch does not get there: with every lean it meets {names}, {place_words(seam)}"
    return f"{words}{better}{hiding_words(seam)}"
