"""Whole records as numbers and words, for golden results: every field and every property, by its place.

The leaves of records of one type are one column. A long column of numbers is stored as its count and two sums with
uneven weights: no value of it changes without them. `pytest FILE --regenerate` writes records that changed.
"""

import json
import re
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate.errors.robot_field import ResidualRows
from wpcal.calibrate.solve.bodies_problem import Whitened
from wpcal.core.errors import WpcalError

FOLDER = Path(__file__).parents[1] / "fixtures" / "whole"
FOLDER_OF_A_FILE = re.compile(r"(?<!\S)/\S*/")  #: That of a run.
FEW = 8  #: Numbers of a column that are stored as they are.
MANY = 12  #: Different words of a column are stored as one number.
DIGITS = 6
GOLDEN = 2e-5  #: Other processors change last digits, as in the golden results of parts.
NOT_A_NUMBER, FAR = 77.0, 1e4  #: Stand for NaN and infinity in a column.
LEFT_OUT = (BrepGraph, TrimmedFaces, ResidualRows, Whitened, type)
CHANGES = ("iterations", "error_field")  #: Round-off decides them: steps, and the length of a field of no size.


def whole_differences(name: str, value: Any, *, regenerate: bool) -> list[str]:
    """Return how a record differs from the kept one of its name."""
    path, found = FOLDER / f"{name}.json", columns_of(value)
    kept = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    told = [
        f"{place}: {found.get(place)}, kept {kept.get(place)}"
        for place in sorted({*found, *kept})
        if not _is_same(found.get(place, []), kept.get(place, []))
    ]
    if told and regenerate:
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = (f" {json.dumps(place)}: {json.dumps(column)}" for place, column in found.items())
        path.write_text("{\n" + ",\n".join(rows) + "\n}\n", encoding="utf-8")
        return []
    return told


def columns_of(value: Any) -> dict[str, list[Any]]:
    """Return the columns of records: numbers, or the count and sums of many, then how often each word is there."""
    columns = defaultdict[str, list[float | str]](list)
    for place, leaf in _leaves(value, ""):
        columns[place].append(leaf)
    return {place: _column(column) for place, column in sorted(columns.items())}


def _leaves(value: Any, place: str) -> Iterator[tuple[str, float | str]]:
    """Yield the plain values in a record with their places."""
    if isinstance(value, bool | int | float | np.number | np.bool_):
        yield place, float(value)
    elif isinstance(value, str | Path | Enum):
        yield place, value.name if isinstance(value, Enum) else FOLDER_OF_A_FILE.sub("", str(value))
    elif isinstance(value, np.ndarray):
        yield from (leaf for one in value.ravel().tolist() for leaf in _leaves(one, place))
    elif is_dataclass(value) and not isinstance(value, LEFT_OUT):
        yield from (leaf for name in _names(type(value)) for leaf in _leaves(_read(value, name), f"{place}.{name}"))
    elif isinstance(value, Mapping):
        yield from (leaf for key in value if key not in CHANGES for leaf in _leaves(value[key], f"{place}.{key}"))
    elif isinstance(value, list | tuple):
        yield f"{place} are", float(len(value))
        yield from (leaf for one in value for leaf in _leaves(one, place))


@cache
def _names(kind: Any) -> list[str]:
    """Return the fields and properties of a type of record."""
    own = {name for each in kind.__mro__ for name, value in vars(each).items() if isinstance(value, property)}
    return sorted(name for name in {*own, *(one.name for one in fields(kind))} - {*CHANGES} if not name.startswith("_"))


def _read(record: Any, name: str) -> Any:
    try:
        return getattr(record, name)
    except (WpcalError, ValueError) as error:
        return str(error)


def _column(column: list[float | str]) -> list[Any]:
    numbers = np.array([one for one in column if isinstance(one, float)])
    numbers = np.nan_to_num(numbers, nan=NOT_A_NUMBER, posinf=FAR, neginf=-FAR)
    words = dict(sorted(Counter(one for one in column if isinstance(one, str)).items()))
    if len(words) > MANY:
        words = {"different": len(words), "crc": zlib.crc32(json.dumps(words).encode())}
    k, root = np.arange(len(numbers)), np.sqrt(len(numbers))
    if len(numbers) > FEW:
        weights = np.cos(k) / root, np.sin(1.0 + np.sqrt(2.0) * k) / root
        numbers = np.array([len(numbers), numbers @ weights[0], numbers @ weights[1]])
    return [*(numbers.round(DIGITS) + 0.0).tolist(), *([words] if words else [])]


def _is_same(found: list[Any], kept: list[Any]) -> bool:
    words = [[one for one in column if isinstance(one, dict)] for column in (found, kept)]
    numbers = [[one for one in column if not isinstance(one, dict)] for column in (found, kept)]
    is_long = len(numbers[0]) == len(numbers[1])
    return words[0] == words[1] and is_long and np.allclose(*numbers, rtol=GOLDEN / 100, atol=GOLDEN)
