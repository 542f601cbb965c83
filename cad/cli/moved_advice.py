"""What to touch on a weldment whose bodies may have moved, as text on the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from wpcal.touch.moved_advice import AdvisedTouch, MovedAdvice


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
        table.add_row(touch.name, touch.body, touch.where, touch.seam, *_errors(touch))
    return table


def _errors(touch: AdvisedTouch) -> tuple[str, str]:
    before, after = ("not held" if error is None else f"{error:.2f}" for error in (touch.before_mm, touch.after_mm))
    return before, after
