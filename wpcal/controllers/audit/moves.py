"""Read the moves of written programs: which pose leads to which, on a line or on an arc.

Only what is between two poses of one file, or of a pair of files, is read: the first move of a procedure comes from
wherever its caller left the tool.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from wpcal.controllers.audit.read_back import UR_MOVE, URSCRIPT, VAL3, ReadPose
from wpcal.controllers.taught_program import ENCODING
from wpcal.core.arrays import FloatArray
from wpcal.core.input_file import read_bytes
from wpcal.robot.moves.interpolation import Moves, turns_between

STEP_MM = 1.0
"""Places along a move: as fine as weld poses are compared with the part before they are written."""
STEP_RAD = np.radians(2.0)
"""Turns of a tool of 300 mm move its end by 10 mm in a step."""

Step = tuple[str, ...]
"""Names of poses: the end of a line; an empty name and the end of a joint move; or middle and end of an arc."""

_RAPID_BEGIN, _RAPID_END = re.compile(r"\bPROC\b", re.IGNORECASE), re.compile(r"\bENDPROC\b", re.IGNORECASE)
_RAPID_MOVE = re.compile(
    r"^[ \t]*+(?:Move|Arc)(?P<kind>[JLC])\w*+[ \t]++(?P<a>\w++)[ \t]*+(?:,[ \t]*+(?P<b>\w++))?",
    re.MULTILINE | re.IGNORECASE,
)
_KRL_MOVE = re.compile(
    r"^[ \t]*+S?(?P<kind>PTP|LIN|CIRC)[ \t]++(?P<a>\w++)[ \t]*+(?:,[ \t]*+(?P<b>\w++))?", re.MULTILINE | re.IGNORECASE
)
_FANUC_MOVE = re.compile(
    r"^[ \t]*+\d++:[ \t]*+(?P<kind>[JLC])[ \t]*+P\[(?P<a>\d++)[^\]\n]*+\]"
    r"(?:[ \t]*+\r?\n[ \t]*+:[ \t]*+P\[(?P<b>\d++))?",
    re.MULTILINE,
)
_INFORM_MOVE = re.compile(r"^MOV(?P<kind>[JLC])[ \t]++(?P<a>[CP]\d++)", re.MULTILINE)
_VAL3_MOVE = re.compile(r"\bmove(?P<kind>[jlc])\(\s*+(?P<a>\w++\[\w++\])\s*+,\s*+(?:(?P<b>\w++\[\w++\])\s*+,)?")
_UR_JOINTS = re.compile(r"\bmovej\(\s*+\[")
_AS_MOVE = re.compile(
    r"^[ \t]*+(?:(?P<kind>[LJ])(?:MOVE|W[SCE])|C(?P<place>[12])(?:MOVE|WC))[ \t]++(?P<a>[\w.]++)",
    re.MULTILINE | re.IGNORECASE,
)
LARGEST_MOVE_MM = 20_000.0
"""No robot makes longer moves; they are not followed."""


def read_moves(raw: bytes, path: Path) -> list[list[Step]]:
    """Return the moves of a program, as far as its language is known; in each list one leads to the next.

    Parameters
    ----------
    raw : Of the file that holds the poses.
    path : Path
        Its suffix tells the language. The moves of KRL and VAL3 are in another file beside it, if there is one. Loops
        over the points of an array are not followed.
    """
    text, suffix = raw.decode(ENCODING), path.suffix.lower()
    if suffix == VAL3:
        return [list(_named(_VAL3_MOVE.finditer(_beside(path.parent / "start.pgx"))))]
    if suffix == ".dat":
        return [list(_named(_KRL_MOVE.finditer(_beside(path.with_suffix(".src")))))]
    of_text = {URSCRIPT: _urscript, ".ls": _fanuc, ".jbi": _inform}
    if suffix in of_text:
        return [list(of_text[suffix](text))]
    if suffix == ".as":
        return [list(_kawasaki(body)) for body in re.split(r"^\.END\b", text, flags=re.MULTILINE)]
    plain = re.sub(r"![^\n]*+", "", text)
    bodies = [_RAPID_BEGIN.split(piece, maxsplit=1)[-1] for piece in _RAPID_END.split(plain)[:-1]]
    return [list(_named(_RAPID_MOVE.finditer(body))) for body in bodies]


def _beside(path: Path) -> str:
    return read_bytes(path).decode(ENCODING) if path.is_file() else ""


def _named(found: Iterator[re.Match[str]], *, prefix: str = "") -> Iterator[Step]:
    for match in found:
        kind, a, b = (match["kind"] or "L")[0].upper(), prefix + match["a"], match["b"]
        if kind == "C" and b:
            yield a, prefix + b
        else:
            yield (a,) if kind == "L" else ("", a)[kind == "C" :]


def _fanuc(text: str) -> Iterator[Step]:
    return _named(_FANUC_MOVE.finditer(text.split("/POS", maxsplit=1)[0]), prefix="P")


def _inform(text: str) -> Iterator[Step]:
    """Yield the moves; three MOVC are an arc, and the first of them is a line to its start."""
    arc: list[str] = []
    for match in _INFORM_MOVE.finditer(text):
        kind, name = match["kind"], match["a"]
        if kind != "C":
            arc = []
            yield (name,) if kind == "L" else ("", name)
            continue
        arc.append(name)
        if len(arc) == 1:
            yield (name,)
        elif len(arc) == 3:
            yield arc[1], arc[2]
            arc = []


def _kawasaki(text: str) -> Iterator[Step]:
    """Yield the moves of one program; a C1 with the C2 after it is an arc."""
    middle = ""
    for match in _AS_MOVE.finditer(text):
        kind, name = (match["kind"] or "").upper(), match["a"]
        if match["place"] == "1":
            middle = name
        elif match["place"] == "2":
            yield middle, name
        else:
            yield (name,) if kind == "L" else ("", name)


def _urscript(text: str) -> Iterator[Step]:
    """Yield the moves; one to joints leads from where no pose is known."""
    middle, done = "", 0
    for number, match in enumerate(UR_MOVE.finditer(text), 1):
        if _UR_JOINTS.search(text, done, match.start()):
            yield "", "joints"
        done = match.end()
        name, kind = f"move {number}", match[0][4:5] if match[0].startswith("move") else ""
        if kind == "c":
            middle = name
        elif kind == "":
            yield middle, name
        else:
            yield ("", name) if kind == "j" else (name,)


def places_between(
    poses: Sequence[ReadPose], chains: Sequence[Sequence[Step]]
) -> tuple[FloatArray, FloatArray, list[ReadPose]]:
    """Return where the tool is between the poses of a program.

    Parameters
    ----------
    poses : Sound ones, in `base`.
    chains : As `read_moves` returns them; steps that name other poses are left out.

    Returns
    -------
    p, R : ndarray, shapes (m, 3) and (m, 3, 3). In `base`.
    to : list of ReadPose. The end of the move of each place.
    """
    named = {pose.name.lower(): pose for pose in poses}
    by_name: Mapping[str, ReadPose] = {**{f"x{name}": pose for name, pose in named.items()}, **named}  # folds of KRL
    rows = list[tuple[ReadPose, ReadPose, FloatArray]]()
    for chain in chains:
        for before, step in pairwise(chain):
            known = [by_name.get(name.lower()) for name in (before[-1], *step)]
            start, end = known[0], known[-1]
            if start is None or end is None or None in known:
                continue
            if np.linalg.norm(end.p_base - start.p_base) > LARGEST_MOVE_MM:
                continue
            middle = known[1] if len(known) == 3 else None
            rows.append((start, end, np.full(3, np.nan) if middle is None else middle.p_base))
    if not rows:
        return np.zeros((0, 3)), np.zeros((0, 3, 3)), []
    starts, ends, via = zip(*rows, strict=True)
    p0, p1 = (np.array([pose.p_base for pose in side]) for side in (starts, ends))
    R0, R1 = (np.array([pose.R_base for pose in side]) for side in (starts, ends))
    turn = turns_between(R0, R1)
    moves = Moves.between(p0, R0, p1, turn, np.array(via))
    length = np.maximum(np.linalg.norm(moves.chord, axis=1), moves.sweep * np.linalg.norm(moves.u, axis=1))
    steps = np.maximum(length / STEP_MM, np.linalg.norm(turn, axis=1) / STEP_RAD)
    counts = np.maximum(np.ceil(steps).astype(np.int64) - 1, 0)
    own = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(own)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (number + 1) / (counts[own] + 1)
    at = moves.select(own)
    return at.positions(share), at.rotations(share), [ends[row] for row in own]
