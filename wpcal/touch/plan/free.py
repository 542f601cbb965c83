"""Which touches the torch can make: their strokes, what the wire meets first, and the room of the torch.

The wire is followed along exact faces. The nozzle, the neck and the body of the torch are compared with the part and
with every body of the cell, farther away than the part may be displaced.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.hits import find_hits
from wpcal.brep.material import Material
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.robot.torch.shape import TorchShape
from wpcal.touch.plan.contacts import BORDER_MM, TouchPlaces, surface_labels
from wpcal.touch.plan.options import TouchOptions

MARGIN_MM = 3.0
"""A search begins and ends this much beyond the displacement of the part: what the uncertainty did not foresee."""
LEAST_GAP_MM = 0.5
"""Least room between the wire and a displaced part at the start, and before the next body behind the face."""
GUARD_MM = 1.0  #: Other faces must be this much farther than the touched one: a turned part changes which is first.
FLOOR_MM = 1.0  #: The tip stays this much above the lowest level of the displaced part: the part stands on something.
APPROACH_MM = 30.0  #: From the start back along the wire to where the robot comes through the air.
RISE_STEP_MM = 12.0
"""On its way up the torch is compared with the part at this distance, and its wire is felt as thick as this."""
SAFE_MM = 20.0  #: The tip crosses the part this much above its displaced top.
SPINS = 8  #: Turns of a bent neck about the wire that are tried.
BIN_MM = 2.0  #: Displacements are rounded up to this, so that many poses are compared at once.


@dataclass(frozen=True, slots=True, eq=False)
class Strokes(Columns):
    """n contacts with their searches."""

    contacts: TouchPlaces
    radius_mm: FloatArray  #: shape (n,). Distance of the tool centre point from the face at contact.
    #: `before_mm`, `after_mm`: shape (n,). Length of the search before and behind the planned contact.
    before_mm: FloatArray
    after_mm: FloatArray
    bend: FloatArray  #: shape (n, 3). Towards which the neck bends: x of the tool, in `part`.

    def __len__(self) -> int:
        return len(self.contacts)

    def at(self, mm: FloatArray | float) -> FloatArray:
        """Return places of the tool centre point on the way of the search, shape (n, 3).

        `mm`: shape (n,). Distance before the contact; negative behind it.
        """
        off = np.broadcast_to(self.radius_mm + mm, (len(self),))
        return np.asarray(self.contacts.p + off[:, None] * self.contacts.normal)

    @property
    def approach(self) -> FloatArray:
        """Where the tool centre point comes through the air, shape (n, 3)."""
        return np.asarray(self.at(self.before_mm) - APPROACH_MM * self.contacts.wire)


def tool_axes(strokes: Strokes) -> FloatArray:
    """Return the axes of the tool as columns in `part`, shape (n, 3, 3): x to the neck's side, z along the wire."""
    x, z = strokes.bend, strokes.contacts.wire
    return np.stack([x, np.cross(z, x), z], axis=2)


def find_strokes(graph: BrepGraph, trimmed: TrimmedFaces, contacts: TouchPlaces, options: TouchOptions) -> Strokes:
    """Find start and end of the search of each contact; those that are not possible are left out."""
    wire_radius = options.wire_mm / 2.0
    sin = np.sqrt(np.maximum(1.0 - contacts.cos_angle**2, 0.0))
    radius = wire_radius * sin
    tip = contacts.p + radius[:, None] * contacts.normal
    most = 2.0 * contacts.normal_mm + MARGIN_MM + options.wire_mm + LEAST_GAP_MM
    lift = 1e-3  # the ray begins outside the face itself
    out = find_hits(trimmed, contacts.p + lift * contacts.normal, contacts.normal, length_mm=most)
    behind_start = np.full(len(contacts), np.inf)
    np.minimum.at(behind_start, out.ray, out.at_mm)
    room = behind_start - radius - wire_radius - contacts.normal_mm - LEAST_GAP_MM
    before = np.minimum(contacts.normal_mm + MARGIN_MM, room)
    after = np.minimum(contacts.normal_mm + MARGIN_MM, _next_body_mm(graph, trimmed, contacts, most) - LEAST_GAP_MM)
    bend = np.cross(contacts.wire, np.eye(3)[np.argmin(np.abs(contacts.wire), axis=1)])
    strokes = Strokes(contacts, radius, before, after, bend / np.linalg.norm(bend, axis=1, keepdims=True))
    possible = (before >= contacts.normal_mm + LEAST_GAP_MM) & (after >= contacts.normal_mm) & np.isfinite(tip).all(1)
    strokes = strokes.select(possible)
    return strokes.select(_meets_its_face_first(graph, trimmed, strokes, options))


def _next_body_mm(graph: BrepGraph, trimmed: TrimmedFaces, contacts: TouchPlaces, length_mm: FloatArray) -> FloatArray:
    """Return how far behind the face the next body begins, along the search; infinite beyond `length_mm`."""
    skin = 1e-3
    hits = find_hits(trimmed, contacts.p - skin * contacts.normal, -contacts.normal, length_mm=length_mm)
    other = (hits.way < 0) | (graph.face_solid[hits.face] != graph.face_solid[contacts.face[hits.ray]])
    found = np.full(len(contacts), np.inf)
    np.minimum.at(found, hits.ray[other], hits.at_mm[other])
    return found


def _meets_its_face_first(
    graph: BrepGraph, trimmed: TrimmedFaces, strokes: Strokes, options: TouchOptions
) -> BoolArray:
    """Tell which searches meet their own face, and nothing else of the part before it, also beside the plan."""
    contacts, labels = strokes.contacts, surface_labels(graph)
    length = options.torch.wire_mm - GUARD_MM
    along, across = contacts.ways
    flat = graph.face_kind[contacts.face] == SurfaceKind.PLANE
    good = np.ones(len(strokes), dtype=bool)
    reach = strokes.before_mm + strokes.radius_mm + GUARD_MM + contacts.apart_mm
    start = strokes.at(strokes.before_mm)
    for share in (0.0, 1 / 3, 2 / 3, 1.0):
        for side in (-1.0, 0.0, 1.0):
            aside = np.where(flat, side * contacts.across_mm, 0.0)[:, None] * across
            origins = start - share * length * contacts.wire + aside
            hits = find_hits(trimmed, origins, -contacts.normal, length_mm=reach)
            good[hits.ray[labels[hits.face] != labels[contacts.face[hits.ray]]]] = False
    beside = _is_hit_beside(graph, trimmed, strokes, labels, along, across)
    return np.asarray(good & (flat | beside), dtype=bool)


def _is_hit_beside(
    graph: BrepGraph, trimmed: TrimmedFaces, strokes: Strokes, labels: IntArray, along: FloatArray, across: FloatArray
) -> BoolArray:
    """Tell which searches meet their own round face first where the part is displaced to any side."""
    contacts = strokes.contacts
    hollow = graph.face_outward[contacts.face] < 0
    room = np.where(hollow, 0.0, BORDER_MM)  # a hole is hit from within as long as the wire is in it
    start, length = strokes.at(strokes.before_mm), strokes.before_mm + strokes.radius_mm + strokes.after_mm
    good = np.ones(len(strokes), dtype=bool)
    offsets = [side * (contacts.across_mm + room)[:, None] * across for side in (-1.0, 1.0)]
    offsets.append(-(contacts.along_mm + BORDER_MM)[:, None] * along)
    offsets.append(np.where(contacts.is_side, 0.0, contacts.along_mm + BORDER_MM)[:, None] * along)
    for offset in offsets:
        hits = find_hits(trimmed, start + offset, -contacts.normal, length_mm=length)
        first = np.full(len(strokes), -1)
        first[hits.ray[::-1]] = hits.face[::-1]  # sorted by distance: the nearest is written last
        good &= (first >= 0) & (labels[first] == labels[contacts.face])
    return good


def keeps_above_floor(strokes: Strokes, up: FloatArray, floor_mm: float, rise_mm: FloatArray) -> BoolArray:
    """Tell which searches stay above the lowest level of the part.

    `up`: shape (3,). Against gravity, in `part`.
    `rise_mm`: shape (n,). By how much the part may be displaced along `up` there.
    """
    level = np.minimum(strokes.at(strokes.before_mm) @ up, strokes.at(0.0) @ up)
    return np.asarray(level >= floor_mm + np.minimum(rise_mm, MARGIN_MM) + FLOOR_MM)


def with_free_torch(
    materials: Sequence[Material], strokes: Strokes, torch: TorchShape, wire_mm: float, up: FloatArray, safe_mm: float
) -> Strokes:
    """Turn the neck so that the torch is free from the safe level to the end of the search; leave the others out.

    `up`: shape (3,). Against gravity, in `part`.
    """
    away, other = strokes.bend, np.cross(strokes.contacts.wire, strokes.bend)
    bend, free = strokes.bend.copy(), np.zeros(len(strokes), dtype=bool)
    for spin in range(SPINS if torch.bends else 1):
        angle = 2.0 * math.pi * spin / SPINS
        tried = np.flatnonzero(~free)
        turned = math.cos(angle) * away[tried] + math.sin(angle) * other[tried]
        some = strokes.select(tried)
        own = Strokes(some.contacts, some.radius_mm, some.before_mm, some.after_mm, turned)
        works = np.flatnonzero(_is_free(materials, own, torch, wire_mm, up, safe_mm))
        free[tried[works]], bend[tried[works]] = True, turned[works]
    rows = np.flatnonzero(free)
    some = strokes.select(rows)
    return Strokes(some.contacts, some.radius_mm, some.before_mm, some.after_mm, bend[rows])


def _is_free(
    materials: Sequence[Material], strokes: Strokes, torch: TorchShape, wire_mm: float, up: FloatArray, safe_mm: float
) -> BoolArray:
    contacts, axes = strokes.contacts, tool_axes(strokes)
    free = np.ones(len(strokes), dtype=bool)
    approach = strokes.approach
    steps = [
        (strokes.at(strokes.before_mm), wire_mm),
        (strokes.at(0.0), None),
        (strokes.at(-strokes.after_mm), None),
        (strokes.at(strokes.before_mm) - APPROACH_MM / 2 * contacts.wire, wire_mm),
        (approach, wire_mm),
    ]
    most = max(0, math.ceil(float(np.max(safe_mm - approach @ up, initial=0.0)) / RISE_STEP_MM))
    for step in range(1, most + 1):
        height = np.minimum(step * RISE_STEP_MM, np.maximum(safe_mm - approach @ up, 0.0))
        steps.append((approach + height[:, None] * up, RISE_STEP_MM))
    for tips, felt_mm in steps:
        rows = np.flatnonzero(free)
        if len(rows) == 0:
            break
        clear = contacts.normal_mm[rows] + LEAST_GAP_MM
        free[rows] = torch_keeps_away(materials, torch, tips[rows], axes[rows], clear, wire_mm=felt_mm)
    return free


def torch_keeps_away(
    materials: Sequence[Material],
    torch: TorchShape,
    tips: FloatArray,
    axes: FloatArray,
    clear_mm: FloatArray,
    *,
    wire_mm: float | None,
) -> BoolArray:
    """Tell at which poses the torch keeps away from everything, shape (n,).

    `tips`: shape (n, 3). In `part`, mm.
    `axes`: shape (n, 3, 3). Of the tool in `part`, as columns.
    `clear_mm`: shape (n,). Least distance of nozzle, neck and body.
    """
    free = np.ones(len(tips), dtype=bool)
    frames = axes * [1.0, -1.0, -1.0]  # z from the tip to the body
    back = frames[:, :, 2]
    mouth = tips + torch.wire_mm * back
    zero = np.zeros(len(tips))
    if wire_mm is not None:
        for material in materials:
            found = material.tube_solids(tips, back, zero, zero + torch.wire_mm, wire_mm / 2.0 + LEAST_GAP_MM)
            free &= found < 0
    tubes = [(np.zeros(3), np.array([0.0, 0.0, torch.front_mm]), torch.nozzle_radius_mm)]
    tubes += [(tube.start, tube.end, tube.radius_mm) for tube in torch.tubes]
    bins = np.ceil(clear_mm / BIN_MM) * BIN_MM
    for wider in np.unique(bins):
        for start, end, radius in tubes:
            rows = np.flatnonzero(free & (bins == wider))
            length = float(np.linalg.norm(end - start))
            way = np.einsum("nij,j->ni", frames[rows], (end - start) / length)
            at = mouth[rows] + np.einsum("nij,j->ni", frames[rows], start)
            for material in materials:
                met = material.tube_solids(at, way, zero[rows], zero[rows] + length, radius + float(wider))
                free[rows] &= met < 0
    return free
