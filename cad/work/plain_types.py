"""Which types are plain data, by their names in a packet (`cad.work.plain_data`)."""

from __future__ import annotations

from dataclasses import is_dataclass
from enum import Enum
from importlib import import_module
from typing import Any

import numpy as np

OUR_PACKAGES = frozenset({"wpcal", "cad"})  #: Only enums, dataclasses and errors from these packages are made.
PLAIN_ARRAYS = "biufcUS"  #: Kinds of NumPy arrays that hold plain data: no Python objects.
BARE = frozenset({type(None), bool, int, float, str})  #: Types that are in the text of a packet as they are.


class PlainDataError(ValueError):
    """A value cannot be sent, or a packet is damaged."""


def name_of(kind: type) -> str:
    """Return the name of a class of ours: ``package.module:Class``."""
    if kind.__module__.partition(".")[0] not in OUR_PACKAGES:
        raise PlainDataError(f"a {kind.__module__}.{kind.__qualname__} is not plain data")
    return f"{kind.__module__}:{kind.__qualname__}"


def type_named(name: str) -> type[Any]:
    """Return a class of ours by its name."""
    module, _, path = name.partition(":")
    if module.partition(".")[0] not in OUR_PACKAGES:
        raise PlainDataError(f"{name} is not a type of wpcal")
    found: Any = import_module(module)
    for part in path.split("."):
        found = getattr(found, part)
    if not isinstance(found, type) or found.__module__ != module:
        raise PlainDataError(f"{name} is not a type of wpcal")
    return found


def enum_named(name: str) -> type[Enum]:
    """Return an enum of ours by its name."""
    kind = type_named(name)
    if not issubclass(kind, Enum):
        raise PlainDataError(f"{name} is not an enum")
    return kind


def dataclass_named(name: str) -> type[Any]:
    """Return a dataclass of ours by its name."""
    kind = type_named(name)
    if not is_dataclass(kind):
        raise PlainDataError(f"{name} is not a dataclass")
    return kind


def require_plain(dtype: str) -> None:
    """Refuse an array of Python objects."""
    if np.dtype(dtype).kind not in PLAIN_ARRAYS:
        raise PlainDataError(f"an array of {dtype!r} is not plain data")
