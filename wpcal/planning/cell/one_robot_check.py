"""What is odd in a cell with one robot: missing bodies, wrong units, an arm off the floor, a home in collision."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue
from wpcal.planning.cell.cell_check import (
    CELL_CHECK_SCHEMA,
    FLOOR_MM,
    SMALLEST_MM,
    capsule_issues,
    extent_mm,
    metres_issue,
)
from wpcal.planning.cell.one_robot import OneRobotCell
from wpcal.planning.cell.one_robot_clearance import OneRobotClearance, one_robot_bodies
from wpcal.planning.cell.segments import Segments, segment_distances

WIRE_MM = 80.0
"""No wire is so long: the nozzle of a torch is nearer to the tip."""


def check_one_robot(cell: OneRobotCell) -> tuple[Issue, ...]:
    """Return everything that is odd in a cell with one robot.

    Returns
    -------
    tuple of Issue
        Codes ``mounting-face``, ``no-bodies``, ``metres``, ``capsule-and-hull``, ``torch-place`` and ``home``.
    """
    bodies = one_robot_bodies(cell)
    small = [body for body in bodies if extent_mm(body.shape) < SMALLEST_MM]
    sized = [body for body in bodies if body not in small]
    return (
        *_mounting_face(cell),
        *_missing(cell),
        *(metres_issue(body) for body in small),
        *capsule_issues(sized),
        *_torch_place(cell),
        *_home(cell),
    )


def one_robot_check_record(cell: OneRobotCell, issues: Sequence[Issue]) -> dict[str, Any]:
    """Return the record of a check: the name of the cell and what is odd in it."""
    return {"schema": CELL_CHECK_SCHEMA, "cell": cell.name, "issues": [issue.to_record() for issue in issues]}


def one_robot_mounts(cell: OneRobotCell) -> list[tuple[str, FloatArray, FloatArray]]:
    """Return name, rotation (3, 3) and origin (3,), mm in `world`, of the mounting faces: robot, then positioner."""
    places = [("robot", cell.T_world_base, cell.arm)]
    if cell.positioner is not None:
        places.append(("positioner", cell.positioner.T_world_base, cell.positioner.arm))
    return [(name, T.R, np.asarray(T.R @ arm.mount_mm + T.t_mm)) for name, T, arm in places]


def _mounting_face(cell: OneRobotCell) -> Iterator[Issue]:
    _, _, face = one_robot_mounts(cell)[0]
    stated = cell.mount_z_mm
    expected = cell.floor_z_mm if stated is None else stated
    off = float(face[2]) - expected
    if abs(off) > FLOOR_MM:
        where = "the floor" if stated is None else "its stated height"
        yield Issue(
            "mounting-face",
            f"robot ({cell.arm.name}): its mounting face is at z = {face[2]:g} mm, {abs(off):g} mm "
            f"{'above' if off > 0 else 'below'} {where} (z = {expected:g} mm): correct T_world_base of torch_robot, or "
            f'write "mounting_face_z_mm": {face[2]:g} there',
            ("robot",),
        )


def _missing(cell: OneRobotCell) -> Iterator[Issue]:
    groups = [
        (cell.links, "robot", "the robot has no bodies: no collision of its arm can be found", "torch_robot.links"),
        (
            cell.torch,
            "torch",
            "the torch has no bodies: no collision of the torch can be found",
            "torch_robot.torch",
        ),
    ]
    if cell.positioner is not None:
        says = "the positioner has no bodies: no collision with it can be found"
        groups.append((cell.positioner.links, "positioner", says, "positioner.links"))
    for shapes, name, says, field in groups:
        if not shapes:
            yield Issue("no-bodies", f"{says}; list bodies in {field}", (name,))


def _torch_place(cell: OneRobotCell) -> Iterator[Issue]:
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


def _home(cell: OneRobotCell) -> Iterator[Issue]:
    clearance = OneRobotClearance(cell, None)
    found = clearance.margins(cell.home[None])
    if not found.is_clear[0]:
        one, two = clearance.names(int(found.pair[0]))
        yield Issue(
            "home",
            f"home is in collision: {one} and {two} miss their safety distance by {-found.margin_mm[0]:.0f} mm; write "
            "another home_deg in torch_robot",
            (one, two),
        )
