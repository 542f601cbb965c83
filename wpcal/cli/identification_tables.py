"""What `wpcal identify` shows: errors before and after, parameters, verdict; or the poses to measure."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wpcal.cli.console import new_table, show_notes

MOST_TOLD = 2  #: Notes of one kind on the console.

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wpcal.core.issue import Issue
    from wpcal.robot.identify.error_summary import ErrorFigures
    from wpcal.robot.identify.identification import Identification
    from wpcal.robot.identify.observability import PosePlan


def show_identification(result: Identification, console: Console) -> None:
    """Print the errors of the test poses, the parameters, the warnings and the verdict."""
    console.print(_errors(result))
    console.print(_parameters(result))
    absorbing = any(unseen.like for unseen in result.fit.unseen)
    if absorbing and result.half_widths is not None:
        o = result.options
        console.print(
            f"* absorbs the error of a parameter that no pose shows; its interval takes that error as "
            f"{o.expected_mm:g} mm or {np.rad2deg(o.expected_rad):g} deg (one sigma, assumed)"
        )
    fit = result.fit
    noise = f"noise {fit.noise.sigma_mm:.3g} mm"
    if result.observations.has_orientations:
        noise += f", {np.rad2deg(fit.noise.sigma_rad):.3g} deg"
    asked = fit.rank + len(fit.unseen)
    console.print(f"rank {fit.rank} of {asked}, condition {fit.condition:.3g}, {noise}")
    if any(not outlier.held_back for outlier in result.outliers):
        console.print("leave an outlier out with --leave-out and its row, once you know why it is one")
    show_notes(_shortened(result.issues), console)
    if result.verdict.improved:
        console.print(Text.assemble(("IMPROVED", "bold green"), " on poses that were not fitted"))
    else:
        reasons = "; ".join(result.verdict.reasons)
        console.print(Text.assemble(("NOT IMPROVED", "bold red"), f" {reasons}"))


def _shortened(issues: Sequence[Issue]) -> list[Issue]:
    """Return at most `MOST_TOLD` issues of a kind, the last one with the number of those left out."""
    told = []
    for code in dict.fromkeys(issue.code for issue in issues):
        own = [issue for issue in issues if issue.code == code]
        last = own[:MOST_TOLD][-1]
        if len(own) > MOST_TOLD:
            last = replace(last, message=f"{last.message}; {len(own) - MOST_TOLD} more in identification.json")
        told += [*own[: MOST_TOLD - 1], last] if len(own) >= MOST_TOLD else own
    return told


def _errors(result: Identification) -> Table:
    folds = result.options.folds
    how = f"{folds} folds" if folds else f"{len(result.train)} rows fitted"
    table = new_table(f"{result.arm.name}: errors on {len(result.test)} test rows ({how})", "<|mean|rms|95 %|largest")
    _row(table, "nominal, mm", result.before.distance_mm)
    _row(table, "identified, mm", result.after.distance_mm)
    if result.before.turn_deg is not None and result.after.turn_deg is not None:
        _row(table, "nominal, deg", result.before.turn_deg)
        _row(table, "identified, deg", result.after.turn_deg)
    return table


def _row(table: Table, name: str, figures: ErrorFigures) -> None:
    values = (figures.mean, figures.rms, figures.percentile_95, figures.largest)
    table.add_row(name, *(f"{value:.4f}" for value in values))


def _parameters(result: Identification) -> Table:
    from wpcal.robot.identify.identification_record import parameter_rows

    table = new_table("Link parameters", "<parameter|<unit|nominal|identified|change|± 95 %")
    for row in parameter_rows(result):
        table.add_row(
            row["name"],
            row["unit"],
            f"{row['nominal']:.4f}",
            f"{row['identified']:.4f}",
            f"{row['change']:+.4f}",
            "" if row["half_width_95"] is None else f"{row['half_width_95']:.4f}" + ("*" if row["absorbs"] else ""),
        )
    return table


def show_plan(plan: PosePlan, console: Console) -> None:
    """Print the planned poses and how well they determine the parameters."""
    names = [f"q{joint + 1}" for joint in range(plan.joints.shape[1])]
    table = new_table(f"{len(plan.joints)} poses to measure (joint angles, degrees)", "|".join(["pose", *names]))
    for number, joints in enumerate(np.rad2deg(plan.joints), start=1):
        table.add_row(str(number), *(f"{angle:.2f}" for angle in joints))
    console.print(table)
    gain = f"observability O1 {plan.index:.3f}; of as many random poses {plan.random_index:.3f}"
    console.print(gain)
    worst = _largest(plan)
    console.print(f"with a laser tracker's noise the least certain parameters: {worst}")


def _largest(plan: PosePlan) -> str:
    parts = []
    for unit in ("mm", "deg"):
        found = [(row["half_width_95"], row["parameter"]) for row in plan.expected_95() if row["unit"] == unit]
        if found:
            half_width, name = max(found)
            parts.append(f"{name} ± {half_width:.2g} {unit}")
    return ", ".join(parts)
