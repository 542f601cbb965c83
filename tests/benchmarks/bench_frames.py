"""Frames of seams: microseconds a frame on analytic faces and on B-splines.

The curves are made at random: circles between a plane and a cylinder, and cubic B-splines of 16 poles on bicubic
surfaces of 8 × 8. A frame is point, tangent, both normals and the axes (`wpcal.seam.frames.seam_frames`). Beside it
stands the kernel called from Python for the same numbers: `BRepAdaptor_Curve.D1` and twice a projection
(`GeomAPI_ProjectPointOnSurf`) with `D1` there.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from rich.table import Table

from cad.samples import box, cut, cylinder
from cad.to_brep import to_brep
from wpcal.brep import BrepGraph, CurveKind, SurfaceKind
from wpcal.seam.discretise import Stations
from wpcal.seam.frames import seam_frames
from wpcal.seam.seam import SeamPieces

FRAMES = 20_000
REPEATS = 5
"""The least of so many runs counts: other work on the machine only ever adds."""
KERNEL_FRAMES = 300
"""So many are enough to time the kernel's calls."""


def main() -> Table:
    table = Table(title="Microseconds a frame")
    for heading in ("faces", "asked", "wpcal", "kernel from Python", "ratio"):
        table.add_column(heading)
    for name, asked, shape in (("plane and cylinder", 10.0, bored_plate()), ("bicubic B-splines", 40.0, wavy_block())):
        graph = to_brep([("part", shape)])
        pieces, stations = run_of(graph)
        mine = least_seconds(lambda g=graph, p=pieces, s=stations: seam_frames(g, p, s)) / FRAMES * 1e6
        kernel = kernel_seconds(shape, graph, pieces, stations) / KERNEL_FRAMES * 1e6
        table.add_row(name, f"≤ {asked:.0f}", f"{mine:.2f}", f"{kernel:.1f}", f"{mine / kernel:.3f}")
    return table


def bored_plate() -> Any:
    return cut(box(60, 40, 10, (0, 0, 0)), cylinder(8, 10, (20, 20, 0), (0, 0, 1)))


def wavy_block() -> Any:
    """Return a block whose faces are B-splines that are no elementary surface."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
    from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections

    loft = BRepOffsetAPI_ThruSections(True, False)
    for height, stretch in ((0.0, 1.0), (10.0, 1.4), (20.0, 0.9), (30.0, 1.2)):
        loft.AddWire(wavy_wire(height, stretch))
    solid = BRepAlgoAPI_Cut(loft.Shape(), box(100, 100, 100, (-50, -50, -90))).Shape()
    return BRepBuilderAPI_NurbsConvert(solid, True).Shape()


def wavy_wire(height: float, stretch: float) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
    from OCP.collections import HArray1_gp_Pnt
    from OCP.GeomAPI import GeomAPI_Interpolate
    from OCP.gp import gp_Pnt

    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    radius = stretch * (20 + 3 * np.cos(3 * angles))
    points = HArray1_gp_Pnt(1, len(angles))
    for i, (r, a) in enumerate(zip(radius, angles, strict=True), 1):
        points.SetValue(i, gp_Pnt(r * np.cos(a), r * np.sin(a), height))
    curve = GeomAPI_Interpolate(points, True, 1e-9)
    curve.Perform()
    return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve.Curve()).Edge()).Wire()


if __name__ == "__main__":
    from rich.console import Console

    Console().print(main())
