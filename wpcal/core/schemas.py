"""The JSON Schema of every record that wpcal writes, found by the name that the record states.

Schemas (draft 2020-12) are generated from the types of `wpcal.core.record_types`. Records are read with them, too
(`wpcal.core.record_check`); readers are in every layer, so this module is in the lowest.
"""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import Any

from wpcal.core.errors import InputError
from wpcal.core.record_types import RECORDS


def schema_names() -> list[str]:
    """Return the names of all records that have a schema, sorted."""
    return sorted(RECORDS)


def schema_file(name: str) -> str:
    """Return the name of a file with the schema of a record: ``plan-1.schema.json`` for ``wpcal/plan/1``.

    Raises `InputError` when there is no schema of that name.
    """
    if not has_schema(name):
        raise InputError(f"no schema {name!r}; known: {', '.join(schema_names())}")
    _, kind, version = name.split("/")
    return f"{kind}-{version}.schema.json"


def has_schema(name: str) -> bool:
    """Tell whether a record of this name has a schema here."""
    return name in RECORDS


@cache
def schema(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a record, for example of ``wpcal/seams/1``; errors as `schema_file`."""
    from wpcal.core.record_types.schema import schema_of, type_at

    schema_file(name)
    _, kind, version = name.split("/")
    found = schema_of(type_at(RECORDS[name]), f"urn:wpcal:schema:{kind}:{version}")
    examples = _examples().get(name)
    return {**found, "examples": examples} if examples else found


@cache
def _examples() -> dict[str, Any]:
    """Return examples of records, by their names."""
    text = resources.files("wpcal.core.record_types").joinpath("examples.json").read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text)
    return found


def schema_text(name: str) -> str:
    """Return the JSON Schema of a record as text; errors as `schema_file`."""
    return json.dumps(schema(name), indent=1, ensure_ascii=False) + "\n"


def required_fields(name: str) -> tuple[str, ...]:
    """Return the fields that every record of this name has at its top level; errors as `schema_file`."""
    return tuple(schema(name).get("required", ()))
