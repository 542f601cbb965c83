"""Whether one solid is a frame of tubes: welded by itself, and then built into an assembly.

Inside a solid that others touch, a concave edge is rather the corner of a milled bracket, a bend or the rim of a wheel
than a weld. A frame of tubes is an exception. Nobody casts, mills or bends long closed tubes that run in two directions
and open into each other. A tube is felt from its hollow: across, there is a wall on all sides; along, there is none for
a length of several widths.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.hits import find_hits
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.built_up import SKIN_MM, sampled_surface, why_one_piece
from wpcal.seam.find.concave import find_concave_edges

POINTS = 120  #: Places on the surface from which the hollows are felt: the share of tubes is then known within 0.05.
LEAST_TUBES = 0.5  #: The share of the surface of a frame that is on its tubes: less is a housing with a few necks.
LEAST_SECOND = 0.1
"""The share of these places that is on tubes across the others: one tube with plates at its ends is not a frame."""
SLENDER = 3.0  #: A tube is this many times longer than it is wide.
WAYS = 16  #: Directions in which a hollow is felt, over a whole turn.
ACROSS = 2  #: From so many directions beside the axis (45 degrees) on, there must be a wall.
FARTHEST = 4.0
"""A wall across a hollow is nearer than this many times the width that was felt first: tubes of 80 x 20 count."""
PARALLEL_SIN = 0.35
"""Two tubes run in one direction if the sine between them is below this (20 degrees); the felt axes are 11 off."""


def are_tube_frames(graph: BrepGraph, trimmed: TrimmedFaces, solids: IntArray) -> BoolArray:
    """Tell which solids are frames of tubes in one piece, shape (n,).

    `solids`: ndarray of int, shape (n,).
    """
    found = np.zeros(len(solids), dtype=bool)
    may = np.isin(solids, _with_joints(graph))
    for row in np.flatnonzero(may).tolist():
        key = ("tube frame", int(solids[row]))
        if key not in trimmed.known:
            trimmed.known[key] = _is_tube_frame(graph, trimmed, int(solids[row]))
        found[row] = trimmed.known[key]
    return found


def _with_joints(graph: BrepGraph) -> IntArray:
    """Return the solids with concave edges that are not all lines in one direction, as those inside one tube are."""
    edges = find_concave_edges(graph).pieces.edge
    solid, way = graph.edge_solid[edges], graph.edge_frame[edges, 1]
    order = np.lexsort((np.arange(len(edges)), solid))
    edges, solid, way = edges[order], solid[order], way[order]
    begin = np.unique(solid, return_index=True)[1]
    first = np.repeat(begin, np.diff(np.append(begin, len(solid))))
    turned = np.linalg.norm(np.cross(way, way[first]), axis=1) > PARALLEL_SIN
    return np.unique(solid[(graph.edge_kind[edges] != CurveKind.LINE) | turned])


def _is_tube_frame(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> bool:
    p, normal, thick = sampled_surface(graph, trimmed, solid, POINTS)
    if len(p) == 0:
        return False
    inward = p - np.where(np.isfinite(thick), thick + SKIN_MM, 0.0)[:, None] * normal
    outside = _axes(graph, trimmed, solid, p + 2.0 * SKIN_MM * normal, normal)
    axis = np.where(np.isfinite(outside), outside, _axes(graph, trimmed, solid, inward, -normal))
    tubes = axis[np.isfinite(axis).all(axis=1)]
    if len(tubes) < LEAST_TUBES * len(p):
        return False
    across = np.linalg.norm(np.cross(tubes[:, None], tubes), axis=2) > PARALLEL_SIN
    if np.median(across.mean(axis=1)) < LEAST_SECOND and across.mean(axis=1).max() < 1.0 - LEAST_SECOND:
        return False
    return why_one_piece(graph, trimmed, solid) is None


def _axes(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, start: FloatArray, way: FloatArray) -> FloatArray:
    """Return the axes of the tubes whose hollow begins at points; not a number where there is no tube, (n, 3)."""
    axis = np.full_like(start, np.nan)
    width = _wall(graph, trimmed, solid, start, way)
    rows = np.flatnonzero(np.isfinite(width) & (width > SKIN_MM))
    if len(rows) == 0:
        return axis
    centre = start[rows] + (width[rows] / 2)[:, None] * way[rows]
    side = np.cross(way[rows], np.eye(3)[np.argmin(np.abs(way[rows]), axis=1)])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(way[rows], side)
    turn = np.arange(WAYS) * 2.0 * np.pi / WAYS
    rays = np.cos(turn)[:, None] * side[:, None] + np.sin(turn)[:, None] * other[:, None]
    far = _wall(graph, trimmed, solid, np.repeat(centre, WAYS, axis=0), rays.reshape(-1, 3)).reshape(-1, WAYS)
    length = np.minimum(far, graph.size_mm)
    both = length + np.roll(length, WAYS // 2, axis=1)
    along = np.argmax(both[:, : WAYS // 2], axis=1)
    turned = np.take_along_axis(far, (along[:, None] + np.arange(WAYS)) % WAYS, axis=1)
    off = np.minimum(np.arange(WAYS) % (WAYS // 2), WAYS // 2 - np.arange(WAYS) % (WAYS // 2))
    walls = turned[:, off >= ACROSS]
    quarter = [WAYS // 4, 3 * WAYS // 4]
    widest = np.maximum(width[rows], turned[:, quarter].sum(axis=1))
    is_tube = (walls <= FARTHEST * width[rows, None]).all(axis=1)
    is_tube &= both[np.arange(len(rows)), along] >= SLENDER * widest
    axis[rows[is_tube]] = rays[is_tube, along[is_tube]]
    return axis


def _wall(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, start: FloatArray, way: FloatArray) -> FloatArray:
    """Return how far it is from points outside the material to a wall of the solid, mm; infinite if there is none."""
    hits = find_hits(graph, trimmed, start, way, length_mm=graph.size_mm, solid=solid)
    rows, first = np.unique(hits.ray, return_index=True)
    far = np.full(len(start), np.inf)
    enters = hits.way[first] < 0
    far[rows[enters]] = hits.at_mm[first[enters]]
    return far
