"""Values that pass between a command and the kernel's process, as JSON and raw arrays.

A damaged file can corrupt the memory of the kernel's process. What comes back is therefore read as data: no code of its
own runs while it is read, as it could with pickle. It may hold numbers, texts, bytes, arrays, paths, lists, tuples,
sets, dicts, and the enums, frozen dataclasses and errors of wpcal. An object that occurs twice is one object again,
except in columns.

A packet is the length of the JSON text (8 bytes), the text, and then the arrays and bytes one after another. In the
text a container or an object is an object with one key: its kind (`_READERS`). A tuple of many objects of one dataclass
is sent as columns (`cad.work.plain_columns`).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from itertools import accumulate
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from cad.work.plain_columns import are_rows, column_of, values_of
from cad.work.plain_types import (
    BARE,
    PLAIN_ARRAYS,
    PlainDataError,
    dataclass_named,
    enum_named,
    name_of,
    require_plain,
    type_named,
)
from wpcal.core.errors import WpcalError

_LENGTH = struct.Struct("<Q")


def pack(value: object) -> bytes:
    """Return a value as a packet.

    Raises `PlainDataError` when a part of it is of another type than the module's docstring lists.
    """
    packer = _Packer()
    text = json.dumps({"value": packer.tree(value), "sizes": [len(part) for part in packer.parts]}).encode("ascii")
    return b"".join([_LENGTH.pack(len(text)), text, *packer.parts])


def unpack(packet: bytes) -> Any:
    """Return the value of a packet. Its arrays are read-only.

    Raises `PlainDataError` when the packet is damaged, or names a type that is not ours.
    """
    try:
        end = _LENGTH.size + _LENGTH.unpack_from(packet)[0]
        record = json.loads(packet[_LENGTH.size : end])
        return _Unpacker(_split(memoryview(packet)[end:], record["sizes"])).value(record["value"])
    except PlainDataError:
        raise
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, ImportError, RecursionError) as error:
        raise PlainDataError(f"a damaged packet ({type(error).__name__}: {error})") from None
    except struct.error as error:
        raise PlainDataError(f"a damaged packet ({error})") from None


def _split(data: memoryview, sizes: list[int]) -> list[memoryview]:
    if sum(sizes) != len(data) or any(size < 0 for size in sizes):
        raise PlainDataError(f"{len(data)} bytes of arrays, expected {sum(sizes)}")
    ends = accumulate(sizes)
    return [data[end - size : end] for size, end in zip(sizes, ends, strict=True)]


class _Packer:
    """Turns values into what JSON can hold; arrays and bytes are collected in `parts`."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self._seen: dict[int, int] = {}
        self._kept: list[object] = []  # while they live, no other object has their id

    def tree(self, value: object) -> Any:
        """Return a value as JSON can hold it."""
        if type(value) in BARE:
            return value
        if isinstance(value, list):
            return {"list": [self.tree(item) for item in value]}
        if isinstance(value, tuple) and type(value) is tuple:
            return {"rows": column_of(value, self)} if are_rows(value) else {"tuple": [self.tree(v) for v in value]}
        if isinstance(value, dict | MappingProxyType):
            return {"dict": [[self.tree(key), self.tree(item)] for key, item in value.items()]}
        if isinstance(value, Enum):
            return {"enum": [name_of(type(value)), value.name]}
        return self._once(value)

    def _once(self, value: object) -> Any:
        """Send an object, or the number of the one that was sent already."""
        number = self._seen.get(id(value))
        if number is not None:
            return {"again": number}
        sent = self._object(value)
        self._seen[id(value)] = len(self._kept)
        self._kept.append(value)
        return sent

    def _object(self, value: object) -> Any:
        if isinstance(value, np.ndarray | np.generic):
            return self._array(value)
        if isinstance(value, bytes):
            return {"bytes": self.part(value)}
        if isinstance(value, Path):
            return {"path": str(value)}
        if isinstance(value, frozenset | set):
            return {"set": [isinstance(value, frozenset), [self.tree(item) for item in value]]}
        if isinstance(value, WpcalError):
            return {"error": [name_of(type(value)), self.tree(value.args), self.tree(vars(value))]}
        if is_dataclass(value) and not isinstance(value, type):
            return {"data": [name_of(type(value)), [self.tree(getattr(value, each.name)) for each in fields(value)]]}
        raise PlainDataError(f"a {type(value).__module__}.{type(value).__qualname__} is not plain data")

    def _array(self, value: np.ndarray[Any, Any] | np.generic) -> Any:
        if value.dtype.kind not in PLAIN_ARRAYS:
            raise PlainDataError(f"an array of {value.dtype} is not plain data")
        if isinstance(value, np.generic):
            return {"scalar": [value.dtype.str, self.part(value.tobytes())]}
        by_column = value.flags.f_contiguous and not value.flags.c_contiguous
        data = value.tobytes("F" if by_column else "C")
        return {"array": [value.dtype.str, list(value.shape), "F" if by_column else "C", self.part(data)]}

    def part(self, data: bytes) -> int:
        """Keep bytes, and return their number."""
        self.parts.append(data)
        return len(self.parts) - 1


class _Unpacker:
    """Makes values again. Objects are numbered in the order in which the packer finished them."""

    def __init__(self, parts: list[memoryview]) -> None:
        self._parts = parts
        self._made: list[object] = []

    def value(self, tree: Any) -> Any:
        """Return the value of a tree."""
        if not isinstance(tree, dict):
            return tree
        ((kind, content),) = tree.items()
        return _READERS[kind](self, content)

    def bytes_of(self, part: int) -> memoryview:
        """Return the bytes of a number."""
        return self._parts[part]

    def again(self, number: int) -> object:
        return self._made[number]

    def made(self, value: object) -> object:
        self._made.append(value)
        return value

    def array(self, dtype: str, shape: list[int], order: str, part: int) -> object:
        require_plain(dtype)
        flat = np.frombuffer(self._parts[part], dtype).copy()  # a part may begin at an odd address
        flat.setflags(write=False)
        return self.made(flat.reshape(shape, order="F" if order == "F" else "C"))

    def scalar(self, dtype: str, part: int) -> object:
        return self.made(np.frombuffer(self._parts[part], dtype)[0])

    def data(self, name: str, values: list[Any]) -> object:
        """Make a dataclass without its own checks: they ran where the object was made first."""
        kind = dataclass_named(name)
        made = object.__new__(kind)
        for each, tree in zip(fields(kind), values, strict=True):
            object.__setattr__(made, each.name, self.value(tree))
        return self.made(made)

    def error(self, name: str, args: Any, state: Any) -> object:
        kind = type_named(name)
        if not issubclass(kind, WpcalError):
            raise PlainDataError(f"{name} is not an error of wpcal")
        made = kind.__new__(kind)
        made.args = self.value(args)
        vars(made).update(self.value(state))
        return self.made(made)


_READERS: Mapping[str, Callable[[_Unpacker, Any], Any]] = {
    "list": lambda reader, items: [reader.value(item) for item in items],
    "tuple": lambda reader, items: tuple(reader.value(item) for item in items),
    "dict": lambda reader, items: {reader.value(key): reader.value(item) for key, item in items},
    "rows": lambda reader, column: tuple(values_of(column, reader)),
    "enum": lambda _, content: enum_named(content[0])[content[1]],
    "again": lambda reader, number: reader.again(number),
    "array": lambda reader, content: reader.array(*content),
    "scalar": lambda reader, content: reader.scalar(*content),
    "bytes": lambda reader, part: reader.made(bytes(reader._parts[part])),
    "path": lambda reader, text: reader.made(Path(text)),
    "set": lambda reader, content: reader.made(
        (frozenset if content[0] else set)(reader.value(item) for item in content[1])
    ),
    "error": lambda reader, content: reader.error(*content),
    "data": lambda reader, content: reader.data(*content),
}
"""By the key in the text: how the value is made again."""
