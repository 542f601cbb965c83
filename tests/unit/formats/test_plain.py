"""Plain JSON and CSV, and the JSON Schemas that are shipped."""

import csv
import io
import json

import jsonschema
import numpy as np
import pytest

from wpcal.core.schemas import schema_text
from wpcal.formats.plain import write_program_csv, write_program_json


def test_seams_json_follows_its_schema(finished_folder):
    record = json.loads((finished_folder() / "seams.json").read_text(encoding="utf-8"))
    validator = jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/seams/1")))
    validator.validate(record)
    del record["seams"][0]["frames"][0]["R"]
    with pytest.raises(jsonschema.ValidationError, match="'R' is a required property"):
        validator.validate(record)


def test_json_keeps_every_digit_and_follows_its_schema(make_program):
    program = make_program(1)
    files = write_program_json(program)
    record = json.loads(files["WPCAL.program.json"])
    jsonschema.Draft202012Validator(json.loads(files["program-1.schema.json"])).validate(record)
    poses = record["seams"][0]["poses"]
    np.testing.assert_array_equal([pose["p_mm"] for pose in poses], program.paths[0].p_base)
    np.testing.assert_array_equal([pose["R"] for pose in poses], program.paths[0].R_base)


def test_csv_keeps_every_digit_and_says_frame_and_sense(make_program):
    program = make_program(1, names=('a,"b"\n', "W2"))
    rows = list(csv.DictReader(io.StringIO(write_program_csv(program)["WPCAL.program.csv"])))
    assert [row["seam"] for row in rows[:16]] == ['a,"b"\n'] * 16
    assert {(row["frame"], row["z_sense"]) for row in rows} == {("base", "inward")}
    p = np.array([[float(row[key]) for key in ("x_mm", "y_mm", "z_mm")] for row in rows])
    R = np.array([[float(row[f"r{i}{j}"]) for i in (1, 2, 3) for j in (1, 2, 3)] for row in rows]).reshape(-1, 3, 3)
    np.testing.assert_array_equal(p, np.concatenate([path.p_base for path in program.paths]))
    np.testing.assert_array_equal(R, np.concatenate([path.R_base for path in program.paths]))
    assert [row["role"] for row in rows[:3]] == ["approach", "weld", "weld"]
    assert rows[0]["u95_mm"] == ""
