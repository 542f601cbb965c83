"""`wpcal taught`: the taught points of a controller's program as the table that `wpcal calibrate` reads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option

if TYPE_CHECKING:
    from wpcal.controllers.taught_program import PointsAsked


@command()
@path_argument("program", metavar="PROGRAM")
@path_option("-o", "--out", metavar="TAUGHT.csv", help="Output: a table.  [default: stdout]")
@takes("reading", "wpcal.controllers.taught_program:PointsAsked")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: TAUGHT.csv.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the points.")
def taught(*, program: Path, out: Path | None, reading: PointsAsked, force: bool, as_json: bool) -> int:
    """Read taught points from PROGRAM, a file of a robot controller, in base coordinates.

    The column feature repeats the name of the point. Replace it by the name of the touched feature. `wpcal calibrate`
    reads programs directly; this command shows what it reads.
    """
    from wpcal.controllers.taught_program import require_program
    from wpcal.core.records import write_file
    from wpcal.taught.table import taught_csv, taught_record

    require_program(program)
    read = reading.read_taught(program)
    if out is not None:
        write_file(out, taught_csv(read), overwrite=force)
    if as_json:
        print_json(taught_record(read))
    elif out is None:
        click.echo(taught_csv(read), nl=False)
    else:
        click.echo(f"wrote {len(read.names)} points to {out}")
    return 0
