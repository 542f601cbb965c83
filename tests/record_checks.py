"""Every record that wpcal writes follows the JSON Schema that it names: checked wherever a test writes one."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema

from wpcal.core import records

OWN_NAME_OF_TESTS = "wpcal/test/1"  #: A record that tests of `wpcal.core.records` make up.

_to_json = records.to_json
_valid: set[int] = set()  #: Texts that were found valid, by their hash.


@cache
def _validator(name: str) -> jsonschema.Draft202012Validator:
    from wpcal.core.schemas import schema_text

    return jsonschema.Draft202012Validator(json.loads(schema_text(name)))


def check_record(record: Mapping[str, Any]) -> None:
    """Validate a record against its schema; a record that names no schema is a `KeyError`."""
    if record["schema"] != OWN_NAME_OF_TESTS:
        _validator(record["schema"]).validate(record)


def _check_text(text: str) -> None:
    """Validate a record as it was written; the same text is validated once."""
    if hash(text) not in _valid:
        check_record(json.loads(text))
        _valid.add(hash(text))


def checked_to_json(record: Mapping[str, Any]) -> str:
    """Write a record as JSON, as the real function does, and validate what was written."""
    text = _to_json(record)
    _check_text(text)
    return text


def check_output(arguments: Sequence[Path | str], stdout: str, *, cwd: Path) -> None:
    """Validate what a command printed with ``--json``, and the records in the folder or file that ``-o`` names.

    For the records that are written in other processes, where `checked_to_json` is not in place.
    """
    if "--json" in arguments:
        _check_text(stdout)
    if "-o" not in arguments:
        return
    out = cwd / arguments[list(arguments).index("-o") + 1]
    for path in sorted(out.rglob("*.json")) if out.is_dir() else []:
        if not path.name.endswith(".schema.json"):
            _check_text(path.read_text(encoding="utf-8"))
