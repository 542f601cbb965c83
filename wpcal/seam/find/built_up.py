"""Whether one solid was built up of plates, bars and tubes, or cut, cast, turned or printed as one piece.

A plate, a bar or a tube has two faces opposite to each other, at a distance much smaller than they are wide. On a
weldment, nearly the whole surface is of this kind, with few different thicknesses; on a machined, cast or printed part
it is not. The share of the surface is measured with random lines: their hits are spread evenly over a surface, whatever
its shape (Cauchy-Crofton).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from wpcal.brep.concavity import are_concave, inner_edges
from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.hits import find_hits
from wpcal.brep.surfaces import off_axis, project_to_faces, square_to, unit
from wpcal.brep.trim import TrimmedFaces, once_per_solid
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.seam.find.tubes import find_tubes

LEAST_BUILT_UP = 0.9
"""A solid with a smaller share of its surface on plates, bars and tubes is one piece. Of 72 parts with known answers,
weldments have 0.95 to 1.00, machined, cast and printed parts 0.00 to 0.88."""
FLATTEST = 0.3  #: A plate, bar or tube is thinner than this share of the square root of the area of its face.
OPPOSITE_COS = -0.999  #: Cosine between the normals of two faces of one plate: 2.6 degrees from opposite.
THICKNESSES = 3
"""A weldment is cut from this many thicknesses of plate at most; what has others does not count. Round tubes count
whatever their walls: a bicycle frame has five."""
SAME_THICKNESS = 0.02  #: Relative difference of thicknesses that are one.
POINTS, POINTS_A_FACE = 600, 10
"""Random points on the surface of a solid that are to be explained: at least this many, and this many for each face."""
LINES, ROUNDS = 500, 40  #: Random lines per round, and most rounds.
TOGETHER = 100  #: Solids through which lines are sent together: some 50 MB.
LOOKS = ((60, 0.35), (250, 0.15), (1200, 0.0))
"""Points on the surface that are looked at. A share this much below `LEAST_BUILT_UP` is the answer (more than
5 sigma); all of them are enough for 0.02."""
RIM_WAYS = 6
"""Directions along the surface in which the other faces of a plate are looked for from its rim, over half a turn."""
ON_SURFACE = 0.5  #: A normal has the length 1; at the tip of a cone it has none.
SKIN_MM = 1e-3  #: Rays into the material start this far below the surface.
ROUND_KINDS = (SurfaceKind.CYLINDER, SurfaceKind.CONE, SurfaceKind.TORUS)
"""Surfaces with an axis, about which a turned part may have them."""
LEFT_ROUND = 0.7  #: Of the height of flats and keyways, this much is round yet.
TURNED_SIN, TURNED_MM = 1e-6, 1e-3  #: Faces are round about one axis if their axes agree within this.


@once_per_solid
def is_turned(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> bool:
    """Tell whether all faces of a solid are round about one axis: planes across it, cylinders, cones, tori about it.

    Flats and keyways may be cut into it: other faces, some of them planes along the axis, that do not reach beyond it,
    meet its cylinders at no inner corner, and leave most of it round.
    """
    faces = np.flatnonzero(graph.face_solid == solid)
    is_round = np.isin(np.arange(graph.face_count), faces[are_round(graph, faces)])
    rest, first, kind = faces[~is_round[faces]], _axis_of(graph, faces), graph.face_kind
    if len(rest) == 0 or first < 0:
        return len(rest) == 0
    o, z = graph.face_frame[first, [0, 3]]
    shaft = is_round & (kind == SurfaceKind.CYLINDER)
    outer = shaft & (graph.face_outward > 0)
    p = np.concatenate([trimmed.p0[trimmed.start[face] : trimmed.start[face + 1]] for face in rest.tolist()])
    is_along = (kind[rest] == SurfaceKind.PLANE) & (np.abs(graph.face_frame[rest, 3] @ z) <= TURNED_SIN)
    most = graph.face_param[outer, 0].max(initial=0.0) + TURNED_MM
    if not is_along.any() or (off_axis(p, o, z) > most).any():
        return False
    edges = inner_edges(graph, np.arange(len(graph.solid_names)) == solid)
    sides = graph.edge_faces[edges[are_concave(graph, edges)]]
    if (shaft[sides].any(axis=1) & ~is_round[sides].all(axis=1)).any():
        return False
    surface, low, high = sampled_surface(graph, trimmed, solid), (p @ z).min(), (p @ z).max()
    own = outer[surface.face] & (surface.p @ z > low) & (surface.p @ z < high)
    around_mm = 2.0 * np.pi * graph.face_param[surface.face[own], 0]
    return bool(surface.mm2 * (1.0 / around_mm).sum() > LEFT_ROUND * (high - low))


def are_round(graph: BrepGraph, faces: IntArray) -> BoolArray:
    """Tell which faces are round about the axis of the first round one that bulges, if one does, shape (n,)."""
    kinds, first = graph.face_kind[faces], _axis_of(graph, faces)
    if first < 0:
        return np.zeros(len(faces), dtype=bool)
    o, z = graph.face_frame[first, 0], graph.face_frame[first, 3]
    across = np.linalg.norm(np.cross(graph.face_frame[faces, 3], z), axis=1) <= TURNED_SIN
    off = off_axis(graph.face_frame[faces, 0], o, z) <= TURNED_MM
    fits = np.where(kinds == SurfaceKind.PLANE, across, np.where(kinds == SurfaceKind.SPHERE, off, across & off))
    return np.asarray(fits & np.isin(kinds, (*ROUND_KINDS, SurfaceKind.PLANE, SurfaceKind.SPHERE)), dtype=bool)


def _axis_of(graph: BrepGraph, faces: IntArray) -> int:
    """Return the first round face of many that bulges, else the first round one; -1 if there is none."""
    about = faces[np.isin(graph.face_kind[faces], ROUND_KINDS)]
    return int(about[np.argmax(graph.face_outward[about] > 0)]) if len(about) else -1


def built_up_share(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, *, but: BoolArray | None = None) -> float:
    """Return the share of the surface of a solid that is on plates, bars or tubes of at most `THICKNESSES`.

    `but`: shape (F,). Faces that do not count.
    """
    counted = graph.face_solid == solid if but is None else (graph.face_solid == solid) & ~but
    lines, share = _lines_through(graph, trimmed, solid), 0.0
    for count, clearly in LOOKS:
        share = lines.share(graph, trimmed, counted, count)
        if share < LEAST_BUILT_UP - clearly:
            break
    return share


@dataclass(frozen=True, slots=True, eq=False)
class Surface(Columns):
    """Random points that are spread evenly over the surface of a solid, and what was felt there."""

    p: FloatArray  #: shape (n, 3). `SKIN_MM` below the surface, mm.
    normal: FloatArray  #: shape (n, 3). Outward.
    face: IntArray  #: shape (n,).
    thick: FloatArray  #: shape (n,). How far straight through the material, mm.
    facing: FloatArray  #: shape (n,). Cosine between the outward normals here and on the other side.
    mm2: float  #: The area that each point stands for.

    @property
    def flat(self) -> BoolArray:
        """Whether the other side is parallel, shape (n,)."""
        return self.facing < OPPOSITE_COS


def sampled_surface(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> Surface:
    """Return about `POINTS` points on the surface of a solid, or `POINTS_A_FACE` for each face if these are more."""
    lines, own = _lines_through(graph, trimmed, solid), graph.face_solid == solid
    sent = lines.send(graph, trimmed, own, int(_points_asked(graph)[solid]))
    felt = replace(lines.felt, mm2=2.0 * np.pi * lines.radius**2 / (sent * LINES))
    return felt.select(np.flatnonzero(np.linalg.norm(felt.normal[: lines.rounds[sent - 1]], axis=1) > ON_SURFACE))


def filled_share(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> float:
    """Return which share of its convex hull a solid fills, from the flux through its faces; exact for planes."""
    from scipy.spatial import ConvexHull

    faces = np.repeat(np.arange(graph.face_count), np.diff(trimmed.start))
    rows = np.flatnonzero(graph.face_solid[faces] == solid)
    own, p0, p1, surface = faces[rows], trimmed.p0[rows], trimmed.p1[rows], sampled_surface(graph, trimmed, solid)
    sums = np.column_stack([np.bincount(own, p, graph.face_count) for p in (p0 - p0.mean(axis=0)).T])
    middle = p0.mean(axis=0) + sums / np.maximum(np.bincount(own, minlength=graph.face_count), 1)[:, None]
    areas = np.cross(p0 - middle[own], p1 - middle[own]) / 2.0
    flux = np.einsum("ki,ki->", middle[own] - p0.mean(axis=0), areas)
    flux += surface.mm2 * np.einsum("ki,ki->", surface.p - middle[surface.face], surface.normal)
    return float(flux / 3.0 / ConvexHull(np.concatenate([p0, surface.p]), qhull_options="QJ").volume)


def sample_surfaces(graph: BrepGraph, trimmed: TrimmedFaces, solids: Sequence[int]) -> None:
    """Feel the surfaces of solids with few faces together; of others `sampled_surface` feels each by itself."""
    asked = _points_asked(graph)
    lines = [_lines_through(graph, trimmed, solid) for solid in solids if 0 < asked[solid] <= POINTS]
    while due := [own for own in lines if len(own.rounds) < ROUNDS and len(own.felt.face) < asked[own.solid]]:
        _send_round(graph, trimmed, due[:TOGETHER])


def _points_asked(graph: BrepGraph) -> IntArray:
    counts = np.bincount(graph.face_solid, minlength=len(graph.solid_names))
    return np.where(counts, np.maximum(POINTS, POINTS_A_FACE * counts), 0)


@dataclass(slots=True, eq=False)
class _Lines:
    """Random lines through the ball around a solid, where they go through its faces, and what was felt there."""

    solid: int
    centre: FloatArray  #: shape (3,).
    radius: float  #: Of the ball, mm.
    rng: np.random.Generator
    felt: Surface  #: What was felt in all rounds; `mm2` is not used.
    rounds: list[int] = field(default_factory=list)  #: How many points there are after each round of lines.
    #: shape (n, RIM_WAYS). How thick the material is along the surface, mm; negative where it was not felt yet,
    #: infinite where the two sides are not parallel.
    across: FloatArray = field(default_factory=lambda: np.zeros((0, RIM_WAYS)))

    def share(self, graph: BrepGraph, trimmed: TrimmedFaces, counted: BoolArray, hits: int) -> float:
        """Return the share of `built_up_share` after this many hits on the counted faces."""
        sent = self.send(graph, trimmed, counted, hits)
        rows = np.flatnonzero(counted[self.felt.face[: self.rounds[sent - 1]]])
        if len(rows) == 0:
            return 0.0
        rows = rows[np.linalg.norm(self.felt.normal[rows], axis=1) > ON_SURFACE]
        face, thick = self.felt.face[rows], self.felt.thick[rows]
        # a line through the ball meets a surface as often as the two areas say
        hit = np.bincount(face, minlength=graph.face_count)
        face_area = hit * (2.0 * np.pi * self.radius**2) / (sent * LINES)
        flat = self.felt.facing[rows] < OPPOSITE_COS
        is_plate = flat & (thick < FLATTEST * np.sqrt(face_area[face]))
        tubes, wall = find_tubes(graph, trimmed, self.solid), np.full(graph.face_count, np.nan)
        wall[tubes.face] = tubes.wall_mm
        is_tube = flat & (np.abs(thick - wall[face]) <= SAME_THICKNESS * thick)
        used, plates = _commonest(np.sort(thick[is_plate & ~is_tube]))
        plates += int(is_tube.sum())
        used = np.concatenate([used, np.unique(wall[np.isfinite(wall)])])
        rim = rows[~is_plate & ~is_tube]
        self._feel_rim(graph, trimmed, rim)
        near = np.abs(self.across[rim][..., None] - used) <= SAME_THICKNESS * used
        return (plates + int(near.any(axis=(1, 2)).sum())) / len(rows)

    def send(self, graph: BrepGraph, trimmed: TrimmedFaces, counted: BoolArray, hits: int) -> int:
        """Send lines until there are this many hits on the counted faces; return after how many rounds that is."""
        for sent in range(1, ROUNDS + 1):
            if sent > len(self.rounds):
                _send_round(graph, trimmed, [self])
            if np.count_nonzero(counted[self.felt.face[: self.rounds[sent - 1]]]) >= hits:
                return sent
        return ROUNDS

    def drawn(self) -> tuple[FloatArray, FloatArray]:
        """Return starts and directions of new lines."""
        z = unit(self.rng.normal(size=(LINES, 3)))
        x = unit(np.cross(z, self.rng.normal(size=(LINES, 3))))
        off = self.radius * np.sqrt(self.rng.uniform(size=LINES))[:, None] * x
        return self.centre + off - self.radius * z, z

    def _feel_rim(self, graph: BrepGraph, trimmed: TrimmedFaces, rows: IntArray) -> None:
        """Feel how thick the material is along the surface: on the rim of a plate, one of the known thicknesses."""
        rows = rows[self.across[rows, 0] == -np.inf]
        p, normal = self.felt.p[rows], self.felt.normal[rows]
        side = square_to(normal)
        other = np.cross(normal, side)
        for number, turn in enumerate(np.arange(RIM_WAYS) * np.pi / RIM_WAYS):
            way = np.cos(turn) * side + np.sin(turn) * other
            there, n0 = way_out(graph, trimmed, self.solid, p, way)
            back, n1 = way_out(graph, trimmed, self.solid, p, -way)
            with np.errstate(invalid="ignore"):
                across = (there + back) * np.abs(np.einsum("ki,ki->k", way, n0))
            opposite = np.einsum("ki,ki->k", n0, n1) < OPPOSITE_COS
            self.across[rows, number] = np.where(opposite, across, np.inf)


def _send_round(graph: BrepGraph, trimmed: TrimmedFaces, lines: Sequence[_Lines]) -> None:
    """Send new lines through solids, and feel how thick the material is where they meet it."""
    origins, z = (np.concatenate(column) for column in zip(*(own.drawn() for own in lines), strict=True))
    solid, far_mm = np.repeat([(own.solid, 2.0 * own.radius) for own in lines], LINES, axis=0).T
    solid = solid.astype(np.int64)
    found = find_hits(trimmed, origins, z, length_mm=far_mm, solid=solid)
    p = origins[found.ray] + found.at_mm[:, None] * z[found.ray]
    normal = project_to_faces(graph, found.face, p).normal
    inside = p - SKIN_MM * normal
    thick, opposite = way_out(graph, trimmed, solid[found.ray], inside, -normal)
    facing = np.einsum("ki,ki->k", normal, opposite)
    felt = Surface(inside, normal, found.face, thick + SKIN_MM, facing, 0.0)
    ends = np.searchsorted(found.ray, LINES * np.arange(len(lines) + 1)).tolist()
    for own, first, last in zip(lines, ends[:-1], ends[1:], strict=True):
        own.felt = Surface.joined([own.felt, felt.select(slice(first, last))])
        own.across = np.concatenate([own.across, np.full((last - first, RIM_WAYS), -np.inf)])
        own.rounds.append(len(own.felt.face))


@once_per_solid
def _lines_through(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> _Lines:
    low, high = (corner[solid] for corner in trimmed.solid_boxes)
    none, nowhere = np.zeros(0), np.zeros((0, 3))
    felt = Surface(nowhere, nowhere, none.astype(np.int64), none, none, 0.0)
    return _Lines(solid, (low + high) / 2, float(np.linalg.norm(high - low)) / 2, np.random.default_rng(0), felt)


def way_out(
    graph: BrepGraph, trimmed: TrimmedFaces, solid: IntArray | int, p: FloatArray, ray: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far rays run before they leave a solid, and the outward normal where they do.

    Returns `length_mm`: ndarray, shape (m,). Infinite where a ray does not leave the solid.
    Returns `normal`: ndarray, shape (m, 3).

    `solid`: int or ndarray of int, shape (m,)
    `p`, `ray`: shape (m, 3). Starts inside the solid (mm) and unit directions, in `part`.
    """
    hits = find_hits(trimmed, p, ray, length_mm=graph.size_mm, solid=solid)
    rows = np.flatnonzero(hits.way > 0)
    first = rows[np.unique(hits.ray[rows], return_index=True)[1]]
    length, normal = np.full(len(p), np.inf), np.zeros_like(p)
    length[hits.ray[first]] = hits.at_mm[first]
    at = p[hits.ray[first]] + hits.at_mm[first, None] * ray[hits.ray[first]]
    normal[hits.ray[first]] = project_to_faces(graph, hits.face[first], at).normal
    return length, normal


def _commonest(thick: FloatArray) -> tuple[FloatArray, int]:
    """Return the `THICKNESSES` commonest of many thicknesses, ascending, and how many have one of them."""
    left, used, total = thick, [], 0
    for _ in range(THICKNESSES):
        if len(left) == 0:
            break
        end = np.searchsorted(left, left * (1.0 + SAME_THICKNESS), side="right")
        row = int(np.argmax(end - np.arange(len(left))))
        used.append(float(np.median(left[row : end[row]])))
        total += int(end[row]) - row
        left = np.delete(left, slice(row, end[row]))
    return np.array(used), total
