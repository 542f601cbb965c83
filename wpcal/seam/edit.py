"""What a person decides about candidates: accept or reject, reverse, rename, use a part of the length.

The decisions are in ``seams.json`` itself. The object ``edit`` of a seam holds them, and its object ``candidate``
identifies the candidate by its place on the part, not by its number. So the same file also works with other options, or
after a change elsewhere on the part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import read_json
from wpcal.seam.judge.leans import with_leans
from wpcal.seam.options import SeamOptions
from wpcal.seam.path.build import with_frames
from wpcal.seam.path.cut import cut_run, middles
from wpcal.seam.path.direction import Runs
from wpcal.seam.path.turning import face_free_space
from wpcal.seam.record import SEAMS_SCHEMA
from wpcal.seam.seam import Candidate, Seam, SeamEdit, SeamPieces

SAME_PLACE_MM = 0.1
"""A candidate is the one in the file if start, middle and length agree within this. Files hold all digits. Few seams of
one part are nearer to each other (both rims of the hole of a pin are); the number decides between those."""
EDIT_KEYS = ("accept", "reject", "reverse", "name", "range_mm")


@dataclass(frozen=True, slots=True)
class PlacedEdit:
    """A decision about one candidate.

    Parameters
    ----------
    candidate : Candidate
    edit : SeamEdit
    path : str
        The file of the decision, for messages.
    """

    candidate: Candidate
    edit: SeamEdit
    path: str


def read_edits(path: Path) -> tuple[PlacedEdit, ...]:
    """Read the decisions in an edited ``seams.json``.

    Parameters
    ----------
    path : Path

    Returns
    -------
    tuple of PlacedEdit
        One for every seam with an object ``edit`` that is not empty.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it is not a seams file, or an edit has an unknown key or a value of the wrong type.
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


def candidate_from_record(record: Any, label: str, *, path: str) -> Candidate:
    """Return the candidate that a record describes.

    Raises
    ------
    FormatError
        If something is missing.
    """
    try:
        start, middle = (tuple(float(v) for v in record[key]) for key in ("start_part_mm", "middle_part_mm"))
        x, y, z = start
        u, v, w = middle
        return Candidate(str(record["name"]), (x, y, z), (u, v, w), float(record["length_mm"]))
    except (KeyError, TypeError, ValueError):
        message = f"seam {label}: its edit needs a whole candidate (name, start_part_mm, middle_part_mm, length_mm)"
        raise FormatError(message, path=path) from None


def edit_from_record(record: Any, label: str, *, path: str) -> SeamEdit:
    """Return one edit.

    Raises
    ------
    FormatError
        If a key is unknown or a value has the wrong type.
    """

    def refuse(message: str) -> FormatError:
        return FormatError(f"edit of seam {label}: {message}", path=path)

    if not isinstance(record, dict):
        raise refuse("expected an object")
    for key in record:
        if key not in EDIT_KEYS:
            raise refuse(f"unknown key {key!r}; expected {', '.join(EDIT_KEYS)}")
    for key in ("accept", "reject", "reverse"):
        if not isinstance(record.get(key, False), bool):
            raise refuse(f"{key} must be true or false, got {record[key]!r}")
    if record.get("accept") and record.get("reject"):
        raise refuse("accept and reject exclude each other")
    name = record.get("name")
    if name is not None and not (isinstance(name, str) and name.strip()):
        raise refuse(f"name must be a text, got {name!r}")
    accept = True if record.get("accept") else False if record.get("reject") else None
    return SeamEdit(accept, bool(record.get("reverse", False)), name, _range(record.get("range_mm"), refuse))


def _range(value: Any, refuse: Any) -> tuple[float, float] | None:
    if value is None:
        return None
    is_pair = isinstance(value, list) and len(value) == 2
    if not is_pair or not all(isinstance(v, int | float) and not isinstance(v, bool) for v in value):
        raise refuse(f"range_mm must be two lengths [from, to], got {value!r}")
    low, high = float(value[0]), float(value[1])
    if not 0 <= low < high:
        raise refuse(f"range_mm must rise from 0 or more, got [{low:g}, {high:g}]")
    return low, high


def apply_edits(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    seams: Sequence[Seam],
    edits: Sequence[PlacedEdit],
    options: SeamOptions,
) -> tuple[Seam, ...]:
    """Carry out decisions on the candidates of a part.

    Parameters
    ----------
    graph, trimmed :
        The part.
    seams : sequence of Seam
        The candidates, with frames in `part`.
    edits : sequence of PlacedEdit
        Several edits of one candidate, with different names, make several seams of it: stretches of a long one.
    options : SeamOptions
        The options with which the seams were found; edited seams get new frames.

    Returns
    -------
    tuple of Seam
        In the order of the candidates. Seams that were accepted or changed by an edit have the torch's leans; they are
        not cut where no torch gets to them.

    Raises
    ------
    InputError
        If the candidate of an edit is not on the part, a range is longer than its seam, or two seams get one name.
    """
    edits_of: dict[int, list[PlacedEdit]] = {}
    for edit in edits:
        edits_of.setdefault(_row_of(seams, edit), []).append(edit)
    edited = []
    for row, seam in enumerate(seams):
        edited += [_edited(graph, trimmed, seam, edit, options) for edit in edits_of.get(row, [])] or [seam]
    names = [seam.name for seam in edited]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{edits[0].path}: two seams would be called {name!r}; give each edit a different name")
    return with_leans(graph, trimmed, edited)


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


def _edited(graph: BrepGraph, trimmed: TrimmedFaces, seam: Seam, placed: PlacedEdit, options: SeamOptions) -> Seam:
    edit = placed.edit
    pieces, closed = seam.pieces, seam.closed
    if edit.range_mm is not None:
        low, high = edit.range_mm
        if high > seam.length_mm + SAME_PLACE_MM:
            ends = f"range_mm ends at {high:g}, but the seam at {seam.length_mm:.3f} mm"
            raise InputError(f"{placed.path}: edit of seam {seam.name}: {ends}")
        pieces, closed = cut_run(graph, pieces, low, min(high, seam.length_mm)), False
    if edit.reverse:
        pieces = pieces.backwards()
    changed = replace(
        seam,
        name=edit.name or seam.name,
        pieces=pieces,
        closed=closed,
        accepted=not seam.inside and (seam.accepted if edit.accept is None else edit.accept),
        reasons=(*seam.reasons, *_in_words(edit, seam)),
        edit=edit,
    )
    if pieces is seam.pieces:
        return changed
    return face_free_space(graph, trimmed, with_frames(graph, changed, options))


def _in_words(edit: SeamEdit, seam: Seam) -> tuple[str, ...]:
    if edit.accept and seam.inside:
        return ("accepted by hand, but it stays refused: no torch welds inside material",)
    return () if edit.accept is None else (f"{'accepted' if edit.accept else 'rejected'} by hand",)


def with_candidates(graph: BrepGraph, seams: Sequence[Seam]) -> tuple[Seam, ...]:
    """Return seams with their candidates: name, start, middle and length as found."""
    if not seams:
        return ()
    runs = Runs(SeamPieces.joined([s.pieces for s in seams]), np.cumsum([0, *(len(s.pieces) for s in seams)]))
    start, middle = runs.ends(graph)[0], middles(graph, runs)
    return tuple(
        replace(seam, candidate=Candidate(seam.name, _xyz(start[row]), _xyz(middle[row]), seam.length_mm))
        for row, seam in enumerate(seams)
    )


def _xyz(p: FloatArray) -> tuple[float, float, float]:
    x, y, z = p.tolist()
    return x, y, z
