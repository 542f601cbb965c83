"""Bolts, screws, nuts, washers and tie rods: solids that hold others together without a weld.

They are recognised by shape and seat, so that a file without names works as well. A *pin* is a solid of revolution
without a bore (flats along its axis may be a hexagon, flats across it are end faces). A *ring* is a short one with a
through bore. A pin that goes through other solids is a fastener if it has a head or carries a ring. A ring is a
fastener if such a pin goes through it and through something else. So a plain pin, a shaft and a collar on a tube are
not.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

LARGEST_RADIUS_MM = 20.0
"""Bolts of steelwork go up to M36; a thicker round bar in a hole is a member."""
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
NAMES = frozenset(
    ("bolt", "screw", "nut", "washer", "rivet", "fastener", "schraube", "mutter", "unterlegscheibe", "niet")
)
"""Words in names of fasteners, in English and German."""


@dataclass(frozen=True, slots=True)
class Fastener:
    """One fastener.

    Parameters
    ----------
    what : str
        For people: ``a bolt or screw``, ``a nut or washer``, ``a rod with nuts``.
    through : frozenset of int
        The solids that it goes through; for a ring, those of its pin.
    """

    what: str
    through: frozenset[int]


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
    """Find the solids that are fasteners, by shape and seat.

    Parameters
    ----------
    graph : BrepGraph
    trimmed : TrimmedFaces
        Of the same graph.

    Returns
    -------
    dict
        The fasteners, by number of the solid.
    """
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
    return _fasteners(turned, rings, through)


def _fasteners(turned: dict[int, _Turned], rings: set[int], through: dict[int, frozenset[int]]) -> dict[int, Fastener]:
    found = {}
    for pin, solids in through.items():
        headed = _has_head(turned[pin])
        if not solids or not (headed or (solids & rings and len(solids) > 1)):
            continue
        found[pin] = Fastener("a bolt or screw" if headed else "a rod with nuts", solids)
        for ring in solids & rings:
            found[ring] = Fastener("a nut or washer", (solids | {pin}) - {ring})
    return found


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
    arm = graph.face_frame[faces, 0] - o
    off = np.linalg.norm(arm - (arm @ z)[:, None] * z, axis=1)
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


def _has_head(shape: _Turned) -> bool:
    return shape.widest >= HEAD_RATIO * shape.shank and 0 < shape.head <= 2.0 * HEAD_HEIGHT * shape.shank


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


def is_named_fastener(name: str) -> bool:
    """Tell whether the name of a solid contains a word for a fastener (``Hex Nut M10``, ``bolt_3``) as a whole word."""
    return any(word.rstrip("s") in NAMES for word in re.split(r"[^a-z]+", name.lower()))
