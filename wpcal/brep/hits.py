"""Where rays go through the faces of a part: in closed form, except for free-form faces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wpcal.brep.boxes import BoxTree
from wpcal.brep.graph import SurfaceKind
from wpcal.brep.strips import items_of
from wpcal.brep.surface_rays import meet_rays, way_through
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.torus_rays import torus_roots
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray, blocks

CHUNK = 5000  #: Rays handled in one array: some 50 MB at ten faces per ray.
FEW_FACES = 64  #: Rays through solids with this few faces each are compared with all their boxes, without a tree.
THIN_MM = 0.1  #: Boxes grow by this, so that a ray across a plane face has samples on both sides of the face.
ON_SURFACE = 1e-6
"""A root of the equation of a surface is a hit if its nearest point on the surface is this near, relative to the
length of the ray's way there or 1 mm; the other nappe of a cone is farther away."""
START_MM = 1.0  #: Rays start this far outside the part, clear of a gap and of the faces beside the joint.
TOOL_MM = 300.0
"""Length of a straight tool: with a usual torch neck, from the tip of the wire to where the wrist has room to turn."""
PARALLEL = 1e-14  #: A leading coefficient below this is round-off: the ray runs along a plane or a ruling.


@dataclass(frozen=True, slots=True, eq=False)
class RayHits(Columns):
    """Places where rays go through faces, sorted by ray, then by distance."""

    #: `ray`, `face`: shape (k,).
    ray: IntArray
    face: IntArray
    at_mm: FloatArray  #: shape (k,). Distance from the start of the ray.
    way: IntArray  #: shape (k,). +1 where the ray leaves the material of the face's solid, -1 where it enters it.

    def in_order(self) -> RayHits:
        """Return the places sorted."""
        return self.select(np.lexsort((self.at_mm, self.ray)))


def find_hits(
    trimmed: TrimmedFaces,
    origins: FloatArray,
    rays: FloatArray,
    *,
    length_mm: FloatArray | float,
    solid: IntArray | int | None = None,
) -> RayHits:
    """Find all places where rays go through faces.

    `origins`, `rays`: shape (m, 3). Starts (mm) and unit directions in `part`.
    `length_mm`: shape (m,). Where the rays end.
    `solid`: shape (m,). Only the faces of this solid, one for all rays or one for each.
    """
    length, found = np.broadcast_to(np.asarray(length_mm, dtype=np.float64), len(origins)), []
    for near in _near_pairs(trimmed, origins, rays, length, solid):
        ray, face = near
        with np.errstate(divide="ignore", invalid="ignore"):
            box = (corner[face].T for corner in trimmed.face_box)
            low, high = passage(origins[ray].T, rays[ray].T, length[ray], *box)
        met = np.flatnonzero(high > low)
        ray, face, low, high = ray[met], face[met], low[met], high[met]
        pair, at, way = through_faces(trimmed, face, origins[ray], rays[ray], length[ray], (low, high))
        found.append(RayHits(ray[pair], face[pair], at, way))
    return RayHits.joined(found).in_order()


def is_blocked(
    trimmed: TrimmedFaces, origins: FloatArray, rays: FloatArray, *, length_mm: FloatArray | float = TOOL_MM
) -> BoolArray:
    """Tell which rays hit a face of the part, shape (m,).

    `origins`, `rays`: shape (m, 3). Starts (mm) and unit directions in `part`.
    `length_mm`: shape (m,). Where the rays end.
    """
    blocked = np.zeros(len(origins), dtype=bool)
    blocked[find_hits(trimmed, origins, rays, length_mm=length_mm).ray] = True
    return blocked


def _near_pairs(
    trimmed: TrimmedFaces, origins: FloatArray, rays: FloatArray, length: FloatArray, solid: IntArray | int | None
) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield pairs of a ray and a face whose box it may meet, by ray, this many rays at a time; of its solid only."""
    of_face, each = trimmed.graph.face_solid, np.broadcast_to(-1 if solid is None else solid, len(origins))
    asked = np.zeros(len(trimmed.graph.solid_names) + 1, dtype=bool)
    asked[each] = True  # the last one: all
    faces = np.flatnonzero(asked[of_face] | asked[-1])
    is_whole = len(faces) == len(of_face)
    tree = trimmed.box_tree if is_whole else BoxTree.of(*(corner[faces] for corner in trimmed.face_box))
    by_solid = np.argsort(of_face, kind="stable")
    start = np.searchsorted(of_face[by_solid], np.arange(len(asked)))
    are_few = isinstance(solid, np.ndarray) and np.diff(start)[each].max(initial=0) <= FEW_FACES
    for chunk in blocks(len(origins), CHUNK):
        if are_few:
            ray, item = items_of(start, each[chunk])
            yield ray + chunk.start, by_solid[item]
        else:
            ray, item = boxes_met(tree, origins[chunk], rays[chunk], length[chunk])
            ray, face = ray + chunk.start, faces[item]
            own = asked[-1] | (of_face[face] == each[ray])
            yield ray[own], face[own]


def through_faces(
    trimmed: TrimmedFaces,
    face: IntArray,
    origins: FloatArray,
    rays: FloatArray,
    length: FloatArray,
    ends_mm: tuple[FloatArray, FloatArray],
) -> tuple[IntArray, FloatArray, IntArray]:
    """Find which of k pairs of a ray and a face meet.

    `face`: ndarray of int, shape (k,)
    `origins`, `rays`: shape (k, 3). Starts (mm) and unit directions in `part`.
    `length`: shape (k,). Where the rays end, mm.
    `ends_mm`: shapes (k,). Distances between which the ray is in the box of the face.

    Returns `pair`: shape (h,). The pairs that meet.
    Returns `at_mm`: shape (h,). At which distance.
    Returns `way`: shape (h,). +1 where the ray leaves the material of the face's solid, -1 where it enters it.
    """
    graph, (low, high) = trimmed.graph, ends_mm
    kind, frame, param = graph.face_kind[face], graph.face_frame[face], graph.face_param[face]
    o = np.einsum("kij,kj->ki", frame[:, 1:], origins - frame[:, 0])
    d = np.einsum("kij,kj->ki", frame[:, 1:], rays)
    free_form = np.flatnonzero(kind == SurfaceKind.NURBS)
    roots = _roots(kind, param, o, d)
    pair, root = np.nonzero((roots > 0) & (roots <= length[:, None]))
    at = roots[pair, root]
    rings = np.flatnonzero(
        (kind == SurfaceKind.TORUS) & _is_between(o[:, 2], d[:, 2], param[:, 1] + THIN_MM, low, high)
    )
    if len(rings):
        roots = torus_roots(o[rings], d[rings], *param[rings].T)
        hit = (roots > 0) & (roots <= length[rings, None])
        pair, at = np.concatenate([pair, rings[np.nonzero(hit)[0]]]), np.concatenate([at, roots[hit]])
    points = origins[pair] + at[:, None] * rays[pair]
    foot = project_to_faces(graph, face[pair], points)
    kept = np.flatnonzero(np.linalg.norm(foot.p - points, axis=1) <= ON_SURFACE * np.maximum(1.0, at))
    kept = kept[trimmed.contains(face[pair[kept]], foot.uv[kept])]
    pair, at, normal = pair[kept], at[kept], foot.normal[kept]
    if len(free_form):
        own = face[free_form], origins[free_form], rays[free_form], low[free_form], high[free_form]
        more, at_more, normals = _through_free_form(trimmed, *own)
        pair, at = np.concatenate([pair, free_form[more]]), np.concatenate([at, at_more])
        normal = np.concatenate([normal, normals])
    return pair, at, np.where(np.einsum("ki,ki->k", rays[pair], normal) > 0, 1, -1)


def _through_free_form(
    trimmed: TrimmedFaces, face: IntArray, origins: FloatArray, rays: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return which pairs of a ray and a free-form face meet, at which distances, and the outward normals there."""
    graph = trimmed.graph
    hits = meet_rays(graph.nurbs_cells, graph.face_nurbs[face], origins, rays, low, high)
    hits = hits.select((hits.at_mm > 0) & trimmed.contains(face[hits.row], hits.uv))
    return hits.row, hits.at_mm, hits.normal * graph.face_outward[face[hits.row]][:, None]


def _roots(kind: IntArray, param: FloatArray, o: FloatArray, d: FloatArray) -> FloatArray:
    """Return the distances at which rays meet the whole surfaces of faces, shape (k, 2); NaN where there is none.

    `kind`, `param`: Of the faces, shapes (k,) and (k, …). `o`, `d`: shape (k, 3). The rays in their frames.
    """
    # |q|² with the third axis weighted by m, less the square of the radius there, r + slope · z
    slope = np.where(kind == SurfaceKind.CONE, np.tan(np.where(kind == SurfaceKind.CONE, param[:, 1], 0.0)), 0.0)
    m = np.where(kind == SurfaceKind.SPHERE, 1.0, 0.0)
    radius = param[:, 0] + slope * o[:, 2]
    a = d[:, 0] ** 2 + d[:, 1] ** 2 + (m - slope**2) * d[:, 2] ** 2
    b = o[:, 0] * d[:, 0] + o[:, 1] * d[:, 1] + m * o[:, 2] * d[:, 2] - radius * slope * d[:, 2]
    c = o[:, 0] ** 2 + o[:, 1] ** 2 + m * o[:, 2] ** 2 - radius**2
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - a * c)
        q = -(b + np.copysign(root, b))  # no difference of nearly equal numbers
        first, second = np.where(np.abs(a) > PARALLEL, q / a, np.nan), c / q
        flat = np.where(np.abs(d[:, 2]) > PARALLEL, -o[:, 2] / d[:, 2], np.nan)
    plane = kind == SurfaceKind.PLANE
    known = np.isin(kind, (SurfaceKind.CYLINDER, SurfaceKind.CONE, SurfaceKind.SPHERE))
    first = np.where(plane, flat, np.where(known, first, np.nan))
    return np.stack([first, np.where(known, second, np.nan)], axis=1)


def _is_between(z: FloatArray, dz: FloatArray, half: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Tell which rays go through a torus, from z along dz, between its two end planes where they are in its box."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (-half - z) / dz, (half - z) / dz
    return np.asarray(np.minimum(high, np.fmax(a, b)) > np.maximum(low, np.fmin(a, b)), dtype=bool)


def boxes_met(tree: BoxTree, origins: FloatArray, rays: FloatArray, length: FloatArray) -> tuple[IntArray, IntArray]:
    """Return all pairs of a ray and a box that it meets, shape (k,), by ray; arguments as of `find_hits`."""
    o, d = np.ascontiguousarray(origins.T), np.ascontiguousarray(rays.T)

    def meets(ray: IntArray, low: FloatArray, high: FloatArray) -> BoolArray:
        enter, leave = passage(np.take(o, ray, axis=1), np.take(d, ray, axis=1), length[ray], low, high)
        return np.asarray(leave > enter, dtype=bool)

    with np.errstate(divide="ignore", invalid="ignore"):
        return tree.search(len(origins), meets)


def passage(
    o: FloatArray, d: FloatArray, length: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where rays from o along d enter boxes and where they leave them; a ray that leaves first misses its box.

    `o`, `d`, `low`, `high`: shape (3, m). As of `way_through`; the boxes grow by `THIN_MM`.
    `length`: shape (m,). Where the rays end, mm.
    """
    return way_through(o, d, np.zeros(len(length)), length, low - THIN_MM, high + THIN_MM)
