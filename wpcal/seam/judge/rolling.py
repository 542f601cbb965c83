"""Round bodies that roll or lie loose: rollers of a bearing, bars in a rack, a wheel on its shaft.

They touch others along lines, as a round bar does that is welded along a plate. Three or more equal ones are taken for
rollers or stock if they touch each other, or touch other solids on opposite sides, and their flat ends touch nothing. A
round body with a bore is taken for a wheel if a shaft goes through it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import off_axis
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.find.built_up import is_turned
from wpcal.seam.find.flare import TILT_SIN
from wpcal.seam.find.flare_sections import face_pairs, find_groove_roots, pipe_ranges

EQUAL = 3  #: Fewer equal bodies are members: a handrail has two bars.
SAME_AXIS_MM, SAME_AXIS_SIN = 0.2, 2e-3  #: Axes nearer and more parallel than this are one.
OPPOSITE_COS = -0.87  #: A body is held between two others if they touch it on opposite sides, within 30 degrees.
SHAFT_RATIO = 0.75  #: A shaft fills at least this share of a bore.
BULGE_MM = 0.5  #: The tread of a wheel bulges by more than this beyond its sides: the round of an edge does not.
LENGTH_MM = 0.1  #: Bodies whose radius, and whose length, differ by less are equal.


def find_rolling(graph: BrepGraph, trimmed: TrimmedFaces, gap_mm: float) -> dict[int, str]:
    """Find the solids that roll or lie loose. What each of them is taken for, in words, by number of the solid."""
    touches = _line_touches(graph, trimmed, gap_mm)
    round_ = {solid: axis for solid in touches if (axis := _axis(graph, trimmed, solid)) is not None}
    found = {solid: "turns on a shaft" for solid in round_ if _has_shaft(graph, trimmed, solid, round_[solid])}
    for group in _equal(graph, trimmed, round_):
        loose = [solid for solid in group if not _has_end_contact(graph, trimmed, solid, gap_mm)]
        touch_each_other = any(other in group for solid in loose for other, _ in touches[solid])
        held = [solid for solid in loose if _is_between(touches[solid])]
        if len(loose) >= EQUAL and (touch_each_other or len(held) == len(loose)):
            words = f"is one of {len(group)} equal round bodies that touch others along lines only: rollers or stock"
            found |= dict.fromkeys(loose, words)
    return found


def has_round_tread(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> bool:
    """Tell whether a solid is a wheel by its shape: turned, with a bore, flat sides, and a tread that bulges."""
    faces = np.flatnonzero(graph.face_solid == solid)
    kind, out = graph.face_kind[faces], graph.face_outward[faces]
    tread = faces[(kind == SurfaceKind.TORUS) & (out > 0)]
    has_bore = bool(((kind == SurfaceKind.CYLINDER) & (out < 0)).any())
    if len(tread) == 0 or not has_bore or not (kind == SurfaceKind.PLANE).any() or not is_turned(graph, trimmed, solid):
        return False
    o, z = graph.face_frame[tread[0], 0], graph.face_frame[tread[0], 3]
    sides = faces[~np.isin(faces, tread)].tolist()
    rim = np.concatenate([trimmed.p0[trimmed.start[face] : trimmed.start[face + 1]] for face in sides])
    widest = float(off_axis(rim, o, z).max())
    return bool((graph.face_param[tread].sum(axis=1) > widest + BULGE_MM).any())


def _line_touches(graph: BrepGraph, trimmed: TrimmedFaces, gap_mm: float) -> dict[int, list[tuple[int, FloatArray]]]:
    """Return for each solid with a cylinder the solids that it touches along a line, and in which direction."""
    pairs = face_pairs(graph, trimmed, gap_mm)
    pairs = pairs.select((pairs.side > 0) & ~pairs.is_ring(graph))
    low, high = pipe_ranges(graph, trimmed, pairs, gap_mm)
    pairs, middle = pairs.select(high > low), ((low + high) / 2)[high > low]
    roots = find_groove_roots(graph, pairs, middle)
    touches: dict[int, list[tuple[int, FloatArray]]] = defaultdict(list)
    for row in np.flatnonzero((np.abs(roots.gap_mm) <= gap_mm) & (roots.tilt <= TILT_SIN)).tolist():
        pipe, other = int(graph.face_solid[pairs.pipe[row]]), int(graph.face_solid[pairs.other[row]])
        touches[pipe].append((other, roots.m[row]))
        touches[other].append((pipe, -roots.m[row]))
    return dict(touches)


def _axis(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> int | None:
    """Return a cylinder of a solid of revolution, the widest one, or None if the solid is something else."""
    is_outer = (graph.face_solid == solid) & (graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward > 0)
    outer = np.flatnonzero(is_outer & is_turned(graph, trimmed, solid))
    return int(outer[np.argmax(graph.face_param[outer, 0])]) if len(outer) else None


def _span(trimmed: TrimmedFaces, faces: IntArray, cylinder: int) -> tuple[float, float]:
    """Return where along the axis of a cylinder the boundaries of faces begin and end, mm; 0 and 0 without one."""
    z = trimmed.graph.face_frame[cylinder, 3]
    along = np.concatenate([trimmed.heights(face, z) for face in faces.tolist()])
    return (float(along.min()), float(along.max())) if len(along) else (0.0, 0.0)


def _equal(graph: BrepGraph, trimmed: TrimmedFaces, round_: dict[int, int]) -> Iterator[set[int]]:
    """Yield sets of at least `EQUAL` bodies of one radius and length."""
    groups: dict[tuple[int, int], set[int]] = defaultdict(set)
    for solid, cylinder in round_.items():
        low, high = _span(trimmed, np.flatnonzero(graph.face_solid == solid), cylinder)
        size = graph.face_param[cylinder, 0], high - low
        groups[round(size[0] / LENGTH_MM), round(size[1] / LENGTH_MM)].add(solid)
    yield from (group for group in groups.values() if len(group) >= EQUAL)


def _is_between(touches: list[tuple[int, FloatArray]]) -> bool:
    ways = np.array([way for _, way in touches])
    return bool((ways @ ways.T).min() < OPPOSITE_COS)


def _has_end_contact(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, gap_mm: float) -> bool:
    """Tell whether a flat end of a solid touches a flat face of another one."""
    ends = np.flatnonzero((graph.face_solid == solid) & (graph.face_kind == SurfaceKind.PLANE))
    low, high = (corner[ends] for corner in trimmed.face_box)
    row, other = trimmed.box_tree.meeting(low - gap_mm, high + gap_mm)
    end = ends[row]
    n, n_other = (graph.face_frame[face, 3] * graph.face_outward[face][:, None] for face in (end, other))
    apart = np.einsum("ki,ki->k", graph.face_frame[other, 0] - graph.face_frame[end, 0], n)
    met = (graph.face_kind[other] == SurfaceKind.PLANE) & (graph.face_solid[other] != solid)
    met &= (np.einsum("ki,ki->k", n, n_other) < -1 + SAME_AXIS_SIN) & (np.abs(apart) <= gap_mm)
    return bool(met.any())


def _has_shaft(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, cylinder: int) -> bool:
    """Tell whether a cylinder of another solid fills a bore of a solid of revolution."""
    mine = graph.face_solid == solid
    bores = np.flatnonzero(mine & (graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward < 0))
    if len(bores) == 0:
        return False
    bore = float(graph.face_param[bores, 0].min())
    shafts = np.flatnonzero(~mine & (graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward > 0))
    radius = graph.face_param[shafts, 0]
    along = np.linalg.norm(np.cross(graph.face_frame[shafts, 3], graph.face_frame[cylinder, 3]), axis=1)
    fits = (radius >= SHAFT_RATIO * bore) & (radius <= bore + SAME_AXIS_MM) & (along <= SAME_AXIS_SIN)
    shafts = shafts[fits & (off_axis(graph.face_frame[shafts, 0], *graph.face_frame[cylinder, [0, 3]]) <= SAME_AXIS_MM)]
    low, high = _span(trimmed, bores, cylinder)
    spans = [_span(trimmed, np.array([shaft]), cylinder) for shaft in shafts.tolist()]
    return any(a < high and b > low for a, b in spans)
