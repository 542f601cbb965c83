"""A picture of a part with its seams and their names. No screen is needed, but matplotlib is (extra `plots`)."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import style
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection

from wpcal.brep import BrepGraph
from wpcal.brep.curves import edge_polylines
from wpcal.core.arrays import FloatArray
from wpcal.seam import Seam

VIEWS = (("from the front, left and above", 28.0, -125.0), ("from the front, right and above", 28.0, -35.0))
"""Name, elevation and azimuth in degrees. Hidden edges are visible too; two views a quarter turn apart show what is in
front."""
STYLES = {True: ("#c0392b", 2.4, "-", "bold"), False: ("#7d8a97", 1.0, "--", "normal")}
"""Colour, width and kind of the line, and weight of the name: of accepted seams and of the other candidates."""
EDGES = "#aab2ba"
MOST_REFUSED_NAMES = 30
"""If more candidates than this were refused, their names are left out: they would cover the part."""
PIXELS_PER_INCH = 110
WIDTH_IN, HEIGHT_IN = 16.0, 8.5


@style.context("default")  # not that of a matplotlibrc in the current folder, which could even start TeX
def seams_png(graph: BrepGraph, seams: Sequence[Seam], title: str) -> bytes:
    """Draw a part's edges with its seams in two views.

    Returns: PNG without a time stamp. The same part and the same matplotlib version give the same bytes.
    """
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), dpi=PIXELS_PER_INCH)
    start, _, points = edge_polylines(graph)
    own = np.flatnonzero(graph.edge_solid >= 0)
    edges = [points[start[edge] : start[edge + 1]] for edge in own.tolist() if start[edge + 1] > start[edge]]
    for number, (name, elevation, azimuth) in enumerate(VIEWS, 1):
        axes: Any = figure.add_subplot(1, len(VIEWS), number, projection="3d")
        _draw(axes, edges, seams)
        axes.view_init(elev=elevation, azim=azimuth)
        axes.set_title(name, fontsize=9, y=1.0)
    taken = sum(seam.accepted for seam in seams)
    figure.suptitle(f"{title}: {taken} seams (red), {len(seams) - taken} candidates not taken (grey)", fontsize=12)
    figure.subplots_adjust(0, 0, 1, 0.93, 0, 0)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _draw(axes: Any, edges: list[FloatArray], seams: Sequence[Seam]) -> None:
    axes.add_collection3d(Line3DCollection(edges, colors=EDGES, linewidths=0.6))
    names_refused = sum(not seam.accepted for seam in seams) <= MOST_REFUSED_NAMES
    for seam in sorted(seams, key=lambda seam: seam.accepted):  # the accepted ones over the others
        colour, width, line, weight = STYLES[seam.accepted]
        axes.plot(*seam.frames.p.T, color=colour, linewidth=width, linestyle=line)
        if seam.accepted or names_refused:
            middle = seam.frames.p[len(seam.frames) // 2]
            axes.text(*middle, seam.name, fontsize=8, color=colour, fontweight=weight)
    _fit(axes, np.concatenate([*edges, *(seam.frames.p for seam in seams)]))
    axes.set_axis_off()


def _fit(axes: Any, points: FloatArray) -> None:
    """Set the axes so that all points are visible, with the same scale along x, y and z."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.maximum(high - low, 1e-3 * float((high - low).max()))
    for limits, a, b in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), low, low + size, strict=True):
        limits(a, b)
    axes.set_box_aspect(size, zoom=0.95)
