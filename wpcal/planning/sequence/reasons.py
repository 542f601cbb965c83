"""Why a stretch of a seam cannot be welded: the torch, the reach, a limit of a joint, a configuration, or a body."""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.workplace import reach_shortage
from wpcal.planning.sequence.external import external_axes, values_along
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import SeamTask
from wpcal.planning.sequence.torch_poses import TorchPoses, torch_poses

TRIED_AXES = 16  #: Positions of the external axes that a reason is looked for at: the most promising ones.
TESTED = 64  #: Joints whose clearance is measured for a reason.


def find_reason(search: SeamSearch, stretch: SeamTask) -> str:
    """Return why no way welds a stretch, and where on the seam, for people."""
    poses = torch_poses(stretch, search.targets, search.clearance, tilted=True)
    free = poses.is_free.any(axis=1)
    if not free.all():
        where = _at(stretch, poses, int(np.argmin(free)))
        return f"the torch meets the part at every angle within its range{where}"
    values = external_axes(search.cell, stretch, search.targets).values[:TRIED_AXES]
    joints, usable = search.states(stretch, poses, values)
    along = values_along(values, stretch, poses.rungs)
    reached = usable.any(axis=(2, 3)).any(axis=0)
    if not reached.all():
        rung = int(np.argmin(reached))
        return f"{_unreached(search, poses, along, joints, rung)}{_at(stretch, poses, rung)}"
    return _body_in_the_way(search, stretch, poses, along, joints, usable)


def _at(stretch: SeamTask, poses: TorchPoses, rung: int) -> str:
    return f", at {stretch.s_mm[poses.rungs[rung]]:.0f} mm"


def _unreached(search: SeamSearch, poses: TorchPoses, along: FloatArray, joints: FloatArray, rung: int) -> str:
    """Return why no branch reaches a rung."""
    free = poses.is_free[rung]
    q = joints[:, rung][:, free]  # (C, K', 8, 6)
    reached = np.isfinite(q).all(axis=-1)
    if not reached.any():
        at = np.repeat(along[:, rung : rung + 1], int(free.sum()), axis=1)
        T = search.flange_places(poses.T_part_tool[rung][free], at).reshape(-1, 4, 4)
        short = float(reach_shortage(search.cell.arm, T).min())
        return f"out of reach of {search.cell.arm.name}, by {short:.0f} mm at least"
    return _limit(search.cell, q[reached])


def _limit(cell: Cell, q: FloatArray) -> str:
    """Name the joint that is nearest to letting joints (r, 6) within its limits."""
    low, high = cell.arm.limits
    turned = q - 2 * np.pi * np.rint((q - (low + high) / 2) / (2 * np.pi))
    beyond = np.maximum(np.maximum(low - turned, turned - high), 0.0)
    row = int(np.argmin(beyond.max(axis=1)))
    joint = int(np.argmax(beyond[row]))
    if beyond[row, joint] == 0.0:
        return "only singular poses reach it (the wrist, the elbow or the arm is stretched)"
    least, most = np.degrees(cell.arm.limits[:, joint])
    at, name = np.degrees(turned[row, joint]), cell.arm.joints[joint].name
    return f"joint {name} would be at {at:.0f} deg, its limits are {least:g} and {most:g} deg"


def _body_in_the_way(
    search: SeamSearch,
    stretch: SeamTask,
    poses: TorchPoses,
    along: FloatArray,
    joints: FloatArray,
    usable: BoolArray,
) -> str:
    """Name the two bodies that are too near at the best state of the worst rung."""
    worst: tuple[float, str, int] | None = None
    for rung in range(joints.shape[1]):
        c, k, b = np.nonzero(usable[:, rung])
        rows = np.linspace(0, len(c) - 1, min(TESTED, len(c))).astype(int)
        q = np.concatenate([joints[c[rows], rung, k[rows], b[rows]], along[c[rows], rung]], axis=1)
        found = search.clearance.margins(q)
        best = int(np.argmax(found.margin_mm))
        margin = float(found.margin_mm[best])
        if worst is None or margin < worst[0]:
            one, two = search.clearance.names(int(found.pair[best]))
            worst = (margin, f"{one} against {two}, which miss their safety distance by {-margin:.0f} mm at best", rung)
    if worst is None or worst[0] > 0.0:
        return _change_of_configuration(search, stretch, poses, joints, usable)
    return f"a body is in the way: {worst[1]}{_at(stretch, poses, worst[2])}"


def _change_of_configuration(
    search: SeamSearch, stretch: SeamTask, poses: TorchPoses, joints: FloatArray, usable: BoolArray
) -> str:
    """Say how far the best branch gets, and what ends it."""
    ways = np.asarray(usable.any(axis=2))  # (C, m, 8)
    m = ways.shape[1]
    prefix = np.where(ways.all(axis=1), m, np.argmin(ways, axis=1))
    c, b = np.unravel_index(int(np.argmax(prefix)), prefix.shape)
    rung = int(prefix[c, b])
    what = "the arm would have to change its configuration"
    if rung == m:  # it reaches every rung, but not along the seam
        return f"{what} on the way: its states at neighbouring points are too far apart, or a body is between them"
    q = joints[c, rung, poses.is_free[rung], b]
    q = q[np.isfinite(q).all(axis=-1)]
    end = _limit(search.cell, q) if len(q) else "the configuration it has does not reach it"
    return f"{what}{_at(stretch, poses, rung)}: {end}"
