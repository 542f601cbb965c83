"""Bolts, screws, nuts, washers and tie rods: solids that hold others together without a weld.

They are recognised by shape and seat, so that a file without names works as well. A *pin* is a solid of revolution
without a bore (flats along its axis may be a hexagon, flats across it are end faces). A *ring* is a short one with a
through bore. A pin that goes through other solids is a fastener if it has a head or carries a ring. A ring is a
fastener if such a pin goes through it and through something else. So a plain pin, a shaft and a collar on a tube are
not. Of bolts that were drawn in one body with their plate only faces are left, and thin, headed ones are known by them.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import off_axis, project_to_faces, square_to
from wpcal.brep.trim import TrimmedFaces, once_per_solid
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.built_up import ROUND_KINDS
from wpcal.seam.member.prisms import Prism, find_prisms

SEAT_MM = 0.5  #: A head, a nut or a washer lies on a face that is this near: some are modelled a little in or above it.
LARGEST_RADIUS_MM = 20.0  #: Bolts of steelwork go up to M36; a thicker round bar in a hole is a member.
COAXIAL_MM, COAXIAL_SIN = 0.2, 2e-3
"""Axes nearer and more parallel than this are one: holes are modelled in place, and exporters round."""
BORE_RATIO = (0.75, 1.3)
"""Radius of a hole over that of its pin: a tapped nut is modelled at the core diameter (0.8); a clearance hole is
1.1."""
HEAD_RATIO, HEAD_HEIGHT = 1.15, 1.5
"""A head is wider than the first times the shank (that of a set screw is not) and at most the second times its
diameter high."""
RING_WIDTH, RING_HEIGHT = 1.75, 1.5
"""Largest radius and height of a ring, in bores: a nut has radius 1, a large washer 1.5; a nut is 0.8 high, a lock nut
1.2."""
HEXAGON, HEXAGON_SHARE, MOST_FLATS_MM = 6, 0.02, 46.0
"""A head or a nut that was drawn in one body with its plate has this many sides, equal within this share, and is this
wide across flats at most (M30)."""
SHANK_SHARE = (0.28, 0.4)  #: Radius of a bolt over its width across flats.
LARGEST_SCREW_MM, MOST_PLATE = 8.0, 4.0
"""A screw with a round head that was drawn in one body with its plate has a shank up to this radius (M16), and a plate
up to this many of these thick."""
MOST_HEAD_RATIO, MOST_HEAD = 2.3, 2.2
"""Such a head is no wider and no higher than this many radii of its shank: that of a socket screw is 2 high. Nothing
tells that it is a piece of its own, so less is allowed than of a body."""


@dataclass(frozen=True, slots=True, eq=False)
class Fastener:
    """One fastener."""

    what: str  #: For people: ``a bolt or screw``, ``a nut or washer``, ``a rod with nuts``.
    through: frozenset[int]  #: The solids that it goes through; for a ring, those of its pin.
    on: frozenset[int]  #: The solids on which its flat faces lie: what a head, a nut or a washer presses on.
    pin: int  #: The solid that is the pin: itself, or that of a ring.
    #: `o`, `z`: shape (3,). A point on its axis, and the direction of the axis, in `part`, mm.
    o: FloatArray
    z: FloatArray
    #: `low`, `high`: Where its pin begins and ends along the axis, measured from `o`, mm.
    low: float
    high: float


@dataclass(frozen=True, slots=True, eq=False)
class _Turned:
    """A solid of revolution: its axis, and along it the radii and the ends."""

    o: FloatArray
    z: FloatArray
    shank: float
    bore: float
    widest: float
    low: float
    high: float
    head: float


def find_fasteners(graph: BrepGraph, trimmed: TrimmedFaces) -> dict[int, Fastener]:
    """Find the solids that are fasteners, by shape and seat. The fasteners, by number of the solid."""
    turned = {}
    faces = np.argsort(graph.face_solid, kind="stable")
    starts = np.searchsorted(graph.face_solid[faces], np.arange(len(graph.solid_names) + 1))
    for solid in range(len(graph.solid_names)):
        shape = _turned(graph, trimmed, faces[starts[solid] : starts[solid + 1]])
        if shape is not None:
            turned[solid] = shape
    rings = {solid for solid, shape in turned.items() if _is_ring(shape)}
    holes = np.flatnonzero((graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward < 0))
    through = {
        solid: _gone_through(graph, trimmed, holes, solid, shape)
        for solid, shape in turned.items()
        if shape.bore == 0 and 0 < shape.shank <= LARGEST_RADIUS_MM
    }
    chosen = {}
    for pin, solids in through.items():
        shank, head, widest = turned[pin].shank, turned[pin].head, turned[pin].widest
        headed = widest >= HEAD_RATIO * shank and 0 < head <= 2.0 * HEAD_HEIGHT * shank
        if solids and (headed or (solids & rings and len(solids) > 1)):
            chosen[pin] = (pin, "a bolt or screw" if headed else "a rod with nuts", solids)
            chosen |= {ring: (pin, "a nut or washer", (solids | {pin}) - {ring}) for ring in solids & rings}
    lies_on = _lies_on(graph, trimmed, {solid: turned[solid] for solid in chosen})
    found = {}
    for solid, (pin, what, solids) in chosen.items():
        shape, on = turned[pin], lies_on[solid] - chosen.keys()
        found[solid] = Fastener(what, solids, on, pin, shape.o, shape.z, shape.low, shape.high)
    return found


@once_per_solid
def screw_faces(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> frozenset[int]:
    """Return the faces of bolts and screws that are one body with more."""
    own, prisms = np.flatnonzero(graph.face_solid == solid), find_prisms(graph, trimmed, solid)
    return frozenset((*_hexagons(graph, trimmed, own, prisms), *_headed_pins(graph, trimmed, own)))


def _hexagons(graph: BrepGraph, trimmed: TrimmedFaces, faces: IntArray, prisms: Iterable[Prism]) -> Iterator[int]:
    """Yield the sides of regular hexagons no higher than wide, and the shanks in their middle.

    A hollow one is a socket, a long one a bar. One with a bore is a nut without its bolt: such a nut was welded on.
    """
    round_ = faces[graph.face_kind[faces] == SurfaceKind.CYLINDER]
    for one in prisms:
        q = one.contour.corners
        step = np.linalg.norm(np.roll(q, -1, axis=0) - q, axis=1)
        off = np.linalg.norm(q - q.mean(axis=0), axis=1)
        is_regular = len(q) == HEXAGON and np.ptp(step) + np.ptp(off) <= HEXAGON_SHARE * step.max()
        flats_mm = np.sqrt(3.0) * step.max()
        if not is_regular or flats_mm > MOST_FLATS_MM or one.contour.is_bore:
            continue
        u = square_to(one.way)
        on = round_[_share_axis(graph, round_, q.mean(axis=0) @ np.stack([u, np.cross(one.way, u)]), one.way)]
        share = graph.face_param[on, 0] / flats_mm
        is_shank, is_bore = (share >= SHANK_SHARE[0]) & (share <= SHANK_SHARE[1]), graph.face_outward[on] < 0
        pin = share[is_shank & ~is_bore].max(initial=0.0)
        if not (is_bore & (share < (0.5 if pin == 0.0 else pin))).any():  # a bore inside its flats, or inside its shank
            yield from (face for face in one.faces if np.ptp(trimmed.heights(face, one.way)) <= flats_mm)
            yield from on[is_shank].tolist()


def _headed_pins(graph: BrepGraph, trimmed: TrimmedFaces, faces: IntArray) -> Iterator[int]:
    """Yield the faces of thin solid pins with a wider, low head on the other side of a plate."""
    turned = faces[np.isin(graph.face_kind[faces], ROUND_KINDS)]
    is_pin = (graph.face_kind[turned] == SurfaceKind.CYLINDER) & (graph.face_outward[turned] > 0)
    for pin in turned[is_pin & (graph.face_param[turned, 0] <= LARGEST_SCREW_MM)].tolist():
        o, z, radius = graph.face_frame[pin, 0], graph.face_frame[pin, 3], graph.face_param[pin, 0]
        on = turned[_share_axis(graph, turned, o, z)]
        spans = np.array([_span(trimmed, face, o, z) for face in on.tolist()])
        own = spans[:, 2] <= MOST_HEAD_RATIO * radius  # and not the outline of a round plate
        on, (low, high, widest) = on[own], spans[own].T
        start, end, _ = _span(trimmed, pin, o, z)
        if (graph.face_outward[on] < 0).any():  # hollow
            continue
        for side, apart in ((low >= end, low - end), (high <= start, start - high)):
            is_head = side.any() and SEAT_MM < apart[side].min() <= MOST_PLATE * radius
            is_head = is_head and HEAD_RATIO * radius <= widest[side].max()
            if is_head and high[side].max() - low[side].min() <= MOST_HEAD * radius:
                yield from (pin, *on[side].tolist())


def _lies_on(graph: BrepGraph, trimmed: TrimmedFaces, fasteners: dict[int, _Turned]) -> dict[int, frozenset[int]]:
    """Return for each fastener the other solids that have a face in the plane of one of its flat faces, near its axis.

    The planes are felt at four points around the axis, half way from the shank or the bore to the outside.
    """
    points, owners = [], []
    for solid, shape in fasteners.items():
        faces = np.flatnonzero((graph.face_solid == solid) & (graph.face_kind == SurfaceKind.PLANE))
        flat = faces[np.abs(graph.face_frame[faces, 3] @ shape.z) > 1 - COAXIAL_SIN]
        heights = np.unique(np.round((graph.face_frame[flat, 0] - shape.o) @ shape.z, 3))
        x = graph.face_frame[flat[0], 1] if len(flat) else shape.o
        y = np.cross(shape.z, x)
        off = (max(shape.shank if shape.bore == 0 else shape.bore, 0.0) + shape.widest) / 2
        for height in heights.tolist():
            middle = shape.o + height * shape.z
            points += [middle + off * arm for arm in (x, y, -x, -y)]
            owners += [solid] * 4
    on: dict[int, set[int]] = {solid: set() for solid in fasteners}
    if points:
        p, owner = np.array(points), np.array(owners)
        row, face = trimmed.box_tree.meeting(p - SEAT_MM, p + SEAT_MM)
        z = np.array([fasteners[solid].z for solid in owners])
        is_flat = (graph.face_kind[face] == SurfaceKind.PLANE) & (graph.face_solid[face] != owner[row])
        is_flat &= np.abs(np.einsum("ki,ki->k", graph.face_frame[face, 3], z[row])) > 1 - COAXIAL_SIN
        row, face = row[is_flat], face[is_flat]
        foot = project_to_faces(graph, face, p[row])
        near = np.linalg.norm(foot.p - p[row], axis=1) <= SEAT_MM
        row, face = row[near], face[near]
        inside = trimmed.contains(face, foot.uv[near])
        for solid, other in zip(owner[row[inside]].tolist(), graph.face_solid[face[inside]].tolist(), strict=True):
            on[solid].add(other)
    return {solid: frozenset(others) for solid, others in on.items()}


def _turned(graph: BrepGraph, trimmed: TrimmedFaces, faces: IntArray) -> _Turned | None:
    """Return the shape of a solid if it is a solid of revolution, except for flats along or across its axis."""
    kinds = graph.face_kind[faces]
    round_ = kinds == SurfaceKind.CYLINDER
    if not round_.any() or np.isin(kinds, (SurfaceKind.NURBS, SurfaceKind.NONE)).any():
        return None
    o, z = graph.face_frame[faces[round_][0], 0], graph.face_frame[faces[round_][0], 3]
    flat = kinds == SurfaceKind.PLANE
    leaning = np.abs(graph.face_frame[faces[flat], 3] @ z)
    if ((leaning > COAXIAL_SIN) & (leaning < 1 - COAXIAL_SIN)).any():
        return None
    if not _share_axis(graph, faces[~flat & (kinds != SurfaceKind.SPHERE)], o, z).all():
        return None
    span = {int(face): _span(trimmed, int(face), o, z) for face in faces}
    ends = np.array([s[:2] for s in span.values()])
    low, high = float(ends[:, 0].min()), float(ends[:, 1].max())
    outer = faces[round_ & (graph.face_outward[faces] > 0)].tolist()
    inner = faces[round_ & (graph.face_outward[faces] < 0)].tolist()
    longest = max(outer, key=lambda face: span[face][1] - span[face][0], default=-1)
    shank = float(graph.face_param[longest, 0]) if outer else 0.0
    shaft = span[longest][1] - span[longest][0] if outer else 0.0
    bores = [float(graph.face_param[face, 0]) for face in inner if span[face][1] - span[face][0] > 0.5 * (high - low)]
    widest = max(s[2] for s in span.values())
    return _Turned(o, z, shank, min(bores, default=0.0), widest, low, high, high - low - shaft)


def _share_axis(graph: BrepGraph, faces: IntArray, o: FloatArray, z: FloatArray) -> BoolArray:
    off = off_axis(graph.face_frame[faces, 0], o, z)
    turn = np.linalg.norm(np.cross(graph.face_frame[faces, 3], z), axis=1)
    return np.asarray((off <= COAXIAL_MM) & (turn <= COAXIAL_SIN), dtype=bool)


def _span(trimmed: TrimmedFaces, face: int, o: FloatArray, z: FloatArray) -> tuple[float, float, float]:
    """Return where along an axis the boundary of a face begins and ends, and its largest distance from the axis, mm."""
    arm = trimmed.p0[trimmed.start[face] : trimmed.start[face + 1]] - o
    if len(arm) == 0:
        return 0.0, 0.0, 0.0
    along = arm @ z
    off = np.linalg.norm(arm - along[:, None] * z, axis=1)
    return float(along.min()), float(along.max()), float(off.max())


def _is_ring(shape: _Turned) -> bool:
    bore = 2.0 * shape.bore
    return 0 < shape.bore <= LARGEST_RADIUS_MM * BORE_RATIO[1] and (
        shape.high - shape.low <= RING_HEIGHT * bore and shape.widest <= RING_WIDTH * bore
    )


def _gone_through(graph: BrepGraph, trimmed: TrimmedFaces, holes: IntArray, solid: int, pin: _Turned) -> frozenset[int]:
    """Return the solids with a hole for a pin."""
    ratio = graph.face_param[holes, 0] / pin.shank
    fits = (graph.face_solid[holes] != solid) & (ratio >= BORE_RATIO[0]) & (ratio <= BORE_RATIO[1])
    fits[fits] = _share_axis(graph, holes[fits], pin.o, pin.z)
    found = set()
    for face in holes[fits].tolist():
        low, high, _ = _span(trimmed, face, pin.o, pin.z)
        if low < pin.high and high > pin.low:
            found.add(int(graph.face_solid[face]))
    return frozenset(found)
