"""`wpcal place`: where the part or the robot should stand so that most length of the seams is reachable."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json, require_result
from wpcal.cli.part_option import part_option, read_part_option
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, ONLY_HELP, path_argument, path_option

if TYPE_CHECKING:
    from wpcal.planning.sequence.place import MapOptions


@command()
@path_argument("cell_json", metavar="CELL.json")
@path_argument("result", metavar="RESULT")
@click.option("--only", metavar="W1,W5-W8", help=f"{ONLY_HELP}  [default: the accepted ones]")
@part_option
@takes("options", "wpcal.planning.sequence.place:MapOptions")
@path_option("-o", "--out", "output", metavar="MAP.svg", required=True, help="Output: a file.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the picture.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the map.")
def place(
    *,
    cell_json: Path,
    result: Path,
    only: str | None,
    part: Path | None,
    options: MapOptions,
    output: Path,
    force: bool,
    as_json: bool,
) -> int:
    """Search where the part or the robot should stand so that most length of the seams is reachable.

    Writes a picture of the map. The ends and the middle of each seam are looked at: joint limits, singular poses, and
    collisions with the bodies of the cell. Plan at the best place to see the rest. Ends with code 1 if no place
    reaches all seams.
    """
    from wpcal.cli.progress import shown_progress
    from wpcal.core.records import write_file
    from wpcal.pages.draw.place import place_svg
    from wpcal.planning.cell.cell_file import read_one_robot
    from wpcal.planning.sequence.place import WHOLE, map_places
    from wpcal.planning.sequence.sequence_input import read_sequence_input
    from wpcal.planning.sequence.targets import SequenceTargets
    from wpcal.seam.names import split_names

    require_result(result, cell_json)
    cell = read_one_robot(cell_json)
    names = None if only is None else split_names(only)
    given = read_sequence_input(result, cell, names, part_glb=read_part_option(part))
    cell = given.placed(cell)
    with shown_progress("starting") as progress:
        found = map_places(cell, given.part, given.seams, SequenceTargets(), options, progress=progress)
    write_file(output, place_svg(found), overwrite=force)
    if as_json:
        print_json(found.to_record(cell.name))
    else:
        flag = "robot" if options.moved.value == "robot" else "part" if cell.carrier is None else "positioner"
        numbers = itertools.chain(*found.best_at.to_record().values())
        click.echo(f"now: {100 * found.now:.0f} % of the length is reachable with seams in one piece")
        click.echo(f"best: {100 * found.best.share:.0f} % with {found.best.words(options.moved)}")
        click.echo(f"in a new cell file: --{flag}-at {','.join(f'{round(number, 3) + 0.0:.7g}' for number in numbers)}")
        click.echo(f"drawn in {output}")
    return 0 if found.best.share > WHOLE else 1
