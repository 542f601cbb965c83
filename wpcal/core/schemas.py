"""The JSON Schema of every record that wpcal writes, found by the name that the record states.

The file ``wpcal/results/schemas/plan-1.schema.json`` (JSON Schema, draft 2020-12) describes the record
``wpcal/plan/1``. There is no list beside the files, so no schema can be forgotten. Records are read with them, too
(`wpcal.core.record_check`); readers are in every layer, so this module is in the lowest.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files

from wpcal.core.errors import InputError

_FOLDER = files("wpcal") / "results" / "schemas"
_ENDING = ".schema.json"


def schema_names() -> list[str]:
    """Return the names of all records that have a schema, sorted."""
    return sorted(_names())


@cache
def _names() -> frozenset[str]:
    parts = (file.name.removesuffix(_ENDING).rpartition("-") for file in _FOLDER.iterdir())
    return frozenset(f"wpcal/{kind}/{version}" for kind, _, version in parts)


def schema_file(name: str) -> str:
    """Return the name of the file that describes a record: ``plan-1.schema.json`` for ``wpcal/plan/1``.

    Raises
    ------
    InputError
        When there is no schema of that name.
    """
    if not has_schema(name):
        raise InputError(f"no schema {name!r}; known: {', '.join(schema_names())}")
    _, kind, version = name.split("/")
    return f"{kind}-{version}{_ENDING}"


def has_schema(name: str) -> bool:
    """Tell whether a record of this name has a schema here."""
    return name in _names()


def schema_text(name: str) -> str:
    """Return the JSON Schema of a record as text, for example of ``wpcal/seams/1``.

    Raises
    ------
    InputError
        When there is no schema of that name.
    """
    return (_FOLDER / schema_file(name)).read_text(encoding="utf-8")


@cache
def required_fields(name: str) -> tuple[str, ...]:
    """Return the fields that every record of this name has at its top level, as its schema lists them.

    Raises
    ------
    InputError
        When there is no schema of that name.
    """
    return tuple(json.loads(schema_text(name)).get("required", ()))
