"""The edges that a person chose: marked in the STEP file by name, layer or colour, or picked by a place on the part."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from cad.kernel.to_brep import curve_row
from cad.kernel.topology import EDGE, sub_shape_uses
from cad.step.read import StepMark
from wpcal.brep import BrepGraph, CurveKind
from wpcal.brep.curves import edge_polylines, evaluate_edges
from wpcal.brep.extend import FreeEdge, add_edges
from wpcal.brep.trim import distance_to_segments
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ErrorCode, InputError
from wpcal.core.linked import near_tree
from wpcal.seam.find.marked import MarkedEdges
from wpcal.taught.features import ReferenceFeature, feature_named

SAME_EDGE_MM = 1e-3
"""An edge of the file and an edge of the graph are the same if their middles and ends agree within this. Kernels keep
vertices at least this exactly."""
PICK_MM = 2.0  #: A place picked on a screen, or typed with one decimal, is within this distance of its edge.
SAME_COLOUR = 1.5 / 255  #: Colours are equal within this: #rrggbb is rounded to 1/255.
MOST_NAMES = 6  #: Names shown in a message.


def find_marked(
    graph: BrepGraph,
    marks: Sequence[StepMark],
    features: Sequence[ReferenceFeature],
    *,
    patterns: Sequence[str],
    places: Sequence[str],
) -> tuple[BrepGraph, MarkedEdges]:
    """Find marked and picked edges in a graph. Marked wires that bound no face are added to the graph.

    `patterns`: Each is the name or layer of edges or wires, with ``*`` and ``?``, or a colour ``#rrggbb``.
    `places`: Each is ``x,y,z`` in `part`, mm, or the name of a feature on the edge, such as ``M12``.
    Raises `InputError` when a pattern fits no edge, or a place is not readable or not near an edge.
    """
    found: list[tuple[FreeEdge, str]] = []
    for pattern in patterns:
        fitting = [mark for mark in marks if mark.kind in ("edge", "wire") and _fits(mark, pattern)]
        if not fitting:
            what = f"no edge or wire has the name, layer or colour {pattern!r}{_hint(marks)}"
            raise InputError(what, code=ErrorCode.MARK_UNKNOWN)
        found += [(edge, mark.name or pattern) for mark in fitting for edge in _edges(mark.shape)]
    graph, numbers = _numbered(graph, [edge for edge, _ in found])
    labels = dict(zip(numbers, (label for _, label in found), strict=True))
    for place in places:
        labels.setdefault(_nearest_edge(graph, _point(place, features), place), f"picked at {place}")
    return graph, MarkedEdges(np.array(list(labels), dtype=np.int64), tuple(labels.values()))


def _fits(mark: StepMark, pattern: str) -> bool:
    if re.fullmatch(r"#[0-9a-fA-F]{6}", pattern):
        wanted = [int(pattern[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        rgb = mark.color_rgb
        return rgb is not None and max(abs(a - b) for a, b in zip(rgb, wanted, strict=True)) <= SAME_COLOUR
    return any(fnmatchcase(text, pattern) for text in (mark.name, *mark.layers) if text)


def _hint(marks: Sequence[StepMark]) -> str:
    names = dict.fromkeys(text for mark in marks if mark.kind != "face" for text in (mark.name, *mark.layers) if text)
    if not names:
        return "; none in this file has a name or a layer"
    shown = ", ".join(list(names)[:MOST_NAMES])
    return f"; there are {shown}{', …' if len(names) > MOST_NAMES else ''}"


def _edges(shape: Any) -> Iterator[FreeEdge]:
    for edge, _ in sub_shape_uses(shape, EDGE):
        (kind, frame, param), span, nurbs = curve_row(edge)
        if kind != CurveKind.DEGENERATE:
            yield FreeEdge(kind, np.array(frame), param, span, nurbs)


def _numbered(graph: BrepGraph, edges: Sequence[FreeEdge]) -> tuple[BrepGraph, list[int]]:
    """Return the number of each edge in the graph. An edge that the graph does not have is added."""
    if not edges:
        return graph, []
    wider, added = add_edges(graph, edges)
    known = np.flatnonzero((graph.edge_kind != CurveKind.DEGENERATE) & (graph.edge_solid >= 0))
    tree = near_tree(_places(graph, known)[:, 1])
    numbers: list[int] = []
    missing: list[int] = []
    for row, place in enumerate(_places(wider, added)):
        same = [n for n in known[tree.query_ball_point(place[1], SAME_EDGE_MM)] if _has_ends(graph, int(n), place)]
        numbers.append(int(min(same)) if same else graph.edge_count + len(missing))
        if not same:
            missing.append(row)
    return add_edges(graph, [edges[row] for row in missing])[0], numbers


def _places(graph: BrepGraph, edges: Any) -> FloatArray:
    """Return the start, the middle and the end of edges, shape (k, 3, 3), mm."""
    first, last = graph.edge_range[edges].T
    points = [evaluate_edges(graph, edges, t)[0] for t in (first, (first + last) / 2, last)]
    return np.stack(points, axis=1)


def _has_ends(graph: BrepGraph, edge: int, place: FloatArray) -> bool:
    here = _places(graph, np.array([edge]))[0]
    off = [np.abs(here[ends] - place[[0, 2]]).max() for ends in ([0, 2], [2, 0])]
    return bool(min(off) <= SAME_EDGE_MM)


def _point(place: str, features: Sequence[ReferenceFeature]) -> FloatArray:
    parts = place.split(",")
    if len(parts) == 1:
        return np.asarray(feature_named(features, place).p_mm, dtype=np.float64)
    try:
        x, y, z = (float(part) for part in parts)
    except ValueError:
        what = f"the edge {place!r}: expected x,y,z in mm or the name of a feature"
        raise InputError(what, code=ErrorCode.EDGE_UNKNOWN) from None
    return np.array([x, y, z])


def _nearest_edge(graph: BrepGraph, p: FloatArray, place: str) -> int:
    start, _, points = edge_polylines(graph)
    of_point = np.repeat(np.arange(graph.edge_count), np.diff(start))
    inner = np.flatnonzero(of_point[1:] == of_point[:-1])
    inner = inner[~graph.is_seam_edge[of_point[inner]]]
    off = distance_to_segments(np.broadcast_to(p, (len(inner), 3)), points[inner], points[inner + 1])
    nearest = int(np.argmin(off))
    if off[nearest] > PICK_MM:
        raise InputError(
            f"no edge is within {PICK_MM:g} mm of {place}; the nearest is {off[nearest]:.1f} mm away",
            code=ErrorCode.EDGE_UNKNOWN,
        )
    return int(of_point[inner[nearest]])
