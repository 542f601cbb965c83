"""JSON Schema from the types of records (`wpcal.core.record_types`)."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import msgspec

from wpcal.core.record_types.parts import inlined

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def type_at(where: str) -> type[Any]:
    """Return the type at ``"module:Class"``."""
    module, _, name = where.partition(":")
    found: type[Any] = getattr(import_module(module), name)
    return found


def schema_of(kind: type[Any], urn: str, *, inline: bool = False) -> dict[str, Any]:
    """Return the JSON Schema of a type.

    `kind`: Its docstring is the title, and after an empty line the description.
    `urn`: The ``$id``.
    `inline`: Whether parts stand at their places, without ``$defs``.
    """
    parts: dict[str, Any] = {}
    if inline:
        (own,) = inlined(kind)
    else:
        (root,), parts = msgspec.json.schema_components([kind], ref_template="#/$defs/{name}")
        own = parts.pop(root["$ref"].removeprefix("#/$defs/"))
        for part in (own, *parts.values()):
            del part["title"]
    title, _, description = own.pop("description", "").partition("\n\n")
    head = {"$schema": DRAFT, "$id": urn, "title": title}
    if description:
        head["description"] = description
    found: dict[str, Any] = _with_constants({**head, **own, **({"$defs": parts} if parts else {})})
    return found


def _with_constants(node: Any) -> Any:
    """Say ``const`` in place of a choice of one; descriptions are on one line."""
    if isinstance(node, list):
        return [_with_constants(each) for each in node]
    if not isinstance(node, dict):
        return node
    found = {key: _with_constants(each) for key, each in node.items()}
    if found.get("required") == []:
        del found["required"]
    if isinstance(found.get("enum"), list) and len(found["enum"]) == 1:
        (found["const"],) = found.pop("enum")
    if isinstance(found.get("description"), str):
        found["description"] = " ".join(found["description"].split())
    return found
