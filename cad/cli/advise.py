"""`wpcal advise`: which features to teach."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.options import POINT_LETTERS, marked_options, seam_options, to_seam_choice, to_seam_options

if TYPE_CHECKING:
    from rich.table import Table

    from wpcal.advise import Advice


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@click.option("--points", type=int, default=4, show_default=True, help="How many to teach, --have included.")
@click.option(
    "--seams",
    metavar="W1,W2|FILE",
    multiple=True,
    help="Where the error counts (default: on all accepted seams), or a seams.json with edits.",
)
@click.option("--sigma-mm", type=float, default=0.3, show_default=True, help="Teaching error per axis.")
@click.option(
    "--criterion",
    type=click.Choice(["minimax", "least_squares"]),
    default="minimax",
    show_default=True,
    help="That of `wpcal calibrate`.",
)
@click.option("--have", metavar="V1,V4", default="", help="Features that are taught anyway.")
@click.option("--exclude", metavar="V3,H2", default="", help="Features not to be advised.")
@click.option("--near", metavar="X,Y,Z,R", help="Only features within R mm of this point of the part.")
@click.option("--kind", type=click.Choice(POINT_LETTERS), multiple=True, help="Only these kinds.")
@seam_options
@marked_options
@click.option("-o", "--out", metavar="TEMPLATE.csv", type=click.Path(path_type=Path), help="Taught file to fill in.")
@click.option("--force", is_flag=True, help="Overwrite TEMPLATE.csv.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON on stdout.")
def advise(*, part_step: Path, out: Path | None, force: bool, as_json: bool, **values: Any) -> int:
    """Choose the features of PART.step to teach, so that the largest predicted 95 % error along the seams is smallest.

    The figure is the one that `wpcal calibrate` reports with the same --sigma-mm. Shows what three to six points
    promise and which point to add. Free sharp corners and holes come first; other features only where these are too
    few.
    """
    from cad.cli.progress import shown_progress
    from cad.kernel.child import run_in_child
    from wpcal.core.errors import InputError

    found_by = to_seam_options(values)
    options = _options(values)
    files = [Path(word) for word in values["seams"] if word.endswith(".json")]
    if len(files) > 1:
        raise InputError(f"--seams: expected one file with edits, got {', '.join(map(str, files))}")
    choice = to_seam_choice({**values, "seams_file": files[0] if files else None})
    if out is not None and out.exists() and not force:
        raise InputError(f"{out}: exists; give --force to overwrite it")
    with shown_progress() as progress:
        found: Advice = run_in_child(
            "cad.workpiece.advise:advise_points",
            {"part": part_step, "options": options, "seam_options": found_by, "choice": choice},
            what=f"advising for {part_step}",
            progress=progress,
        )
    if out is not None:
        from wpcal.advise import template_csv
        from wpcal.core.records import write_file

        write_file(out, template_csv(found), overwrite=force)
    if as_json:
        from wpcal.core.records import to_json

        click.echo(to_json(found.to_record()), nl=False)
    else:
        _show(found, part_step.name, out)
    return 0


def _options(values: dict[str, Any]) -> Any:
    from cad.workpiece.advise import AdviseOptions
    from wpcal.calibrate import Criterion
    from wpcal.features import POINT_KINDS, FeatureKind

    return AdviseOptions(
        points=values["points"],
        seams=_names(",".join(word for word in values["seams"] if not word.endswith(".json"))),
        sigma_mm=values["sigma_mm"],
        criterion=Criterion(values["criterion"]),
        have=_names(values["have"]),
        exclude=_names(values["exclude"]),
        near=None if values["near"] is None else _sphere(values["near"]),
        kinds=tuple(FeatureKind(letter) for letter in values["kind"]) or POINT_KINDS,
    )


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _sphere(text: str) -> tuple[float, float, float, float]:
    import math

    from wpcal.core.errors import InputError

    try:
        x, y, z, radius = (float(value) for value in text.split(","))
    except ValueError:
        raise InputError(f"--near: expected X,Y,Z,R in mm, got {text!r}") from None
    if not (all(math.isfinite(v) for v in (x, y, z, radius)) and radius > 0):
        raise InputError(f"--near: expected finite numbers and a positive radius, got {text!r}")
    return x, y, z, radius


def _show(found: Advice, part: str, out: Path | None) -> None:
    from wpcal.cli.console import plain_console

    console = plain_console()
    console.print(_points_table(found, part))
    console.print(_counts_table(found))
    if found.next_point is not None and found.with_next is not None:
        error = f"{found.with_next.error_95_mm:.3f} mm"
        console.print(f"one more point: {found.next_point.name} makes the largest error {error}", highlight=False)
    for note in found.notes:
        console.print(f"note: {note}", highlight=False)
    if out is not None:
        console.print(f"wrote {out}: fill in x_mm, y_mm, z_mm", highlight=False)


def _points_table(found: Advice, part: str) -> Table:
    from rich.table import Table

    from wpcal.advise.advice import where_it_is

    table = Table(title=f"Teach these features of {part}")
    table.add_column("feature", no_wrap=True)
    table.add_column("where")
    for feature in found.chosen.features:
        table.add_row(feature.name, where_it_is(feature))
    return table


def _counts_table(found: Advice) -> Table:
    from rich.table import Table

    title = f"Largest predicted 95 % error along the seams (sigma {found.sigma_mm:g} mm, {found.criterion.value})"
    table = Table(title=title)
    for heading in ("points", "95 % mm", "at seam"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("features")
    table.add_column("swap leaves mm", justify="right")
    for advised in found.by_count:
        mark = " (advised)" if advised is found.chosen else ""
        cells = (f"{len(advised.features)}{mark}", f"{advised.error_95_mm:.3f}", advised.seam)
        table.add_row(*cells, " ".join(advised.names), f"{advised.swap_rms_mm:.2f}")
    return table
