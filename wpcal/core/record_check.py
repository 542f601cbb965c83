"""Check a record that was read against its JSON Schema: every number is finite, in range and of its type.

This covers the part of JSON Schema that the schemas of wpcal use. It differs from a general validator in three ways:
fields that the schema does not know are allowed, numbers have a largest value also where the schema states none, and a
message names the place of the first fault only.
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, TypeAlias

from wpcal.core.arrays import LARGEST_MM
from wpcal.core.errors import FormatError
from wpcal.core.schemas import has_schema, schema
from wpcal.core.wording import shown

LARGEST_DEG = 1e6  #: Angles: more than 2700 turns are a mistake, and far below this a float64 still has 1e-9 degrees.
LARGEST_NUMBER = 1e15  #: Other numbers: the largest whole number below which float64 holds every tenth.
LARGEST_WHOLE = 2**64  #: Whole numbers: seeds have up to 64 bits.
MOST_LEVELS = 64  #: Lists and objects in one another, in a field that the schema does not know.
_ENTRY_WORDS = {"frames": "point", "searches": "search", "bodies": "body"}
"""Names of list entries that are not the singular of the list's name: ``seams.csv`` counts points, too."""

Where: TypeAlias = "tuple[Where, str | int] | None"
"""The place of a value: its parent's place, and its key or index."""
Check: TypeAlias = Callable[[Any, Where], None]


class _WrongError(Exception):
    """A value at a place is not what was expected."""

    def __init__(self, where: Where, what: str) -> None:
        super().__init__(what)
        self.where = where


def check_record(record: Mapping[str, Any], schema: str, *, path: str, is_complete: bool = False) -> None:
    """Refuse a record with a value that is not what its schema says.

    Raises `FormatError` with the place of the first fault, for example ``seam W1: point 3: p_mm[1]``.

    `schema`: Its name and version, for example ``wpcal/seams/1``. A record of an extension has no schema here; its
    numbers and texts are checked all the same.
    `is_complete`: Whether a missing field is a fault, too. A reader needs fewer fields than wpcal writes, and people
    write files by hand: each reader says itself which field it misses.
    """
    _apply(_check_of(schema, is_complete) if has_schema(schema) else _check_unknown, record, path)


def check_complete(value: Mapping[str, Any], schema: Mapping[str, Any], *, path: str) -> None:
    """Refuse a value that is not what a schema says, or lacks a field; for schemas that are no record's.

    Raises `FormatError` as `check_record`.
    """
    _apply(_Schema(schema.get("$defs", {}), True).check_for(schema, ""), value, path)


def _apply(check: Check, record: Mapping[str, Any], path: str) -> None:
    try:
        check(record, None)
    except _WrongError as error:
        place = _place(error.where, record)
        raise FormatError(f"{place}: {error}" if place else str(error), path=path) from None


def find_faults(record: Mapping[str, Any], schema: str, *, most: int = 50) -> list[tuple[str, str]]:
    """Return every value that is not what its schema says: its place and what is wrong, as `check_record` says them."""
    check = _check_of(schema, False) if has_schema(schema) else _check_unknown
    left, faults = copy.deepcopy(dict(record)), list[tuple[str, str]]()
    while len(faults) < most:
        try:
            check(left, None)
        except _WrongError as error:
            faults.append((_place(error.where, left), str(error)))
            if not _drop(error.where, left):
                break
        else:
            break
    return faults


def _drop(where: Where, record: Any) -> bool:
    """Delete the nearest field around a place, so that what follows can be checked; False for the whole record."""
    while where is not None and not isinstance(where[1], str):
        where = where[0]
    if where is None:
        return False
    keys, above = list[str | int](), where[0]
    while above is not None:
        keys.append(above[1])
        above = above[0]
    for key in reversed(keys):
        record = record[key]
    del record[where[1]]
    return True


@cache
def _check_of(name: str, is_complete: bool) -> Check:
    found = schema(name)
    return _Schema(found.get("$defs", {}), is_complete).check_for(found, "")


def _place(where: Where, record: Any) -> str:
    """Return a place as people say it: ``seam W1: point 3: p_mm[1]``; ``seams[0].name`` if an entry has no name."""
    keys: list[str | int] = []
    while where is not None:
        where, key = where
        keys.append(key)
    parts: list[str] = [""]
    field, value = "", record
    for key in reversed(keys):
        value = value[key]
        if isinstance(key, str):
            parts[-1] += f".{key}" if parts[-1] else key
            field = key
            continue
        name = value.get("name") if isinstance(value, dict) else None
        word = _ENTRY_WORDS.get(field, field.removesuffix("s"))
        if isinstance(value, dict) and word != field and (field in _ENTRY_WORDS or (isinstance(name, str) and name)):
            parts[-1] = parts[-1].removesuffix(field) + f"{word} {name if isinstance(name, str) and name else key}"
            parts.append("")
        else:
            parts[-1] += f"[{key}]"
    return ": ".join(part for part in parts if part)


class _Schema:
    """Turns the parts of one schema into functions."""

    def __init__(self, definitions: Mapping[str, Any], is_complete: bool) -> None:
        self.definitions, self.is_complete = definitions, is_complete

    def check_for(self, schema: Mapping[str, Any], field: str) -> Check:
        """Return the function that checks a value. `field`: Name of the nearest field above; its end is the unit."""
        if "$ref" in schema:
            return self.check_for(self.definitions[schema["$ref"].removeprefix("#/$defs/")], field)
        alternatives = schema.get("oneOf") or schema.get("anyOf")
        if alternatives:
            return _any_of([self.check_for(one, field) for one in alternatives])
        if "enum" in schema or "const" in schema:
            return _one_of(schema.get("enum", [schema.get("const")]))
        kinds = schema.get("type")
        if isinstance(kinds, list):
            return _any_of([self.check_for({**schema, "type": kind}, field) for kind in kinds])
        makers: Mapping[str, Callable[[Mapping[str, Any], str], Check]] = {
            "object": self._object,
            "array": self._array,
            "number": _number,
            "integer": _whole,
            "string": _string,
            "boolean": lambda *_: _boolean,
            "null": lambda *_: _null,
        }
        return makers[kinds](schema, field) if kinds else _check_unknown

    def _object(self, schema: Mapping[str, Any], field: str) -> Check:
        checks = {key: self.check_for(value, key) for key, value in schema.get("properties", {}).items()}
        required, fewest = schema.get("required", ()) if self.is_complete else (), schema.get("minProperties", 0)
        others = schema.get("additionalProperties")
        check_other = self.check_for(others, field) if isinstance(others, dict) else _check_unknown

        def check(value: Any, where: Where) -> None:
            if type(value) is not dict:
                raise _WrongError(where, f"expected an object, got {shown(value)}")
            for key in required:
                if key not in value:
                    raise _WrongError(where, f"the field {key!r} is missing")
            if len(value) < fewest:
                raise _WrongError(where, f"expected at least {fewest} entries, got {len(value)}")
            for key, inner in value.items():
                if key in checks:
                    checks[key](inner, (where, key))
                else:
                    _require_unicode(key, where)
                    check_other(inner, (where, key))

        return check

    def _array(self, schema: Mapping[str, Any], field: str) -> Check:
        check_item = self.check_for(schema["items"], field) if "items" in schema else _check_unknown
        fewest, most = schema.get("minItems", 0), schema.get("maxItems")
        is_unique = schema.get("uniqueItems", False)
        wanted = f"{fewest}" if fewest == most else f"at least {fewest}" if most is None else f"{fewest} to {most}"

        def check(value: Any, where: Where) -> None:
            if type(value) is not list:
                raise _WrongError(where, f"expected a list, got {shown(value)}")
            if len(value) < fewest or (most is not None and len(value) > most):
                raise _WrongError(where, f"expected {wanted} entries, got {len(value)}")
            for index, item in enumerate(value):
                check_item(item, (where, index))
            if is_unique and len({json.dumps(item) for item in value}) < len(value):
                raise _WrongError(where, "expected entries that differ")

        return check


def _any_of(checks: Sequence[Check]) -> Check:
    def check(value: Any, where: Where) -> None:
        faults = []
        for one in checks:
            try:
                return one(value, where)
            except _WrongError as fault:
                faults.append(fault)
        deep = [fault for fault in faults if fault.where != where]  # the kind was right, an entry of it is not
        raise (deep or faults)[0]

    return check


def _one_of(allowed: Sequence[Any]) -> Check:
    expected = " or ".join(json.dumps(one) for one in allowed)

    def check(value: Any, where: Where) -> None:
        if not any(type(value) is type(one) and value == one for one in allowed):  # true == 1
            raise _WrongError(where, f"expected {expected}, got {shown(value)}")

    return check


def _number(schema: Mapping[str, Any], field: str) -> Check:
    most = _largest(field)
    low, high = schema.get("minimum", -most), schema.get("maximum", most)
    above = schema.get("exclusiveMinimum")
    span = f"from {low:g} to {high:g}" if above is None else f"above {above:g}, at most {high:g}"

    def check(value: Any, where: Where) -> None:
        is_number = type(value) is float or type(value) is int
        if not is_number or not low <= value <= high or (above is not None and value <= above):
            raise _WrongError(where, f"expected a number {span}, got {shown(value)}")

    return check


def _whole(schema: Mapping[str, Any], field: str) -> Check:
    low, high = schema.get("minimum", -LARGEST_WHOLE), schema.get("maximum", LARGEST_WHOLE)

    def check(value: Any, where: Where) -> None:
        if type(value) is not int or not low <= value <= high:
            raise _WrongError(where, f"expected a whole number from {low} to {high}, got {shown(value)}")

    return check


def _largest(field: str) -> float:
    """Return the largest number of a field: its name ends with its unit, and transforms are in mm."""
    if field.endswith("_deg"):
        return LARGEST_DEG
    return LARGEST_MM if field.endswith("_mm") or field.startswith("T_") else LARGEST_NUMBER


def _string(schema: Mapping[str, Any], field: str) -> Check:
    fewest = schema.get("minLength", 0)
    pattern = re.compile(schema["pattern"]) if "pattern" in schema else None

    def check(value: Any, where: Where) -> None:
        if type(value) is not str:
            raise _WrongError(where, f"expected a text, got {shown(value)}")
        if len(value) < fewest or (pattern is not None and not pattern.search(value)):
            expected = f"a text of the form {pattern.pattern}" if pattern else "a text that is not empty"
            raise _WrongError(where, f"expected {expected}, got {shown(value)}")
        _require_unicode(value, where)

    return check


def _boolean(value: Any, where: Where) -> None:
    if type(value) is not bool:
        raise _WrongError(where, f"expected true or false, got {shown(value)}")


def _null(value: Any, where: Where) -> None:
    if value is not None:
        raise _WrongError(where, f"expected null, got {shown(value)}")


def _require_unicode(text: str, where: Where) -> None:
    if not text.isascii():
        try:
            text.encode("utf-8")
        except UnicodeEncodeError:
            raise _WrongError(where, "a text holds half of a surrogate pair, which is not Unicode") from None


def _check_unknown(value: Any, where: Where) -> None:
    """Check what the schema does not describe: numbers must be finite, texts Unicode, and levels few."""
    stack: list[tuple[Any, Where, int]] = [(value, where, 0)]
    while stack:
        one, place, level = stack.pop()
        if level > MOST_LEVELS:
            raise _WrongError(where, f"more than {MOST_LEVELS} lists or objects in one another")
        if isinstance(one, dict):
            for key, inner in one.items():
                _require_unicode(key, place)
                stack.append((inner, (place, key), level + 1))
        elif isinstance(one, list):
            stack.extend((inner, (place, index), level + 1) for index, inner in enumerate(one))
        elif isinstance(one, str):
            _require_unicode(one, place)
        elif isinstance(one, float) and not abs(one) <= LARGEST_NUMBER:
            raise _WrongError(place, f"expected a number of at most {LARGEST_NUMBER:g}, got {shown(one)}")
        elif isinstance(one, int) and abs(one) > LARGEST_WHOLE:
            raise _WrongError(place, f"expected a whole number of at most 64 bits, got {shown(one)}")
