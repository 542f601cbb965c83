"""`wpcal match`: which feature each taught point is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cad.cli.options import POINT_LETTERS, POINTS, no_cache_option
from wpcal.cli.option_groups import command, takes
from wpcal.cli.shared_help import JSON_HELP, KIND_HELP, SIGMA_HELP

if TYPE_CHECKING:
    from wpcal.controllers.points_asked import PointsAsked
    from wpcal.taught.match import Match

MOST_SHOWN = 20  #: Answers shown; --json has all of them.


@command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@click.argument("taught", metavar="TAUGHT", type=click.Path(path_type=Path))
@click.option("--sigma-mm", type=float, help=f"{SIGMA_HELP}  [default: 0.3]")
@click.option(
    "--nominal",
    metavar="POSE",
    help="Place of the part in the cell's model: as in `wpcal calibrate`. Of several answers the nearest is taken.",
)
@click.option(
    "--kind",
    type=click.Choice(POINT_LETTERS),
    multiple=True,
    help=f"{KIND_HELP} For points without a name.  [default: all]",
)
@takes("reading", POINTS)
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: all answers.")
def match(
    *,
    part_step: Path,
    taught: Path,
    sigma_mm: float | None,
    nominal: str | None,
    kind: tuple[str, ...],
    reading: PointsAsked,
    as_json: bool,
    no_cache: bool,
) -> int:
    """Find which feature of PART.step each point of TAUGHT is, from the distances between the points.

    TAUGHT is a table (.csv) or a controller's program, as for `wpcal calibrate`. Rows whose column feature is empty,
    and points of a program whose name the part does not have, may be any feature. Lists every answer that the teaching
    error can explain. If the points do not decide between the answers, the command ends with code 2, and the line on
    stderr says what would decide.
    """
    from cad.batch.request import read_pose
    from cad.cli.kernel_work import run_on_part
    from wpcal.taught.features import POINT_KINDS, FeatureKind

    arguments = {
        "taught": reading.read_taught(taught),
        "sigma_mm": sigma_mm,
        "T_nominal_part": None if nominal is None else read_pose(nominal),
        "kinds": tuple(FeatureKind(letter) for letter in kind) or POINT_KINDS,
    }
    found: Match = run_on_part(
        "cad.workpiece.calibrate:match_taught", part_step, arguments, what=f"matching {taught}", use_cache=not no_cache
    )
    if as_json:
        from wpcal.core.records import to_json

        click.echo(to_json(found.to_record()), nl=False)
    else:
        _show(found)
    if found.chosen is None:
        click.echo(f"wpcal: {taught}: {found.reason}", err=True)
        return 2
    return 0


def _show(found: Match) -> None:
    from rich.table import Table

    from wpcal.cli.console import plain_console

    table = Table(title="Which feature each taught point is")
    table.add_column("")
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
        console.print(f"taken: {found.reason}", highlight=False)
