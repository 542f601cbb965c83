"""`plan.html`: the plans of a seam: the trade-off chart, the curves of each plan, and the cell moving in 3-D.

`cell.html` (`wpcal plan --check`) shows the cell alone: its bodies, frames, floor and mounting faces.

``plan.json`` or ``pareto.json`` hold the same numbers; here they are rounded to what a screen shows. The page holds no
clock, path or host name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.pages.html import build_page, json_blob
from wpcal.planning.cell.bodies import PART, TOOL, WORLD, Body, Owner, bodies_of, body_frames, body_pairs
from wpcal.planning.cell.cell_check import check_cell, mounting_faces
from wpcal.planning.cell.robot_cell import JOINTS, CellState, RobotCell, part_in_world, tool_in_world
from wpcal.planning.plan.run import CellRun
from wpcal.planning.plan.run_record import check_record, tip_record
from wpcal.planning.search.objectives import Objective

BODY = """
<main id="page"></main>
<noscript>This page needs JavaScript to draw the plan; its numbers are in the files beside it.</noscript>
"""
ANGLE_DIGITS, TIME_DIGITS, PLACE_DIGITS = 3, 4, 3  #: The page shows one decimal of a degree, a second and a millimetre.
WIRE_MM = 26.0  #: Drawn length of the wire, from its tip back: the usual stick-out, and the part inside the nozzle.


@dataclass(frozen=True, slots=True, eq=False)
class MethodFront:
    """What one method found by itself."""

    name: str  #: ``ladder`` or ``nsga2``.
    values: FloatArray  #: shape (m, k). Objectives of its m plans, in the order of the page's objectives.
    hypervolume: float  #: Hypervolume that its plans dominate.


def build_plan_page(
    runs: Sequence[CellRun],
    cell: RobotCell,
    objectives: Sequence[Objective],
    *,
    chosen: int,
    fronts: Sequence[MethodFront] = (),
    part_glb: bytes | None = None,
) -> str:
    """Return the page of the trade-off plans of a seam. A self-contained HTML file, the same for the same runs.

    Parameters
    ----------
    part_glb : bytes, optional
        The part's triangles, as `wpcal.brep.mesh_glb.write_part_glb` writes them. Without them the page draws the
        part's collision bodies.

    Raises
    ------
    InputError : If there is no run, the runs are of different seams, or `chosen` is not one of their rows.
    """
    if not 0 <= chosen < len(runs) or len({run.plan.seam for run in runs}) != 1:
        raise InputError(
            f"expected the plans of one seam and one of their rows, got {len(runs)} plans and row {chosen}"
        )
    pairs, names = body_pairs(cell), [objective.name for objective in objectives]
    data = {
        "seam": runs[0].plan.seam,
        "names": names,
        "titles": {objective.name: objective.title for objective in objectives},
        "axes": {"x": names[0], "y": names[-1], "colour": names[1] if len(names) > 2 else None},
        "chosen": chosen,
        "plans": [_plan_record(run) for run in runs],
        "fronts": [_front_record(front, names) for front in fronts],
        "joints": [[joint.name for joint in arm.joints] for arm in (cell.arm1, cell.arm2)],
        "pairs": [list(pairs.names(row)) for row in range(len(pairs))],
        **_cell_record(cell, shows_frames=False),
    }
    blobs = {} if part_glb is None else {"part": part_glb}
    for row, run in enumerate(runs):
        blobs[f"curves-{row}"] = json_blob(_curves(run, cell))
        blobs[f"frames-{row}"] = _frames(cell, run.state).astype("<f4").tobytes()
    return build_page(title=f"Plan of seam {runs[0].plan.seam}", entry="plan", body=BODY, data=data, blobs=blobs)


def build_cell_page(cell: RobotCell) -> str:
    """Return the page of a cell: what its file describes, and what is odd in it.

    Returns str. A self-contained HTML file, the same for the same cell.
    """
    low, high = cell.joint_limits
    joints = np.clip(np.zeros((1, 2 * JOINTS)), low, high)
    state = CellState(joints[:, :JOINTS], joints[:, JOINTS:])
    arms, bases = (cell.arm1, cell.arm2), (cell.T_world_base1, cell.T_world_base2)
    data = {
        **_cell_record(cell, shows_frames=True),
        "kind": "cell of two robots",
        "pose": "all joints at zero, or at the limit that is nearest to zero",
        "robots": [
            {"robot": row + 1, "arm": arm.name, "base": T.t_mm.tolist(), "mount": mount.tolist()}
            for row, (arm, T, mount) in enumerate(zip(arms, bases, mounting_faces(cell), strict=True))
        ],
        "carrierNames": _carrier_names(),
    }
    blobs = {"frames": _frames(cell, state).astype("<f4").tobytes()}
    return build_page(title=f"Cell {cell.name}", entry="cell", body=BODY, data=data, blobs=blobs)


def _carrier_names() -> list[str]:
    links = ["base", *(f"link {link}" for link in range(1, JOINTS)), "flange"]
    return [*(f"robot {robot}, {name}" for robot in (1, 2) for name in links), "tool", "part", "world"]


def _cell_record(cell: RobotCell, *, shows_frames: bool) -> dict[str, Any]:
    """Return what both pages draw of a cell."""
    bases = (cell.T_world_base1, cell.T_world_base2)
    return {
        "cell": cell.name,
        "issues": [issue.to_record() for issue in check_cell(cell)],
        "bodies": [body_record(body, _group(body)) for body in bodies_of(cell)],
        "bases": [T.t_mm.tolist() for T in bases],
        "mounts": [
            {"p": p.tolist(), "x": T.R[:, 0].tolist(), "y": T.R[:, 1].tolist()}
            for T, p in zip(bases, mounting_faces(cell), strict=True)
        ],
        "labels": {"robot1": "robot 1", "robot2": "robot 2"},
        "floor_z_mm": cell.floor_z_mm,
        "frames": [0, JOINTS, JOINTS + 1, 2 * JOINTS + 1, TOOL, PART],
        "showsFrames": shows_frames,
        "carriers": {"count": WORLD + 1, "tool": TOOL, "part": PART},
        "wire_mm": WIRE_MM,
    }


def _front_record(front: MethodFront, names: Sequence[str]) -> dict[str, Any]:
    values = [dict(zip(names, row, strict=True)) for row in front.values.tolist()]
    return {"name": front.name, "hypervolume": front.hypervolume, "values": values}


def _plan_record(run: CellRun) -> dict[str, Any]:
    return {
        "objectives": dict(run.plan.objectives),
        "found_by": run.plan.found_by,
        "freedom": run.verdict.value,
        "check": None if run.check is None else check_record(run.check),
        "schedule": run.schedule.describe(),
        "tip": tip_record(run.tip),
        "between_points": run.tip.describe(run.schedule.speed_mm_s),
    }


def _group(body: Body) -> str:
    groups = {TOOL: "torch", PART: "part", WORLD: "bench"}
    return groups.get(body.carrier, "robot1" if body.owner is Owner.ROBOT1 else "robot2")


def body_record(body: Body, group: str) -> dict[str, Any]:
    """Return a body as the page takes it."""
    shape = body.shape
    record: dict[str, Any] = {
        "name": body.name,
        "group": group,
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


def _curves(run: CellRun, cell: RobotCell) -> dict[str, Any]:
    """Return the curves of one run as columns; values of the weld are null outside the weld."""
    plan, rows = run.plan, slice(run.first, run.last + 1)
    T = np.linalg.inv(part_in_world(cell, run.state.joints2[rows])) @ tool_in_world(cell, run.state.joints1[rows])
    return {
        "t": np.round(run.t_s, TIME_DIGITS).tolist(),
        "s": _column(run.along(plan.s_mm), PLACE_DIGITS),
        "first": run.first,
        "last": run.last,
        "joints1": np.round(np.degrees(run.state.joints1), ANGLE_DIGITS).tolist(),
        "joints2": np.round(np.degrees(run.state.joints2), ANGLE_DIGITS).tolist(),
        **{
            name: _column(np.degrees(run.along(getattr(plan, f"{name}_rad"))), ANGLE_DIGITS)
            for name in ("slope", "rotation", "work", "travel")
        },
        "seam": np.round(T[:, :3, 3], PLACE_DIGITS).tolist(),
        "checked": _checked(run),
    }


def _checked(run: CellRun) -> dict[str, Any] | None:
    check = run.check
    if check is None or not len(check.clearance.pairs):
        return None
    at = np.arange(len(check.s_mm)) / check.refine
    return {
        "t": np.round(np.interp(at, np.arange(len(run)), run.t_s), TIME_DIGITS).tolist(),
        "margin": np.round(check.clearance.margin_mm, PLACE_DIGITS).tolist(),
        "distance": np.round(check.clearance.distance_mm, PLACE_DIGITS).tolist(),
        "pair": check.clearance.pair.tolist(),
    }


def _column(values: FloatArray, digits: int) -> list[float | None]:
    return [None if np.isnan(value) else round(float(value), digits) for value in values]


def _frames(cell: RobotCell, state: CellState) -> FloatArray:
    """Return the upper three rows of every carrier's frame at every state, shape (N, carriers, 3, 4)."""
    frames = [np.broadcast_to(frame.matrices(), (len(state), 4, 4)) for frame in body_frames(cell, state)]
    return np.stack(frames, axis=1)[:, :, :3]
