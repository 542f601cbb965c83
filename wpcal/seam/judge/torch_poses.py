"""What a whole torch meets at poses along seams: its wire, nozzle, neck and body as lines against exact faces.

The lines of wire and nozzle are on circles around the wire. The outermost circle is a little wider than the torch, so
that no plane reaches in between two of them; what ends between two of them has an edge in the nozzle. Lines across its
mouth find a wall along the torch that is longer than the torch. Programs are checked against triangles
(`material.find_poses_in_material`), so wire and nozzle are felt wider by the error of the triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.mesh import usual_deflection_mm
from wpcal.brep.near_groups import NearBundles
from wpcal.brep.surfaces import square_to
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.robot.torch.shape import PRISM, TorchShape
from wpcal.seam.judge.material import NEAR_ROOT_MM, WIRE_RADIUS_MM, Necks
from wpcal.seam.judge.torch_neck import bend_directions, edges_in_tubes, neck_faces

MOST_WIDER_MM = 0.15
"""The wire is felt wider by at most this: otherwise it would meet the plates of a joint of 60 degrees."""
AROUND = 16
"""Lines on the outermost circle: 4 mm apart on a nozzle of 22 mm. There are half as many on the circle inside it."""
CHUNK = 2000  #: Poses handled in one array: some 25 MB.
POCKET_WIDTHS = 4  #: Directions across the wire in which a pocket is measured: every 45 degrees around it.
POCKET_STEP_MM = 2.0
"""Lines at which the width of a pocket is measured are this far apart: a wall around the wire is rarely thinner."""


@dataclass(frozen=True, slots=True, eq=False)
class FeltPoses(Columns):
    """n poses of a torch along seams."""

    torch: TorchShape
    owner: IntArray  #: shape (n,). Number of the seam, ascending.
    p: FloatArray  #: shape (n, 3). Tips of the wire in `part`, mm.
    back: FloatArray  #: shape (n, 3). Unit directions in `part` from the tip along the wire.
    R: FloatArray  #: shape (n, 3, 3). Frames of the seams in `part`.
    start_mm: FloatArray  #: shape (n,). From this distance from the tip on the torch is felt.
    more_mm: FloatArray  #: shape (n,). How far beyond its length the torch is felt: it comes and goes along the wire.
    wire_mm: FloatArray  #: shape (n,). From the tip to the mouth of the nozzle.
    spin_rad: FloatArray  #: shape (n,). How far the neck is turned about the wire (`torch_neck.bend_directions`).

    def __len__(self) -> int:
        return len(self.p)

    @property
    def mouth_mm(self) -> FloatArray:
        """Distance of the nozzle from the tip, mm, shape (n,)."""
        return np.maximum(self.wire_mm, self.start_mm)

    @property
    def end_mm(self) -> FloatArray:
        """Distance from the tip to the end of the nozzle, of a straight torch to its own end, mm, shape (n,)."""
        return np.asarray(self.wire_mm + self.torch.front_mm + self.more_mm, dtype=np.float64)

    @property
    def bend(self) -> FloatArray:
        """Directions towards which the neck bends, shape (n, 3)."""
        return bend_directions(self.back, self.R, self.spin_rad)

    @property
    def necks(self) -> Necks:
        """Neck and body at the poses."""
        return Necks(self.torch, self.p + self.mouth_mm[:, None] * self.back, self.back, self.bend, self.more_mm)


def felt_radii_mm(graph: BrepGraph, torch: TorchShape) -> tuple[float, float]:
    """Return the radii with which wire and nozzle are felt, mm: around the prism that planners measure."""
    wider = usual_deflection_mm(graph.size_mm)
    return WIRE_RADIUS_MM + min(wider, MOST_WIDER_MM), torch.nozzle_radius_mm * PRISM + wider


def find_solids_met(
    graph: BrepGraph, trimmed: TrimmedFaces, poses: FeltPoses, *, is_between: bool = False, is_told: bool = True
) -> IntArray:
    """Return the solid that wire and nozzle meet at each pose, or -1; shape (n,). A straight torch is all nozzle.

    If it need not be told which of several solids is met first, the axis is felt before all else: most are met there.
    """
    found = np.full(len(poses), -1)
    for every in np.split(np.arange(len(poses)), np.arange(CHUNK, len(poses), CHUNK)):
        own, rows = poses.select(every), every
        if not is_told:
            axis, far = (own.p + own.start_mm[:, None] * own.back)[:, None], (own.end_mm - own.start_mm)[:, None]
            near = NearBundles.around(trimmed, own.owner, axis, axis + far[..., None] * own.back[:, None])
            face = near.first_faces(trimmed, axis, own.back[:, None], far)
            found[rows] = np.where(face < 0, -1, graph.face_solid[face])
            own, rows = own.select(face < 0), rows[face < 0]
        found[rows] = _solids_met(graph, trimmed, own, is_between=is_between)
    return found


def _solids_met(graph: BrepGraph, trimmed: TrimmedFaces, poses: FeltPoses, *, is_between: bool) -> IntArray:
    start, mouth = poses.start_mm, poses.mouth_mm
    wire_mm, nozzle_mm = felt_radii_mm(graph, poses.torch)
    around = _circle(poses.back, wire_mm, 4 if is_between else AROUND // 2)
    whole = np.clip(NEAR_ROOT_MM, start, mouth)
    axis = (poses.p + start[:, None] * poses.back)[:, None]
    wire = np.concatenate([axis, (poses.p + whole[:, None] * poses.back)[:, None] + around], axis=1)
    lengths = np.repeat((mouth - whole)[:, None], wire.shape[1], axis=1)
    lengths[:, 0] = mouth - start
    begin, end = (poses.p + at[:, None] * poses.back for at in (mouth, poses.end_mm))
    near = NearBundles.around(trimmed, poses.owner, axis, begin[:, None], within_mm=wire_mm)
    face = near.first_faces(trimmed, wire, np.broadcast_to(poses.back[:, None], wire.shape), lengths)
    rows, rim_mm = np.flatnonzero(face < 0), nozzle_mm / np.cos(np.pi / AROUND)
    left, rim = poses.select(rows), _circle(poses.back[rows], rim_mm, AROUND)
    near = NearBundles.around(trimmed, left.owner, begin[rows, None], end[rows, None], within_mm=rim_mm)
    face[rows] = near.first_faces(trimmed, *_first_lines(left, rim, is_between=is_between))
    if not is_between:  # most of what is in the way is met by the first few lines
        more = np.flatnonzero(face[rows] < 0)
        face[rows[more]] = near.select(more).first_faces(trimmed, *_other_lines(left.select(more), rim[more]))
    near = near.select(face[rows] < 0)
    rows = np.flatnonzero(face < 0)
    own, wider_mm = poses.select(rows), nozzle_mm - poses.torch.nozzle_radius_mm
    first, cone = own.mouth_mm - wider_mm, own.mouth_mm + own.torch.taper_mm
    face[rows] = edges_in_tubes(trimmed, near, (own.p, own.back), (cone - wider_mm, own.end_mm), nozzle_mm)
    if own.torch.taper_mm > 0.0:
        radii = own.torch.mouth_mm + wider_mm, nozzle_mm
        in_cone = edges_in_tubes(trimmed, near, (own.p, own.back), (first, cone), radii)
        face[rows] = np.where(face[rows] < 0, in_cone, face[rows])
    if not is_between:
        rows = np.flatnonzero(face < 0)
        face[rows] = _pocket_faces(graph, trimmed, poses.select(rows))
    return np.where(face < 0, -1, graph.face_solid[face])


def find_solids_beside_neck(graph: BrepGraph, trimmed: TrimmedFaces, poses: FeltPoses) -> IntArray:
    """Return the solid that neck or body of the torch meets at each pose, or -1; shape (n,)."""
    if poses.torch.neck is None:
        return np.full(len(poses), -1)
    wider = usual_deflection_mm(graph.size_mm)
    chunks = (poses.select(slice(first, first + CHUNK)) for first in range(0, len(poses), CHUNK))
    found = [neck_faces(graph, trimmed, own.owner, own.necks, wider_mm=wider) for own in chunks]
    face = np.concatenate([np.zeros(0, dtype=np.int64), *found])
    return np.where(face < 0, -1, graph.face_solid[face])


def _first_lines(poses: FeltPoses, rim: FloatArray, *, is_between: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the axis and the lines on the rim: all lines between stations, elsewhere four. As `_rim_lines` does."""
    origins, rays, lengths = _rim_lines(poses, rim if is_between else rim[:, ::4])
    axis = (poses.p + poses.mouth_mm[:, None] * poses.back)[:, None]
    origins = np.concatenate([origins, axis], axis=1)
    rays = np.concatenate([rays, poses.back[:, None]], axis=1)
    return origins, rays, np.concatenate([lengths, (poses.end_mm - poses.mouth_mm)[:, None]], axis=1)


def _rim_lines(poses: FeltPoses, rim: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return starts, directions and lengths of lines on the nozzle: along its cylinder, and on its cone if it has one.

    `rim` are places on the outermost circle, relative to the axis, mm, shape (n, k, 3).
    """
    torch = poses.torch
    low = poses.mouth_mm + torch.taper_mm
    origins = (poses.p + low[:, None] * poses.back)[:, None] + rim
    rays = np.broadcast_to(poses.back[:, None], rim.shape)
    lengths = np.broadcast_to((poses.end_mm - low)[:, None], rim.shape[:2])
    if torch.taper_mm == 0.0:
        return origins, rays, lengths
    radius = np.linalg.norm(rim, axis=2, keepdims=True)
    mouth = rim * (1.0 - (torch.nozzle_radius_mm - torch.mouth_mm) / radius)
    starts = (poses.p + poses.mouth_mm[:, None] * poses.back)[:, None] + mouth
    ways = origins - starts
    slant = np.linalg.norm(ways, axis=2)
    return (
        np.concatenate([origins, starts], axis=1),
        np.concatenate([rays, ways / slant[..., None]], axis=1),
        np.concatenate([lengths, slant], axis=1),
    )


def _other_lines(poses: FeltPoses, rim: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the other lines, and those across the mouth."""
    outer, outer_rays, outer_far = _rim_lines(poses, np.delete(rim, np.s_[::4], axis=1))
    centre = (poses.p + poses.mouth_mm[:, None] * poses.back)[:, None]
    radius = np.linalg.norm(rim, axis=2)
    inner = centre + rim[:, ::2] / 2.0
    far = np.broadcast_to((poses.end_mm - poses.mouth_mm)[:, None], inner.shape[:2])
    half = radius[:, : AROUND // 2] - (poses.torch.nozzle_radius_mm - poses.torch.mouth_mm)
    across = rim[:, : AROUND // 2] / radius[:, : AROUND // 2, None]
    origins = np.concatenate([outer, inner, centre - half[..., None] * across], axis=1)
    ways = np.broadcast_to(poses.back[:, None], inner.shape)
    rays = np.concatenate([outer_rays, ways, across], axis=1)
    return origins, rays, np.concatenate([outer_far, far, 2 * half], axis=1)


def _pocket_faces(graph: BrepGraph, trimmed: TrimmedFaces, poses: FeltPoses) -> IntArray:
    """Return a face beside the wire where it is in a hole or pocket narrower than the nozzle, elsewhere -1.

    There the wire alone would fit, without gas and without sight. The width is measured around the wire in four
    directions normal to z of the seam. A seam that goes on to one side is not in a pocket.
    """
    found, rows = np.full(len(poses), -1), np.arange(len(poses))
    for turns in np.split(np.arange(POCKET_WIDTHS) * np.pi / POCKET_WIDTHS, [1]):  # most are not narrow one way
        own, turn = poses.select(np.tile(rows, len(turns))), np.repeat(turns, len(rows))[:, None]
        way = np.cos(turn) * own.R[:, :, 0] + np.sin(turn) * own.R[:, :, 1]
        face, one = _nearest_beside(graph, trimmed, own, way)
        near = np.flatnonzero(face >= 0)
        other = np.full(len(own), np.inf)
        other[near] = _nearest_beside(graph, trimmed, own.select(near), -way[near])[1]
        narrow = (one + other < 2.0 * poses.torch.mouth_mm + POCKET_STEP_MM).reshape(len(turns), -1).all(axis=0)
        found[rows] = np.where(narrow, face[len(own) - len(rows) :], -1)
        rows = rows[narrow]
    return found


def _nearest_beside(
    graph: BrepGraph, trimmed: TrimmedFaces, poses: FeltPoses, way: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return the face nearest to the wire in a direction (n, 3), -1 for none, and at which distance a line meets it."""
    radii = np.arange(POCKET_STEP_MM, 2.0 * poses.torch.mouth_mm, POCKET_STEP_MM)
    n, k = len(poses), len(radii)
    start = (poses.p + poses.start_mm[:, None] * poses.back)[:, None] + radii[:, None] * way[:, None]
    lines, back = start.reshape(-1, 1, 3), np.repeat(poses.back, k, axis=0)[:, None]
    owner, far = np.repeat(poses.owner, k), np.repeat(poses.mouth_mm - poses.start_mm, k)[:, None]
    near = NearBundles.around(trimmed, owner, lines, lines + far[..., None] * back)
    met = near.first_faces(trimmed, lines, back, far)
    met = np.where((met >= 0) & _is_wide_round(graph, poses.torch.mouth_mm)[met], -1, met).reshape(n, k)
    nearest = (met >= 0).argmax(axis=1) if n else np.zeros(0, dtype=np.int64)
    face = met[np.arange(n), nearest]
    return face, np.where(face < 0, np.inf, radii[nearest])


def _is_wide_round(graph: BrepGraph, radius_mm: float) -> BoolArray:
    """Tell which faces are round about a nozzle that fits inside: bores and the insides of rings; shape (F,).

    Along the inside of a ring, lines beside the wire begin inside the ring, but it is no narrow pocket.
    """
    a, b = graph.face_param.T
    bore = (graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward < 0) & (a >= radius_mm)
    ring = (graph.face_kind == SurfaceKind.TORUS) & (a - b >= radius_mm)
    return np.asarray(bore | ring, dtype=bool)


def _circle(back: FloatArray, radius_mm: float, count: int) -> FloatArray:
    """Return places on circles around directions, relative to their centres, mm; shape (n, count, 3)."""
    u = square_to(back)
    w = np.cross(back, u)
    turn = np.arange(count) * 2.0 * np.pi / count
    return np.asarray(radius_mm * (np.cos(turn)[:, None] * u[:, None] + np.sin(turn)[:, None] * w[:, None]))
