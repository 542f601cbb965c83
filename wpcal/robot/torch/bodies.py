"""The bodies of a torch for a cell file: from its sizes, from a mesh, or from capsules that the user states.

All are in the frame `tool`, whose z is the wire direction and whose origin is the tip of the wire. A torch with a neck
bends towards the flange.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.urdf_bodies import capsule_around, hull_corners, read_stl
from wpcal.robot.surface_points import surface_points
from wpcal.robot.torch.shape import CONE_STEP_MM, CORNERS, PRISM, Neck, TorchShape

NOZZLE_TO_PART_MM = 3.0  #: The nozzle works near the part: this is above the errors of a calibration and of a path.
NOZZLE_MM = 110.0  #: From the tip of the wire to where a usual swan neck bends.
NECK_RADIUS_MM = 30.0  #: Half of the width of a usual torch body with its cables.
ON_WIRE_MM = 1.0  #: A flange that is nearer to the line of the wire gives no direction for the neck.
SLICE_MM = 30.0
"""A torch mesh is cut across the wire into pieces of this length, each with its own hull: a bent neck stays bent."""
SMALLEST_TORCH_MM = 30.0  #: No torch is shorter.
SAMPLE_MM = 3.0  #: Points on a torch mesh are at most this far apart.


def hulled(name: str, hull: FloatArray, **more: Any) -> dict[str, Any]:
    """Return the record of a body: a convex hull, and the capsule around it.

    `hull`: shape (n, 3). Corners in the frame of the body, mm.
    """
    p, q, radius = capsule_around(hull)
    capsule = {"p_mm": _rounded(p), "q_mm": _rounded(q), "radius_mm": float(np.ceil(radius * 100 + 2) / 100)}
    return {"name": name, **more, "capsules": [capsule], "hull_mm": hull.tolist()}


def mounted(shape: TorchShape, T_flange_tool: RigidTransform) -> TorchShape:
    """Return the torch as it is on the flange: what has no neck gets one with the bodies of `bodies_of_shape`.

    Behind the nozzle a body leads straight to the flange; where the wire leads there, the neck does not bend. Where the
    nozzle fits in front of the flange, it ends there.
    """
    if shape.neck is not None:
        return shape
    flange = T_flange_tool.inverse().t_mm
    least = shape.wire_mm + max(2.0 * shape.nozzle_radius_mm, shape.taper_mm)
    bend = np.array([0.0, 0.0, -round(max(min(NOZZLE_MM, -float(flange[2])), least), 3)])
    off = float(np.linalg.norm(flange[:2]))
    angle = float(np.degrees(np.arctan2(off if off > ON_WIRE_MM else 0.0, bend[2] - flange[2])))
    from_mm, apart = -float(bend[2]) - shape.wire_mm, _apart(bend, flange)
    radius = min(NECK_RADIUS_MM, from_mm / 2, max(apart / 2, ON_WIRE_MM))  # as thick as there is room
    neck = Neck(round(angle, 3), from_mm, 0.0, radius, from_mm, radius)
    length = round(apart - float(bend[2]), 3)
    return replace(shape, name=f"{shape.name} on its flange", length_mm=length, neck=neck)


def bodies_of_shape(shape: TorchShape, T_flange_tool: RigidTransform) -> list[dict[str, Any]]:
    """Return the bodies of a torch with known sizes, and what joins it to the flange. Records of shapes in `tool`.

    They are the pieces with which seams are judged. Where a piece is wider than the one before it, it begins as a hull:
    a capsule would reach ahead of it, or would not reach its rim.

    `shape`: Straight, or with a neck.
    """
    shape, flange = mounted(shape, T_flange_tool), T_flange_tool.inverse().t_mm
    towards = np.array([flange[0], flange[1], 0.0])
    off = float(np.linalg.norm(towards))
    x = towards / off if off > ON_WIRE_MM else np.array([-1.0, 0.0, 0.0])  # as wpcal export turns a neck
    back = np.array([0.0, 0.0, -1.0])
    R = np.stack([x, np.cross(back, x), back], axis=1)
    mouth, bend = shape.wire_mm * back, (shape.wire_mm + shape.front_mm) * back
    bodies, end, before_mm = [_nozzle(shape)], bend, shape.nozzle_radius_mm
    for number, tube in enumerate(shape.tubes, start=1):
        p, end = mouth + R @ tube.start, mouth + R @ tube.end
        near = {"to_part_mm": NOZZLE_TO_PART_MM} if _apart(p, bend) + shape.wire_mm + shape.front_mm < NOZZLE_MM else {}
        if tube.radius_mm > before_mm + CONE_STEP_MM:
            way = (end - p) / _apart(p, end)
            edge = p + min(tube.radius_mm, _apart(p, end)) * way
            bodies.append(
                _prism(f"torch {number} front", ((tube.radius_mm, p), (tube.radius_mm, edge)), R[:, 1], way, **near)
            )
            p = edge
        if _apart(p, end) > 0.0:
            bodies.append({**_capsule(f"torch {number}", p, end, tube.radius_mm), **near})
        before_mm = tube.radius_mm
    if _apart(end, flange) > NECK_RADIUS_MM:  # else they are as near as the body is thick
        bodies.append(_capsule("torch body", end, flange, NECK_RADIUS_MM))
    return bodies


def _apart(p: FloatArray, q: FloatArray) -> float:
    return float(np.linalg.norm(q - p))


def _nozzle(shape: TorchShape) -> dict[str, Any]:
    """Return the hull of the nozzle from its mouth to its end."""
    rings = {
        (shape.wire_mm, shape.mouth_mm),
        *((shape.wire_mm + mm, shape.nozzle_radius_mm) for mm in (shape.taper_mm, shape.front_mm)),
    }
    x, _, z = np.eye(3)
    return _prism("nozzle", [(r, -mm * z) for mm, r in sorted(rings)], x, -z, to_part_mm=NOZZLE_TO_PART_MM)


def _prism(
    name: str, rings: Iterable[tuple[float, FloatArray]], side: FloatArray, way: FloatArray, **more: Any
) -> dict[str, Any]:
    """Return the hull around circles, given by radii and middles, in planes normal to `way`; `side` is in them."""
    turn = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    circle = np.outer(np.cos(turn), side) + np.outer(np.sin(turn), np.cross(side, way))
    return hulled(name, np.concatenate([middle + r * PRISM * circle for r, middle in rings]), **more)


def bodies_of_capsules(
    capsules: Sequence[tuple[FloatArray, FloatArray, float]], T_flange_tool: RigidTransform
) -> list[dict[str, Any]]:
    """Return the bodies of capsules that the user states.

    `capsules`: Ends, shape (3,) each, in the frame `flange`, and the radius, mm.
    """
    T, bodies = T_flange_tool.inverse(), []
    for number, (p, q, radius) in enumerate(capsules, start=1):
        ends = T.apply(np.array([p, q]))
        body = _capsule(f"torch {number}", ends[0], ends[1], radius)
        if ends[:, 2].min() > -NOZZLE_MM - radius:
            body["to_part_mm"] = NOZZLE_TO_PART_MM
        bodies.append(body)
    return bodies


def _capsule(name: str, p: FloatArray, q: FloatArray, radius: float) -> dict[str, Any]:
    return {"name": name, "capsules": [{"p_mm": _rounded(p), "q_mm": _rounded(q), "radius_mm": float(radius)}]}


def _rounded(values: FloatArray) -> list[float]:
    return [float(value) for value in np.round(values, 2) + 0.0]


def bodies_of_mesh(path: Path, T_flange_tool: RigidTransform, wire_mm: float) -> list[dict[str, Any]]:
    """Return hulls of the slices of a torch mesh across the wire; what is in front of the nozzle is the wire.

    `path`: STL file in the frame `flange`, mm.
    Raises `InputError` when nothing of the mesh is behind the nozzle, or it is so small that it must be in metres.
    Raises `FormatError` when the file is not an STL file.
    """
    corners = T_flange_tool.inverse().apply(read_stl(path)).reshape(-1, 3, 3)
    size_mm = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    if size_mm < SMALLEST_TORCH_MM:
        raise InputError(f"{path}: this mesh is {size_mm:.3g} mm long: it is probably in metres; expected it in mm")
    points = np.concatenate(surface_points(corners, SAMPLE_MM))
    points = points[points[:, 2] <= SAMPLE_MM - wire_mm]
    if not len(points):
        raise InputError(f"{path}: no part of this mesh is behind the nozzle; expected it in mm in the frame flange")
    bodies = []
    number = np.floor(points[:, 2] / SLICE_MM).astype(int)
    for row, which in enumerate(np.unique(number)[::-1], start=1):
        edge = which * SLICE_MM
        own = points[(points[:, 2] >= edge - SAMPLE_MM) & (points[:, 2] <= edge + SLICE_MM + SAMPLE_MM)]
        try:
            body = hulled(f"torch {row}", hull_corners(own))
        except FormatError:  # the last points of a mesh: they are in the slice beside it, too
            continue
        if -edge - SLICE_MM < NOZZLE_MM:
            body["to_part_mm"] = NOZZLE_TO_PART_MM
        bodies.append(body)
    return bodies
