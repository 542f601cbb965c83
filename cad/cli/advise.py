"""`wpcal advise`: which features to teach."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.bodies_options import ContactBodiesFlags
from cad.cli.moved_advice import show_moved_advice
from cad.cli.options import POINT_LETTERS, SeamChoiceFlags, SeamFlags, no_cache_option
from wpcal.cli.option_groups import option, takes
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, KIND_HELP, ONLY_HELP, SIGMA_HELP

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from cad.workpiece.advise import AdviseOptions
    from wpcal.touch.advice import Advice
    from wpcal.touch.moved_advice import MovedAdvice


@dataclass(frozen=True, slots=True, kw_only=True)
class AdviseFlags:
    """How many points are advised, for which seams, and from which features."""

    points: int | None = option(
        "--count",
        type=int,
        help=(
            "Number of touches: points to teach, with --have; with --bodies, to add.  [default: 4; with --bodies 2 "
            "per body]"
        ),
    )
    tolerance_mm: float | None = option(
        "--tolerance-mm",
        type=float,
        help="Allowed error: with --bodies, as many points as keep all accepted seams within it, with 95 % confidence.",
    )
    only: str | None = option(
        "--only", metavar="W1,W5-W8", help=f"{ONLY_HELP} The error counts there.  [default: on all accepted seams]"
    )
    sigma_mm: float = option("--sigma-mm", type=float, default=0.3, show_default=True, help=SIGMA_HELP)
    criterion: str = option(
        "--criterion",
        type=click.Choice(["minimax", "least_squares"]),
        default="minimax",
        show_default=True,
        help="What is minimised: the criterion that `wpcal calibrate` will get.",
    )
    have: str = option("--have", metavar="V1,V4", default="", help="Features that will be taught in any case.")
    exclude: str = option("--exclude", metavar="V3,H2", default="", help="Features that must not be advised.")
    within: str | None = option(
        "--within", metavar="X,Y,Z,R", help="Only features within R mm of this point of the part."
    )
    kind: tuple[str, ...] = option("--kind", type=click.Choice(POINT_LETTERS), multiple=True, help=KIND_HELP)

    def to_options(self) -> AdviseOptions:
        """Return the options as the advice takes them."""
        from cad.workpiece.advise import AdviseOptions
        from wpcal.calibrate import Criterion
        from wpcal.seam.names import split_names
        from wpcal.taught.features import POINT_KINDS, FeatureKind

        return AdviseOptions(
            points=self.points,
            seams=split_names(self.only or ""),
            sigma_mm=self.sigma_mm,
            criterion=Criterion(self.criterion),
            have=split_names(self.have),
            exclude=split_names(self.exclude),
            near=None if self.within is None else _sphere(self.within),
            kinds=tuple(FeatureKind(letter) for letter in self.kind) or POINT_KINDS,
            tolerance_mm=self.tolerance_mm,
        )


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@takes("advice", AdviseFlags)
@takes("weldment", ContactBodiesFlags)
@takes("seams", SeamFlags)
@takes("choice", SeamChoiceFlags)
@click.option("-o", "--out", metavar="TEMPLATE.csv", type=click.Path(path_type=Path), help="Output: a table.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: TEMPLATE.csv.")
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the advice.")
def advise(
    *,
    part_step: Path,
    advice: AdviseFlags,
    weldment: ContactBodiesFlags,
    seams: SeamFlags,
    choice: SeamChoiceFlags,
    out: Path | None,
    force: bool,
    as_json: bool,
    no_cache: bool,
) -> int:
    """Choose the features of PART.step to teach, so that the largest predicted 95 % error along the seams is smallest.

    The error is the one that `wpcal calibrate` reports with the same --sigma-mm. The output compares three to six
    points and names the next point to add. Free sharp corners and holes come first. Other features are advised only if
    there are too few of these.

    With --bodies the points are chosen for `wpcal calibrate --bodies`: in the order in which each lowers the error of
    the worst seam most, with the body of each point and the seam that it serves.
    """
    from cad.cli.kernel_work import run_on_part
    from wpcal.cli.outputs import require_new
    from wpcal.core.errors import InputError

    bodies = weldment.to_options()
    if bodies is None and advice.tolerance_mm is not None:
        raise InputError("--tolerance-mm is for --bodies; without it the table says what three to six points reach")
    arguments: dict[str, Any] = {"seam_options": seams.to_options(), "options": advice.to_options()}
    arguments |= {"choice": choice.to_choice()}
    if bodies is not None:
        arguments["bodies"] = bodies
    if out is not None:
        require_new(out, overwrite=force)
    found: Advice | MovedAdvice = run_on_part(
        f"cad.workpiece.advise:{'advise_points' if bodies is None else 'advise_weldment'}",
        part_step,
        arguments,
        what=f"advising for {part_step}",
        use_cache=not no_cache,
    )
    if out is not None:
        from wpcal.core.records import write_file
        from wpcal.touch.advice import template_csv

        write_file(out, template_csv(found.template_rows()), overwrite=force)
    if as_json:
        from wpcal.core.records import to_json

        click.echo(to_json(found.to_record()), nl=False)
    else:
        _show(found, part_step.name, out)
    return 1 if found.misses_tolerance else 0


def _sphere(text: str) -> tuple[float, float, float, float]:
    from wpcal.core.errors import InputError
    from wpcal.core.numbers import parse_numbers

    try:
        x, y, z, radius = parse_numbers(text)
    except ValueError:
        raise InputError(f"--within: expected X,Y,Z,R in mm, got {text!r}") from None
    if not radius > 0:
        raise InputError(f"--within: expected a positive radius, got {text!r}")
    return x, y, z, radius


def _show(found: Advice | MovedAdvice, part: str, out: Path | None) -> None:
    from wpcal.cli.console import plain_console
    from wpcal.touch.advice import Advice

    console = plain_console()
    if isinstance(found, Advice):
        _show_points(console, found, part)
    else:
        show_moved_advice(console, found, part)
    if out is not None:
        console.print(f"wrote {out}: fill in x_mm, y_mm, z_mm", highlight=False)


def _show_points(console: Console, found: Advice, part: str) -> None:
    console.print(_points_table(found, part))
    console.print(_counts_table(found))
    if found.next_point is not None and found.with_next is not None:
        error = f"{found.with_next.error_95_mm:.3f} mm"
        console.print(f"one more point: {found.next_point.name} makes the largest error {error}", highlight=False)
    for note in found.notes:
        console.print(f"note: {note}", highlight=False)


def _points_table(found: Advice, part: str) -> Table:
    from rich.table import Table

    from wpcal.touch.advice import where_it_is

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
