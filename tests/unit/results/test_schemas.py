"""Every record that wpcal writes has a JSON Schema, which is found by the name that the record states."""

import json
import re
from pathlib import Path

import jsonschema
import pytest

from tests.record_checks import check_output
from wpcal.core.errors import InputError
from wpcal.core.schemas import required_fields, schema_file, schema_names, schema_text

ROOT = Path(__file__).parents[3]
NAME_IN_SOURCE = re.compile(r"wpcal/[a-z]+(?:-[a-z]+)*/[0-9]+")


@pytest.mark.parametrize("name", schema_names())
def test_a_schema_is_valid_and_so_are_its_examples(name: str) -> None:
    schema = json.loads(schema_text(name))
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["properties"]["schema"]["const"] == name
    assert schema["$id"] == f"urn:{':'.join(name.split('/')[:1])}:schema:{':'.join(name.split('/')[1:])}"
    assert "schema" in required_fields(name)
    assert schema_file(name) == "{1}-{2}.schema.json".format(*name.split("/"))
    for example in schema.get("examples", ()):
        jsonschema.Draft202012Validator(schema).validate(example)


@pytest.mark.parametrize(
    "name", ["wpcal/x/1", f"wpcal/{'x' * 300}/1", "plan", "wpcal/plan/01", "wpcal/../plan/1", "wpcal/plan/1/"]
)
def test_an_unknown_schema_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=rf"no schema '{re.escape(name)}'; known: .*wpcal/program/1"):
        schema_text(name)


def test_every_record_that_the_source_names_has_a_schema_and_the_reverse() -> None:
    source = [path for package in ("wpcal", "cad") for path in (ROOT / package).rglob("*.py")]
    source = [path for path in source if path.parent.name != "records"]
    named = {name for path in source for name in NAME_IN_SOURCE.findall(path.read_text(encoding="utf-8"))}
    assert named == set(schema_names())


def test_a_record_that_breaks_its_schema_is_noticed_wherever_a_test_writes_it() -> None:
    from wpcal.core.records import to_json

    to_json({"schema": "wpcal/taught/1", "points": [{"name": "P1", "p_base_mm": [1.0, 2.0, 3.0]}]})
    with pytest.raises(jsonschema.ValidationError, match="is too short"):
        to_json({"schema": "wpcal/taught/1", "points": [{"name": "P1", "p_base_mm": [1.0, 2.0]}]})
    with pytest.raises(KeyError, match="schema"):
        to_json({"points": []})


FIXTURES = [path for path in sorted((ROOT / "fixtures").rglob("*.json")) if not {"welds", "whole"} & {*path.parts}]
"""Without what no command writes: lists of welds (`test_weld_lists` checks them), and columns of golden records."""


@pytest.mark.parametrize("path", FIXTURES, ids=lambda path: str(path.relative_to(ROOT)))
def test_the_records_among_the_fixtures_follow_their_schemas(path: Path) -> None:
    record = json.loads(path.read_text(encoding="utf-8"))
    validator = jsonschema.Draft202012Validator(json.loads(schema_text(record["schema"])))
    assert [error.message for error in validator.iter_errors(record)] == []


@pytest.mark.parametrize("path", sorted((ROOT / "wpcal" / "robot" / "arms").glob("*.json")), ids=lambda path: path.stem)
def test_the_shipped_arms_follow_their_schema(path: Path) -> None:
    validator = jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/arm/1")))
    assert [error.message for error in validator.iter_errors(json.loads(path.read_text()))] == []


def test_a_file_that_breaks_its_schema_is_noticed_after_a_command(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    record = {"schema": "wpcal/taught/1", "points": [{"name": "P1", "p_base_mm": [1.0, 2.0, 3.0]}]}
    check_output(["taught", "--json", "-o", "out"], json.dumps(record), cwd=tmp_path)
    (tmp_path / "out" / "a.json").write_text(json.dumps({**record, "more": 1}))
    with pytest.raises(jsonschema.ValidationError, match="'more' was unexpected"):
        check_output(["taught", "-o", "out"], "", cwd=tmp_path)
    with pytest.raises(jsonschema.ValidationError, match="'more' was unexpected"):
        check_output(["taught", "--json"], json.dumps({**record, "more": 1}), cwd=tmp_path)
