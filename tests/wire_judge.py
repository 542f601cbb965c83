"""How deep the wire of a torch goes into a part on the joint moves of a plan: nothing of the planner is used here.

Joints become poses by the URDF file, the wire is points on a line, and a point is inside where the winding number of
the part's triangles says so (Van Oosterom, Strackee, The solid angle of a plane triangle, 1983).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.real_cells import RealCell

Array = np.ndarray[Any, Any]
STEP_MM = 2.0
"""The tip moves by about so much between two states that are judged: a plate of 8 mm is met several times."""
ALONG_MM = 1.0  #: Points of the wire are so far apart.
AT_ONCE = 200


@dataclass(frozen=True)
class AirContact:
    """What the wire does on the joint moves of a plan."""

    deepest_mm: float  #: How deep a point of the wire's axis is inside the part; 0 if none is.
    least_mm: float  #: Least distance of the axis from the surface.
    where: int  #: The row of the state before the worst place.


def winding(points: Array, corners: Array) -> Array:
    """Return the winding numbers of points (n, 3) about triangles (m, 3, 3): 1 inside a solid, 0 outside."""
    found = np.empty(len(points))
    for first in range(0, len(points), AT_ONCE):
        a, b, c = (corners[None, :, k] - points[first : first + AT_ONCE, None] for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
        triple = np.einsum("nmi,nmi->nm", a, np.cross(b, c))
        dots = [np.einsum("nmi,nmi->nm", x, y) for x, y in ((a, b), (b, c), (c, a))]
        found[first : first + AT_ONCE] = np.arctan2(
            triple, la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
        ).sum(axis=1) / (2.0 * np.pi)
    return found


def off_surface(points: Array, corners: Array) -> Array:
    """Return the distances of points (n, 3) from triangles (m, 3, 3)."""
    found = np.empty(len(points))
    for first in range(0, len(points), AT_ONCE):
        p = points[first : first + AT_ONCE, None]
        best = np.full((p.shape[0], len(corners)), np.inf)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        over = np.ones(best.shape, dtype=bool)
        for k in range(3):
            a, edge = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
            t = np.clip(((p - a) * edge).sum(axis=2) / np.maximum((edge * edge).sum(axis=1), 1e-18), 0.0, 1.0)
            best = np.minimum(best, np.linalg.norm(p - a - t[..., None] * edge, axis=2))
            over &= np.einsum("nmi,mi->nm", p - a, np.cross(normal, edge)) >= 0.0
        height = np.abs(np.einsum("nmi,mi->nm", p - corners[:, 0], normal))
        found[first : first + AT_ONCE] = np.where(over, np.minimum(best, height), best).min(axis=1)
    return found


def air_states(record: dict[str, Any]) -> Iterator[tuple[int, Array, Array]]:
    """Yield the joint moves of ``plan.json``: the row of the state, the axes before and after, rad."""
    points = record["points"]
    for row in range(1, len(points)):
        if points[row]["phase"] == "air":
            yield row, np.radians(points[row - 1]["axes"]), np.radians(points[row]["axes"])


def wire_in_the_air(cell: RealCell, corners: Array, record: dict[str, Any], wire_mm: float) -> AirContact:
    """Judge the wire, from the tip back to the mouth of the nozzle, on all joint moves of ``plan.json``.

    `corners`: shape (m, 3, 3). Triangles of the part in its own frame, mm.
    """
    line = np.zeros((int(wire_mm / ALONG_MM) + 1, 3))
    line[:, 2] = -np.linspace(0.0, wire_mm, len(line))
    low, high = corners.min(axis=(0, 1)) - 5.0, corners.max(axis=(0, 1)) + 5.0
    deepest, least, where = 0.0, np.inf, -1
    for row, a, b in air_states(record):
        tips = [cell.places(q)["tool"][:3, 3] for q in (a, (a + b) / 2, b)]
        way = np.linalg.norm(tips[1] - tips[0]) + np.linalg.norm(tips[2] - tips[1])
        found = []
        for t in np.linspace(0.0, 1.0, int(way / STEP_MM) + 2):
            at = cell.places(a + t * (b - a))
            T = np.linalg.inv(at["part"]) @ at["tool"]
            found.append(line @ T[:3, :3].T + T[:3, 3])
        points = np.concatenate(found)
        points = points[((points > low) & (points < high)).all(axis=1)]
        if not len(points):
            continue
        off = off_surface(points, corners)
        inside = winding(points, corners) > 0.5
        least = min(least, float(off.min()))
        if inside.any() and float(off[inside].max()) > deepest:
            deepest, where = float(off[inside].max()), row
    return AirContact(deepest, least, where)
