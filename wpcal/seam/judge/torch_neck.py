"""What neck and body of a torch meet: a neck bends to one side, and the torch may be turned about the wire (spin).

Each straight piece of neck and body is felt by lines on its surface and on its axis, and by spokes at its begin.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.near_groups import find_near_faces, first_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.robot.torch.shape import TorchShape, Tube

AROUND = 16  #: Lines on the surface of a piece: 8 mm apart on a body of 44 mm.
APPROACH_STEPS = 2
"""Where the torch comes and goes, neck and body are felt at so many places on their way back along the wire."""


def bend_directions(back: FloatArray, R: FloatArray, spin_rad: FloatArray) -> FloatArray:
    """Return the directions towards which the neck bends, shape (n, 3). Unit vectors in `part`, normal to `back`.

    `back`: shape (n, 3). Unit directions in `part` from the tip of the wire along it.
    `R`: shape (n, 3, 3). Frames of the seam in `part`.
    `spin_rad`: shape (n,). Turn about `back`, right-handed. At 0 the neck bends against the travel.
    """
    behind = -R[:, :, 0]
    u = behind - np.einsum("ni,ni->n", behind, back)[:, None] * back
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    turned = np.cos(spin_rad)[:, None] * u + np.sin(spin_rad)[:, None] * np.cross(back, u)
    return np.asarray(turned, dtype=np.float64)


def neck_faces(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    torch: TorchShape,
    owner: IntArray,
    mouth: FloatArray,
    back: FloatArray,
    bend: FloatArray,
    more_mm: FloatArray,
    *,
    wider_mm: float,
) -> IntArray:
    """Return a face that neck or body meets at each pose, or -1, shape (n,).

    `owner`: shape (n,). Ascending: neighbours of one owner are searched together.
    `mouth`: shape (n, 3). Middles of the mouths of the nozzles in `part`, mm.
    `back`, `bend`: shape (n, 3). Unit directions in `part`: along the wire to the torch, and towards which the neck
    bends.
    `more_mm`: shape (n,). How far the torch goes back along the wire.
    """
    found = np.full(len(mouth), -1)
    frames = np.stack([bend, np.cross(back, bend), back], axis=2)
    for step in range(APPROACH_STEPS + 1):
        far = step / APPROACH_STEPS * more_mm
        for tube in torch.tubes:
            rows = np.flatnonzero((found < 0) & ((step == 0) | (more_mm > 0)))
            if len(rows) == 0:
                continue
            origins, rays, lengths = _lines(tube, wider_mm)
            at = np.einsum("nij,kj->nki", frames[rows], origins)
            at += (mouth[rows] + far[rows, None] * back[rows])[:, None]
            way = np.einsum("nij,kj->nki", frames[rows], rays)
            length = np.broadcast_to(lengths, way.shape[:2])
            found[rows] = first_faces(graph, trimmed, owner[rows], at, way, length)
    return found


def _lines(tube: Tube, wider_mm: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return starts (k, 3), directions (k, 3) and lengths (k,) of the lines of a piece, the axis first."""
    way = tube.end - tube.start
    length = float(np.linalg.norm(way))
    way = way / length
    side = np.array([0.0, 1.0, 0.0])  # normal to every piece: the neck bends in the plane of x and z
    turn = np.arange(AROUND) * 2.0 * np.pi / AROUND
    unit = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * np.cross(way, side)
    radius = (tube.radius_mm + wider_mm) / np.cos(np.pi / AROUND)
    along = np.concatenate([np.zeros((1, 3)), radius * unit, radius / 2.0 * unit[::2]])
    spokes = np.broadcast_to(tube.start, (AROUND, 3))
    origins = np.concatenate([tube.start + along, spokes])
    rays = np.concatenate([np.broadcast_to(way, along.shape), unit])
    return origins, rays, np.concatenate([np.full(len(along), length), np.full(AROUND, radius)])


def are_necks_clear(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    torch: TorchShape,
    mouth: FloatArray,
    back: FloatArray,
    bend: FloatArray,
    begin: IntArray,
    *,
    within_mm: float,
) -> BoolArray:
    """Tell which groups of poses have no face near neck and body; no line is sent, shape (g,).

    `mouth`, `back`, `bend`: shape (n, 3). As in `neck_faces`, sorted by group.
    `begin`: shape (g,). The first pose of each group.
    """
    clear = np.ones(len(begin), dtype=bool)
    frames = np.stack([bend, np.cross(back, bend), back], axis=2)
    for tube in torch.tubes:
        p0, p1 = (mouth + np.einsum("nij,j->ni", frames, at) for at in (tube.start, tube.end))
        near = find_near_faces(graph, trimmed, p0, p1, begin, within_mm=tube.radius_mm + within_mm)
        clear &= near.counts == 0
    return clear
