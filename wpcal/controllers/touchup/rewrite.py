"""The same text with some poses moved: everything else stays to the byte."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.registry import grammar_of_file
from wpcal.controllers.touchup.poses import ProgramPose, ProgramText
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.taught.programs import ProgramPoint

NUMBER = re.compile(r"(?<![\w.])( *)([-+]?\d++\.\d*+(?:[eE][-+]?\d++)?)")
SAME = 1e-6  #: A number of the text is the coordinate that was read if they differ by less of its size.
CHECKED = re.compile(rb"\bchecked against the part\b")
NOT_CHECKED = b"NOT CHECKED: touched up "
"""In place of "checked against the part", of the same length: lines of some languages are short."""
METRES = (".script",)  #: Suffixes of texts in m.


@dataclass(frozen=True, slots=True, eq=False)
class _Data:
    """Where the text of a file has the coordinates of a pose."""

    file: str
    point: ProgramPoint
    spans: tuple[tuple[int, int], ...]  #: Of x, y, z with the blanks before them.


def moved_text(program: ProgramText, shifts: FloatArray) -> dict[str, bytes]:
    """Return the files with poses moved by `shifts`, shape (n, 3), in `base`, mm.

    Raises `InputError` when a pose that is to move has no coordinates of its own in the text.
    """
    texts = {name: data.decode(ENCODING) for name, data in program.files.items()}
    edits: dict[tuple[str, int], tuple[int, str]] = {}
    data = {name: list(_data_of(name, text)) for name, text in texts.items()}
    for row in np.flatnonzero(np.linalg.norm(shifts, axis=1) > 0.0).tolist():
        pose = program.poses[row]
        found = _data_for(pose, data)
        if found is None:
            raise InputError(
                f"{pose.where}: the coordinates of this pose are not in the files; the text is not changed"
            )
        R = pose.T[:3, :3] @ found.point.R.T  # from the frame of the data to the base
        unit = 1e-3 if Path(found.file).suffix.lower() in METRES else 1.0
        for (begin, end), value in zip(found.spans, unit * (found.point.p_mm + R.T @ shifts[row]), strict=True):
            edits[found.file, begin] = (end, _written(texts[found.file][begin:end], float(value)))
    for (file, begin), (end, number) in sorted(edits.items(), reverse=True):
        texts[file] = texts[file][:begin] + number + texts[file][end:]
    return {**{name: text.encode(ENCODING) for name, text in texts.items()}, **program.beside}


def without_claim(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the files without the claim that they were checked."""
    return {name: CHECKED.sub(NOT_CHECKED, data) for name, data in files.items()}


def _written(old: str, value: float) -> str:
    """Write a number as another one was: with as many decimals, and in as many columns where they are aligned."""
    blanks, number = len(old) - len(old.lstrip(" ")), old.strip()
    decimals = len(number.partition(".")[2])
    new = f"{value:.{decimals}f}"
    return new.rjust(len(old)) if blanks > 1 else " " * blanks + new


def _data_of(name: str, text: str) -> Iterator[_Data]:
    """Yield the poses that a file holds, and where."""
    grammar = grammar_of_file(Path(name))
    if grammar is None or Path(name).suffix.lower() not in grammar.poses_in:
        return
    unit = 1e-3 if Path(name).suffix.lower() in METRES else 1.0
    starts = [0, *(match.end() for match in re.finditer("\n", text))]
    for point in grammar.read(text, name).points:
        if point.fault is None:
            begin = starts[point.line - 1] if point.line else _of_element(text, point.name)
            spans = _spans(text, begin, unit * point.p_mm)
            if spans is not None:
                yield _Data(name, point, spans)


def _of_element(text: str, label: str) -> int:
    """Return where the value of ``name[number]`` begins in a database of points."""
    name, _, number = label.rstrip("]").partition("[")
    begin = text.index(f'name="{name}"')
    for _ in range(int(number) + 1):
        begin = text.index("<Value", begin + 1)
    return begin


def _spans(text: str, begin: int, p: FloatArray) -> tuple[tuple[int, int], ...] | None:
    """Return where x, y, z stand one after another, from `begin` on."""
    found: list[tuple[int, int]] = []
    for match in NUMBER.finditer(text, begin):
        value = float(match[2])
        if abs(value - p[len(found)]) <= SAME * max(1.0, abs(value)):
            found.append(match.span())
        else:
            found = [match.span()] if abs(value - p[0]) <= SAME * max(1.0, abs(value)) else []
        if len(found) == 3:
            return tuple(found)
    return None


def _data_for(pose: ProgramPose, data: Mapping[str, list[_Data]]) -> _Data | None:
    """Return the data that a pose of a program comes from: on its own line, or by the name in its instruction."""
    stem = Path(pose.place.file).stem.lower()
    own = [each for name, found in data.items() if Path(name).stem.lower() == stem for each in found]
    beside = [each for found in data.values() for each in found if each not in own]
    inline = [each for each in own if each.file == pose.place.file and each.point.line == pose.place.line]
    for each in (*inline, *own, *beside):
        if each in inline or _names(pose.text, each.point.name):
            return each
    return None


def _names(text: str, name: str) -> bool:
    """Tell whether an instruction names a point; what is read as ``P3`` may stand as ``P[3]`` or ``P[3:web]``."""
    numbered = re.fullmatch(r"([A-Za-z]+)(\d+)", name)
    pattern = re.escape(name) if numbered is None else rf"{numbered[1]}\[?{numbered[2]}(?!\d)"
    return re.search(rf"(?<!\w){pattern}(?!\w)", text) is not None
