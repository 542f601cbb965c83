"""Many objects of one dataclass, as columns of plain data: one array instead of thousands of small ones.

A part of 8640 faces has 8000 seams of 26 fields with 11 arrays each. Sent one by one, they take as long as finding
them. A column is an object with one key, its kind: `_READERS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from itertools import accumulate, chain, pairwise
from typing import Any, Protocol

import numpy as np

from cad.work.plain_types import BARE, PLAIN_ARRAYS, PlainDataError, dataclass_named, enum_named, name_of, require_plain

LEAST_ROWS = 4  #: Fewer objects are sent one by one: columns would not be smaller.


class Sender(Protocol):
    """What sends single values."""

    def tree(self, value: object) -> Any:
        """Return a value as JSON can hold it."""

    def part(self, data: bytes) -> int:
        """Keep bytes, and return their number."""


class Receiver(Protocol):
    """What makes single values again."""

    def value(self, tree: Any) -> Any:
        """Return the value."""

    def bytes_of(self, part: int) -> memoryview:
        """Return the bytes of a number."""


def are_rows(values: Sequence[object]) -> bool:
    """Whether values are objects of one dataclass, and enough of them for columns."""
    kind = _only_type(values) if len(values) >= LEAST_ROWS else None
    return kind is not None and is_dataclass(kind) and bool(fields(kind))


def column_of(values: Sequence[Any], sender: Sender) -> Any:
    """Return values as one column."""
    kind = _only_type(values)
    if kind is None or kind in BARE:
        return _mixed_column(values, sender)
    if kind is tuple:
        return {"tuples": [[len(value) for value in values], column_of(list(chain.from_iterable(values)), sender)]}
    if kind is np.ndarray and _have_one_form(values):
        counts = [len(value) for value in values]
        part = sender.part(np.concatenate(values).tobytes())
        return {"arrays": [values[0].dtype.str, list(values[0].shape[1:]), counts, part]}
    if issubclass(kind, Enum):
        return {"enums": [name_of(kind), [value.name for value in values]]}
    return _rows_or_each(kind, values, sender)


def _mixed_column(values: Sequence[Any], sender: Sender) -> Any:
    """Return numbers and texts, or values some of which are None, as a column."""
    if set(map(type, values)) <= BARE:
        return {"bare": list(values)}
    if any(value is None for value in values):
        there = [value is not None for value in values]
        return {"some": [there, column_of([value for value in values if value is not None], sender)]}
    return {"each": [sender.tree(value) for value in values]}


def _rows_or_each(kind: type[Any], values: Sequence[Any], sender: Sender) -> Any:
    if not is_dataclass(kind) or not fields(kind):
        return {"each": [sender.tree(value) for value in values]}
    columns = [column_of([getattr(value, each.name) for value in values], sender) for each in fields(kind)]
    return {"rows": [name_of(kind), columns]}


def values_of(column: Any, receiver: Receiver) -> list[Any]:
    """Return the values of a column. Arrays of one column are views of one array, and read-only."""
    ((form, content),) = column.items()
    return _READERS[form](content, receiver)


def _only_type(values: Sequence[object]) -> type[Any] | None:
    """Return the type of all values; None if there is no value, or more than one type."""
    kinds = set(map(type, values))
    return kinds.pop() if len(kinds) == 1 else None


def _have_one_form(arrays: Sequence[np.ndarray[Any, Any]]) -> bool:
    """Whether arrays differ in their first size only, and lie row by row in memory."""
    forms = {(array.dtype, array.shape[1:], array.ndim > 0 and array.flags.c_contiguous) for array in arrays}
    dtype, _, in_rows = next(iter(forms))
    return len(forms) == 1 and in_rows and dtype.kind in PLAIN_ARRAYS


def _some(content: Any, receiver: Receiver) -> list[Any]:
    there, column = content
    values = iter(values_of(column, receiver))
    return [next(values) if is_there else None for is_there in there]


def _tuples(content: Any, receiver: Receiver) -> list[Any]:
    counts, column = content
    values = values_of(column, receiver)
    return [tuple(values[start:end]) for start, end in _spans(counts, len(values))]


def _arrays(content: Any, receiver: Receiver) -> list[Any]:
    dtype, shape, counts, part = content
    require_plain(dtype)
    flat = np.frombuffer(receiver.bytes_of(part), dtype).copy()  # a part may begin at an odd address
    flat.setflags(write=False)
    whole = flat.reshape(sum(counts), *shape)
    return [whole[start:end] for start, end in _spans(counts, len(whole))]


def _enums(content: Any, _: Receiver) -> list[Any]:
    name, members = content
    kind = enum_named(name)
    by_name = {member: kind[member] for member in set(members)}
    return [by_name[member] for member in members]


def _rows(content: Any, receiver: Receiver) -> list[Any]:
    """Make objects of a dataclass without its own checks: they ran where the objects were made first."""
    name, columns = content
    kind = dataclass_named(name)
    names = [each.name for each in fields(kind)]
    found = [values_of(column, receiver) for column in columns]
    made = [object.__new__(kind) for _ in found[0]]
    for field_name, values in zip(names, found, strict=True):
        for one, value in zip(made, values, strict=True):
            object.__setattr__(one, field_name, value)
    return made


def _spans(counts: list[int], total: int) -> list[tuple[int, int]]:
    """Return where each stretch of a column starts and ends."""
    if sum(counts) != total or any(count < 0 for count in counts):
        raise PlainDataError(f"{total} values in a column, expected {sum(counts)}")
    return list(pairwise(accumulate(counts, initial=0)))


_READERS: Mapping[str, Callable[[Any, Receiver], list[Any]]] = {
    "bare": lambda content, _: list(content),
    "some": _some,
    "tuples": _tuples,
    "arrays": _arrays,
    "enums": _enums,
    "rows": _rows,
    "each": lambda content, receiver: [receiver.value(tree) for tree in content],
}
"""By the form of a column: how its values are made again."""
