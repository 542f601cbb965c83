"""The intersection curves of solids that overlap, as pieces of seams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Section
from OCP.TopoDS import TopoDS_Face

from cad.kernel.call import kernel_call
from cad.kernel.to_brep import curve_row
from cad.kernel.topology import EDGE, NumberedShapes, numbered_faces, sub_shape_uses
from wpcal.brep import BrepGraph
from wpcal.brep.extend import FreeEdge, add_edges
from wpcal.brep.nurbs import NurbsCurve
from wpcal.core.arrays import IntArray
from wpcal.core.errors import KernelError
from wpcal.core.issue import Issue
from wpcal.seam.seam import SeamPieces


def add_sections(
    graph: BrepGraph, shapes: Sequence[Any], pairs: IntArray
) -> tuple[BrepGraph, SeamPieces, tuple[Issue, ...]]:
    """Add the intersection curves of pairs of solids to a graph, as edges that belong to no face.

    `shapes`: The solids that the graph was made from, in its order.
    `pairs`: shape (k, 2). Solids by number.

    Returns `pieces`: SeamPieces. Wall and base are the two faces that meet.
    Returns `issues`: tuple of Issue. Pairs that the kernel could not intersect; the curves of the other pairs are in
    the graph.
    """
    faces = numbered_faces(shapes)
    rows: list[tuple[Any, tuple[float, float], NurbsCurve | None, int, int]] = []
    issues = []
    for a, b in pairs:
        names = (graph.solid_names[a], graph.solid_names[b])
        try:
            rows += _section(shapes[a], shapes[b], faces)
        except KernelError as error:
            issues.append(Issue("no-section", f"{' and '.join(names)} run into each other: {error}", names))
    return (*_with_edges(graph, rows), tuple(issues))


def _section(first: Any, second: Any, faces: NumberedShapes) -> list[Any]:
    rows = []
    with kernel_call("cutting two solids with each other"):
        section = BRepAlgoAPI_Section(first, second, False)
        section.Approximation(True)
        section.Build()
        for edge, _ in sub_shape_uses(section.Shape(), EDGE):
            on_first, on_second = TopoDS_Face(), TopoDS_Face()
            if section.HasAncestorFaceOn1(edge, on_first) and section.HasAncestorFaceOn2(edge, on_second):
                rows.append((*curve_row(edge), faces.number(on_first), faces.number(on_second)))
    return rows


def _with_edges(graph: BrepGraph, rows: list[Any]) -> tuple[BrepGraph, SeamPieces]:
    found = [FreeEdge(kind, np.array(frame), param, span, nurbs) for (kind, frame, param), span, nurbs, _, _ in rows]
    wider, edges = add_edges(graph, found)
    wall, base = (np.array([row[k] for row in rows], dtype=np.int64) for k in (3, 4))
    t0, t1 = wider.edge_range[edges].T
    return wider, SeamPieces(edges, t0, t1, wall, base, np.zeros((len(rows), 3)))
