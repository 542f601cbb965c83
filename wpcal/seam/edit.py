"""What a person decides about candidates: accept or reject, reverse, rename, use a part of the length.

The decisions are in ``seams.json`` itself. The object ``edit`` of a seam holds them, and its object ``candidate``
identifies the candidate by its place on the part, not by its number. So the same file also works with other options, or
after a change elsewhere on the part.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import LARGEST_MM
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import read_json
from wpcal.seam.edited_run import framed, is_loop, joined_run, judged_anew, marks_in, part_of
from wpcal.seam.judge.last_check import refuse_frames_in_material
from wpcal.seam.judge.leans import with_leans
from wpcal.seam.options import Judging, SaidMember, SeamOptions
from wpcal.seam.path.cut import middles
from wpcal.seam.path.direction import Runs
from wpcal.seam.record import SEAMS_SCHEMA
from wpcal.seam.rules import Rule
from wpcal.seam.seam import Seam
from wpcal.seam.seam_edit import Candidate, JoinedStretch, SeamEdit

SAME_PLACE_MM = 0.1
"""A candidate is the one in the file if start, middle and length agree within this. Files hold all digits. Few seams of
one part are nearer to each other (both rims of the hole of a pin are); the number decides between those."""
EDIT_KEYS = ("accept", "reject", "reverse", "name", "range_mm", "other_side", "join")


STRETCH_KEYS = {"candidate", "range_mm"}
LONGEST_NAME = 200  #: Robot programs allow far shorter names, which their writers make from this one.
MOST_JOINED = 100
"""Stretches in one seam. Each is tried at every end, so the time grows with the square; no torch runs through more."""


@dataclass(frozen=True, slots=True)
class PlacedEdit:
    """A decision about one candidate."""

    candidate: Candidate
    edit: SeamEdit
    path: str = "script"  #: The file of the decision, for messages.


def read_edits(path: Path) -> tuple[PlacedEdit, ...]:
    """Read the decisions in an edited ``seams.json``. One for every seam with an object ``edit`` that is not empty.

    Raises `InputError` if the file cannot be opened.
    Raises `FormatError` if it is not a seams file, or an edit has an unknown key or a value of the wrong type.
    """
    record = read_json(path, schema=SEAMS_SCHEMA)
    found = []
    for seam in record.get("seams", []):
        if not isinstance(seam, dict) or not seam.get("edit"):
            continue
        label = str(seam.get("name", "?"))
        candidate = candidate_from_record(seam.get("candidate"), label, path=str(path))
        found.append(PlacedEdit(candidate, edit_from_record(seam["edit"], label, path=str(path)), str(path)))
    return tuple(found)


def read_judging(path: Path) -> Judging:
    """Read what a person said about solids and members in a ``seams.json``; errors as for `read_edits`."""
    said = read_json(path, schema=SEAMS_SCHEMA).get("judging") or {}
    try:
        weld, not_welded = (tuple(map(str, said.get(key) or ())) for key in ("weld", "not"))
        places = [(one, one.get("at_part_mm")) for one in said.get("members") or ()]
        members = [SaidMember(str(one["member"]), str(one["is"]), at and _point(at)) for one, at in places]
        return Judging(weld, not_welded, tuple(members))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise FormatError(f"judging: expected lists weld, not, members: {error}", path=str(path)) from None


def candidate_from_record(record: Any, label: str, *, path: str) -> Candidate:
    """Return the candidate that a record describes. Raises `FormatError` if something is missing."""
    try:
        start_mm, middle_mm = (_point(record[key]) for key in ("start_part_mm", "middle_part_mm"))
        return Candidate(str(record["name"]), start_mm, middle_mm, _length(record["length_mm"]))
    except (KeyError, TypeError, ValueError, OverflowError):
        message = f"seam {label}: its edit needs a whole candidate (name, start_part_mm, middle_part_mm, length_mm)"
        raise FormatError(message, path=path) from None


def _point(value: Any) -> tuple[float, float, float]:
    x, y, z = map(_length, value)
    return x, y, z


def _length(value: Any) -> float:
    """Return a number of a record in mm; a page can also send texts, NaN and true."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST_MM:
        raise TypeError("expected a number")
    return float(value)


def edit_from_record(record: Any, label: str, *, path: str) -> SeamEdit:
    """Return one edit. Raises `FormatError` if a key is unknown or a value has the wrong type."""

    def refuse(message: str) -> FormatError:
        return FormatError(f"edit of seam {label}: {message}", path=path)

    if not isinstance(record, dict):
        raise refuse("expected an object")
    for key in record:
        if key not in EDIT_KEYS:
            raise refuse(f"unknown key {key!r}; expected {', '.join(EDIT_KEYS)}")
    for key in ("accept", "reject", "reverse", "other_side"):
        if not isinstance(record.get(key, False), bool):
            raise refuse(f"{key} must be true or false, got {record[key]!r}")
    if record.get("accept") and record.get("reject"):
        raise refuse("accept and reject exclude each other")
    name = record.get("name")
    if name is not None and not (isinstance(name, str) and name.strip()):
        raise refuse(f"name must be a text, got {name!r}")
    if name is not None and not (name.isprintable() and len(name) <= LONGEST_NAME):
        raise refuse(f"name must be at most {LONGEST_NAME} characters without control characters, got {name[:80]!r}")
    accept = True if record.get("accept") else False if record.get("reject") else None
    return SeamEdit(
        accept,
        bool(record.get("reverse", False)),
        name,
        _range(record.get("range_mm"), refuse),
        bool(record.get("other_side", False)),
        _join(record.get("join", []), label, path),
    )


def _join(value: Any, label: str, path: str) -> tuple[JoinedStretch, ...]:
    def refuse(message: str) -> FormatError:
        return FormatError(f"edit of seam {label}: join: {message}", path=path)

    if not isinstance(value, list) or not all(isinstance(one, dict) and one.keys() <= STRETCH_KEYS for one in value):
        raise refuse(f"expected a list of objects with {' and '.join(sorted(STRETCH_KEYS))}")
    if len(value) > MOST_JOINED:
        raise refuse(f"expected at most {MOST_JOINED} stretches, got {len(value)}")
    return tuple(
        JoinedStretch(
            candidate_from_record(one.get("candidate"), label, path=path), _range(one.get("range_mm"), refuse)
        )
        for one in value
    )


def _range(value: Any, refuse: Any) -> tuple[float, float] | None:
    if value is None:
        return None
    is_pair = isinstance(value, list) and len(value) == 2
    if not is_pair or not all(isinstance(v, int | float) and not isinstance(v, bool) for v in value):
        raise refuse(f"range_mm must be two lengths [from, to], got {value!r}")
    if not all(abs(v) <= LARGEST_MM for v in value):
        raise refuse(f"range_mm must be two lengths of at most {LARGEST_MM:g} mm")
    low, high = float(value[0]), float(value[1])
    if not 0 <= low < high:
        raise refuse(f"range_mm must rise from 0 or more, got [{low:g}, {high:g}]")
    return low, high


def apply_edits(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], edits: Sequence[PlacedEdit], options: SeamOptions
) -> tuple[Seam, ...]:
    """Carry out decisions on the candidates of a part.

    Returns: In the order of the candidates. Seams that were accepted or changed by an edit have the torch's leans; they
    are not cut where no torch gets to them. None that is accepted has a frame that points into material.

    Raises `InputError` if the candidate of an edit is not on the part, a range is longer than its seam, joined seams do
    not meet, or two seams get one name.
    """
    own: dict[int, list[PlacedEdit]] = {}
    for edit in edits:
        own.setdefault(_row_of(seams, edit), []).append(edit)
    taken = _rows_joined(seams, edits, own)
    edited: list[Seam] = []
    again: list[int] = []
    for row, seam in enumerate(seams):
        for edit in own.get(row, []):
            if _needs_judging(edit.edit):
                again.append(len(edited))
            edited.append(_edited(graph, trimmed, seams, seam, edit, options))
        if row not in own and row not in taken:
            edited.append(seam)
    judged = judged_anew(graph, trimmed, [edited[k] for k in again], options, has_marks=marks_in(seams))
    for k, seam in zip(again, judged, strict=True):
        edited[k] = seam
    edited = [seam if seam.edit is None else _decided(seam, seam.edit) for seam in edited]
    for name, count in Counter(seam.name for seam in edited).items():
        if count > 1:
            raise InputError(f"{edits[0].path}: two seams would be called {name!r}; give each edit a different name")
    names = {seam.candidate.name: seam.name for seam in reversed(edited) if seam.candidate is not None}
    edited = [seam if seam.wrap_of is None else replace(seam, wrap_of=names.get(seam.wrap_of)) for seam in edited]
    leant = with_leans(graph, trimmed, edited, options.reach)
    return refuse_frames_in_material(graph, trimmed, leant, options)


def _rows_joined(
    seams: Sequence[Seam], edits: Sequence[PlacedEdit], own: Mapping[int, list[PlacedEdit]]
) -> dict[int, str]:
    """Return the candidates that are welded as a part of another one, with the name of that one."""
    taken: dict[int, str] = {}
    for edit in edits:
        for stretch in edit.edit.join:
            row = _row_of(seams, replace(edit, candidate=stretch.candidate))
            main = edit.edit.name or edit.candidate.name
            if row in own and (stretch.range_mm is None or any(one.edit.range_mm is None for one in own[row])):
                what = f"{stretch.candidate.name} is joined to {main} and cannot have an edit of its own"
                raise InputError(f"{edit.path}: {what}")
            if stretch.range_mm is None and row in taken:
                raise InputError(f"{edit.path}: {stretch.candidate.name} is joined to {taken[row]} and to {main}")
            taken[row] = main
    return taken


def _row_of(seams: Sequence[Seam], edit: PlacedEdit) -> int:
    wanted = edit.candidate
    known = [(row, seam.candidate) for row, seam in enumerate(seams) if seam.candidate is not None]
    near = [(row, here) for row, here in known if _largest_difference(here, wanted) <= SAME_PLACE_MM]
    if near:
        return min(near, key=lambda item: (item[1].name != wanted.name, item[0]))[0]
    place = ", ".join(f"{v:.1f}" for v in wanted.start_mm)
    raise InputError(
        f"{edit.path}: seam {wanted.name}, {wanted.length_mm:.1f} mm long from ({place}) in part coordinates, is not "
        "found on this part: the part has changed there, the options differ, or the seam is now cut where it goes "
        "through another solid or where no torch gets to it; run wpcal seams again"
    )


def _largest_difference(a: Candidate, b: Candidate) -> float:
    rows = [np.array([*c.start_mm, *c.middle_mm, c.length_mm]) for c in (a, b)]
    return float(np.abs(rows[0] - rows[1]).max())


def _needs_judging(edit: SeamEdit) -> bool:
    """Tell whether an edit makes a seam about which the rules may say something else."""
    return edit.range_mm is not None or edit.other_side or bool(edit.join)


def _edited(
    graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], seam: Seam, placed: PlacedEdit, options: SeamOptions
) -> Seam:
    """Return a candidate with the name, the run and the solids that an edit gives it."""
    edit = placed.edit
    try:
        pieces = part_of(graph, seam, edit.range_mm)
        others = [(_row_of(seams, replace(placed, candidate=one.candidate)), one.range_mm) for one in edit.join]
        if others:
            runs = [(seams[row].name, part_of(graph, seams[row], range_mm)) for row, range_mm in others]
            pieces = joined_run(graph, [(seam.name, pieces), *runs], join_mm=options.most_join_mm)
    except InputError as error:
        is_placed = str(error).startswith(placed.path)
        raise error if is_placed else InputError(f"{placed.path}: {error}") from None
    if edit.reverse:
        pieces = pieces.backwards()
    joined = f"joined by hand with {', '.join(seams[row].name for row, _ in others)}"
    changed = replace(
        seam,
        name=edit.name or seam.name,
        solids=tuple(dict.fromkeys([*seam.solids, *(name for row, _ in others for name in seams[row].solids)])),
        pieces=pieces,
        reasons=(*seam.reasons, joined) if others else seam.reasons,
        closed=is_loop(graph, pieces) if _needs_judging(edit) else seam.closed,
        findings=tuple(one for one in seam.findings if not (others and one.rule == Rule.SHORT_END.key)),
        wrap_of=None if others else seam.wrap_of,  # with others it is no end any more
        edit=edit,
    )
    return framed(graph, trimmed, changed, options) if edit.reverse and not _needs_judging(edit) else changed


def _decided(seam: Seam, edit: SeamEdit) -> Seam:
    """Return a seam, judged by the rules, with the decision of the person."""
    accepted = not seam.inside and (seam.accepted if edit.accept is None else edit.accept)
    confidence = 1.0 if edit.accept and accepted else seam.confidence  # what a person accepts is a weld
    return replace(seam, accepted=accepted, confidence=confidence, reasons=(*seam.reasons, *_in_words(edit, seam)))


def _in_words(edit: SeamEdit, seam: Seam) -> tuple[str, ...]:
    if edit.accept and seam.inside:
        return ("accepted by hand, but it stays refused: no torch welds inside material",)
    return () if edit.accept is None else (f"{'accepted' if edit.accept else 'rejected'} by hand",)


def candidates_of(graph: BrepGraph, seams: Sequence[Seam], names: Sequence[str]) -> list[Candidate]:
    """Return seams of those names as candidates: name, start, middle and length as found."""
    if not seams:
        return []
    runs = Runs.of([seam.pieces for seam in seams])
    places = zip(runs.ends(graph)[0].tolist(), middles(graph, runs).tolist(), strict=True)
    return [
        Candidate(name, (x0, y0, z0), (x1, y1, z1), seam.length_mm)
        for name, seam, ((x0, y0, z0), (x1, y1, z1)) in zip(names, seams, places, strict=True)
    ]
