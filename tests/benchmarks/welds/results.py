"""Recorded scores: `python -m tests.benchmarks.welds.results` prints them, and their sum into docs/benchmark.md."""

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from tests.benchmarks.welds.lists import FOLDER

FIRST, LAST = FOLDER / "results-first.json", FOLDER / "results.json"
PAGE = FOLDER.parents[1] / "docs" / "benchmark.md"
BEGIN, END = "<!-- scores -->", "<!-- end of scores -->"
LEFT_OUT = ("missed", "wrong_seams", "seconds")


def read_results(path: Path) -> dict[str, dict[str, Any]]:
    """Return recorded scores by the name of the part."""
    return {row["part"]: row for row in json.loads(path.read_text(encoding="utf-8"))["parts"]}


def write_results(path: Path, records: Sequence[dict[str, Any]], *, only_new: bool = False) -> None:
    """Write the counts of scores, one line per part. Parts that were not at hand keep the line that they had.

    With `only_new`, so do all parts that have one, and the others get the commit of the code on their line.
    """
    rows, commit = read_results(path) if path.is_file() else {}, _commit()
    for record in records:
        if "sure" in record and not (only_new and record["part"] in rows):
            rows[record["part"]] = {key: value for key, value in record.items() if key not in LEFT_OUT}
            if only_new:
                rows[record["part"]]["commit"] = commit
    lines = ",\n".join(f"  {json.dumps(rows[name])}" for name in sorted(rows))
    if only_new and path.is_file():
        commit = json.loads(path.read_text(encoding="utf-8"))["commit"]
    head = '"about": "Scores of the seams that wpcal accepts by default, by the code of the commit."'
    path.write_text(f'{{\n {head},\n "commit": "{commit}",\n "parts": [\n{lines}\n ]\n}}\n', encoding="utf-8")


def _commit() -> str:
    """Return the commit of the code at hand."""
    git = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=True, cwd=FOLDER)
    return git.stdout.strip()


HEAD = """| part | sure, first | now | probable, first | now | accepted: right or optional + wrong, first | now |
|-|-|-|-|-|-|-|"""


def table() -> str:
    """Return the first and last scores of every part; those that were added later with their first commit."""
    first, last = read_results(FIRST), read_results(LAST)
    rows = (_row(f"{name} {first[name].get('commit', '')[:7]}", first[name], last[name]) for name in sorted(last))
    return "\n".join([HEAD, *rows])


def total() -> str:
    """Return the table of the page: the scores of all parts together."""
    sums = (_sum(read_results(path).values()) for path in (FIRST, LAST))
    return f"{HEAD}\n{_row('**all**', *sums)}\n"


def _row(name: str, first: dict[str, Any], last: dict[str, Any]) -> str:
    cells = (cell for one in ("sure", "probable") for cell in (_found(first[one]), _found(last[one])))
    return f"| {name} | {' | '.join((*cells, _accepted(first), _accepted(last)))} |"


def _found(cls: dict[str, Any]) -> str:
    if not cls["of"]:
        return ""
    return f"{cls['found']} of {cls['of']}, {cls['found_mm'] / cls['of_mm']:.0%}"


def _accepted(row: dict[str, Any]) -> str:
    fault, wrong_mm = " (fault)" if row.get("fault") else "", abs(row["wrong_mm"])
    return f"{row['right'] + row['optional']} + {row['wrong']}, wrong {wrong_mm:.0f} mm{fault}"


def _sum(rows: Iterator[dict[str, Any]] | Any) -> dict[str, Any]:
    """Return the counts of all parts together."""
    found = list(rows)
    total: dict[str, Any] = {
        cls: {key: sum(row[cls][key] for row in found) for key in ("found", "of", "found_mm", "of_mm")}
        for cls in ("sure", "probable")
    }
    return total | {key: sum(row[key] for row in found) for key in ("right", "optional", "wrong", "wrong_mm")}


def main() -> None:
    head, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    PAGE.write_text(f"{head}{BEGIN}\n{total()}{END}{rest.split(END)[1]}", encoding="utf-8")
    sys.stdout.write(f"{table()}\n")


if __name__ == "__main__":
    main()
