"""`wpcal report`: the page of a finished calibration, made again from its files."""

from __future__ import annotations

from pathlib import Path

import click

from wpcal.cli.outputs import print_json, say_note
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option


@click.command()
@path_argument("folder", metavar="DIR")
@path_option("-o", "--out", help="Output: the page.  [default: DIR/report.html]")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the page.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the verdict and the file.")
def report(*, folder: Path, out: Path | None, force: bool, as_json: bool) -> int:
    """Write the page of the calibration in DIR: one HTML file that opens from disk.

    It is made from calibration.json, seams.json and, if it exists, part.glb. `wpcal calibrate` writes the
    same page. Ends with code 1 unless the verdict of the calibration is PASS; the page is written and says so.
    """
    from wpcal.core.records import write_file
    from wpcal.core.result_files import PAGE_FILE
    from wpcal.core.whole_folder import begin_replacing
    from wpcal.pages.report import build_report
    from wpcal.results.agree import note_written
    from wpcal.results.folder import read_result_folder

    found = read_result_folder(folder)
    say_note(found.note)
    target = out or folder / PAGE_FILE
    page = build_report(found.calibration, found.seams, found.part_glb)
    begin_replacing()
    write_file(target, page, overwrite=force)
    if target.absolute() == (folder / PAGE_FILE).absolute():
        note_written(folder, PAGE_FILE)
    verdict = found.calibration["verdict"]
    if as_json:
        print_json({"schema": "wpcal/report/1", "verdict": verdict, "file": str(target)})
    else:
        click.echo(f"wrote {target}")
    return 0 if verdict == "PASS" else 1
