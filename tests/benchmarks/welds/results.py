"""Recorded scores, and their table in `docs/benchmark.md`: `python -m tests.benchmarks.welds.results` writes it."""

from __future__ import annotations

import json
import subprocess
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


def table() -> str:
    """Return the table of the page: first and last scores of every part, and all parts together."""
    first, last = read_results(FIRST), read_results(LAST)
    lines = [
        "| part | sure, first | now | probable, first | now | accepted: right or optional + wrong, first | now |",
        "|-|-|-|-|-|-|-|",
        *(_row(name, first[name], last[name]) for name in sorted(last)),
        _row("**all**", _sum(first.values()), _sum(last.values())),
    ]
    later = [f"`{name}` by commit {row['commit'][:7]}" for name, row in sorted(first.items()) if "commit" in row]
    commits = [json.loads(path.read_text(encoding="utf-8"))["commit"][:7] for path in (FIRST, LAST)]
    added = f"; parts that were added later: {', '.join(later)}" if later else ""
    return "\n".join([*lines, "", f"First: commit {commits[0]}{added}. Now: commit {commits[1]}.", ""])


def _row(name: str, first: dict[str, Any], last: dict[str, Any]) -> str:
    cells = (cell for one in ("sure", "probable") for cell in (_found(first[one]), _found(last[one])))
    return f"| {name} | {' | '.join((*cells, _accepted(first), _accepted(last)))} |"


def _found(cls: dict[str, Any]) -> str:
    if not cls["of"]:
        return ""
    return f"{cls['found']} of {cls['of']}, {cls['found_mm'] / cls['of_mm']:.0%}"


def _accepted(row: dict[str, Any]) -> str:
    fault = " (fault)" if row.get("fault") else ""
    return f"{row['right'] + row['optional']} + {row['wrong']}, wrong {row['wrong_mm']:.0f} mm{fault}".replace(
        "-0 ", "0 "
    )


def _sum(rows: Iterator[dict[str, Any]] | Any) -> dict[str, Any]:
    """Return the counts of all parts together."""
    found = list(rows)
    total: dict[str, Any] = {
        cls: {key: sum(row[cls][key] for row in found) for key in ("found", "of", "found_mm", "of_mm")}
        for cls in ("sure", "probable")
    }
    return total | {key: sum(row[key] for row in found) for key in ("right", "optional", "wrong", "wrong_mm")}


def main() -> None:
    """Put the table into the page."""
    text = PAGE.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN)
    PAGE.write_text(f"{head}{BEGIN}\n{table()}{END}{rest.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()
