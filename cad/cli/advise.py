"""`wpcal advise`: which features to teach."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.options import BODIES, CHOICE, FINDING, no_cache_option
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from cad.batch.bodies_asked import BodiesAsked
    from cad.batch.seams_asked import SeamsAsked
    from cad.workpiece.advise import AdviseOptions
    from wpcal.seam import SeamOptions
    from wpcal.touch.advice import Advice
    from wpcal.touch.moved_advice import MovedAdvice


@command()
@path_argument("part_step", metavar="PART.step")
@takes("options", "cad.workpiece.advise:AdviseOptions")
@takes("weldment", BODIES, without=["bending_mm"])
@takes("finding", FINDING)
@takes("choice", CHOICE)
@path_option("-o", "--out", metavar="TEMPLATE.csv", help="Output: a table.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: TEMPLATE.csv.")
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the advice.")
def advise(
    *,
    part_step: Path,
    options: AdviseOptions,
    weldment: BodiesAsked,
    finding: SeamOptions,
    choice: SeamsAsked,
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
    if bodies is None and options.tolerance_mm is not None:
        raise InputError("--tolerance-mm is for --bodies; without it the table says what three to six points reach")
    arguments: dict[str, Any] = {"seam_options": finding, "options": options}
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
    from wpcal.touch.advice import Advice, template_csv

    if out is not None:
        from wpcal.core.records import write_file

        write_file(out, template_csv(found.template_rows()), overwrite=force)
    if as_json:
        print_json(found.to_record())
    else:
        _show(found, part_step.name, out)
    return 0 if isinstance(found, Advice) or not found.why_not else 1


def _show(found: Advice | MovedAdvice, part: str, out: Path | None) -> None:
    from wpcal.cli.console import plain_console
    from wpcal.touch.advice import Advice

    console = plain_console()
    if isinstance(found, Advice):
        _show_points(console, found, part)
    else:
        show_moved_advice(console, found, part)
    if out is not None:
        console.print(f"wrote {out}: fill in x_mm, y_mm, z_mm")


def _show_points(console: Console, found: Advice, part: str) -> None:
    console.print(_points_table(found, part))
    console.print(_counts_table(found))
    if found.next_point is not None and found.with_next is not None:
        error = f"{found.with_next.error_95_mm:.3f} mm"
        console.print(f"one more point: {found.next_point.name} makes the error {error}")
    for note in found.notes:
        console.print(f"note: {note}")


def _points_table(found: Advice, part: str) -> Table:
    from wpcal.cli.console import new_table
    from wpcal.touch.advice import where_it_is

    table = new_table(f"Teach these features of {part}", "<=feature|<where")
    for feature in found.chosen.features:
        table.add_row(feature.name, where_it_is(feature))
    return table


def _counts_table(found: Advice) -> Table:
    from wpcal.cli.console import new_table

    title = f"Predicted 95 % error of all seams together (sigma {found.sigma_mm:g} mm, {found.criterion.value})"
    table = new_table(title, "=points|=95 % mm|=worst seam|<features|swap leaves mm")
    for advised in found.by_count:
        mark = " (advised)" if advised.names == found.chosen.names else ""
        cells = (f"{len(advised.features)}{mark}", f"{advised.error_95_mm:.3f}", advised.seam)
        table.add_row(*cells, " ".join(advised.names), f"{advised.swap_rms_mm:.2f}")
    return table


def show_moved_advice(console: Console, found: MovedAdvice, part: str) -> None:
    """Print the touches in their order, what they reach, and the best further one."""
    console.print(_touches_table(found, part))
    for line in reached_lines(found):
        console.print(line)
    if found.next_touch is not None:
        console.print(f"after these, {found.next_touch.sentence()}")


def reached_lines(found: MovedAdvice) -> list[str]:
    """Say what touches reach: the worst seam, all seams, the tolerances, and why a tolerance is not reached."""
    tacks = sorted({(each.mm, each.mrad) for each in found.model.bodies.tolerances})
    told = ", ".join(f"{mm:g} mm and {mrad:g} mrad" for mm, mrad in tacks)
    lines = [
        f"largest predicted 95 % error of the seams: {found.error_95_mm:.2f} mm at {found.seam}, of which "
        f"{found.unseen_mm:.2f} mm from motions that no touch sees",
        f"all accepted seams together: within {found.joint_95_mm:.2f} mm with 95 % confidence (tack tolerance {told})",
    ]
    return [*lines, found.why_not] if found.why_not else lines


def _touches_table(found: MovedAdvice, part: str) -> Table:
    from wpcal.cli.console import new_table

    table = new_table(
        f"Touch these features of {part}, in this order", "<=touch|<=body|<where|for seam|95 % mm before|after"
    )
    for touch in found.touches:
        errors = ("not held" if error is None else f"{error:.2f}" for error in (touch.before_mm, touch.after_mm))
        table.add_row(touch.name, touch.body, touch.where, touch.seam, *errors)
    return table
