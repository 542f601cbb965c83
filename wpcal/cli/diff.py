"""`wpcal diff`: compare the results of a calibration with golden ones."""

from __future__ import annotations

from pathlib import Path

import click

from wpcal.cli.option_groups import command, option_of
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import JSON_HELP, path_argument


@command()
@path_argument("out", metavar="OUT")
@path_argument("golden", metavar="GOLDEN")
@option_of("wpcal.results.diff:compare_folders.atol_mm", "--atol-mm", help="Distances up to this count as equal.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the differences.")
def diff(*, out: Path, golden: Path, atol_mm: float, as_json: bool) -> int:
    """Compare calibration.json and seams.json in OUT with those in GOLDEN; ends with code 1 if they differ."""
    from wpcal.results.agree import require_as_written
    from wpcal.results.diff import compare_folders

    for folder in (out, golden):
        require_as_written(folder)
    differences = compare_folders(out, golden, atol_mm=atol_mm)
    if as_json:
        found = [d.to_record() for d in differences]
        print_json({"schema": "wpcal/diff/1", "atol_mm": atol_mm, "differences": found})
    else:
        from wpcal.cli.console import new_table, plain_console

        console = plain_console()
        if differences:
            table = new_table(f"{len(differences)} differences (limit {atol_mm:g} mm)", "<where|<found|<golden|<off by")
            for d in differences:
                table.add_row(d.where, d.found, d.expected, d.off_by)
            console.print(table)
        else:
            console.print(f"no difference (limit {atol_mm:g} mm)")
    return 1 if differences else 0
