"""Whether one solid was built up of plates, bars and tubes, or cut, cast, turned or printed as one piece.

A plate, a bar or a tube has two faces opposite to each other, at a distance much smaller than they are wide. On a
weldment, nearly the whole surface is of this kind, with few different thicknesses; on a machined, cast or printed part
it is not. The share of the surface is measured with random lines: their hits are spread evenly over a surface, whatever
its shape (Cauchy-Crofton).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.hits import find_hits
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.issue import Issue
from wpcal.seam.find.concave import find_concave_edges

LEAST_BUILT_UP = 0.9
"""A solid with a smaller share of its surface on plates, bars and tubes is one piece. Of 72 parts with known answers,
weldments have 0.95 to 1.00, machined, cast and printed parts 0.00 to 0.88."""
FLATTEST = 0.3
"""A plate, bar or tube is thinner than this share of the square root of the area of its face."""
OPPOSITE_COS = -0.999
"""Cosine between the normals of two faces of one plate: 2.6 degrees from opposite."""
THICKNESSES = 3
"""A weldment is cut from this many thicknesses of material at most; what has others does not count."""
SAME_THICKNESS = 0.02
"""Relative difference of thicknesses that are one."""
LINES, ROUNDS = 500, 40
"""Random lines per round, and most rounds."""
FIRST_HITS, LEAST_HITS = 250, 1200
"""After the first hits, a share that is lower by `CLEARLY` is the answer; the others are enough for 0.02."""
CLEARLY = 0.15
MOST_TOLD = 3
"""Most solids that are told of."""
RIM_WAYS = 6
"""Directions along the surface in which the other faces of a plate are looked for from its rim, over half a turn."""
SKIN_MM = 1e-3
"""Rays into the material start this far below the surface."""
ROUND_KINDS = (SurfaceKind.CYLINDER, SurfaceKind.CONE, SurfaceKind.TORUS)
"""Surfaces with an axis, about which a turned part may have them."""
TURNED_SIN, TURNED_MM = 1e-6, 1e-3
"""Faces are round about one axis if their axes agree within this."""


def why_one_piece(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, *, but: BoolArray | None = None) -> str | None:
    """Tell why a solid looks as if it had been made as one piece; None if it may be a weldment.

    Parameters
    ----------
    graph, trimmed :
        The part.
    solid : int
    but : ndarray of bool, shape (F,), optional
        Faces that do not count: strips that may be beads.
    """
    if is_turned(graph, solid):
        return "all its faces are round about one axis, as on a turned part"
    share = built_up_share(graph, trimmed, solid, but=but)
    if share < LEAST_BUILT_UP:
        return f"{share:.0%} of its surface is on plates, bars or tubes; a weldment has {LEAST_BUILT_UP:.0%} or more"
    return None


def left_out(graph: BrepGraph, trimmed: TrimmedFaces) -> list[Issue]:
    """Tell in which solids concave edges are not taken for welds, and why, for a part without a candidate.

    Parameters
    ----------
    graph, trimmed :
        The part.

    Returns
    -------
    list of Issue
        One for each solid with concave edges that looks as if made as one piece, the solid with most edges first.
    """
    solid_of = graph.face_solid[find_concave_edges(graph).pieces.wall]
    solids, counts = np.unique(solid_of, return_counts=True)
    found = []
    for solid, count in sorted(zip(solids.tolist(), counts.tolist(), strict=True), key=lambda pair: -pair[1])[
        :MOST_TOLD
    ]:
        why = why_one_piece(graph, trimmed, solid)
        if why is not None:
            name = graph.solid_names[solid]
            told = (
                f"{count} concave edges of {name} are not taken for welds: {why}; if they are welds: --concave always"
            )
            found.append(Issue("one-piece", told, (name,)))
    return found


def is_turned(graph: BrepGraph, solid: int, *, but: BoolArray | None = None) -> bool:
    """Tell whether all faces of a solid are round about one axis: planes across it, cylinders, cones and tori about it.

    Parameters
    ----------
    graph : BrepGraph
    solid : int
    but : ndarray of bool, shape (F,), optional
        Faces that do not count, such as holes.
    """
    faces = np.flatnonzero(graph.face_solid == solid if but is None else (graph.face_solid == solid) & ~but)
    kinds = graph.face_kind[faces]
    about = faces[np.isin(kinds, ROUND_KINDS)]
    if len(about) == 0 or not np.isin(kinds, (*ROUND_KINDS, SurfaceKind.PLANE, SurfaceKind.SPHERE)).all():
        return False
    o, z = graph.face_frame[about[0], 0], graph.face_frame[about[0], 3]
    across = np.linalg.norm(np.cross(graph.face_frame[faces, 3], z), axis=1) <= TURNED_SIN
    arm = graph.face_frame[faces, 0] - o
    off = np.linalg.norm(arm - (arm @ z)[:, None] * z, axis=1) <= TURNED_MM
    fits = np.where(kinds == SurfaceKind.PLANE, across, np.where(kinds == SurfaceKind.SPHERE, off, across & off))
    return bool(fits.all())


def built_up_share(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, *, but: BoolArray | None = None) -> float:
    """Return the share of the surface of a solid that is on plates, bars or tubes of at most `THICKNESSES`.

    Parameters
    ----------
    graph, trimmed :
        The part.
    solid : int
    but : ndarray of bool, shape (F,), optional
        Faces that do not count.
    """
    share = 0.0
    for share, _ in built_up_shares(graph, trimmed, solid, (FIRST_HITS, LEAST_HITS), but=but):
        if share < LEAST_BUILT_UP - CLEARLY:
            break
    return share


def built_up_shares(
    graph: BrepGraph, trimmed: TrimmedFaces, solid: int, counts: Sequence[int], *, but: BoolArray | None = None
) -> Iterator[tuple[float, int]]:
    """Yield the share of `built_up_share` after each of some numbers of points on the surface, and the true number.

    Parameters
    ----------
    graph, trimmed :
        The part.
    solid : int
    counts : sequence of int
        Ascending. More points take more time.
    but : ndarray of bool, shape (F,), optional
        Faces that do not count.
    """
    counted = graph.face_solid == solid if but is None else (graph.face_solid == solid) & ~but
    lines = _Lines.through(trimmed, solid)
    for count in counts:
        lines.send(counted, count)
        yield _share(graph, trimmed, solid, lines), len(lines.face)


@dataclass(slots=True, eq=False)
class _Lines:
    """Random lines through the ball around a solid, and where they go through its faces."""

    trimmed: TrimmedFaces
    centre: FloatArray
    radius: float
    rng: np.random.Generator
    sent: int = 0
    p: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    face: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    @classmethod
    def through(cls, trimmed: TrimmedFaces, solid: int) -> _Lines:
        own = trimmed.graph.face_solid == solid
        low, high = trimmed.face_box[0][own].min(axis=0), trimmed.face_box[1][own].max(axis=0)
        return cls(trimmed, (low + high) / 2, float(np.linalg.norm(high - low)) / 2, np.random.default_rng(0))

    def send(self, counted: BoolArray, hits: int) -> None:
        """Send lines until there are so many hits on the counted faces, or no more rounds."""
        while len(self.face) < hits and self.sent < ROUNDS * LINES:
            z = self.rng.normal(size=(LINES, 3))
            z /= np.linalg.norm(z, axis=1, keepdims=True)
            x = np.cross(z, self.rng.normal(size=(LINES, 3)))
            x /= np.linalg.norm(x, axis=1, keepdims=True)
            off = self.radius * np.sqrt(self.rng.uniform(size=LINES))[:, None] * x
            origins = self.centre + off - self.radius * z
            found = find_hits(self.trimmed.graph, self.trimmed, origins, z, length_mm=2.0 * self.radius)
            here = counted[found.face]
            p = (origins[found.ray] + found.at_mm[:, None] * z[found.ray])[here]
            self.p, self.face = np.concatenate([self.p, p]), np.concatenate([self.face, found.face[here]])
            self.sent += LINES

    @property
    def area_mm2(self) -> float:
        """Area of the counted faces: a line through the ball meets a surface as often as the two areas say."""
        return 2.0 * np.pi * self.radius**2 * len(self.face) / self.sent


def _share(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, lines: _Lines) -> float:
    p, face = lines.p, lines.face
    if len(p) == 0:
        return 0.0
    normal = project_to_faces(graph, face, p).normal
    regular = np.linalg.norm(normal, axis=1) > 0.5  # not the tip of a cone
    p, face, normal = p[regular], face[regular], normal[regular]
    inside = p - SKIN_MM * normal
    thick, opposite = way_out(graph, trimmed, solid, inside, -normal)
    face_area = np.bincount(face, minlength=graph.face_count) * lines.area_mm2 / len(lines.face)
    flat = np.einsum("ki,ki->k", normal, opposite) < OPPOSITE_COS
    flat &= thick + SKIN_MM < FLATTEST * np.sqrt(face_area[face])
    used, count = _commonest(np.sort(thick[flat] + SKIN_MM))
    rim = np.flatnonzero(~flat)
    return (count + int(_is_rim(graph, trimmed, solid, inside[rim], normal[rim], used).sum())) / len(p)


def _is_rim(
    graph: BrepGraph, trimmed: TrimmedFaces, solid: int, p: FloatArray, normal: FloatArray, thick: FloatArray
) -> BoolArray:
    """Tell which points just below a surface are on the rim of a plate: across the rim, it has a known thickness."""
    side = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal), axis=1)])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(normal, side)
    is_rim = np.zeros(len(p), dtype=bool)
    for turn in np.arange(RIM_WAYS) * np.pi / RIM_WAYS:
        way = np.cos(turn) * side + np.sin(turn) * other
        there, n0 = way_out(graph, trimmed, solid, p, way)
        back, n1 = way_out(graph, trimmed, solid, p, -way)
        with np.errstate(invalid="ignore"):
            across = (there + back) * np.abs(np.einsum("ki,ki->k", way, n0))
        fits = (np.abs(across[:, None] - thick) <= SAME_THICKNESS * thick).any(axis=1)
        is_rim |= fits & (np.einsum("ki,ki->k", n0, n1) < OPPOSITE_COS)
    return is_rim


def way_out(
    graph: BrepGraph, trimmed: TrimmedFaces, solid: IntArray | int, p: FloatArray, ray: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far rays run before they leave a solid, and the outward normal where they do.

    Parameters
    ----------
    graph, trimmed :
        The part.
    solid : int or ndarray of int, shape (m,)
    p, ray : ndarray, shape (m, 3)
        Starts inside the solid (mm) and unit directions, in `part`.

    Returns
    -------
    length_mm : ndarray, shape (m,)
        Infinite where a ray does not leave the solid.
    normal : ndarray, shape (m, 3)
    """
    hits = find_hits(graph, trimmed, p, ray, length_mm=graph.size_mm)
    leaves = (graph.face_solid[hits.face] == np.broadcast_to(solid, len(p))[hits.ray]) & (hits.way > 0)
    rows = np.flatnonzero(leaves)
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
