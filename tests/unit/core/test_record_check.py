"""Records: written, read, and checked against their schemas as a general validator does; faults say where."""

import copy
import json
import random
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from tests.fuzz.mutate import mutated
from wpcal.core.errors import FormatError, InputError
from wpcal.core.record_check import check_record
from wpcal.core.records import new_directory, parse_json, read_json, to_compact_json, to_json, write_file
from wpcal.core.schemas import schema_names, schema_text

ROOT = Path(__file__).parents[3]
CELL = ROOT / "fixtures" / "cells" / "two-mh6.json"


@pytest.mark.parametrize("name", schema_names())
def test_examples_pass(name: str) -> None:
    for example in json.loads(schema_text(name)).get("examples", ()):
        check_record(example, name, path="r.json", is_complete=True)


def loosened(schema: Any) -> Any:
    """Return a schema that allows unknown fields, as our check does."""
    if isinstance(schema, dict):
        return {k: loosened(v) for k, v in schema.items() if not (k == "additionalProperties" and v is False)}
    return [loosened(value) for value in schema] if isinstance(schema, list) else schema


def test_what_passes_here_passes_a_general_validator() -> None:
    validator = jsonschema.Draft202012Validator(loosened(json.loads(schema_text("wpcal/cell/1"))))
    rng, data, passed = random.Random(3), CELL.read_bytes(), 0
    for _ in range(300):
        try:
            record = parse_json(mutated(data, (data,), rng), path="")
            check_record(record, "wpcal/cell/1", path="", is_complete=True)
        except FormatError:
            continue
        passed += 1
        validator.validate(record)
    assert 10 < passed < 290


def place(record: Any) -> Any:
    return record["torch_robot"]["T_world_base"]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda r: place(r)["xyz_mm"].__setitem__(1, float("nan")), "xyz_mm[1]: expected a number"),
        (lambda r: place(r)["xyz_mm"].__setitem__(1, 1e10), "xyz_mm[1]: expected a number from -1e+09"),
        (lambda r: place(r)["rpy_deg"].__setitem__(1, 1e9), "rpy_deg[1]: expected a number from -1e+06"),
        (lambda r: r.update(safety_distance_mm=True), "safety_distance_mm: expected a number from 0"),
        (lambda r: r.update(safety_distance_mm="5"), "safety_distance_mm: expected a number from 0 to 1e+09, got '5'"),
        (lambda r: r.update(name=7), "name: expected a text, got 7"),
        (lambda r: r.update(name="\ud800"), "name: a text holds half of a surrogate pair"),
        (lambda r: r.update(bench=7), "bench: expected a list, got 7"),
        (lambda r: r.update(bench=[None]), "bench[0]: expected an object, got None"),
        (lambda r: r.update(mine={"deep": [1e300]}), "mine.deep[0]: expected a number of at most 1e+15"),
        (lambda r: r.update(mine=10**400), "mine: expected a whole number of at most 64 bits"),
    ],
)  # fmt: skip
def test_the_place_of_a_fault_is_said(change: Any, says: str) -> None:
    record = copy.deepcopy(json.loads(CELL.read_text()))
    change(record)
    with pytest.raises(FormatError) as caught:
        check_record(record, "wpcal/cell/1", path="cell.json")
    assert str(caught.value).startswith("cell.json: ")
    assert says in str(caught.value)


def test_a_missing_field_is_a_fault_of_a_complete_record_only() -> None:
    record = {"schema": "wpcal/seams/1", "seams": [{"name": "W1", "frames": [{"s_mm": 0.0}]}]}
    check_record(record, "wpcal/seams/1", path="seams.json")
    with pytest.raises(FormatError, match="the field 'frame' is missing"):
        check_record(record, "wpcal/seams/1", path="seams.json", is_complete=True)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('{"schema": ' + "[" * 100_000, "too many lists or objects in one another"),
        ('{"schema": ' + "9" * 5000 + "}", "a whole number of thousands of digits"),
        ('{"schema": 7}', "expected a record of schema wpcal/cell/1, found none"),
        ("[]", "found none"),
    ],
)
def test_json_that_python_cannot_take_is_refused(text: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "r.json"
    path.write_text(text)
    with pytest.raises(FormatError, match=says):
        read_json(path, schema="wpcal/cell/1")


def test_a_byte_order_mark_is_read_over(tmp_path: Path) -> None:
    path = tmp_path / "cell.json"
    path.write_bytes(b"\xef\xbb\xbf" + CELL.read_bytes())
    assert read_json(path, schema="wpcal/cell/1")["schema"] == "wpcal/cell/1"


SCHEMA = "wpcal/test/1"


def test_a_record_reads_back_to_the_same_numbers(tmp_path):
    record = {"schema": SCHEMA, "values": np.array([0.1, 1 / 3, 1e-300])}
    write_file(tmp_path / "r.json", to_json(record), overwrite=False)
    assert read_json(tmp_path / "r.json", schema=SCHEMA)["values"] == record["values"].tolist()


def test_nan_has_no_place_in_a_record():
    with pytest.raises(ValueError, match="not JSON compliant"):
        to_json({"schema": SCHEMA, "value": float("nan")})


def test_another_schema_and_broken_json_are_refused(tmp_path):
    (tmp_path / "r.json").write_text(json.dumps({"schema": "wpcal/test/2"}))
    with pytest.raises(FormatError, match=r"expected a record of schema wpcal/test/1, found wpcal/test/2"):
        read_json(tmp_path / "r.json", schema=SCHEMA)
    (tmp_path / "r.json").write_text('{"a": 1,\n "b" 2}')
    with pytest.raises(FormatError, match="line 2"):
        read_json(tmp_path / "r.json", schema=SCHEMA)


def test_an_existing_file_is_kept_without_overwrite(tmp_path):
    write_file(tmp_path / "a.txt", "first", overwrite=False)
    with pytest.raises(InputError, match="allow overwriting"):
        write_file(tmp_path / "a.txt", "second", overwrite=False)
    assert (tmp_path / "a.txt").read_text() == "first"
    write_file(tmp_path / "a.txt", "second", overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_a_folder_appears_whole_or_not_at_all(tmp_path):
    def fill_half_of_it():
        with new_directory(tmp_path / "out", overwrite=False) as folder:
            (folder / "one.txt").write_text("1")
            raise RuntimeError("half way")

    with pytest.raises(RuntimeError):
        fill_half_of_it()
    assert list(tmp_path.iterdir()) == []
    with new_directory(tmp_path / "out", overwrite=False) as folder:
        (folder / "one.txt").write_text("1")
    assert (tmp_path / "out" / "one.txt").read_text() == "1"


def random_value(rng: np.random.Generator, depth: int) -> object:
    """Return a value as a record holds it: lists of like and of unlike things, and dicts with other keys."""
    plain = (None, True, 3, -0.0, 1e-7, 1.5e300, 'a "%s" ü\n', float(rng.normal()), 7, "")
    kind = int(rng.integers(4 if depth else 1))
    if kind == 0:
        return plain[int(rng.integers(len(plain)))]
    if kind == 1:
        return [random_value(rng, depth - 1) for _ in range(int(rng.integers(4)))]
    if kind == 2:
        return tuple(rng.normal(size=int(rng.integers(20))).tolist())
    return {f"k%ü{k}": random_value(rng, depth - 1) for k in range(int(rng.integers(4)))}


def test_a_record_is_written_as_the_standard_library_writes_it():
    for seed in range(300):
        record = {"schema": SCHEMA, "value": random_value(np.random.default_rng(seed), 5), "empty": [{}, [], ()]}
        assert to_json(record) == json.dumps(record, indent=1, ensure_ascii=False) + "\n"
        assert to_compact_json(record) == json.dumps(record, separators=(",", ":"))
