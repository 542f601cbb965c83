"""`wpcal bodies`: which bodies of a part may move, as a file to edit."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.options import no_cache_option
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option

if TYPE_CHECKING:
    from rich.table import Table


@click.command()
@path_argument("part_step", metavar="PART.step")
@path_option("-o", "--out", help="Output: bodies.json, to edit.")
@click.option("--force", is_flag=True, help=FORCE_HELP)
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: bodies.json.")
def bodies(*, part_step: Path, out: Path | None, force: bool, as_json: bool, no_cache: bool) -> int:
    """List the bodies of PART.step that `--bodies` lets move, and write them as a file to edit.

    Each solid is a body; a part of one solid is cut into members at its concave edges. In the file, put solids that
    move as one into one body, and give bodies tack tolerances of their own.
    """
    from cad.cli.kernel_work import run_on_part
    from wpcal.cli.outputs import require_new
    from wpcal.core.records import to_json, write_file

    if out is not None:
        require_new(out, overwrite=force)
    record, issues = run_on_part(
        "cad.workpiece.bodies_file:list_bodies", part_step, {}, what=f"reading {part_step}", use_cache=not no_cache
    )
    if out is not None:
        write_file(out, to_json(record).encode("utf-8"), overwrite=force)
    if as_json:
        print_json(record)
        return 0
    from wpcal.cli.console import plain_console, show_notes

    console = plain_console()
    console.print(_table(record["bodies"], part_step.name))
    show_notes(issues, console)
    if out is not None:
        console.print("tolerances in the file count as stated; delete them to let wpcal estimate them")
        console.print(f"wrote {out}")
    return 0


def _table(rows: Sequence[dict[str, Any]], file_name: str) -> Table:
    from wpcal.cli.console import new_table

    headings = "<body|<=faces|<=centre mm|<=size mm|<=tack mm|<=tack mrad"
    table = new_table(f"Bodies of {file_name} that may move (part frame)", headings)
    for row in rows:
        centre, size = (" ".join(f"{value:.1f}" for value in row[key]) for key in ("centre_mm", "size_mm"))
        table.add_row(row["name"], str(row["faces"]), centre, size, f"{row['tack_mm']:g}", f"{row['tack_mrad']:g}")
    return table
