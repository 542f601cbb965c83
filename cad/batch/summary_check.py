"""Check the summary of a batch against the records of its jobs."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cad.batch.job_record import read_job_record
from cad.batch.summary import CSV_COLUMNS, FAILED, NUMBERS, csv_row
from wpcal.core.csv_text import csv_text
from wpcal.core.errors import FormatError
from wpcal.core.input_file import holds_file, read_bytes
from wpcal.core.record_check import check_record
from wpcal.core.records import parse_json
from wpcal.core.result_files import JOB_FILE, SUMMARY_FILE, SUMMARY_SCHEMA, SUMMARY_TABLE
from wpcal.results.differences import Difference, differences_of, walk_records

FROM_RESULT = ("verdict", *NUMBERS, "pose")  #: Fields of a line that are those of the job's result.


def read_summary(out: Path) -> list[dict[str, Any]]:
    """Read ``summary.jsonl``.

    Raises `InputError` when it cannot be opened.
    Raises `FormatError` when a line is not one of a summary.
    """
    path, lines = out / SUMMARY_FILE, []
    for number, text in enumerate(read_bytes(path).splitlines(), start=1):
        record = parse_json(text, path=f"{path}, line {number}")
        if not isinstance(record, dict) or record.get("schema") != SUMMARY_SCHEMA:
            raise FormatError(f"expected a record {SUMMARY_SCHEMA}", path=str(path), line=number)
        check_record(record, SUMMARY_SCHEMA, path=f"{path}, line {number}", is_complete=True)
        lines.append(record)
    return lines


def check_summary(out: Path, lines: list[dict[str, Any]]) -> Iterator[Difference]:
    """Yield what the summary says otherwise than the folders of its jobs, which are checked apart."""
    yield from _listed_twice(lines)
    for line in lines:
        yield from _check_line(out, line)
    known = {line["job"] for line in lines}
    for path in sorted(out.iterdir()):
        if path.name not in known and (path / JOB_FILE).is_file():
            yield Difference(f"{SUMMARY_FILE} {path.name}", "missing", "a line, as there is a folder")
    if not holds_file(out, SUMMARY_TABLE):
        yield Difference(SUMMARY_TABLE, "missing", "there")
        return
    mine, expected = read_bytes(out / SUMMARY_TABLE), csv_text([CSV_COLUMNS, *map(csv_row, lines)]).encode()
    if mine != expected:
        yield from differences_of(SUMMARY_TABLE, mine, expected)


def _listed_twice(lines: list[dict[str, Any]]) -> Iterator[Difference]:
    """Yield jobs and lines of the list that come twice. A row that repeats the name of a job failed."""
    done = Counter(line["job"] for line in lines if line["verdict"] != FAILED)
    rows = Counter(line["line"] for line in lines)
    twice = {name for name, count in done.items() if count > 1}
    twice |= {line["job"] for line in lines if rows[line["line"]] > 1}
    for name in sorted(twice):
        yield Difference(f"{SUMMARY_FILE} {name}", "listed twice", "listed once")


def _check_line(out: Path, line: Mapping[str, Any]) -> Iterator[Difference]:
    where = f"{SUMMARY_FILE} {line['job']}"
    if line["verdict"] == FAILED:
        yield from (
            Difference(f"{where} {n}", json.dumps(line[n]), "null") for n in FROM_RESULT[1:] if line[n] is not None
        )
        return
    record = read_job_record(out / line["job"])
    if record is None:  # the folder itself is told to be wrong
        return
    expected = {**record["result"], **{name: record["inputs"][name]["file"] for name in ("part", "taught")}}
    for name in (*FROM_RESULT, "part", "taught"):
        yield from walk_records(line[name], expected[name], f"{where} {name}")
    if line["error"] is not None:
        yield Difference(f"{where} error", line["error"], "null")
