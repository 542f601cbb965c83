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
from wpcal.planning.cell.station import Station
from wpcal.planning.cell.station_clearance import StationClearance, station_bodies


def check_station(station: Station) -> tuple[Issue, ...]:
    """Return everything that is odd in a cell with one robot.

    Parameters
    ----------
    station : Station

    Returns
    -------
    tuple of Issue
        Codes ``mounting-face``, ``no-bodies``, ``metres``, ``capsule-and-hull`` and ``home``.
    """
    bodies = station_bodies(station)
    small = [body for body in bodies if extent_mm(body.shape) < SMALLEST_MM]
    sized = [body for body in bodies if body not in small]
    return (
        *_mounting_face(station),
        *_missing(station),
        *(metres_issue(body) for body in small),
        *capsule_issues(sized),
        *_home(station),
    )


def station_check_record(station: Station, issues: Sequence[Issue]) -> dict[str, Any]:
    """Return the record of a check: the name of the cell and what is odd in it."""
    return {"schema": CELL_CHECK_SCHEMA, "cell": station.name, "issues": [issue.to_record() for issue in issues]}


def station_mounts(station: Station) -> list[tuple[str, FloatArray, FloatArray]]:
    """Return name, rotation (3, 3) and origin (3,), mm in `world`, of the mounting faces: robot, then positioner."""
    places = [("robot", station.T_world_base, station.arm)]
    if station.positioner is not None:
        places.append(("positioner", station.positioner.T_world_base, station.positioner.arm))
    return [(name, T.R, np.asarray(T.R @ arm.mount_mm + T.t_mm)) for name, T, arm in places]


def _mounting_face(station: Station) -> Iterator[Issue]:
    _, _, face = station_mounts(station)[0]
    stated = station.mount_z_mm
    expected = station.floor_z_mm if stated is None else stated
    off = float(face[2]) - expected
    if abs(off) > FLOOR_MM:
        where = "the floor" if stated is None else "its stated height"
        yield Issue(
            "mounting-face",
            f"robot ({station.arm.name}): its mounting face is at z = {face[2]:g} mm, {abs(off):g} mm "
            f"{'above' if off > 0 else 'below'} {where} (z = {expected:g} mm): correct T_world_base of torch_robot, or "
            f'write "mounting_face_z_mm": {face[2]:g} there',
            ("robot",),
        )


def _missing(station: Station) -> Iterator[Issue]:
    groups = [
        (station.links, "robot", "the robot has no bodies: no collision of its arm can be found", "torch_robot.links"),
        (
            station.torch,
            "torch",
            "the torch has no bodies: no collision of the torch can be found",
            "torch_robot.torch",
        ),
    ]
    if station.positioner is not None:
        says = "the positioner has no bodies: no collision with it can be found"
        groups.append((station.positioner.links, "positioner", says, "positioner.links"))
    for shapes, name, says, field in groups:
        if not shapes:
            yield Issue("no-bodies", f"{says}; list bodies in {field}", (name,))


def _home(station: Station) -> Iterator[Issue]:
    clearance = StationClearance(station, None)
    found = clearance.margins(station.home[None])
    if not found.is_clear[0]:
        one, two = clearance.names(int(found.pair[0]))
        yield Issue(
            "home",
            f"home is in collision: {one} and {two} miss their safety distance by {-found.margin_mm[0]:.0f} mm; write "
            "another home_deg in torch_robot",
            (one, two),
        )
