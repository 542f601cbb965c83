"""The audit finds each fault that is put into a file, at its place, and calls clean files clean."""

import copy
import json
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cad.batch.summary import CSV_COLUMNS
from tests.running import run_here
from tests.shown_programs import shown_programs
from wpcal.controllers.audit import audit_path
from wpcal.controllers.audit.tables import TABLES as KINDS
from wpcal.controllers.audit.tables import TableKind, audit_table
from wpcal.controllers.audit.two_robots import _compared
from wpcal.core.csv_text import csv_text
from wpcal.core.records import to_json
from wpcal.core.rotations import rotation_from_zyx
from wpcal.seam.record import SEAMS_CSV_COLUMNS
from wpcal.taught.columns import TAUGHT_COLUMNS

ROOT = Path(__file__).parents[4]
FIXTURES = ROOT / "fixtures"
RECORDS = ("tee/golden/calibration.json", "tee/golden/seams.json", "cells/two-mh6.json", "cells/saddle-seams.json")
TABLES = ("tee/taught.csv", "tee/touches_321.csv", "yin2003/table1.csv")


@pytest.mark.parametrize("folder", ["tee", "lap", "frame", "saddle", "yin2003", "cells"])
def test_every_clean_file_of_the_fixtures_is_clean(folder: str) -> None:
    report = audit_path(FIXTURES / folder)
    assert report.files
    assert [(file.path, file.faults) for file in report.files if file.faults] == []
    assert {Path(one).suffix for one in report.not_audited} <= {".step", ".json"}


def test_every_program_in_the_docs_is_clean(tmp_path: Path) -> None:
    for number, shown in enumerate(shown_programs()):
        if shown.command.startswith("export"):
            folder = tmp_path / str(number)
            folder.mkdir()
            (folder / shown.file).write_bytes(shown.raw)
    report = audit_path(tmp_path)
    assert len(report.files) >= 5
    assert [(file.path, file.faults) for file in report.files if file.faults] == []


def leaves(value: Any, place: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Places of all values that hold no others, the first of each list."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, (*place, key))
    elif isinstance(value, list) and value:
        yield from leaves(value[0], (*place, 0))
    else:
        yield place


def wrong_for(value: Any) -> Any:
    """A value that the field cannot hold."""
    if isinstance(value, bool):
        return "maybe"
    return 1e300 if value is None or isinstance(value, int | float) else {"not": ["a", "text"]}


@cache
def record_of(file: str) -> Any:
    return json.loads((FIXTURES / file).read_text(encoding="utf-8"))


@pytest.mark.parametrize("file", RECORDS)
def test_each_wrong_field_of_a_record_is_found_at_its_place(file: str, tmp_path: Path) -> None:
    path = tmp_path / Path(file).name
    missed = []
    for place in leaves(record_of(file)):
        record = copy.deepcopy(record_of(file))
        inner = record
        for key in place[:-1]:
            inner = inner[key]
        inner[place[-1]] = wrong_for(inner[place[-1]])
        path.write_text(json.dumps(record), encoding="utf-8")
        (found,) = audit_path(path).files
        field = next(str(key) for key in reversed(place) if isinstance(key, str))
        if not any(field in f"{fault.field} {fault.message}" for fault in found.faults):
            missed.append((place, found.faults))
    assert missed == []


def test_every_fault_of_a_record_is_listed_not_only_the_first(tmp_path: Path) -> None:
    record = copy.deepcopy(record_of("tee/golden/seams.json"))
    first, second = record["seams"][0], record["seams"][1]
    first["accepted"], first["frames"][1]["p_mm"][2] = "no", float("nan")
    second["frames"][0]["s_mm"], second["length_mm"] = "0", True
    path = tmp_path / "seams.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    (found,) = audit_path(path).files
    assert sorted(str(fault.field) for fault in found.faults) == [
        "seam W1: accepted", "seam W1: point 1: p_mm[2]", "seam W2: length_mm", "seam W2: point 0: s_mm",
    ]  # fmt: skip


@pytest.mark.parametrize("file", TABLES)
def test_each_wrong_cell_of_a_table_is_found_at_its_line(file: str, tmp_path: Path) -> None:
    path = tmp_path / "taught.csv"
    header, *rows = (FIXTURES / file).read_text(encoding="utf-8").splitlines()
    for column, name in enumerate(header.split(",")):
        wrong = {"name": "", "feature": None, "model_name": None}.get(name, "maybe")
        if wrong is None:
            continue
        cells = [row.split(",") for row in rows]
        for row in (1, 2):
            cells[row][column] = wrong
        path.write_text("\n".join([header, *map(",".join, cells)]), encoding="utf-8")
        (found,) = audit_path(path).files
        assert [(fault.line, fault.column) for fault in found.faults] == [(3, name), (4, name)], name


def test_a_missing_or_misspelt_column_is_found(tmp_path: Path) -> None:
    path = tmp_path / "taught.csv"
    path.write_text("name,x_mm,y_mm,zz_mm\nV1,1,2,3\n", encoding="utf-8")
    (found,) = audit_path(path).files
    assert "z_mm" in found.faults[0].message
    path.write_text("point;x;y;z\nV1;1;2;3\n", encoding="utf-8")
    (found,) = audit_path(path).files
    assert "x_mm" in found.faults[0].message


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.kind)
def test_a_table_is_known_by_all_its_columns_or_all_but_one(kind: TableKind, tmp_path: Path) -> None:
    for column in (None, *(kind.columns if len(kind.columns) > 1 else ())):
        names = ["other" if name == column else name for name in kind.columns]
        found = audit_table(",".join(names).encode() + b"\n", tmp_path / "t.csv", is_named=False)
        assert (found or ("",))[0] == kind.kind, column


@pytest.mark.parametrize(
    ("own", "other", "found"),
    [
        ("a b c", "a b c", []),
        ("a b b c", "a b c", [(2, "mark b is there 2 times"), (1, "the marks are in another order than in other.mod")]),
        ("b a c", "a b c", [(1, "the marks are in another order than in other.mod")]),
        ("a b c d", "a b d", [(3, "mark c is not in other.mod: this robot would wait")]),
    ],
)
def test_marks_of_two_robots_are_compared(
    own: str, other: str, found: list[Any], tmp_path: Path, monkeypatch: Any
) -> None:
    (tmp_path / "other.mod").write_text("\n".join(f"WAIT {mark}" for mark in other.split()))
    monkeypatch.setattr("wpcal.controllers.audit.two_robots._other", lambda path: tmp_path / "other.mod")
    faults = _compared([f"WAIT {mark}" for mark in own.split()], tmp_path / "own.mod", r"WAIT (\w+)")
    assert [(fault.line, fault.message) for fault in faults] == found


def test_a_list_of_jobs_names_files_that_are_there(tmp_path: Path) -> None:
    jobs = tmp_path / "jobs.csv"
    jobs.write_text("job,part,taught\na,a.step,a.csv\nb,gone.step,a.csv\n")
    (tmp_path / "a.step").touch()
    (tmp_path / "a.csv").touch()
    [(kind, faults)] = [audit_table(jobs.read_bytes(), jobs, is_named=True) or ("", [])]
    assert (kind, len(faults)) == ("jobs of a batch", 1)
    assert (faults[0].line, faults[0].message) == (3, "gone.step: no such file or directory")
    jobs.write_text("job,part,taught\na,a.step,a.csv\n")
    assert audit_table(jobs.read_bytes(), jobs, is_named=True) == ("jobs of a batch", [])


def test_a_summary_names_inputs_and_no_files_beside_it() -> None:
    row = dict.fromkeys(CSV_COLUMNS, "") | {"job": "a", "verdict": "PASS", "part": "p.step", "taught": "t.csv"}
    raw = csv_text([row, row.values()]).encode()
    assert audit_table(raw, Path("summary.csv"), is_named=True) == ("summary of a batch", [])


def test_a_part_without_seams_has_a_clean_table_of_them(tmp_path: Path) -> None:
    for name, columns, faults in (("seams.csv", SEAMS_CSV_COLUMNS, 0), ("taught.csv", ("name", *TAUGHT_COLUMNS), 1)):
        path = tmp_path / name
        path.write_text(",".join(columns) + "\n", encoding="utf-8")
        assert audit_path(path).fault_count == faults


def test_files_of_two_runs_in_one_folder_are_found(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    shutil.copytree(FIXTURES / "tee" / "golden", folder)
    shutil.copy(FIXTURES / "lap" / "golden" / "part.glb", folder / "part.glb")
    report = audit_path(folder)
    faults = [(Path(file.path).name, fault.field) for file in report.files for fault in file.faults]
    assert faults == [("calibration.json", "part.glb")]


def test_a_rotation_that_lost_digits_is_repaired_and_others_are_not(tmp_path: Path) -> None:
    record = copy.deepcopy(record_of("tee/golden/seams.json"))
    frames = record["seams"][0]["frames"]
    exact = np.array(frames[0]["R"])
    frames[0]["R"] = np.round(exact, 4).tolist()
    path, fixed = tmp_path / "seams.json", tmp_path / "fixed" / "seams.json"
    fixed.parent.mkdir()
    path.write_text(to_json(record), encoding="utf-8")
    assert run_here("audit", path).returncode == 1
    ended = run_here("audit", path, "--fix", "-o", fixed, "--json")
    assert ended.returncode == 0
    assert json.loads(ended.stdout)["repaired"] == ["seam W1: point 0: R: the nearest rotation"]
    repaired = np.array(json.loads(fixed.read_text(encoding="utf-8"))["seams"][0]["frames"][0]["R"])
    np.testing.assert_allclose(repaired, exact, rtol=0, atol=1e-4)

    frames[0]["R"] = (exact @ np.diag([1.0, 1.0, -1.0])).tolist()
    frames[1]["R"] = (np.array(frames[1]["R"]) @ rotation_from_zyx(0.0, 0.0, 0.5)).tolist()
    path.write_text(to_json(record), encoding="utf-8")
    ended = run_here("audit", path, "--fix", "-o", tmp_path / "never.json")
    assert ended.returncode == 2
    assert "a person must decide (3 faults)" in ended.stderr
    assert not (tmp_path / "never.json").exists()


@pytest.mark.parametrize("arguments", [["nothing-here"], [str(ROOT / "LICENSE")], [str(FIXTURES / "tee"), "--fix"]])
def test_wrong_use_ends_with_2(arguments: list[str]) -> None:
    ended = run_here("audit", *arguments)
    assert ended.returncode == 2
    assert len(ended.stderr.strip().splitlines()) == 1
