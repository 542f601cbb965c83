"""A small record of every schema, made from the schema itself, so that no kind of record can be forgotten."""

import json
import re
from collections.abc import Mapping
from typing import Any

from wpcal.core.schemas import schema_names, schema_text

TEXTS = ("a", "a-b", "0" * 64, "1:2", "135", "", "0123abcd")
"""Of these the first that fits the pattern of a field is taken."""


def sample_records() -> dict[str, dict[str, Any]]:
    """Return one record by the name of its schema: every field is there, every list has an entry."""
    found = {}
    for name in schema_names():
        schema = json.loads(schema_text(name))
        found[name] = _sample(schema, schema.get("$defs", {}))
    return found


def _sample(schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> Any:
    if "$ref" in schema:
        return _sample(definitions[schema["$ref"].removeprefix("#/$defs/")], definitions)
    alternatives = schema.get("oneOf") or schema.get("anyOf")
    if alternatives:
        return _sample(alternatives[0], definitions)
    if "const" in schema or "enum" in schema:
        return schema["const"] if "const" in schema else schema["enum"][0]
    kind = schema.get("type", "number")
    kind = next(one for one in kind if one != "null") if isinstance(kind, list) else kind
    makers = {"object": _object, "array": _list, "string": _text, "boolean": lambda *_: True, "null": lambda *_: None}
    return makers.get(kind, _number)(schema, definitions)


def _object(schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> dict[str, Any]:
    found = {key: _sample(inner, definitions) for key, inner in schema.get("properties", {}).items()}
    others = schema.get("additionalProperties")
    return {**found, "a": _sample(others, definitions)} if isinstance(others, dict) else found


def _list(schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> list[Any]:
    item = _sample(schema.get("items", {}), definitions)
    differ = schema.get("uniqueItems", False) and isinstance(item, str)
    return [f"{item}{number}" if differ else item for number in range(max(1, schema.get("minItems", 1)))]


def _text(schema: Mapping[str, Any], _: Mapping[str, Any]) -> str:
    fitting = (text for text in TEXTS if re.search(schema.get("pattern", ""), text))
    return next(text for text in fitting if len(text) >= schema.get("minLength", 0))


def _number(schema: Mapping[str, Any], _: Mapping[str, Any]) -> int:
    above = schema.get("exclusiveMinimum")
    return int(schema.get("minimum", 0)) if above is None else int(above) + 1
