"""What neck and body of a torch meet: a neck bends to one side, and the torch may be turned about the wire (spin).

Each straight piece of neck and body is felt by lines on its surface and on its axis, by spokes at its begin, and by the
edges that are inside.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wpcal.brep.boxes import are_met
from wpcal.brep.graph import BrepGraph
from wpcal.brep.near_groups import NearBundles
from wpcal.brep.surfaces import part_across
from wpcal.brep.trim import TrimmedFaces
from wpcal.brep.tubes import Radius, edge_distances, tube_frames
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.robot.torch.shape import Tube
from wpcal.seam.judge.material import Necks, place_tube

FEWEST, APART_MM = 16, 9.0  #: Lines on the surface of a piece, and how far apart they are at most.
ROUND_OFF_MM = 1e-6  #: Pieces of edges are compared with this much wider tubes before they are measured.
ROUND_MM = 0.5
"""The lines are this much wider than the piece: a round part of radius r reaches in between two of them by a² / 8r."""


def bend_directions(back: FloatArray, R: FloatArray, spin_rad: FloatArray) -> FloatArray:
    """Return the directions towards which the neck bends, shape (n, 3). Unit vectors in `part`, normal to `back`.

    `back`: shape (n, 3). Unit directions in `part` from the tip of the wire along it.
    `R`: shape (n, 3, 3). Frames of the seam in `part`.
    `spin_rad`: shape (n,). Turn about `back`, right-handed. At 0 the neck bends against the travel.
    """
    behind = -R[:, :, 0]
    u = part_across(behind, back)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    turned = np.cos(spin_rad)[:, None] * u + np.sin(spin_rad)[:, None] * np.cross(back, u)
    return np.asarray(turned, dtype=np.float64)


def spin_of_bend(back: FloatArray, R: FloatArray, bend: FloatArray) -> FloatArray:
    """Return the spin at which necks bend in directions, shape (n,), rad; arguments and result of `bend_directions`."""
    axes = torch_axes(back, bend_directions(back, R, np.zeros(len(back))))
    across, beside = np.einsum("nij,ni->jn", axes[:, :, :2], bend)
    return np.asarray(np.arctan2(beside, across), dtype=np.float64)


def torch_axes(back: FloatArray, bend: FloatArray) -> FloatArray:
    """Return the axes of the torch's own frame (`Tube`) in `part`, shape (n, 3, 3)."""
    return np.stack([bend, np.cross(back, bend), back], axis=2)


def neck_faces(graph: BrepGraph, trimmed: TrimmedFaces, owner: IntArray, necks: Necks, *, wider_mm: float) -> IntArray:
    """Return a face that neck or body meets at each of n poses in `part`, or -1, shape (n,).

    `owner`: shape (n,). Ascending: neighbours of one owner are searched together.
    """
    found = np.full(len(owner), -1)
    frames = torch_axes(necks.back, necks.bend)
    for tube, torches, mouths in necks.steps():
        rows = np.flatnonzero(found[torches] < 0)
        own, mouth = torches[rows], mouths[rows]
        start, along, end = place_tube(tube, mouth, necks.back[own], necks.bend[own])
        begin, until = start[:, None], (start + end * along)[:, None]
        widest_mm = (tube.radius_mm + wider_mm + ROUND_MM) / math.cos(math.pi / FEWEST)
        near = NearBundles.around(trimmed, owner[own], begin, until, within_mm=widest_mm)
        kept = np.flatnonzero(near.near.counts[near.group])
        if len(kept) == 0:  # most of a neck is in the open
            continue
        own, near = own[kept], near.select(kept)
        origins, rays, lengths = _lines(tube, wider_mm)
        at = np.einsum("nij,kj->nki", frames[own], origins) + mouth[kept, None]
        way = np.einsum("nij,kj->nki", frames[own], rays)
        faces = near.first_faces(trimmed, at, way, np.broadcast_to(lengths, way.shape[:2]))
        left = np.flatnonzero(faces < 0)
        axis, far = (start[kept[left]], along[kept[left]]), np.full(len(left), end + wider_mm)
        faces[left] = edges_in_tubes(
            trimmed, near.select(left), axis, (np.full(len(left), -wider_mm), far), tube.radius_mm + wider_mm
        )
        found[own[faces >= 0]] = faces[faces >= 0]  # the nearest step of each is written last
    return found


def edges_in_tubes(
    trimmed: TrimmedFaces,
    bundles: NearBundles,
    axis: Sequence[FloatArray],
    ends_mm: tuple[FloatArray, FloatArray],
    radius_mm: Radius,
) -> IntArray:
    """Return a face with an edge inside each of n tubes or cones, or -1: corners that reach in between two lines.

    `bundles`: The faces near the tubes.
    `axis`: shapes (n, 3). Places and unit directions in `part`; a tube leads from one to the other of `ends_mm`.
    """
    (p, way), (low, high), graph = axis, ends_mm, trimmed.graph
    first, last = radius_mm if isinstance(radius_mm, tuple) else (radius_mm, radius_mm)
    begin, end = (p + at[:, None] * way for at in (low, high))
    row, box = bundles.near.pairs(bundles.group)
    least, most = (pick(begin, end) + side * max(first, last) for pick, side in ((np.minimum, -1), (np.maximum, 1)))
    boxes = trimmed.patch_boxes
    own = np.flatnonzero(are_met(boxes.low[box].T, boxes.high[box].T, least[row].T, most[row].T))
    row, face = np.divmod(np.unique(row[own] * graph.face_count + boxes.face[box[own]]), graph.face_count)
    own, piece = trimmed.pieces_meeting(face, least[row], most[row])
    frames, at = tube_frames(way), row[own]
    arm, reach = trimmed.p0[piece] - p[at], max(first, last) + trimmed.piece_mm[piece] + ROUND_OFF_MM
    along = np.einsum("ki,ki->k", arm, way[at])
    near = np.flatnonzero(np.einsum("ki,ki->k", arm, arm) <= along**2 + reach**2)  # the others are beside the tube
    own, piece, at = own[near], piece[near], at[near]
    p0, p1 = (np.einsum("kij,kj->ki", frames[at], corner[piece] - p[at]) for corner in (trimmed.p0, trimmed.p1))
    slope = None if first == last else (last - first) / (high - low)[at]
    is_met = edge_distances((p0[:, :2], p1[:, :2]), (p0[:, 2], p1[:, 2]), low[at], high[at], slope) < first
    found = np.full(len(p), -1)
    found[at[is_met]] = face[own[is_met]]
    return found


def _lines(tube: Tube, wider_mm: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return starts (k, 3), directions (k, 3) and lengths (k,) of the lines of a piece, the axis first."""
    way = tube.end - tube.start
    length = float(np.linalg.norm(way))
    way = way / length
    side = np.array([0.0, 1.0, 0.0])  # normal to every piece: the neck bends in the plane of x and z
    count = max(FEWEST, 2 * math.ceil(math.pi * tube.radius_mm / APART_MM))
    turn = np.arange(count) * 2.0 * np.pi / count
    unit = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * np.cross(way, side)
    radius = (tube.radius_mm + wider_mm + ROUND_MM) / np.cos(np.pi / count)
    along = np.concatenate([np.zeros((1, 3)), radius * unit, radius / 2.0 * unit[::2]])
    spokes = np.broadcast_to(tube.start, (count, 3))
    origins = np.concatenate([tube.start + along, spokes])
    rays = np.concatenate([np.broadcast_to(way, along.shape), unit])
    return origins, rays, np.concatenate([np.full(len(along), length), np.full(count, radius)])
