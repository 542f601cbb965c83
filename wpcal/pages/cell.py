"""`cell.html` (`wpcal plan --check`): a cell with its bodies, frames and mounting faces; other pages draw it too."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from wpcal.core.arrays import FloatArray
from wpcal.pages.html import build_page
from wpcal.planning.cell.bodies import Body, bodies_of
from wpcal.planning.cell.cell import CARRIER, TOOL, WORLD, Cell
from wpcal.planning.cell.cell_check import check_cell, mounts
from wpcal.planning.cell.shape import JOINTS

BODY = """
<main id="page"></main>
<noscript>This page needs JavaScript to draw the plan; its numbers are in the files beside it.</noscript>
"""
WIRE_MM = 26.0  #: Drawn length of the wire, from its tip back: the usual stick-out, and the part inside the nozzle.


def build_cell_page(cell: Cell) -> str:
    """Return the page of a cell at home: what its file describes, and what is odd in it.

    Returns: A self-contained HTML file, the same for the same cell.
    """
    two = cell.has_two_robots
    pose = "all joints at zero, or at the limit that is nearest to zero" if two else "all axes at home"
    robots = [
        {
            "robot": number if two else mount.name,
            "arm": mount.arm.name,
            "base": mount.T_world_base.t_mm.tolist(),
            "mount": mount.face.tolist(),
        }
        for number, mount in enumerate(mounts(cell), start=1)
    ]
    data = {
        **cell_record(cell, shows_frames=True),
        "kind": "cell of two robots" if two else "cell with one robot",
        "pose": pose,
        "robots": robots,
        "carrierNames": _carrier_names(cell),
    }
    blobs = {"frames": frames_at(cell, cell.home[None]).astype("<f4").tobytes()}
    return build_page(title=f"Cell {cell.name}", entry="cell", body=BODY, data=data, blobs=blobs)


def _carrier_names(cell: Cell) -> list[str]:
    links = ["base", *(f"link {link}" for link in range(1, JOINTS)), "flange"]
    if cell.has_two_robots:
        one, two = ([f"robot {robot}, {name}" for name in links] for robot in (1, 2))
        return [*one, "tool", "world", *two, "part"]
    turning = range(1, cell.part_row - CARRIER)
    carrier = [] if cell.carrier is None else ["positioner, base", *(f"positioner, axis {axis}" for axis in turning)]
    return [*links, "tool", "world", *carrier, "part"]


def cell_record(cell: Cell, *, shows_frames: bool) -> dict[str, Any]:
    """Return what every page draws of a cell."""
    two, carried = cell.has_two_robots, [] if cell.carrier is None else [CARRIER]
    flange = [cell.part_row - 1] if two else []
    return {
        "cell": cell.name,
        "issues": [issue.to_record() for issue in check_cell(cell)],
        "bodies": [_body(body, cell) for body in bodies_of(cell)],
        "bases": [mount.T_world_base.t_mm.tolist() for mount in mounts(cell)],
        "mounts": [
            {"p": mount.face.tolist(), "x": R[:, 0].tolist(), "y": R[:, 1].tolist()}
            for mount in mounts(cell)
            for R in (mount.T_world_base.R,)
        ],
        "labels": {"robot1": "robot 1", "robot2": "robot 2"} if two else {"robot1": "robot", "robot2": "positioner"},
        "floor_z_mm": cell.floor_z_mm,
        "frames": [0, JOINTS, TOOL, *carried, *flange, cell.part_row],
        "showsFrames": shows_frames,
        "carriers": {"count": cell.part_row + 1, "tool": TOOL, "part": cell.part_row, "world": WORLD},
        "wire_mm": WIRE_MM,
    }


def _body(body: Body, cell: Cell) -> dict[str, Any]:
    """Return a body with what it is shown and hidden with: ``robot1``, ``robot2``, ``torch``, ``part`` or ``bench``."""
    groups = {TOOL: "torch", cell.part_row: "part", WORLD: "bench"}
    shape = body.shape
    record: dict[str, Any] = {
        "name": body.name,
        "group": groups.get(body.carrier, "robot1" if body.owner.has_torch else "robot2"),
        "carrier": body.carrier,
        "capsules": [
            {"p": p.tolist(), "q": q.tolist(), "radius": float(radius)}
            for p, q, radius in zip(shape.p, shape.q, shape.radius_mm, strict=True)
        ],
        "hull": None,
    }
    if len(shape.hull):
        hull = ConvexHull(shape.hull)
        record["hull"] = {"positions": shape.hull.tolist(), "indices": hull.simplices.tolist()}
    return record


def frames_at(cell: Cell, q: FloatArray) -> FloatArray:
    """Return the upper three rows of every carrier's frame at states (N, k), shape (N, carriers, 3, 4)."""
    frames = [np.broadcast_to(frame.matrices(), (len(q), 4, 4)) for frame in cell.frames(q)]
    return np.stack(frames, axis=1)[:, :, :3]
