"""`wpcal drift`: what changes from job to job of one part."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option

if TYPE_CHECKING:
    from wpcal.study.drift import PartDrift, PartJobs
    from wpcal.study.drift.pooled import CellErrors
    from wpcal.study.drift.watch import JobsAsked


@command()
@path_argument("folders", metavar="OUT...", nargs=-1, required=True)
@path_option("-o", "--out", metavar="PAGE.html", required=True, help="Output: the page.")
@takes("asked", "wpcal.study.drift.watch:JobsAsked")
@path_option(
    "--cell-errors",
    metavar="FILE.json",
    help="Keep the errors of touches, robot and tool in this cell, for calibrate --robot-mm and --tool-mm FILE.json.",
)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the page and its JSON file.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: what the JSON file holds.")
def drift(
    *, folders: tuple[Path, ...], out: Path, asked: JobsAsked, cell_errors: Path | None, force: bool, as_json: bool
) -> int:
    """Show what changes over the jobs of a part: pose, residuals and seam errors, with control limits.

    OUT is a folder of `wpcal batch`, or several of them. A sudden shift is marked with its date and its likely cause:
    the fixture or the base, the touch of one point, or the robot. Beside the page, PAGE.json holds the same numbers.
    Jobs are in the order of the column when of their lists. Each part has a section; a part needs 8 jobs. What was
    corrected alike on the pendant in most of them (wpcal touchup -o OUT/JOB/NAME) is proposed once.
    """
    from wpcal.cli.outputs import require_new
    from wpcal.cli.progress import shown_progress
    from wpcal.core.errors import InputError
    from wpcal.core.records import to_json, write_file
    from wpcal.core.result_files import CALIBRATION_FILE
    from wpcal.pages.drift import build_drift_page
    from wpcal.results.agree import require_as_written
    from wpcal.study.drift import read_drift_jobs
    from wpcal.study.drift.pooled import pool_jobs
    from wpcal.study.drift.record import drift_record

    beside = out.with_suffix(".json")
    if out.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{out}: expected the name of a page, as drift.html")
    for path in filter(None, (out, beside, cell_errors)):
        require_new(path, overwrite=force)
    with shown_progress("reading jobs") as progress:
        jobs, failed = read_drift_jobs(folders, advance=lambda done: progress(f"reading jobs: {done}"))
        for job in (job for folder in folders for job in sorted(folder.glob("*/job.json"))):
            require_as_written(job.with_name(CALIBRATION_FILE))
        parts, left_out = _watched(jobs, asked, failed=len(failed))
        corrected = _corrected(folders, parts)
        record = drift_record(parts, failed, left_out, corrected)
        page = build_drift_page(parts, failed, left_out, corrected)
    pooled = pool_jobs(jobs) if cell_errors else None
    write_file(beside, to_json(record), overwrite=force)
    write_file(out, page, overwrite=force)
    if as_json:
        print_json(record)
    else:
        _show(record)
        click.echo(f"wrote {out} and {beside}")
    if cell_errors and pooled:
        write_file(cell_errors, to_json(pooled.to_record()), overwrite=force)
        click.echo(f"{pooled.field.describe()}; calibrate this cell with {_state(pooled, cell_errors)}", err=as_json)
    return 0


def _state(pooled: CellErrors, file: Path) -> str:
    """Return the options that state the errors of a cell."""
    tool = f" --tool-mm {file}" if pooled.tool else ""
    return f"--sigma-mm {pooled.sigma_mm:.2g} --robot-mm {file}{tool}"


def _corrected(folders: Sequence[Path], parts: Sequence[PartDrift]) -> list[list[str]]:
    """Return for each part what was corrected alike on it: by the touch-ups in the folders of its jobs."""
    from wpcal.controllers.touchup.record import earlier_touch_ups, proposals

    found = [each for folder in folders for each in earlier_touch_ups(folder, must=False)]
    return [proposals([each for each in found if each.get("part") == part.jobs.sha256]) for part in parts]


def _watched(jobs: Sequence[PartJobs], asked: JobsAsked, *, failed: int) -> tuple[list[PartDrift], list[str]]:
    """Return the parts with enough jobs, and a line about each of the others."""
    from wpcal.core.errors import InputError
    from wpcal.core.wording import listed
    from wpcal.study.drift import watch_part

    if not jobs:
        raise InputError(f"no job has a calibration; {failed} failed")
    part = asked.part
    if part is not None:
        found = [each for each in jobs if part in (each.file, each.sha256)]
        if not found:
            raise InputError(
                f"--on-part {part}: no job is on this part; parts: {', '.join(each.file for each in jobs)}"
            )
        jobs = found
    parts, left_out = [], []
    for each in jobs:
        if each.on_others:
            left_out.append(f"{each.file}: jobs without the points of most jobs: {listed(each.on_others)}")
        try:
            parts.append(watch_part(each, first=asked.first))
        except InputError as error:
            left_out.append(str(error))
    if not parts:
        raise InputError("; ".join(left_out[:3]))
    return parts, left_out


def _show(record: dict[str, Any]) -> None:
    from wpcal.cli.console import plain_console
    from wpcal.core.wording import listed

    say = partial(plain_console().print, soft_wrap=True)
    for part in record["parts"]:
        shifts = len(part["shifts"])
        say(f"{part['part']['file']}: {part['jobs']} jobs, {shifts} sudden {'shift' if shifts == 1 else 'shifts'}")
        for shift in part["shifts"]:
            when = f" ({shift['when']})" if shift["when"] else ""
            say(f"  from job {shift['job']}{when}: {shift['sentence']}")
        for line in part["corrected"]:
            say(f"  {line}")
        if part["most_wrong"] is not None:
            say(f"  taught wrong most: {part['most_wrong']}")
    for line in record["left_out"]:
        say(f"left out: {line}")
    if record["failed"]:
        say(f"left out: jobs without a calibration: {listed(each['job'] for each in record['failed'])}")
