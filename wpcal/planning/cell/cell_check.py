"""What is odd in a cell: bodies that are missing, in the wrong unit or frame, and arms that are not on the floor.

Nothing here stops a plan. But a plan is called free by the bodies of its cell, so every oddity is told: by
`wpcal plan --check`, and by every `wpcal plan` on the console and in its records.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.core.issue import Issue
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.bodies import Body, Owner, bodies_of
from wpcal.planning.cell.cell import CARRIER, TOOL, Cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.clearance import require_bases_apart
from wpcal.planning.cell.segments import Segments, segment_distances
from wpcal.planning.cell.shape import JOINTS, Shape
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.urdf_bodies import capsule_around

CELL_CHECK_SCHEMA = "wpcal/cell-check/1"
FLOOR_MM = 25.0
"""A mounting face this near to its height is at this height: floors are levelled, and bases are measured, to less."""
SMALL = "{} is {:.3g} mm long: its numbers look like metres; multiply p_mm, q_mm, radius_mm and hull_mm by 1000"
SMALLEST_MM = 5.0
"""No body of a cell is smaller, and no link of an arm is longer than 5 m: a smaller body is in metres."""
FAR_MM = 150.0  #: Bodies enclose the axes of their link, or are fastened beside them at less than this distance.
STICKS_OUT_MM = 0.1  #: A capsule that misses corners of its hull by less changes no clearance that anyone reads.
NOT_ROBOTS = (Owner.BENCH, Owner.POSITIONER)
"""Owners whose bodies are given anywhere: no frame of an arm says where they should be."""
WIRE_MM = 80.0  #: No wire is so long: the nozzle of a torch is nearer to the tip.
SAMPLES = 17  #: Points per link and per edge of a hull that are measured: one per 100 mm on a large arm.


def check_cell(cell: Cell) -> tuple[Issue, ...]:
    """Return everything that is odd in a cell.

    Returns tuple of Issue. Codes ``mounting-face``, ``below-floor``, ``no-bodies``, ``metres``, ``far-from-link``,
    ``capsule-and-hull``; of two robots ``bases-too-near``, of one ``torch-place`` and ``home``; empty for a cell
    without oddities.
    """
    frames = [frame.matrices()[0] for frame in cell.frames(np.zeros((1, len(cell.home))))]
    bodies = bodies_of(cell)
    small = [body for body in bodies if extent_mm(body.shape) < SMALLEST_MM]
    sized = [body for body in bodies if body not in small]
    return (
        *_mounting_faces(cell),
        *_below_floor(cell, sized, frames),
        *_missing(cell),
        *(Issue("metres", SMALL.format(body.name, extent_mm(body.shape)), (body.name,)) for body in small),
        *_far_from_link(cell, sized, frames),
        *_capsules(sized),
        *(_bases_too_near(cell) if cell.has_two_robots else (*_torch_place(cell), *_home(cell))),
    )


def cell_check_record(cell: Cell, issues: Sequence[Issue]) -> dict[str, Any]:
    """Return the record of a check: the name of the cell and what is odd in it."""
    return {"schema": CELL_CHECK_SCHEMA, "cell": cell.name, "issues": [issue.to_record() for issue in issues]}


class Mount(NamedTuple):
    """Where an arm is mounted: its name, its key in the cell file, its base, and the height at which it should be."""

    name: str
    key: str
    arm: Arm
    T_world_base: RigidTransform
    stated_z_mm: float | None

    @property
    def face(self) -> FloatArray:
        """Origin of the mounting face in `world`, shape (3,), mm."""
        return np.asarray(self.T_world_base.apply(self.arm.mount_mm))


def mounts(cell: Cell) -> list[Mount]:
    """Return the mounting faces: the robot, then the positioner or robot 2."""
    two, carrier = cell.has_two_robots, cell.carrier
    found = [Mount("robot 1" if two else "robot", "torch_robot", cell.arm, cell.T_world_base, cell.mount_z_mm)]
    if carrier is not None:
        name, key = ("robot 2", "holder_robot") if two else ("positioner", "positioner")
        found.append(Mount(name, key, carrier.arm, carrier.T_world_base, carrier.mount_z_mm))
    return found


def _mounting_faces(cell: Cell) -> Iterator[Issue]:
    for name, key, arm, T, stated in (mount for mount in mounts(cell) if mount.key != "positioner"):
        z = float(T.apply(arm.mount_mm)[2])
        expected = cell.floor_z_mm if stated is None else stated
        off = z - expected
        if abs(off) <= FLOOR_MM:
            continue
        side = "above" if off > 0 else "below"
        if stated is None:
            where, right = f"the floor (z = {expected:g} mm)", "on the floor"
            or_floor = f', or "floor_z_mm": {z:g} in the cell if the floor is there'
        else:
            where, right, or_floor = f"its stated height (z = {expected:g} mm)", "at that height", ""
        xyz = ", ".join(f"{value:g}" for value in np.round(T.t_mm - [0.0, 0.0, off], 3) + 0.0)
        yield Issue(
            "mounting-face",
            f"{name} ({arm.name}): its mounting face is at z = {z:g} mm, {abs(off):g} mm {side} {where}."
            f"{_base_frame_text(arm)} If the arm is {right}, write xyz_mm [{xyz}] in T_world_base of {key}. "
            f'If z = {z:g} mm is right, write "mounting_face_z_mm": {z:g} in {key}{or_floor}',
            (name,),
        )


def _base_frame_text(arm: Arm) -> str:
    height = float(np.linalg.norm(arm.mount_mm))
    if height < FLOOR_MM:
        return ""
    numbers = ", ".join(f"{value:g}" for value in arm.mount_mm)
    return f" The base frame of this arm is {height:g} mm from its mounting face (mount_mm {numbers})."


def _below_floor(cell: Cell, bodies: Sequence[Body], frames: Sequence[FloatArray]) -> Iterator[Issue]:
    for body in bodies:
        if body.link != 0 or body.owner in NOT_ROBOTS:
            continue
        T = frames[body.carrier]
        # the round end of a capsule may reach below the floor where the body that it stands for does not
        points = body.shape.hull if len(body.shape.hull) else np.concatenate([body.shape.p, body.shape.q])
        lowest = float((points @ T[2, :3] + T[2, 3]).min())
        stated = mounts(cell)[0 if body.owner.has_torch else 1].stated_z_mm
        floor = cell.floor_z_mm if stated is None else min(stated, cell.floor_z_mm)
        if lowest < floor - FLOOR_MM:
            yield Issue(
                "below-floor",
                f"{body.name} reaches down to z = {lowest:.0f} mm, {floor - lowest:.0f} mm below the floor "
                f"(z = {floor:g} mm): correct T_world_base of {body.owner.value}, or the body, which is given in the "
                f'base frame of the arm; if the floor is lower, write "floor_z_mm" in the cell',
                (body.name,),
            )


def _missing(cell: Cell) -> Iterator[Issue]:
    two, (robot, *others) = cell.has_two_robots, mounts(cell)
    groups = [
        (cell.torch, "torch", "the torch has no bodies: no collision of the torch can be found", "torch_robot.torch")
    ]
    arm = "no collision of its arm can be found"
    own = (cell.links, robot.name, f"{'' if two else 'the '}{robot.name} has no bodies: {arm}", "torch_robot.links")
    if cell.carrier is None or not two:
        groups.insert(0, own)
        if others:
            says = "the positioner has no bodies: no collision with it can be found"
            groups.append((() if cell.carrier is None else cell.carrier.links, "positioner", says, "positioner.links"))
    else:
        says = "the cell has no floor, table or other fixed body: no collision with them can be found"
        groups += [
            (cell.part, "part", "the part has no bodies: no collision of the part can be found", "holder_robot.part"),
            own,
            (cell.carrier.links, "robot 2", f"robot 2 has no bodies: {arm}", "holder_robot.links"),
            (cell.bench, "bench", says, "bench"),
        ]
    for shapes, name, says, field in groups:
        if not shapes:
            yield Issue("no-bodies", f"{says}; list bodies in {field}", (name,))


def extent_mm(shape: Shape) -> float:
    """Return the largest side of the box around a body, mm; its hull counts alone if it has one."""
    if len(shape.hull):
        return float(np.ptp(shape.hull, axis=0).max())
    low, high = shape.box
    return float((high - low).max())


def _far_from_link(cell: Cell, bodies: Sequence[Body], frames: Sequence[FloatArray]) -> Iterator[Issue]:
    for body in bodies:
        if body.owner in NOT_ROBOTS or body.carrier == cell.part_row:
            continue
        T = np.linalg.inv(frames[body.carrier])
        skeleton = _skeleton(cell, body, frames) @ T[:3, :3].T + T[:3, 3]
        apart = _distance(skeleton, body.shape)
        if apart > FAR_MM:
            what = (
                "the torch, which reaches from the flange to the tip of the wire"
                if body.carrier == TOOL
                else (f"link {body.link} of {body.owner.value}")
            )
            frame = "the frame tool" if body.carrier == TOOL else f"the frame after link {body.link} of the arm's file"
            yield Issue(
                "far-from-link",
                f"{body.name} is {apart:.0f} mm away from {what}: bodies are given in {frame}, in mm; a mesh of a URDF "
                "or a drawing has another frame and must be moved into this one",
                (body.name,),
            )


def _skeleton(cell: Cell, body: Body, frames: Sequence[FloatArray]) -> FloatArray:
    """Return points along a link in `world`: from the frame before it, through its own, to the next one."""
    if body.carrier == TOOL:
        return _along([frames[JOINTS][:3, 3], frames[TOOL][:3, 3]])
    first = 0 if body.owner.has_torch else CARRIER
    places = [frames[first + link][:3, 3] for link in range(JOINTS + 1)]
    mount = mounts(cell)[0 if body.owner.has_torch else 1].face
    # what is on the flange reaches to what it carries
    carried = [frames[TOOL][:3, 3]] if body.owner.has_torch else _part_centre(cell, frames)
    return _along([mount, *places, *carried][body.link : body.link + 3])


def _part_centre(cell: Cell, frames: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the middle of the bodies of the part in `world`; nothing if it has none."""
    points = [np.concatenate([shape.p, shape.q, shape.hull]) for shape in cell.part]
    if not points:
        return []
    T, every = frames[cell.part_row], np.concatenate(points)
    return [T[:3, :3] @ ((every.min(axis=0) + every.max(axis=0)) / 2) + T[:3, 3]]


def _along(knots: Sequence[FloatArray]) -> FloatArray:
    parts = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    return np.concatenate([a + parts * (b - a) for a, b in itertools.pairwise(knots)])


def _distance(points: FloatArray, shape: Shape) -> float:
    """Return the least distance of points from a body, mm: from the capsule around its hull if it has one."""
    p, q, radius = shape.p, shape.q, shape.radius_mm
    if len(shape.hull):
        one = capsule_around(shape.hull)
        p, q, radius = one[0][None], one[1][None], np.array([one[2]])
    return float(_outside(points, p, q, radius).min())


def _outside(points: FloatArray, p: FloatArray, q: FloatArray, radius: FloatArray) -> FloatArray:
    """Return how far each of n points is outside the nearest capsule, shape (n,), mm; not positive inside."""
    u = q - p
    along = np.einsum("nkj,kj->nk", points[:, None] - p, u) / np.maximum((u**2).sum(axis=1), 1e-18)
    nearest = p + np.clip(along, 0.0, 1.0)[..., None] * u
    return np.asarray((np.linalg.norm(points[:, None] - nearest, axis=2) - radius).min(axis=1), dtype=np.float64)


def _capsules(bodies: Sequence[Body]) -> Iterator[Issue]:
    """Yield an issue for every body whose hull reaches out of its capsules."""
    for body in bodies:
        shape = body.shape
        if not len(shape.hull):
            continue
        out = float(_outside(_on_edges(shape.hull), shape.p, shape.q, shape.radius_mm).max())
        if out > STICKS_OUT_MM:
            yield Issue(
                "capsule-and-hull",
                f"{body.name}: its hull reaches up to {out:.1f} mm outside its capsules, so the search sees "
                "more room than there is; make the capsule with "
                "wpcal.robot.kinematics.urdf_bodies.capsule_around(hull_mm)",
                (body.name,),
            )


def _on_edges(hull: FloatArray) -> FloatArray:
    """Return the corners of a hull and points on its edges: several capsules may hold all corners, but not these."""
    try:
        faces = ConvexHull(hull).simplices
    except QhullError:  # flat: the check for collisions refuses it
        return hull
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [0, 2]]]), axis=1), axis=0)
    parts = np.linspace(0.0, 1.0, SAMPLES)[:, None, None]
    on_edges = hull[edges[:, 0]] + parts * (hull[edges[:, 1]] - hull[edges[:, 0]])
    return np.concatenate([hull, on_edges.reshape(-1, 3)])


def _bases_too_near(cell: Cell) -> Iterator[Issue]:
    try:
        require_bases_apart(cell)
    except GeometryError as error:
        yield Issue("bases-too-near", str(error), ("robot 1", "robot 2"))
    apart = float(np.linalg.norm(cell.T_base1_base2.t_mm))
    if apart < SMALLEST_MM:
        yield Issue(
            "bases-too-near",
            f"the bases are {apart:.3g} mm apart: T_world_base of both robots is in mm; are these numbers metres?",
            ("robot 1", "robot 2"),
        )


def _torch_place(cell: Cell) -> Iterator[Issue]:
    """Yield what does not fit between the torch and the tip of the wire, the origin of the frame `tool`."""
    nearest = np.inf
    for shape in cell.torch:
        capsules, tip = Segments(shape.p.T, (shape.q - shape.p).T), np.zeros((3, 1))
        apart = segment_distances(capsules, Segments(tip, tip)) - shape.radius_mm
        if not len(apart):
            continue
        nearest = min(nearest, float(apart.min()))
        if not len(shape.hull) and apart.min() < 0.0:  # the capsule around a hull is only a bound
            says = f"the tip of the wire is {-apart.min():.0f} mm inside {shape.name}, which would never reach a seam"
            yield Issue("torch-place", f"{says}; correct T_flange_tool or torch in torch_robot", (shape.name,))
    if WIRE_MM < nearest < np.inf:
        yield Issue(
            "torch-place",
            f"the bodies of the torch begin {nearest:.0f} mm from the tip of the wire: they are in another frame than "
            "tool (--torch-mesh and --torch-capsule: flange), or T_flange_tool is wrong",
            ("torch",),
        )


def _home(cell: Cell) -> Iterator[Issue]:
    clearance = CellClearance(cell, None)
    found = clearance.margins(cell.home[None])
    if not found.is_clear[0]:
        one, two = clearance.names(int(found.pair[0]))
        yield Issue(
            "home",
            f"home is in collision: {one} and {two} miss their safety distance by {-found.margin_mm[0]:.0f} mm; write "
            "another home_deg in torch_robot",
            (one, two),
        )
