"""`wpcal match`: which feature each taught point is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cad.cli.options import POINTS, no_cache_option
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import JSON_HELP, path_argument

if TYPE_CHECKING:
    from cad.batch.request import NominalAsked
    from wpcal.controllers.taught_program import PointsAsked
    from wpcal.taught.match import Match, MatchOptions

MOST_SHOWN = 20  #: Answers shown; --json has all of them.


@command()
@path_argument("part_step", metavar="PART.step")
@path_argument("taught", metavar="TAUGHT")
@takes("options", "wpcal.taught.match:MatchOptions")
@takes("place", "cad.batch.request:NominalAsked")
@takes("reading", POINTS)
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: all answers.")
def match(
    *,
    part_step: Path,
    taught: Path,
    options: MatchOptions,
    place: NominalAsked,
    reading: PointsAsked,
    as_json: bool,
    no_cache: bool,
) -> int:
    """Find which feature of PART.step each point of TAUGHT is, from the distances between the points.

    TAUGHT is a table (.csv) or a controller's program, as for `wpcal calibrate`. Rows whose column feature is empty,
    and points of a program whose name the part does not have, may be any feature. Lists every answer that the teaching
    error can explain; of several answers the one nearest to --nominal is taken. If the points do not decide between the
    answers, the command ends with code 2, and the line on stderr says what would decide.
    """
    from cad.cli.kernel_work import run_on_part

    arguments = {"taught": reading.read_taught(taught), "options": replace(options, T_nominal_part=place.nominal)}
    found: Match = run_on_part(
        "cad.workpiece.calibrate:match_taught", part_step, arguments, what=f"matching {taught}", use_cache=not no_cache
    )
    if as_json:
        print_json(found.to_record())
    else:
        _show(found)
    if found.chosen is None:
        click.echo(f"wpcal: {taught}: {found.reason}", err=True)
        return 2
    return 0


def _show(found: Match) -> None:

    from wpcal.cli.console import new_table, plain_console

    table = new_table("Which feature each taught point is", "<")
    for point in found.points:
        table.add_column(point)
    table.add_column("RMS mm", justify="right")
    table.add_column("probability", justify="right")
    for k, answer in enumerate(found.answers[:MOST_SHOWN]):
        mark = "taken" if k == found.chosen else ""
        table.add_row(mark, *answer.features, f"{answer.rms_mm:.4f}", f"{answer.probability:.2g}")
    if len(found.answers) > MOST_SHOWN:
        table.caption = f"the first {MOST_SHOWN} of {len(found.answers)} answers"
    console = plain_console()
    console.print(table)
    if found.chosen is not None:
        console.print(f"taken: {found.reason}")
