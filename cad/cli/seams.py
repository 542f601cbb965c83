"""`wpcal seams`: what can be welded on a part."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from cad.cli.options import seam_choice_options, seam_options, to_seam_choice, to_seam_options


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@seam_options
@seam_choice_options
@click.option(
    "--png", metavar="FILE", type=click.Path(path_type=Path), help="Write a picture of the part and its seams."
)
@click.option("--force", is_flag=True, help="Overwrite the picture.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON on stdout, in the form of seams.json, frame part.")
def seams(*, part_step: Path, png: Path | None, force: bool, as_json: bool, **values: Any) -> int:
    """List the weld seams of PART.step: contacts between solids, and concave edges inside one.

    Every candidate has a confidence; those below 50 % are listed apart with what speaks against them.
    """
    from cad.child import run_in_child
    from cad.cli.progress import shown_progress

    options, choice = to_seam_options(values), to_seam_choice(values)
    _check_picture(png, overwrite=force)
    with shown_progress() as progress:
        found, picture = run_in_child(
            "cad.convert:list_seams",
            {"step": part_step, "options": options, "choice": choice, "picture": png is not None},
            what=f"finding the seams of {part_step}",
            progress=progress,
        )
    if png is not None:
        from wpcal.core.records import write_file

        write_file(png, picture, overwrite=force)
    if as_json:
        from wpcal.core.records import to_json
        from wpcal.seam.record import seams_record

        click.echo(to_json(seams_record(found)), nl=False)
    else:
        from cad.cli.tables import refused_table, seams_table
        from wpcal.cli.console import plain_console

        console = plain_console()
        console.print(seams_table(found, f"Seams of {part_step.name} (part frame)"))
        if not all(seam.accepted for seam in found):
            console.print(refused_table(found))
    return 0


def _check_picture(png: Path | None, *, overwrite: bool) -> None:
    """Refuse before any work is done what cannot be drawn or written."""
    from importlib.util import find_spec

    from wpcal.core.errors import InputError

    if png is None:
        return
    if find_spec("matplotlib") is None:
        raise InputError("--png needs matplotlib: install wpcal[plots]")
    if png.exists() and not overwrite:
        raise InputError(f"{png}: exists; give --force to overwrite it")
