"""`wpcal advise`: which features to teach."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cad.cli.options import POINT_LETTERS, MarkedFlags, SeamFlags, no_cache_option
from wpcal.cli.option_groups import option, takes

if TYPE_CHECKING:
    from rich.table import Table

    from cad.workpiece.advise import AdviseOptions
    from wpcal.advise import Advice


@dataclass(frozen=True, slots=True, kw_only=True)
class AdviseFlags:
    """How many points are advised, for which seams, and from which features."""

    points: int = option(
        "--count", type=int, default=4, show_default=True, help="Number of points to teach, with --have."
    )
    seams: tuple[str, ...] = option(
        "--seams",
        metavar="W1,W2|FILE",
        multiple=True,
        help="Where the error counts (default: on all accepted seams), or a seams.json with edits.",
    )
    sigma_mm: float = option("--sigma-mm", type=float, default=0.3, show_default=True, help="Teaching error per axis.")
    criterion: str = option(
        "--criterion",
        type=click.Choice(["minimax", "least_squares"]),
        default="minimax",
        show_default=True,
        help="Criterion of `wpcal calibrate`.",
    )
    have: str = option("--have", metavar="V1,V4", default="", help="Features that will be taught in any case.")
    exclude: str = option("--exclude", metavar="V3,H2", default="", help="Features that must not be advised.")
    near: str | None = option("--near", metavar="X,Y,Z,R", help="Only features within R mm of this point of the part.")
    kind: tuple[str, ...] = option("--kind", type=click.Choice(POINT_LETTERS), multiple=True, help="Only these kinds.")

    def to_options(self) -> AdviseOptions:
        """Return the options as the advice takes them."""
        from cad.workpiece.advise import AdviseOptions
        from wpcal.calibrate import Criterion
        from wpcal.features import POINT_KINDS, FeatureKind

        return AdviseOptions(
            points=self.points,
            seams=_names(",".join(word for word in self.seams if not word.endswith(".json"))),
            sigma_mm=self.sigma_mm,
            criterion=Criterion(self.criterion),
            have=_names(self.have),
            exclude=_names(self.exclude),
            near=None if self.near is None else _sphere(self.near),
            kinds=tuple(FeatureKind(letter) for letter in self.kind) or POINT_KINDS,
        )

    def seams_file(self) -> Path | None:
        """Return the file with edits among the words of ``--seams``.

        Raises
        ------
        InputError
            If there are several.
        """
        from wpcal.core.errors import InputError

        files = [word for word in self.seams if word.endswith(".json")]
        if len(files) > 1:
            raise InputError(f"--seams: expected one file with edits, got {', '.join(files)}")
        return Path(files[0]) if files else None


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@takes("advice", AdviseFlags)
@takes("seams", SeamFlags)
@takes("marks", MarkedFlags)
@click.option("-o", "--out", metavar="TEMPLATE.csv", type=click.Path(path_type=Path), help="Table to fill in.")
@click.option("--force", is_flag=True, help="Overwrite TEMPLATE.csv.")
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON on stdout.")
def advise(
    *,
    part_step: Path,
    advice: AdviseFlags,
    seams: SeamFlags,
    marks: MarkedFlags,
    out: Path | None,
    force: bool,
    as_json: bool,
    no_cache: bool,
) -> int:
    """Choose the features of PART.step to teach, so that the largest predicted 95 % error along the seams is smallest.

    The error is the one that `wpcal calibrate` reports with the same --sigma-mm. The output compares three to six
    points and names the next point to add. Free sharp corners and holes come first. Other features are advised only if
    there are too few of these.
    """
    from cad.cli.kernel_work import run_on_part
    from wpcal.cli.outputs import require_new

    arguments = {"seam_options": seams.to_options(), "options": advice.to_options()}
    arguments |= {"choice": marks.to_choice(advice.seams_file())}
    if out is not None:
        require_new(out, overwrite=force)
    found: Advice = run_on_part(
        "cad.workpiece.advise:advise_points",
        part_step,
        arguments,
        what=f"advising for {part_step}",
        use_cache=not no_cache,
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


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _sphere(text: str) -> tuple[float, float, float, float]:
    from wpcal.core.errors import InputError
    from wpcal.core.numbers import parse_numbers

    try:
        x, y, z, radius = parse_numbers(text)
    except ValueError:
        raise InputError(f"--near: expected X,Y,Z,R in mm, got {text!r}") from None
    if not radius > 0:
        raise InputError(f"--near: expected a positive radius, got {text!r}")
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
