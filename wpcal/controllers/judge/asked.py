"""Compare where a program moves the robot with what was asked: every pose in its order, and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from wpcal.controllers.judge.execute import TOOL_OF_CONTROLLER
from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.program.in_run import WeldsAfter
from wpcal.controllers.program.planned import JointMoves
from wpcal.controllers.program.touch_program import TouchProgram
from wpcal.controllers.run.recorder import Motion, Trace
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.tangent import log_rotation
from wpcal.touch.searches import TouchPlan

SAME_MM = 0.05
"""Poses are within this of those that were asked for: a user frame that is typed with three decimals of a degree moves
a point at 2 m by 0.02 mm."""
SAME_RAD = np.radians(0.01)  #: The same for orientations: three formats write three decimals of a degree.
SAME_DEG = 1e-3  #: The same for joints.


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """Where a program should lead, in its order: n poses, or joints."""

    p: FloatArray  #: shape (n, 3). In `base`, mm; NaN for joints.
    R: FloatArray  #: shape (n, 3, 3).
    joints: FloatArray  #: shape (n, 6). deg; NaN where nobody knows them.
    stops: BoolArray  #: shape (n,). Whether the tool stops there: always off the seams.
    #: shape (n,). Whether the tool comes there on a line or an arc; empty where all may be moves by the joints.
    lines: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    home: FloatArray | None = None  #: shape (6,). Where it may begin and end, deg; None: where only the robot knows.
    homes: tuple[int, ...] = ()  #: Rows before which it may go home: a second stage, a weld program.
    #: shape (4, 4). With which tool.
    T_flange_tool: FloatArray = field(default_factory=TOOL_OF_CONTROLLER.copy)
    #: shape (n, e). Where the external axes are, mm and deg; empty where nothing is known of them.
    external: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """What a program does otherwise."""

    missing: tuple[int, ...]  #: Rows of `Asked`.
    others: tuple[Motion, ...]  #: Motions that lead elsewhere.
    bent: tuple[Motion, ...]  #: Motions that do not stop, or are not on a line, where they should.


def asked_of(program: WeldProgram, *, alone: bool = False) -> Asked:
    """Return where a weld program leads; `alone`: also its routines that weld one seam from home and home."""
    rows = [*_rows(program), *(_rows_alone(program) if alone else ())]
    planned = program.planned
    units = np.full(0 if planned is None else planned.axis_count, 180.0 / np.pi)
    units[: planned is not None and planned.rail is not None] = 1.0
    external = np.array([row[4] for row in rows]).reshape(len(rows), len(units)) * units
    p, R, joints, stops = (np.array(each) for each in list(zip(*rows, strict=True))[:4])
    tool = TOOL_OF_CONTROLLER if program.tool_data is None else program.tool_data.matrix
    lines = np.full(len(rows), planned is None)
    starts = np.cumsum([0, *(len(path.p_base) for path in program.paths[:-1])])
    lines[[0] if program.safe_point is not None else starts] = False
    return Asked(p, R, joints, stops, lines, T_flange_tool=tool, external=external)


def asked_of_touches(program: TouchProgram) -> Asked:
    """Return where a touch program leads: after each search it goes back to the start of it."""
    T = program.plan.T_base_part
    p, R = list[FloatArray](), list[FloatArray]()
    for steps in program.steps(T):  # relative to the part itself
        rows = [*range(len(steps.p) - 1), len(steps.p) - 3, len(steps.p) - 1]
        p.append(T.apply(steps.p[rows]))
        R.append(T.R @ steps.R[rows])
    count, home = sum(map(len, p)), program.plan.home_joints
    found = Asked(
        np.concatenate(p),
        np.concatenate(R),
        np.full((count, 6), np.nan),
        np.ones(count, dtype=bool),
        home=None if home is None else np.degrees(home),
        homes=(0 if program.welds is None else sum(map(len, p[: program.welds.stage])),),
    )
    return found if program.welds is None else _with_welds(found, program.welds)


def _with_welds(touches: Asked, welds: WeldsAfter) -> Asked:
    """Return where the searches and the weld program after them lead, with the part as planned."""
    T, after = welds.T_base_part @ welds.program.T_base_part.inverse(), asked_of(welds.program)
    way = [] if welds.way is None else [welds.way]
    p = np.concatenate([touches.p, *(each.p_base for each in way), T.apply(after.p)])
    R = np.concatenate([touches.R, *(each.R_base for each in way), T.R @ after.R])
    joints = np.full((len(p), 6), np.nan)
    stops = np.concatenate([np.ones(len(p) - len(after.p), dtype=bool), after.stops])
    return replace(touches, p=p, R=R, joints=joints, stops=stops, homes=(*touches.homes, len(p) - len(after.p)))


def contacts_of(plan: TouchPlan) -> Callable[[FloatArray], FloatArray | None]:
    """Return from where a search ends, as T_base_tool, where it meets the part as planned; None on a way to a start."""
    T = plan.T_base_part
    ends = T.apply(np.array([search.end - plan.ahead(search) for search in plan.searches]))
    planned = T.apply(np.array([search.planned - plan.ahead(search) for search in plan.searches]))

    def feel(T_base_tool: FloatArray) -> FloatArray | None:
        off = np.linalg.norm(ends - T_base_tool[:3, 3], axis=1)
        found = T_base_tool.copy()
        found[:3, 3] = planned[int(np.argmin(off))]
        return found if off.min() <= SAME_MM else None

    return feel


Row = tuple[FloatArray, FloatArray, FloatArray, bool, FloatArray]
"""Place and axes of the tool, joints in deg, whether the tool stops there, and the external axes, rad and mm."""
NOWHERE, NO_AXIS, NO_JOINTS, NO_AXES = (np.full(shape, np.nan) for shape in ((3,), (3, 3), (6,), (0,)))


def _rows(program: WeldProgram) -> Iterator[Row]:
    planned, safe = program.planned, program.safe_point
    gaps = len(program.paths) + 1
    air = [iter(())] * gaps if planned is None else [_rows_of(moves) for moves in planned.air]
    ends: list[Row] = [] if safe is None else [(safe.p_base[0], safe.R_base[0], NO_JOINTS, True, NO_AXES)]
    yield from ends
    for before, path in zip(air, program.paths, strict=False):
        yield from before
        yield from _rows_along(path, is_planned=planned is not None)
    yield from air[-1]
    yield from ends


def _rows_along(path: WeldPath, *, is_planned: bool) -> Iterator[Row]:
    along = range(path.weld_rows.start + 1, path.weld_rows.stop)
    for row in range(path.before if is_planned else 0, len(path.p_base)):
        joints = NO_JOINTS if not is_planned or path.joints is None else np.degrees(path.joints[row])
        external = NO_AXES if not is_planned or path.external is None else path.external[row]
        yield path.p_base[row], path.R_base[row], joints, row not in along, external


def _rows_alone(program: WeldProgram) -> Iterator[Row]:
    ways = () if program.planned is None else program.planned.ways
    for (to, back), path in zip(ways, program.paths, strict=False):
        if len(to):
            yield from _rows_of(to)
            if path.joints is not None and path.external is not None:
                yield NOWHERE, NO_AXIS, np.degrees(path.joints[0]), True, path.external[0]
            yield from _rows_along(path, is_planned=True)
            yield from _rows_of(back)


def _rows_of(moves: JointMoves) -> Iterator[Row]:
    zones = np.zeros(len(moves)) if moves.zone_mm is None else moves.zone_mm
    rows = zip(np.degrees(moves.joints), zones, moves.external, strict=True)
    yield from ((NOWHERE, NO_AXIS, joints, not mm, external) for joints, mm, external in rows)


def compare(trace: Trace, asked: Asked) -> Compared:
    """Return where a program leads that was not asked, and where it does not lead."""
    at, missing, others, bent = 0, list[int](), list[Motion](), list[Motion]()
    for before, motion in zip((None, *trace.motions), trace.motions, strict=False):
        if _stands(motion, before, flows=_flows(asked, at)):
            continue
        first, last = _matches(motion, asked, at) or (at, None)
        if last is None:
            if at not in (0, *asked.homes, len(asked.p)) or not _is_home(motion, asked):
                others.append(motion)
            continue
        missing += range(at, first)
        if _is_bent(motion, asked, last):
            bent.append(motion)
        at = last + 1
    missing += range(at, len(asked.p))
    return Compared(tuple(row for row in missing if not _repeats(asked, row)), tuple(others), tuple(bent))


def _is_bent(motion: Motion, asked: Asked, row: int) -> bool:
    """Tell whether a motion does not stop, or is not on a line, where it should."""
    is_off_line = motion.kind == "J" and asked.lines[row : row + 1].any()
    return bool(is_off_line or (motion.place.blends and asked.stops[row]))


def _flows(asked: Asked, at: int) -> bool:
    """Tell whether the tool need not stop where it is: before row `at`."""
    return at > 0 and not asked.stops[at - 1] and not _repeats(asked, at)


def _repeats(asked: Asked, row: int) -> bool:
    """Tell whether a program should stay where it is."""
    if (
        not 0 < row < len(asked.p)
        or np.abs(np.diff(asked.external[row - 1 : row + 1], axis=0)).max(initial=0.0) > SAME_DEG
    ):
        return False
    if np.isfinite(asked.joints[row]).all():
        return bool(np.abs(asked.joints[row] - asked.joints[row - 1]).max() <= SAME_DEG)
    return _is_within(asked.p[row] - asked.p[row - 1], asked.R[row] - asked.R[row - 1])


def _is_within(p: FloatArray, R: FloatArray) -> bool:
    return bool(np.abs(p).max() <= SAME_MM and np.abs(R).max() <= SAME_RAD)


def _has_tool(motion: Motion, asked: Asked) -> bool:
    """Tell whether a motion to a pose is one of the tool that was asked for."""
    off = motion.T_flange_tool - asked.T_flange_tool
    return motion.goal is None or _is_within(off[:3, 3], off[:3, :3])


def _has_axes(motion: Motion, asked: Asked, row: int) -> bool:
    """Tell whether the external axes come to where they should; a text without them is right while they stand."""
    if not asked.external.size:
        return True
    given = motion.place.external[: asked.external.shape[1]]
    if len(given) < asked.external.shape[1]:
        return not np.ptp(asked.external, axis=0).any()
    return bool(np.abs(asked.external[row] - given).max() <= SAME_DEG)


def _is_home(motion: Motion, asked: Asked) -> bool:
    if motion.joints is None or asked.home is None:
        return motion.goal is None and motion.joints is None
    return bool(np.abs(motion.joints - asked.home).max() <= SAME_DEG)


def _stands(motion: Motion, before: Motion | None, *, flows: bool) -> bool:
    """Tell whether a motion leads to where the tool is, and stops there unless it `flows`: arcs may begin so."""
    moves_axes = before is not None and motion.place.external != before.place.external
    if moves_axes or motion.place.blends > flows or motion.via is not None or motion.via_joints is not None:
        return False
    if motion.joints is not None:
        joints = None if before is None else before.joints
        return joints is not None and bool(np.abs(motion.joints - joints).max() <= SAME_DEG)
    return motion.kind != "J" and _stays(motion)


def _stays(motion: Motion) -> bool:
    if motion.start is None or motion.goal is None:
        return False
    off = motion.goal - motion.start
    return _is_within(off[:3, 3], off[:3, :3])


def _matches(motion: Motion, asked: Asked, at: int) -> tuple[int, int] | None:
    """Return the first rows from `at` on that a motion leads to: middle and end of an arc, or twice the same."""
    if not _has_tool(motion, asked):
        return None
    near = _near if motion.joints is None else _near_joints
    goal, via = (motion.goal, motion.via) if motion.joints is None else (motion.joints, motion.via_joints)
    for row in [] if goal is None else near(goal, asked, at):
        if not _has_axes(motion, asked, row):
            continue
        if via is None:
            return row, row
        if row > at and row - 1 in near(via, asked, row - 1)[:1]:
            return row - 1, row
    return None


def _near_joints(q: FloatArray, asked: Asked, at: int) -> Sequence[int]:
    return (at + np.flatnonzero(np.abs(asked.joints[at:] - q).max(axis=1, initial=0.0) <= SAME_DEG)).tolist()


def _near(q: FloatArray, asked: Asked, at: int) -> Sequence[int]:
    rows = at + np.flatnonzero(np.linalg.norm(asked.p[at:] - q[:3, 3], axis=1) <= SAME_MM)
    if not len(rows):
        return []
    turns = np.linalg.norm(log_rotation(asked.R[rows].transpose(0, 2, 1) @ q[:3, :3]), axis=-1)
    return [int(row) for row in rows[turns <= SAME_RAD]]
