"""Prismatic stretches of a solid: where it has one closed section along a direction, as bars, tubes and profiles have.

The section is walked on the edges that run along the direction. Each of them is a corner of the section, and each face
between two of them a side. Where something else stands on the member, the walk does not close or closes otherwise; the
stretch goes on behind it.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from wpcal.brep.concavity import are_concave
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import square_to
from wpcal.brep.trim import TrimmedFaces, once_per_solid
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

SAME_WAY = 1e-5  #: Directions whose coordinates agree within this are one.
SAME_MM = 1e-3  #: Heights, and places of faces, that agree within this are one.
MOST_WAYS, MOST_CUTS = 24, 80  #: Directions, and cuts across each of them, that are looked at: the longest.
FEWEST_EDGES = 3  #: A section has at least three corners.
LATERAL_SIN = 1e-5  #: A face runs along a direction within this.
THINNEST_CUT_MM = 0.2  #: Two cuts nearer than this have no room for a section between them.


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """One closed line of a section."""

    faces: tuple[int, ...]  #: Its sides, in order around; side k goes from corner k to the next one.
    corners: FloatArray  #: shape (n, 2). Across the direction, mm.
    is_bore: bool  #: The material is outside of it.
    area_mm2: float  #: Inside of it.
    roots: frozenset[tuple[int, int]]  #: Pairs of sides at a hollow corner, sharp or round, the smaller number first.
    sharp: int  #: How many hollow corners are sharp.


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """A length of a solid along which a closed line of its section stays the same."""

    way: FloatArray  #: shape (3,). Unit vector.
    low: float  #: Where it begins and ends: `low`, `high` as heights along the direction, mm.
    high: float
    contour: Contour  #: Of its longest piece.
    faces: frozenset[int]  #: Of all pieces.
    roots: frozenset[tuple[int, int]]  #: Of all pieces, as in `Contour`.
    pieces_mm: float  #: How long all pieces are together.

    @property
    def length_mm(self) -> float:
        """How long it is, from its first piece to its last."""
        return self.high - self.low

    @property
    def sides_mm(self) -> FloatArray:
        """The sides of the box around the section, the shorter first, along its longest side, shape (2,)."""
        q = self.contour.corners
        step = np.roll(q, -1, axis=0) - q
        x = step[np.argmax(np.linalg.norm(step, axis=1))]
        x = x / np.linalg.norm(x)
        return np.sort(np.ptp(q @ np.array([x, [-x[1], x[0]]]).T, axis=0))


@once_per_solid
def find_prisms(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> tuple[Prism, ...]:
    """Find the prismatic stretches of a solid."""
    return tuple(stretch for way in _ways(graph, solid) for stretch in _along(graph, trimmed, solid, way))


def _lines(graph: BrepGraph, solid: int) -> IntArray:
    own = (graph.edge_solid == solid) & (graph.edge_kind == CurveKind.LINE)
    return np.flatnonzero(own & (graph.edge_faces >= 0).all(axis=1) & ~graph.is_seam_edge)


def _ways(graph: BrepGraph, solid: int) -> list[FloatArray]:
    """Return the directions along which the solid has most length of straight edges, at most `MOST_WAYS`."""
    lines = _lines(graph, solid)
    way = graph.edge_frame[lines, 1]
    way = way / np.linalg.norm(way, axis=1, keepdims=True)
    way = way * np.where(way[np.arange(len(way)), np.abs(way).argmax(axis=1)] < 0, -1.0, 1.0)[:, None]
    _, first, of, count = np.unique(
        np.round(way / SAME_WAY), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    length = np.bincount(of.ravel(), weights=np.ptp(graph.edge_range[lines], axis=1), minlength=len(first))
    order = np.argsort(-length, kind="stable")
    return [way[first[k]] for k in order[:MOST_WAYS] if count[k] >= FEWEST_EDGES]


@dataclass(slots=True, eq=False)
class _Across:
    """A solid seen along a direction."""

    graph: BrepGraph
    way: FloatArray
    plane: FloatArray  #: shape (2, 3). Two unit vectors across it.
    edges: IntArray  #: Along it.
    low: FloatArray  #: Of each edge, mm.
    high: FloatArray
    corner: FloatArray  #: shape (n, 2).
    concave: BoolArray  #: shape (n,).
    other_face: IntArray  #: Faces crossed by edges that do not run along it, and from where to where each does.
    other_low: FloatArray
    other_high: FloatArray
    lateral: BoolArray  #: shape (F,).


def _seen_along(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, way: FloatArray) -> _Across:
    lines = _lines(graph, solid)
    edges = lines[np.linalg.norm(np.cross(graph.edge_frame[lines, 1], way), axis=1) <= SAME_WAY]
    ends = graph.edge_frame[edges, None, 0] + graph.edge_range[edges][..., None] * graph.edge_frame[edges, None, 1]
    height = ends @ way
    u = square_to(way)
    plane = np.stack([u, np.cross(way, u)])
    turn = np.linalg.norm(np.cross(graph.face_frame[:, 3], way), axis=1)
    lateral = (graph.face_kind == SurfaceKind.PLANE) & (np.abs(graph.face_frame[:, 3] @ way) <= LATERAL_SIN)
    lateral |= (graph.face_kind == SurfaceKind.CYLINDER) & (turn <= LATERAL_SIN)
    of_face = np.repeat(np.arange(graph.face_count), np.diff(trimmed.start))
    other = (graph.face_solid[of_face] == solid) & ~np.isin(trimmed.piece_edge, edges)
    both = np.stack([trimmed.p0[other] @ way, trimmed.p1[other] @ way])
    key = np.stack([of_face[other], trimmed.piece_edge[other]])
    pairs, of = np.unique(key, axis=1, return_inverse=True)
    low, high = np.full(pairs.shape[1], np.inf), np.full(pairs.shape[1], -np.inf)
    np.minimum.at(low, of.ravel(), both.min(axis=0))
    np.maximum.at(high, of.ravel(), both.max(axis=0))
    seen = (
        graph,
        way,
        plane,
        edges,
        height.min(axis=1),
        height.max(axis=1),
        ends[:, 0] @ plane.T,
        are_concave(graph, edges),
    )
    return _Across(*seen, pairs[0], low, high, lateral)


def _along(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, way: FloatArray) -> list[Prism]:
    """Return the stretches along one direction: equal contours of all cuts together."""
    seen = _seen_along(graph, trimmed, solid, way)
    heights = np.unique(np.round(np.concatenate([seen.low, seen.high, seen.other_low, seen.other_high]) / SAME_MM))
    heights = heights * SAME_MM
    step = np.diff(heights)
    cuts = np.sort(np.argsort(-step, kind="stable")[:MOST_CUTS])
    found: dict[frozenset[tuple[int, ...]], list[tuple[float, float, Contour]]] = defaultdict(list)
    places = _places(graph, seen)
    for cut in cuts[step[cuts] >= THINNEST_CUT_MM].tolist():
        low, high = float(heights[cut]), float(heights[cut + 1])
        for contour in _contours(seen, (low + high) / 2):
            found[frozenset(places[face] for face in contour.faces)].append((low, high, contour))
    stretches = []
    for pieces in found.values():
        contour = max(pieces, key=lambda piece: piece[1] - piece[0])[2]
        faces = frozenset(face for piece in pieces for face in piece[2].faces)
        roots = frozenset(root for piece in pieces for root in piece[2].roots)
        low, high = min(piece[0] for piece in pieces), max(piece[1] for piece in pieces)
        pieces_mm = sum(piece[1] - piece[0] for piece in pieces)
        stretches.append(Prism(way, low, high, contour, faces, roots, pieces_mm))
    return stretches


def _places(graph: BrepGraph, seen: _Across) -> dict[int, tuple[int, ...]]:
    """Return a key of the surface of each face along the direction: pieces of one surface have one key."""
    places = {}
    for face in np.unique(graph.edge_faces[seen.edges]).tolist():
        o, z = graph.face_frame[face, 0], graph.face_frame[face, 3] * graph.face_outward[face]
        if graph.face_kind[face] == SurfaceKind.PLANE:
            key = np.round(np.append(seen.plane @ z * 1e4, z @ o / SAME_MM / 10))
        else:
            turn = graph.face_outward[face]
            key = np.round(np.append(seen.plane @ o, [graph.face_param[face, 0], turn]) / SAME_MM / 10)
        places[face] = tuple(key.astype(np.int64).tolist())
    return places


def _contours(seen: _Across, at: float) -> list[Contour]:
    """Return the closed lines of the section at a height."""
    graph = seen.graph
    rows = np.flatnonzero((seen.low < at) & (seen.high > at))
    broken = set(seen.other_face[(seen.other_low < at) & (seen.other_high > at)].tolist())
    corners: dict[int, list[int]] = defaultdict(list)
    for row in rows.tolist():
        for face in graph.edge_faces[seen.edges[row]].tolist():
            corners[face].append(row)
    partner: dict[tuple[int, int], int] = {}
    for face, own in corners.items():
        if face in broken or len(own) % 2 or not seen.lateral[face]:
            continue
        order = sorted(own, key=lambda row: _along_face(seen, face, row))
        if graph.face_kind[face] == SurfaceKind.CYLINDER and len(order) != 2:
            continue
        for one, other in zip(order[::2], order[1::2], strict=True):
            partner[face, one], partner[face, other] = other, one
    contours: list[Contour] = []
    used: set[int] = set()
    for start in rows.tolist():
        if start in used:
            continue
        walked = _walk(graph, seen, partner, start)
        used.update(walked[0] if walked else (start,))
        if walked is not None:
            contours.append(_contour(seen, *walked))
    return contours


def _along_face(seen: _Across, face: int, row: int) -> float:
    """Return where an edge lies on a face along the direction."""
    across = np.cross(seen.way, seen.graph.face_frame[face, 3])
    return float(seen.graph.edge_frame[seen.edges[row], 0] @ across)


def _walk(
    graph: BrepGraph, seen: _Across, partner: dict[tuple[int, int], int], start: int
) -> tuple[list[int], list[int]] | None:
    """Return the corners and sides of the closed line through a corner; None if the walk ends before."""
    row, face = start, int(graph.edge_faces[seen.edges[start], 0])
    corners: list[int] = []
    sides: list[int] = []
    while True:
        following = partner.get((face, row))
        if following is None or len(corners) > len(seen.edges):
            return None
        corners.append(row)
        sides.append(face)
        row = following
        left, right = graph.edge_faces[seen.edges[row]].tolist()
        face = right if face == left else left
        if row == start:
            return corners, sides


def _contour(seen: _Across, corners: list[int], sides: list[int]) -> Contour:
    """Return a closed line: side k goes from corner k to the next one."""
    q = seen.corner[corners]
    step = np.roll(q, -1, axis=0) - q
    area = float(np.sum(q[:, 0] * np.roll(q[:, 1], -1) - np.roll(q[:, 0], -1) * q[:, 1])) / 2
    longest = int(np.argmax(np.linalg.norm(step, axis=1)))
    graph, face = seen.graph, sides[longest]
    if graph.face_kind[face] == SurfaceKind.PLANE:
        out = seen.plane @ (graph.face_frame[face, 3] * graph.face_outward[face])
    else:
        out = (q[longest] - seen.plane @ graph.face_frame[face, 0]) * graph.face_outward[face]
    right = np.array([step[longest, 1], -step[longest, 0]])
    is_bore = bool((float(right @ out) > 0) != (area > 0))
    roots, sharp = _roots(seen, corners, sides)
    return Contour(tuple(sides), q, is_bore, abs(area), roots, sharp)


def _roots(seen: _Across, corners: list[int], sides: list[int]) -> tuple[frozenset[tuple[int, int]], int]:
    """Return the pairs of sides at hollow corners, and how many of these corners are sharp."""
    graph, is_sharp = seen.graph, seen.concave[corners]
    pairs = {(sides[k - 1], sides[k]) for k in np.flatnonzero(is_sharp).tolist()}
    for k, face in enumerate(sides):
        after = (k + 1) % len(sides)
        is_hollow = graph.face_kind[face] == SurfaceKind.CYLINDER and graph.face_outward[face] < 0
        if is_hollow and not (is_sharp[k] or is_sharp[after]):
            pairs.add((sides[k - 1], sides[after]))
    return frozenset((min(pair), max(pair)) for pair in pairs), int(is_sharp.sum())
