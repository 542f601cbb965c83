import json

import numpy as np
import pytest

from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import new_directory, read_json, to_compact_json, to_json, write_file

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
