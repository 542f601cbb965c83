"""Where two contents of a file differ: by fields where the file has fields."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

LONGEST = 60  #: Letters of a value that are shown.


@dataclass(frozen=True, slots=True)
class Difference:
    """One thing that differs."""

    where: str  #: File, seam or point, and field.
    found: str
    expected: str
    off_by: str = ""  #: Number with unit; empty for words.

    def to_record(self) -> dict[str, str]:
        """Return plain values for a JSON file."""
        return asdict(self)


def differences_of(name: str, mine: bytes, expected: bytes) -> Iterator[Difference]:
    """Yield where two contents of a file differ, by fields where the file has fields; at least one."""
    count = 0
    for each in _by_fields(name, mine, expected):
        count += 1
        yield each
    if not count:
        at = next((k for k, (a, b) in enumerate(zip(mine, expected, strict=False)) if a != b), -1)
        if at < 0:
            yield Difference(name, f"{len(mine)} bytes", f"{len(expected)} bytes")
        elif name.endswith(".glb"):
            yield Difference(f"{name} byte {at}", str(mine[at]), str(expected[at]))
        else:
            yield Difference(f"{name} line {mine.count(10, 0, at) + 1}", _around(mine, at), _around(expected, at))


def _around(data: bytes, at: int) -> str:
    begin = max(data.rfind(b"\n", 0, at) + 1, at - LONGEST // 2)
    end = data.find(b"\n", at)
    return ascii(data[begin : min(begin + LONGEST, len(data) if end < 0 else end)].decode("utf-8", "replace"))[1:-1]


def _by_fields(name: str, mine: bytes, expected: bytes) -> Iterator[Difference]:
    try:
        if name.endswith(".json"):
            yield from walk_records(json.loads(mine), json.loads(expected), name)
        elif name.endswith(".csv"):
            yield from _cells(name, mine.decode(), expected.decode())
    except (ValueError, RecursionError, csv.Error):
        return


def walk_records(mine: Any, expected: Any, where: str, atol: float = 0.0) -> Iterator[Difference]:
    """Yield the places at which two values of JSON differ; numbers may differ by `atol`."""
    if isinstance(mine, dict) and isinstance(expected, dict):
        for key in {**mine, **expected}:
            if key in mine and key in expected:
                yield from walk_records(mine[key], expected[key], f"{where} {key}", atol)
            else:
                yield Difference(f"{where} {key}", *(("there", "missing") if key in mine else ("missing", "there")))
    elif isinstance(mine, list) and isinstance(expected, list) and len(mine) == len(expected):
        for row, (one, other) in enumerate(zip(mine, expected, strict=True)):
            label = one.get("name") if isinstance(one, dict) else None
            yield from walk_records(one, other, f"{where} {label if isinstance(label, str) else row}", atol)
    elif type(mine) is not type(expected) or mine != expected:
        numbers = all(isinstance(each, int | float) and not isinstance(each, bool) for each in (mine, expected))
        if not (numbers and atol and abs(mine - expected) <= atol):
            yield Difference(
                where, *_shown(json.dumps(mine, ensure_ascii=False), json.dumps(expected, ensure_ascii=False))
            )


def _shown(mine: str, expected: str) -> tuple[str, str]:
    """Return two texts; of long ones the part in which they begin to differ."""
    if max(len(mine), len(expected)) <= LONGEST:
        return mine, expected
    at = next((k for k, (a, b) in enumerate(zip(mine, expected, strict=False)) if a != b), 0)
    begin = max(0, at - LONGEST // 2)
    return mine[begin : begin + LONGEST], expected[begin : begin + LONGEST]


def _cells(name: str, mine: str, expected: str) -> Iterator[Difference]:
    one, other = (list(csv.reader(io.StringIO(text))) for text in (mine, expected))
    if len(one) != len(other):
        yield Difference(f"{name} lines", str(len(one)), str(len(other)))
    for line, (row, right) in enumerate(zip(one, other, strict=False), start=1):
        if len(row) != len(right):
            yield Difference(f"{name} line {line} cells", str(len(row)), str(len(right)))
        for column, (cell, value) in enumerate(zip(row, right, strict=False)):
            if cell != value:
                title = other[0][column] if column < len(other[0]) else str(column)
                yield Difference(f"{name} line {line} {title}", *_shown(cell, value))
