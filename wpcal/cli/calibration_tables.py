"""A calibration as tables on stdout: the points, the verdict and the criteria."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wpcal.calibrate.trust.criteria import Criterion
from wpcal.cli.console import new_table
from wpcal.core.pendant import NOTATIONS
from wpcal.results.next_steps import HELP_PAGE, next_steps

if TYPE_CHECKING:
    from wpcal.calibrate import CalibrationResult, Distrusted, HeldMotion

MOST_ROWS = 60  #: Most points shown, more than a person usually teaches. Of a larger set, those that fit worst.

MOST_NAMED = 6  #: Most distrusted points in the title; the table of points has the rest.


COLOURS = {"PASS": "green", "UNSURE": "yellow", "FAIL": "red"}


def exit_code(result: CalibrationResult, *, accept_unsure: bool = False) -> int:
    """Return the code of a command that ends with this verdict: 0 if it passes or, by consent, is unsure."""
    return 0 if result.verdict == "PASS" or (accept_unsure and result.verdict == "UNSURE") else 1


def show_calibration(
    result: CalibrationResult, console: Console, *, details: bool = False, record: Mapping[str, Any] | None = None
) -> None:
    """Print a calibration: one row per point, the pose as pendants show it, the criteria and the warnings."""
    console.print(_points(result))
    console.print(_fit(result))
    console.print(_pose(result))
    if details:
        console.print(_details(result))
    if result.touches is not None:
        console.print(_motions(result.touches.motions))
    if result.criteria is not None:
        console.print(_criteria(result))
        console.print(f"least predicted error: {result.criteria.best.value} ({result.criteria.why})")
    if result.distrusted is not None:
        console.print(_distrusted(result.distrusted))
    what = f"{result.judgement.sentence}; the largest residual is {result.largest_mm:.4f} mm"
    if result.suspect is None:  # a wrong point spreads its error: the largest residual is often at a right one
        what += f" at {result.worst}{' (check)' * (result.largest_mm > result.residuals.largest_mm)}"
    console.print(Text.assemble((result.verdict.value, f"bold {COLOURS[result.verdict]}"), f": {what}"))
    if result.criterion_advice is not None:
        console.print(f"advice: {result.criterion_advice}")
    for line in _what_next(result, record or result.to_record()):
        console.print(line)


def _what_next(result: CalibrationResult, record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the next steps and the warnings that the verdict does not tell."""
    steps = next_steps(record)
    yield from (f"next: {step}" for step in steps)
    if steps:
        yield f"help: {HELP_PAGE}"
    told = result.judgement.sentence
    yield from (f"warning: {issue.message}" for issue in result.issues if issue.message not in told)


def _points(result: CalibrationResult) -> Table:
    headings = "<point|x mm|y mm|z mm|distance mm|95 % error mm"
    table = new_table("Points (residual = taught - fitted, base frame)", headings)
    if result.criterion is Criterion.MINIMAX:
        table.caption = "minimax: the largest residuals are equal by construction"
    for pairs, residuals, mark in (
        (result.pairs, result.residuals, ""),
        (result.check, result.check_residuals, " (check)"),
    ):
        if pairs is None or residuals is None:
            continue
        distances = residuals.norms_mm
        shown = range(len(pairs)) if len(pairs) <= MOST_ROWS else np.argsort(-distances, kind="stable")[:MOST_ROWS]
        errors = result.point_errors_mm(list(shown), check=bool(mark))
        for i, error in zip(shown, errors, strict=True):
            vector = (f"{v:+.4f}" for v in residuals.vectors_mm[i])
            table.add_row(pairs.names[i] + mark, *vector, f"{distances[i]:.4f}", f"{error:.4f}")
        if len(shown) < len(pairs):
            table.caption = f"the {MOST_ROWS} largest distances of {len(pairs)} points"
    return table


def _fit(result: CalibrationResult) -> Table:
    table = Table(title="Fit", show_header=False)
    table.add_row("criterion", result.criterion.value)
    if result.touches is not None:
        found = result.touches.starts  # touches have no proof
        best = found.next_best_rms_mm
        rest = "no other optimum" if best is None else f"next best RMS {best:.4g} mm"
        table.add_row("starts that agree", f"{found.agreeing} of {found.starts}; {rest} (not proved)")
    if result.seams:
        table.add_row("95 % errors rest on", result.budget.describe())
    for name, points in result.seams:
        if name == result.judgement.seam and len(points):
            shares = result.budget.shares(result.T_base_part.apply(points))
            told = ", ".join(f"{word} {100.0 * share:.0f} %" for word, share in shares.items() if share >= 0.005)
            table.add_row(f"of the variance at {name}" if name else "of the variance", told)
    table.add_row("RMS", f"{result.rms_mm:.6f} mm")
    return table


def _pose(result: CalibrationResult) -> Table:
    table = Table(title="Pose as the pendants show it (base frame)", show_header=False)
    x, y, z = result.T_base_part.t_mm + 0.0
    table.add_row("all", f"X {x:.3f}  Y {y:.3f}  Z {z:.3f} mm")
    for notation in NOTATIONS:
        table.add_row(notation.maker, notation.orientation_text(result.T_base_part))
    return table


def _details(result: CalibrationResult) -> Table:
    table = Table(title="Details of the fit", show_header=False)
    six = result.T_base_nominal.six_tuple
    table.add_row("objective", f"{result.objective_mm:.9f} mm")
    if result.solver.annealed_objective_mm is not None:
        table.add_row("annealed, before the polish", f"{result.solver.annealed_objective_mm:.9f} mm")
    if result.touches is None:
        table.add_row("no rigid fit is below", f"{result.lower_bound_mm:.9f} mm")
        table.add_row("gap", f"{result.gap_mm:.2e} mm ({'certified' if result.certified else 'not certified'})")
    table.add_row("correction x, y, z", f"{six.x_mm:.6f}, {six.y_mm:.6f}, {six.z_mm:.6f} mm")
    table.add_row("correction α, β, γ", f"{six.alpha_rad:.8f}, {six.beta_rad:.8f}, {six.gamma_rad:.8f} rad")
    return table


def _motions(motions: Sequence[HeldMotion]) -> Table:
    table = new_table("What holds the part", "<motion|<singular value|<held by")
    for held in motions:
        table.add_row(held.motion, f"{held.singular_value:.3f}", ", ".join(held.held_by[:MOST_NAMED]))
    return table


def _criteria(result: CalibrationResult) -> Table:
    table = new_table("Criteria on the same data", "<criterion|largest mm|RMS mm|95 % worst seam")
    for row in result.criteria.rows if result.criteria else ():
        numbers = (row["largest_mm"], row["rms_mm"], row["seam_error_95_mm"])
        table.add_row(row["criterion"], *(f"{number:.4f}" for number in numbers))
    if result.criteria is not None and result.criteria.three_point_frame_mm is not None:
        least, largest = result.criteria.three_point_frame_mm
        table.add_row("a frame through three points", f"{least:.4f} to {largest:.4f}", "", "")
    return table


def _distrusted(found: Distrusted) -> Table:
    listed = ", ".join(found.names[:MOST_NAMED]) + (", …" if len(found.names) > MOST_NAMED else "")
    title = f"With and without {listed} ({found.criterion.value})"
    table = new_table(title, "<fit|points|largest mm|RMS mm|95 % worst seam")
    table.caption = f"the two differ by up to {found.shift_mm:.3f} mm"
    for word, fit in (("with", found.with_them), ("without", found.without_them)):
        numbers = (fit.largest_mm, fit.rms_mm, fit.seam_error_95_mm)
        table.add_row(word, str(fit.points), *(f"{number:.4f}" for number in numbers))
    return table
