"""Seams against lists of welds: `python -m tests.benchmarks seams [PART …]`, described in `fixtures/welds/README.md`.

Own parts: `--lists FOLDER`, with STEP files beside the lists. Another program: `--seams FILE`, as in seams.json.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jsonschema
from rich.console import Console
from rich.table import Table

from tests.benchmarks.welds.fused import write_fused
from tests.benchmarks.welds.lists import FOLDER, read_record, sha256, welds_of
from tests.benchmarks.welds.results import FIRST, LAST, write_results
from tests.benchmarks.welds.score import WeldScore, score

PUBLIC = Path(os.environ.get("WPCAL_WELD_PARTS", Path(__file__).parents[3] / "shared" / "welds"))
"""Where the public parts are looked for that are not copied into this repository."""
COUNTS = ("accepted", "right", "optional", "wrong")  #: Of seams, by the names of `WeldScore`.
HEADINGS = ("part", "sure", "sure mm", "probable", "probable mm", *COUNTS, "wrong mm", "s")


@dataclass(frozen=True, slots=True)
class Run:
    """One part: its score, or why it has none."""

    part: str
    score: WeldScore | None
    seconds: float
    fault: str = ""


def main(arguments: Sequence[str] = ()) -> Table | None:
    """Score the parts and return the table; with `--json`, print JSON instead."""
    chosen = _parser().parse_args(arguments)
    runs = [_run(path, chosen) for path in _lists(chosen)]
    if not runs:
        sys.exit(f"no list in {chosen.lists} is called {' or '.join(chosen.part)}")
    if chosen.record:
        records = [_record(run) for run in runs]
        write_results(LAST, records)
        write_results(FIRST, records, only_new=True)
    if chosen.json:
        print(json.dumps([_record(run) for run in runs], indent=1, ensure_ascii=False))
        return None
    if chosen.part or chosen.missed:
        for run in runs:
            _show_faults(run)
    return table_of(runs)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks seams", description=__doc__)
    parser.add_argument("part", nargs="*", help="Names of lists; without one, all of them.")
    parser.add_argument("--lists", type=Path, default=FOLDER / "lists", metavar="FOLDER", help="Own lists.")
    parser.add_argument(
        "--parts", type=Path, default=PUBLIC, metavar="FOLDER", help="Public parts, or parts of own lists."
    )
    parser.add_argument("--seams", type=Path, metavar="FILE", help="Score this seams.json of one part; search nothing.")
    parser.add_argument("--missed", action="store_true", help="List missed welds and wrong seams of all parts.")
    parser.add_argument("--fused", action="store_true", help="Fuse the bodies that welds join; the lists stay.")
    parser.add_argument("--record", action="store_true", help="Keep the counts in fixtures/welds/results*.json.")
    parser.add_argument("--json", action="store_true", help="Print JSON with every missed weld and wrong seam.")
    return parser


def _lists(chosen: argparse.Namespace) -> Iterator[Path]:
    for path in sorted(chosen.lists.glob("*.json")):
        if not chosen.part or path.stem in chosen.part:
            yield path


def part_of(record: dict[str, Any], lists: Path, parts: Path) -> Path | None:
    """Return the STEP file of a list, or None if it is a public part that is not at hand."""
    name = record["part"]["file"]
    for folder in (FOLDER, parts, lists):
        if (folder / name).is_file():
            return folder / name
    return None


def checked_record(path: Path) -> dict[str, Any]:
    """Return a list that follows the schema; another one ends the program with one line."""
    try:
        record = read_record(path)
        jsonschema.validate(record, json.loads((FOLDER / "schema.json").read_text(encoding="utf-8")))
    except ValueError as error:
        sys.exit(f"{path}: is not JSON: {error}")
    except jsonschema.ValidationError as error:
        sys.exit(f"{path}: {error.json_path}: {error.message}; fixtures/welds/schema.json says what a list holds")
    return record


def _run(path: Path, chosen: argparse.Namespace) -> Run:
    record = checked_record(path)
    step = part_of(record, path.parent, chosen.parts)
    if chosen.seams is None and step is None:
        return Run(path.stem, None, 0.0, "part not at hand: " + record["part"].get("address", record["part"]["file"]))
    if step is not None and sha256(step) != record["part"]["sha256"]:
        return Run(path.stem, None, 0.0, f"{step} is another file than the one of the list")
    start, fault = time.process_time(), ""
    if chosen.fused and step is not None:
        step = fused_part(step, record)
        if step is None:
            return Run(path.stem, None, 0.0, "no bodies to fuse")
    try:
        seams = json.loads(chosen.seams.read_text(encoding="utf-8"))["seams"] if chosen.seams else seams_of(step)
    except Exception as error:  # a fault of ours or of the kernel: nothing is found, and the other parts are still run
        seams, fault = [], f"{type(error).__name__}: {error}"
    return Run(path.stem, score(path.stem, welds_of(record), seams), time.process_time() - start, fault)


def fused_part(step: Path, record: dict[str, Any]) -> Path | None:
    """Return the part with welded bodies fused, in a temporary file; None if there is nothing to fuse."""
    path = Path(tempfile.mkdtemp()) / step.with_suffix(".step").name
    return path if write_fused(step, welds_of(record), path) > 0 else None


def seams_of(step: Path | None) -> list[dict[str, Any]]:
    """Search the seams of a part as `wpcal seams` does, and return them as in seams.json."""
    from cad.workpiece.seams import find_seams
    from cad.workpiece.workpiece import open_workpiece
    from wpcal.seam import SeamOptions
    from wpcal.seam.record import seams_record

    found, _ = find_seams(open_workpiece(step), SeamOptions())
    seams: list[dict[str, Any]] = seams_record(found)["seams"]
    return seams


def _record(run: Run) -> dict[str, Any]:
    facts = {"part": run.part} if run.score is None else run.score.to_record()
    return {**facts, "seconds": round(run.seconds, 2), **({"fault": run.fault} if run.fault else {})}


def _show_faults(run: Run) -> None:
    """Print the missed welds and the wrong seams of a part."""
    console = Console(width=160, highlight=False)
    for item in run.score.missed if run.score else ():
        members = " + ".join(item["members"])
        text = f"{item['class']} {item['id']!r}, {item['kind']}, {members}, {item['length_mm']} mm at {item['at_mm']}"
        console.print(f"{run.part}: missed {text}; found {item['found']:.0%}", markup=False)
    for item in run.score.wrong_seams if run.score else ():
        text = f"{item.get('name')} {item.get('joint')} {item.get('weld')}, bodies {item.get('solids')}"
        console.print(f"{run.part}: wrong {text}, {item['length_mm']} mm at {item['at_mm']}", markup=False)


def table_of(runs: Sequence[Run]) -> Table:
    """Return the scores as a table, with a last row for all parts together."""
    table = Table(title="Seams against lists of welds", caption_justify="left")
    for heading in HEADINGS:
        table.add_column(heading, justify="left" if heading == "part" else "right")
    for run in runs:
        cells = [""] * (len(HEADINGS) - 2) if run.score is None else _cells(run.score)
        table.add_row(run.part, *cells, f"{run.seconds:.1f}")
    table.caption = "\n".join(f"{run.part}: {run.fault}" for run in runs if run.fault)
    scores = [run.score for run in runs if run.score is not None]
    if len(scores) > 1:
        table.add_section()
        table.add_row("all", *_sums(scores), f"{sum(run.seconds for run in runs):.1f}")
    return table


def _cells(found: WeldScore) -> list[str]:
    """Return the cells of one part."""
    sure, probable = found.sure, found.probable
    counts = [f"{c.found} of {c.of}" if c.of else "" for c in (sure, probable)]
    lengths = [f"{c.found_mm / c.of_mm:.0%}" if c.of_mm else "" for c in (sure, probable)]
    seams = (getattr(found, name) for name in COUNTS)
    return [counts[0], lengths[0], counts[1], lengths[1], *(str(n) for n in seams), f"{found.wrong_mm:.0f}"]


def _sums(scores: Sequence[WeldScore]) -> list[str]:
    """Return the cells of all parts together: shares of length, and the shares of wrong seams."""
    cells = []
    for cls in ("sure", "probable"):
        found = [getattr(one, cls) for one in scores]
        cells.append(f"{sum(c.found for c in found)} of {sum(c.of for c in found)}")
        cells.append(f"{sum(c.found_mm for c in found) / max(sum(c.of_mm for c in found), 1e-9):.0%}")
    accepted = sum(one.accepted for one in scores)
    cells += [str(sum(getattr(one, name) for one in scores)) for name in COUNTS[:-1]]
    wrong = sum(one.wrong for one in scores)
    wrong_mm, all_mm = sum(one.wrong_mm for one in scores), sum(one.accepted_mm for one in scores)
    return [*cells, f"{wrong} = {wrong / max(accepted, 1):.0%}", f"{wrong_mm:.0f} = {wrong_mm / max(all_mm, 1e-9):.0%}"]
