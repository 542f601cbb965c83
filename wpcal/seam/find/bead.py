"""Modelled beads and rounds inside one solid: the seam is where the two faces beside the strip would meet.

A strip is a concave face that runs smoothly into two other faces along its sides. The curve in which their surfaces
meet is a line for two planes, and a circle for a plane across a cylinder. Otherwise it is computed point by point, in
planes across the side of the strip (`brep.meeting`). A cubic spline through the points is the curve.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wpcal.brep.boxes import BoxTree, boxes_of_solids
from wpcal.brep.concavity import LEAST_TURN_SIN
from wpcal.brep.curves import edge_lengths, evaluate_edges
from wpcal.brep.extend import FreeEdge, add_edges, interpolated, line
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.meeting import meet_surfaces
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.seam.find.built_up import why_one_piece
from wpcal.seam.find.covered import count_solids
from wpcal.seam.find.crumbs import are_crumbs
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.find.tube_frames import are_tube_frames
from wpcal.seam.limits import LEAST_SEAM_MM
from wpcal.seam.options import ConcaveEdges, SeamOptions
from wpcal.seam.seam import JointType, SeamPieces, WeldType

WIDEST_MM = 30.0  #: Largest width of the face of a bead: a fillet with 20 mm legs, laid in many runs, is 28 mm wide.
LEAST_CORNER_COS = 0.87
"""Faces beside a strip at an angle of less than 30 degrees are one bent sheet, not two members."""
STRIPS = (SurfaceKind.CYLINDER, SurfaceKind.TORUS, SurfaceKind.CONE, SurfaceKind.NURBS)
BENDS = (SurfaceKind.CYLINDER, SurfaceKind.TORUS)
SAME_AXIS_MM = 1e-3  #: The inside and the outside of a bend are about one axis within this.
CURVE_POINTS = 513
"""Points of the spline. On an ellipse round a pipe of 60 mm it is then within 1e-7 mm of the curve, and its slope at an
end within 1e-6."""
ACROSS_SIN = 1e-6  #: A plane is across a cylinder if the sine between its normal and the axis is below this.


@dataclass(frozen=True, slots=True)
class Strip:
    """A strip between two faces."""

    face: int
    sides: tuple[int, int]  #: The faces beside it.
    edges: tuple[tuple[int, ...], tuple[int, ...]]  #: The edges between the strip and each of these faces.


def find_strips(
    graph: BrepGraph, solids: BoolArray | None = None, *, min_length_mm: float = LEAST_SEAM_MM
) -> list[Strip]:
    """Find the concave strips that run smoothly into two other faces of their solid at an angle. By face.

    `solids`: shape (S,). Only these solids are searched; by default all.
    """
    edges = np.flatnonzero((graph.edge_faces >= 0).all(axis=1) & ~graph.is_seam_edge)
    edges = edges[graph.edge_kind[edges] != CurveKind.DEGENERATE]
    if solids is not None:
        edges = edges[solids[graph.edge_solid[edges]]]
    edges = edges[np.isin(graph.face_kind[graph.edge_faces[edges]], STRIPS).any(axis=1)]
    p = evaluate_edges(graph, edges, graph.edge_range[edges].mean(axis=1))[0]
    left, right = (project_to_faces(graph, graph.edge_faces[edges, k], p).normal for k in (0, 1))
    smooth = edges[np.linalg.norm(np.cross(left, right), axis=1) < LEAST_TURN_SIN]
    lengths = edge_lengths(graph)
    beside: dict[int, dict[int, list[int]]] = {}
    for edge in smooth.tolist():
        for face, other in (graph.edge_faces[edge].tolist(), graph.edge_faces[edge, ::-1].tolist()):
            if graph.face_kind[face] in STRIPS:
                beside.setdefault(face, {}).setdefault(other, []).append(edge)
    found = []
    for face, others in sorted(beside.items()):
        long = sorted(others, key=lambda other: (-float(lengths[others[other]].sum()), other))[:2]
        if len(long) == 2 and all(lengths[others[other]].sum() >= min_length_mm for other in long):
            strip = Strip(face, (long[0], long[1]), (tuple(others[long[0]]), tuple(others[long[1]])))
            if _is_concave_corner(graph, strip) and not _is_bend(graph, face):
                found.append(strip)
    return found


def _is_bend(graph: BrepGraph, face: int) -> bool:
    """Tell whether a strip is the inside of a bent sheet: its solid has a larger convex face about the same axis."""
    o, z, radius = graph.face_frame[face, 0], graph.face_frame[face, 3], graph.face_param[face]
    same = (graph.face_solid == graph.face_solid[face]) & (graph.face_kind == graph.face_kind[face])
    outside = np.flatnonzero(same & (graph.face_outward > 0) & np.isin(graph.face_kind, BENDS))
    arm = graph.face_frame[outside, 0] - o
    turn = np.linalg.norm(np.cross(graph.face_frame[outside, 3], z), axis=1)
    if graph.face_kind[face] == SurfaceKind.CYLINDER:
        off = np.linalg.norm(arm - (arm @ z)[:, None] * z, axis=1)
        wider = graph.face_param[outside, 0] > radius[0]
    else:
        off = np.linalg.norm(arm, axis=1) + np.abs(graph.face_param[outside, 0] - radius[0])
        wider = graph.face_param[outside, 1] > radius[1]
    return bool(((turn <= ACROSS_SIN) & (off <= SAME_AXIS_MM) & wider).any())


def _is_concave_corner(graph: BrepGraph, strip: Strip) -> bool:
    """Tell whether a strip is narrow, its sides are at an angle, and its middle lies behind the chord across it."""
    first, second = (edges[0] for edges in strip.edges)
    p = evaluate_edges(graph, [first], [graph.edge_range[first].mean()])[0]
    across = evaluate_edges(
        graph,
        np.full(CURVE_POINTS, second),
        np.linspace(graph.edge_range[second, 0], graph.edge_range[second, 1], CURVE_POINTS),
    )[0]
    q = across[np.argmin(np.linalg.norm(across - p, axis=1))][None]
    n1, n2 = (project_to_faces(graph, [side], at).normal[0] for side, at in zip(strip.sides, (p, q), strict=True))
    middle = (p + q) / 2
    foot = project_to_faces(graph, [strip.face], middle)
    behind = float((foot.p[0] - middle[0]) @ foot.normal[0]) < 0
    width = float(np.linalg.norm(q - p))
    return behind and 0 < width <= WIDEST_MM and float(n1 @ n2) < LEAST_CORNER_COS


def add_beads(graph: BrepGraph, trimmed: TrimmedFaces, options: SeamOptions) -> tuple[BrepGraph, JoinedPieces]:
    """Add the curves in which the faces beside beads and rounds meet, as edges without faces of their own.

    Returns `pieces`: JoinedPieces. Wall and base are the faces beside the strips.

    Parameters
    ----------
    options : SeamOptions
        With `ConcaveEdges.AUTO`, only solids are searched that may be built up (`built_up.why_one_piece`) and are apart
        from others, or frames of tubes.
    """
    strips: list[Strip] = []
    if options.concave is ConcaveEdges.ALWAYS:
        strips = find_strips(graph, min_length_mm=options.min_edge_mm)
    elif options.concave is ConcaveEdges.AUTO:
        searched = _are_apart(graph, trimmed, options.gap_for(graph))
        touched = np.flatnonzero(~searched & count_solids(graph, trimmed, np.arange(len(searched))))
        searched[touched] = are_tube_frames(graph, trimmed, touched)
        strips = find_strips(graph, searched, min_length_mm=options.min_edge_mm)
        but = np.zeros(graph.face_count, dtype=bool)
        but[[strip.face for strip in strips]] = True
        one_piece = {
            solid: why_one_piece(graph, trimmed, solid, but=but) for solid in set(graph.face_solid[but].tolist())
        }
        strips = [strip for strip in strips if one_piece[int(graph.face_solid[strip.face])] is None]
    found = [(strip, edge) for strip in strips for edge in _meeting_edges(graph, strip)]
    wider, edges = add_edges(graph, [edge for _, edge in found])
    n = len(found)
    wall, base = (np.array([strip.sides[k] for strip, _ in found], dtype=np.int64) for k in (0, 1))
    t0, t1 = wider.edge_range[edges].T
    pieces = SeamPieces(edges, t0, t1, wall, base, np.zeros((n, 3)))
    return wider, JoinedPieces(pieces, (JointType.UNKNOWN,) * n, (WeldType.FILLET,) * n)


def _are_apart(graph: BrepGraph, trimmed: TrimmedFaces, gap_mm: float) -> BoolArray:
    """Tell which solids are apart: their boxes are near no other box but those of crumbs; shape (S,)."""
    low, high = boxes_of_solids(graph.face_solid, trimmed.face_box, len(graph.solid_names))
    own, other = BoxTree.of(low, high).meeting(low - gap_mm, high + gap_mm)
    near = own[(own != other) & ~are_crumbs(graph, trimmed)[other] & count_solids(graph, trimmed, other)]
    return np.asarray(np.bincount(near, minlength=len(low)) == 0, dtype=bool)


def _meeting_edges(graph: BrepGraph, strip: Strip) -> Iterator[FreeEdge]:
    """Yield, for each edge along the first side, the piece of the curve in which the two sides meet."""
    for edge in strip.edges[0]:
        t = np.linspace(graph.edge_range[edge, 0], graph.edge_range[edge, 1], CURVE_POINTS)
        p0, slope = evaluate_edges(graph, np.full(CURVE_POINTS, edge), t)
        p = _meet(graph, strip.sides, p0, slope)
        if p is None:
            continue
        kinds = {int(graph.face_kind[side]) for side in strip.sides}
        if kinds == {SurfaceKind.PLANE}:
            yield line(p[0], p[-1])
        elif kinds == {SurfaceKind.PLANE, SurfaceKind.CYLINDER} and _is_across(graph, strip.sides):
            yield _circle(graph, strip.sides, p)
        else:
            yield interpolated(p)


def _meet(graph: BrepGraph, sides: tuple[int, int], p0: FloatArray, slope: FloatArray) -> FloatArray | None:
    """Return where two surfaces meet across the points p0 (n, 3) of an edge, or None where they do not."""
    x = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    first, second = (np.full(len(p0), side) for side in sides)
    p = meet_surfaces(graph, first, second, p0, x, least_sin=LEAST_TURN_SIN)
    return p if np.linalg.norm(p - p0, axis=1).max() <= 2.0 * WIDEST_MM else None


def _is_across(graph: BrepGraph, sides: tuple[int, int]) -> bool:
    """Tell whether a plane is across a cylinder."""
    z0, z1 = (graph.face_frame[side, 3] for side in sides)
    return float(np.linalg.norm(np.cross(z0, z1))) <= ACROSS_SIN


def _circle(graph: BrepGraph, sides: tuple[int, int], p: FloatArray) -> FreeEdge:
    """Return the arc in which a plane cuts a cylinder across, from the first of the points p to the last."""
    plane, cylinder = sorted(sides, key=lambda side: int(graph.face_kind[side]))
    o, z = graph.face_frame[cylinder, 0], graph.face_frame[cylinder, 3]
    n = graph.face_frame[plane, 3]
    centre = o + float((graph.face_frame[plane, 0] - o) @ n) / float(z @ n) * z
    radius = float(graph.face_param[cylinder, 0])
    x = (p[0] - centre) / np.linalg.norm(p[0] - centre)
    y = np.cross(z, x)
    arm = p - centre
    turn = float(np.unwrap(np.arctan2(arm @ y, arm @ x))[-1])
    if turn < 0:
        z, y, turn = -z, -y, -turn
    return FreeEdge(CurveKind.CIRCLE, np.stack([centre, x, y, z]), (radius, radius), (0.0, turn))
