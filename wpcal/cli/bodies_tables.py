"""Bodies that moved, as text on stdout: whether they did, how far, and what their seams then are."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from wpcal.cli.console import new_table
from wpcal.core.wording import listed

ERRORS = ("u95_mm", "u95_across_mm", "u95_placing_mm", "u95_unseen_mm")  #: Columns of errors of a seam.
MOST_ROWS = 40  #: Most bodies shown; of more, those with the strongest evidence.
LEAST_P = 0.001
"""Smaller probabilities are shown as "< 0.001"."""


def show_sentence(record: Mapping[str, Any], console: Console) -> None:
    """Print whether bodies moved, and which; `record` is the field ``bodies`` of ``calibration.json``."""
    for sentence in (record["sentence"], record["tolerances_sentence"]):
        console.print(f"{sentence[0].upper()}{sentence[1:]}.")


def show_bodies(record: Mapping[str, Any], console: Console, *, details: bool = False) -> None:
    """Print the motions of the bodies, and the error and the gap of every seam between them."""
    if record["seams"]:
        console.print(_seams(record["seams"], record["gap_limit_mm"]))
    console.print(_bodies(record["bodies"]))
    if details:
        console.print(_motions(record["bodies"]))
        most = 6 * len(record["bodies"])
        console.print(f"the touches see {record['motions_seen']:.1f} of {most} motions of the bodies")


def _seams(rows: Sequence[Mapping[str, Any]], gap_limit_mm: float) -> Table:
    table = new_table(
        "Seams where the moved faces meet: error and gap",
        "<=seam|<bodies|=95 % mm|=across|=from placing|=not seen|=gap mm",
    )
    never, wide = [], []
    for row in rows:
        errors = (f"{row[key]:.3f}" for key in ERRORS)
        low, high = (round(row[key], 2) + 0.0 for key in ("gap_min_mm", "gap_max_mm"))
        gap = f"{low:.2f} … {high:.2f} ± {row['gap_u95_mm']:.2f}"
        table.add_row(row["seam"], " + ".join(row["bodies"]), *errors, gap)
        if row["never_touched"]:
            never.append(f"{row['seam']} ({listed(row['never_touched'])})")
        if row["gap_max_mm"] > gap_limit_mm:
            wide.append(row["seam"])
    captions = [f"never touched, the place rests on the tack tolerance: {listed(never)}"] if never else []
    if wide:
        captions.append(f"gap wider than {gap_limit_mm:g} mm (--gap-mm): {listed(wide)}")
    table.caption = "\n".join(captions) or None
    return table


def _bodies(rows: Sequence[Mapping[str, Any]]) -> Table:
    table = new_table(
        "Bodies: how far each one is from its place in the model",
        "<body|=moved mm|=turned mrad|=sigma|=p|=touches|=tack tolerance",
    )
    strongest = sorted(rows, key=lambda row: -row["sigmas"])[:MOST_ROWS]
    for row in rows if len(rows) <= MOST_ROWS else strongest:
        tack = f"{row['tack_mm']:.3g} mm, {row['tack_mrad']:.3g} mrad"
        if row["touches"]:
            numbers = [f"{math.hypot(*row['moved_mm']):.2f}", f"{math.hypot(*row['turned_mrad']):.1f}"]
            numbers += [
                f"{max(row['sigmas'], 0.0):.1f}",
                "< 0.001" if row["p_still"] < LEAST_P else f"{row['p_still']:.3f}",
            ]
        else:
            numbers = ["–"] * 4
        table.add_row(row["name"], *numbers, str(row["touches"]), tack)
    table.caption = "sigma, p: evidence of the touches that a body moved; p is corrected for the number of bodies"
    if len(rows) > MOST_ROWS:
        table.caption += f"; the {MOST_ROWS} of {len(rows)} bodies with the strongest evidence"
    return table


def _motions(rows: Sequence[Mapping[str, Any]]) -> Table:
    table = new_table("Motions of the bodies, in the axes of the part, each with its standard deviation", "<body")
    for unit, kind in (("mm", "moved"), ("mrad", "turned")):
        for axis in "xyz":
            table.add_column(f"{kind} {axis} {unit}", justify="right")
    for row in rows:
        cells = [
            f"{value:+.3f} ± {sigma:.3f}"
            for values, sigmas in (("moved_mm", "sigma_mm"), ("turned_mrad", "sigma_mrad"))
            for value, sigma in zip(row[values], row[sigmas], strict=True)
        ]
        table.add_row(row["name"], *cells)
    return table
