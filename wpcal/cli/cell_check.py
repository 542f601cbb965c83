"""The check of a cell, as `wpcal cell check` and `wpcal plan --check` run it."""

from __future__ import annotations

from pathlib import Path

import click

from wpcal.cli.outputs import print_json


def run_cell_check(cell_json: Path, output: Path | None, *, force: bool, as_json: bool) -> int:
    """Tell what is odd in a cell, and draw it; 2 if anything is odd."""
    from wpcal.core.records import write_file
    from wpcal.pages.cell import build_cell_page
    from wpcal.planning.cell.cell_check import cell_check_record, check_cell
    from wpcal.planning.cell.cell_file import read_cell

    cell = read_cell(cell_json)
    issues, html = check_cell(cell), build_cell_page(cell)
    record = cell_check_record(cell, issues)
    page = (output or Path()) / "cell.html"
    page.parent.mkdir(parents=True, exist_ok=True)
    write_file(page, html, overwrite=force)
    if as_json:
        print_json(record)
    else:
        for issue in issues:
            click.echo(issue.message)
        found = f"{len(issues)} oddities" if len(issues) > 1 else "1 oddity" if issues else "nothing odd"
        click.echo(f"{cell.name}: {found}")
        click.echo(f"drawn in {page}")
    return 2 if issues else 0
