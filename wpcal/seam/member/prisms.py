"""Prismatic stretches of a solid: where it has one closed section along a direction, as bars, tubes and profiles have.

The section is walked on the edges that run along the direction. Each of them is a corner of the section, and each face
between two of them a side. Where something else stands on the member, the walk does not close or closes otherwise; the
stretch goes on behind it.
"""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from wpcal.brep.concavity import are_concave
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.strips import items_of
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
    own = (graph.edge_solid == solid) & (graph.edge_kind == CurveKind.LINE) & ~graph.is_seam_edge
    lines, faces = np.flatnonzero(own), np.flatnonzero(graph.face_solid == solid)
    lines = lines[(graph.edge_faces[lines] >= 0).all(axis=1)]
    ways = _ways(graph, lines)
    return tuple(stretch for way in ways for stretch in _along(_seen_along(graph, trimmed, lines, faces, way)))


def _ways(graph: BrepGraph, lines: IntArray) -> list[FloatArray]:
    """Return the directions along which there is most length of straight edges, at most `MOST_WAYS`."""
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
    low: FloatArray  #: Of each edge along it, mm.
    high: FloatArray
    corner: FloatArray  #: shape (n, 2).
    concave: BoolArray  #: shape (n,).
    #: Of each edge, the two faces beside it, and how far along each, across the direction, it lies, mm.
    beside: list[tuple[tuple[int, float], ...]]
    faces: IntArray  #: All faces beside edges.
    is_round: dict[int, bool]  #: The faces that run along the direction, and whether each is a cylinder.
    other_face: IntArray  #: Faces crossed by edges that do not run along it, and from where to where each does.
    other_low: FloatArray
    other_high: FloatArray


def _seen_along(graph: BrepGraph, trimmed: TrimmedFaces, lines: IntArray, faces: IntArray, way: FloatArray) -> _Across:
    edges = lines[np.linalg.norm(np.cross(graph.edge_frame[lines, 1], way), axis=1) <= SAME_WAY]
    ends = graph.edge_frame[edges, None, 0] + graph.edge_range[edges][..., None] * graph.edge_frame[edges, None, 1]
    height, u, sides = ends @ way, square_to(way), graph.edge_faces[edges]
    plane = np.stack([u, np.cross(way, u)])
    across = np.einsum("ei,eki->ek", graph.edge_frame[edges, 0], np.cross(way, graph.face_frame[sides, 3]))
    beside = [tuple(zip(*own, strict=True)) for own in zip(sides.tolist(), across.tolist(), strict=True)]
    z, kind = graph.face_frame[faces, 3], graph.face_kind[faces]
    lateral = (kind == SurfaceKind.PLANE) & (np.abs(z @ way) <= LATERAL_SIN)
    round_ = (kind == SurfaceKind.CYLINDER) & (np.linalg.norm(np.cross(z, way), axis=1) <= LATERAL_SIN)
    is_round = {**dict.fromkeys(faces[lateral].tolist(), False), **dict.fromkeys(faces[round_].tolist(), True)}
    row, piece = items_of(trimmed.start, faces)
    other = ~np.isin(trimmed.piece_edge[piece], edges)
    row, piece = row[other], piece[other]
    both = np.stack([trimmed.p0[piece] @ way, trimmed.p1[piece] @ way])
    pairs, of = np.unique(row * graph.edge_count + trimmed.piece_edge[piece], return_inverse=True)
    low, high = np.full(len(pairs), np.inf), np.full(len(pairs), -np.inf)
    np.minimum.at(low, of, both.min(axis=0))
    np.maximum.at(high, of, both.max(axis=0))
    seen = height.min(axis=1), height.max(axis=1), ends[:, 0] @ plane.T, are_concave(graph, edges)
    others = faces[pairs // graph.edge_count], low, high
    return _Across(graph, way, plane, *seen, beside, np.unique(sides), is_round, *others)


def _along(seen: _Across) -> list[Prism]:
    """Return the stretches along one direction: equal contours of all cuts together."""
    heights = np.unique(np.round(np.concatenate([seen.low, seen.high, seen.other_low, seen.other_high]) / SAME_MM))
    heights = heights * SAME_MM
    step = np.diff(heights)
    cuts = np.sort(np.argsort(-step, kind="stable")[:MOST_CUTS])
    found: dict[frozenset[tuple[int, ...]], list[tuple[float, float, Contour]]] = defaultdict(list)
    places = _places(seen)
    for cut in cuts[step[cuts] >= THINNEST_CUT_MM].tolist():
        low, high = float(heights[cut]), float(heights[cut + 1])
        for contour in _contours(seen, (low + high) / 2):
            found[frozenset(places[face] for face in contour.faces)].append((low, high, contour))
    return [_stretch(seen.way, pieces) for pieces in found.values()]


def _stretch(way: FloatArray, pieces: list[tuple[float, float, Contour]]) -> Prism:
    low, high, contours = zip(*pieces, strict=True)
    mm = [end - begin for begin, end in zip(low, high, strict=True)]
    faces = frozenset(face for contour in contours for face in contour.faces)
    roots = frozenset(root for contour in contours for root in contour.roots)
    return Prism(way, min(low), max(high), contours[mm.index(max(mm))], faces, roots, sum(mm))


def _places(seen: _Across) -> dict[int, tuple[int, ...]]:
    """Return a key of the surface of each face along the direction: pieces of one surface have one key."""
    graph, faces = seen.graph, seen.faces
    o, turn = graph.face_frame[faces, 0], graph.face_outward[faces, None]
    z, radius = graph.face_frame[faces, 3] * turn, graph.face_param[faces, :1]
    flat = np.concatenate([z @ seen.plane.T * 1e4, np.einsum("ki,ki->k", z, o)[:, None] / SAME_MM / 10], axis=1)
    round_ = np.concatenate([o @ seen.plane.T, radius, turn], axis=1) / SAME_MM / 10
    is_plane = (graph.face_kind[faces] == SurfaceKind.PLANE).tolist()
    keys = [np.round(own).astype(np.int64).tolist() for own in (round_, flat)]
    return {face: tuple(keys[own][row]) for row, (face, own) in enumerate(zip(faces.tolist(), is_plane, strict=True))}


def _contours(seen: _Across, at: float) -> list[Contour]:
    """Return the closed lines of the section at a height."""
    rows = np.flatnonzero((seen.low < at) & (seen.high > at)).tolist()
    broken = set(seen.other_face[(seen.other_low < at) & (seen.other_high > at)].tolist())
    corners: dict[int, list[tuple[float, int]]] = defaultdict(list)
    for row in rows:
        for face, along in seen.beside[row]:
            corners[face].append((along, row))
    partner: dict[tuple[int, int], int] = {}
    for face, own in corners.items():
        if face in broken or len(own) % 2 or face not in seen.is_round or (seen.is_round[face] and len(own) != 2):
            continue
        order = [row for _, row in sorted(own)]
        for one, other in zip(order[::2], order[1::2], strict=True):
            partner[face, one], partner[face, other] = other, one
    contours: list[Contour] = []
    used: set[int] = set()
    for start in rows:
        if start in used:
            continue
        walked = _walk(seen, partner, start)
        used.update(walked[0] if walked else (start,))
        if walked is not None:
            contours.append(_contour(seen, *walked))
    return contours


def _walk(seen: _Across, partner: dict[tuple[int, int], int], start: int) -> tuple[list[int], list[int]] | None:
    """Return the corners and sides of the closed line through a corner; None if the walk ends before."""
    row, face = start, seen.beside[start][0][0]
    corners: list[int] = []
    sides: list[int] = []
    while True:
        following = partner.get((face, row))
        if following is None or len(corners) > len(seen.beside):
            return None
        corners.append(row)
        sides.append(face)
        row = following
        (left, _), (right, _) = seen.beside[row]
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
