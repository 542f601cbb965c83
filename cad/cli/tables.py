"""What the CAD commands show: features and seams as tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.table import Table

if TYPE_CHECKING:
    from wpcal.core.arrays import FloatArray
    from wpcal.features import ReferenceFeature
    from wpcal.seam import Seam


def features_table(features: Sequence[ReferenceFeature], file_name: str) -> Table:
    """Return one row a feature."""
    table = Table(title=f"What can be taught on {file_name} (part frame)")
    for heading, justify in (("feature", "left"), ("kind", "left"), ("x mm", "right"), ("y mm", "right")):
        table.add_column(heading, justify="right" if justify == "right" else "left")
    for heading in ("z mm", "diameter mm"):
        table.add_column(heading, justify="right")
    table.add_column("solid")
    for feature in features:
        diameter = "" if feature.diameter_mm is None else f"{feature.diameter_mm:.3f}"
        place = (f"{v + 0.0:.3f}" for v in feature.p_mm)
        table.add_row(feature.name, feature.kind.word.replace("_", " "), *place, diameter, feature.solid)
    return table


def seams_table(seams: Sequence[Seam], title: str, u95_mm: Sequence[FloatArray] | None = None) -> Table:
    """Return one row an accepted seam; with its largest predicted error where given."""
    table = Table(title=title)
    for heading in ("seam", "joint", "weld"):
        table.add_column(heading, no_wrap=True)
    table.add_column("joins")
    for heading in ("length mm", "points", "gap mm"):
        table.add_column(heading, justify="right", no_wrap=heading != "length mm")
    table.add_column("sure", justify="right", no_wrap=True)
    if u95_mm is not None:
        table.add_column("95 % mm", justify="right", no_wrap=True)
    for row, seam in enumerate(seams):
        if not seam.accepted:
            continue
        cells = [seam.name, seam.joint.value, seam.weld.value, " + ".join(seam.solids), _length(seam)]
        cells += [str(len(seam.frames)), f"{seam.gap_mm[2]:.3f}", f"{seam.confidence:.0%}"]
        if u95_mm is not None:
            cells.append(f"{u95_mm[row].max():.3f}")
        table.add_row(*cells)
    return table


def refused_table(seams: Sequence[Seam]) -> Table:
    """Return one row a candidate that is not taken as a weld, and why."""
    table = Table(title="Not taken as welds")
    for heading in ("seam", "joint", "joins"):
        table.add_column(heading, no_wrap=heading != "joins")
    table.add_column("length mm", justify="right")
    table.add_column("sure", justify="right", no_wrap=True)
    table.add_column("why")
    for seam in seams:
        if not seam.accepted:
            cells = [seam.name, seam.joint.value, " + ".join(seam.solids), _length(seam)]
            table.add_row(*cells, f"{seam.confidence:.0%}", "; ".join(seam.against))
    return table


def _length(seam: Seam) -> str:
    return f"{seam.length_mm:.3f}{' closed' if seam.closed else ''}"
