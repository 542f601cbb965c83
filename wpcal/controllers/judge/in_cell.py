"""Sweep motions of an arm in its cell: every link, the torch and its wire against part, bench, floor and the arm.

Joints and external axes of the text are taken as they are; on lines and arcs the arm follows in the branch in which it
is, while a rail and a positioner move evenly. Where the positioner turns along seams, the torch is led in the part that
it carries. Between two states no body moves farther than is free around it (`wpcal.planning.sequence.motion_check`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate, groupby, pairwise

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.controllers.judge.swept import LARGEST_MOVE_MM, Meeting, poses_along
from wpcal.controllers.run.machine import WHOLE_ZONE
from wpcal.controllers.run.recorder import Motion
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import GeometryError
from wpcal.core.same_bits import inverse_pose, product
from wpcal.planning.cell.bodies import with_torch_at, with_wire
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.plan.coordinated import HolderMove, HolderPath
from wpcal.planning.sequence.kept_plan import shown_units
from wpcal.planning.sequence.motion_check import MotionChecker
from wpcal.robot.kinematics.inverse import TURN, solve_inverse

STEP_MM = 5.0  #: Between two states on a line the joints turn so little that the tool keeps to it within 0.01 mm.
STEP_RAD = np.radians(2.0)  #: The same where the tool turns.
DIGITS_MM = 0.1  #: The text has fewer digits than the plan; safety distances are kept within this.
PARTS_OF_HALF = 100  #: Of the half of a move before a corner: how finely the end of its zone is found.
LEAST_ZONE_MM = 1.0  #: A smaller zone saves no time.
ROOM_OF_ZONE = 0.45  #: Of a move: the zones at both of its ends do not meet.
LIMIT_RAD = 1e-5  #: The same for limits of joints.


Leg = tuple[Motion, FloatArray]  #: A motion with its states, shape (n, k).
Rows = Sequence[FloatArray]  #: States, shapes (n, k).
Way = tuple[FloatArray, FloatArray]  #: Poses in what leads the tool and the external axes there, (n, 4, 4), (n, k - 6).


@dataclass(frozen=True)
class CellSweep:
    """What sweeps the motions of a program in its cell."""

    cell: Cell  #: With the part in its place.
    part: TriangleMaterial | None  #: In `part`.
    external: FloatArray  #: shape (k - 6,). Where the external axes are at first, rad and mm.
    more_wire_mm: float = 0.0  #: How far the longest wire of a seam sticks out beyond the tool centre point.
    has_moving_axes: bool = False  #: Whether external axes move.
    follows: bool = False  #: Whether the positioner turns along a seam.
    is_carried: bool = True  #: Whether positions of the text are then in the part, as of `PlannedMoves`.
    holder_on_line: bool = False  #: Whether a second robot leads the part on lines, and not by its joints.

    @classmethod
    def of(cls, cell: Cell, part: TriangleMaterial | None, air: Rows, seams: Rows, more_mm: float = 0.0) -> CellSweep:
        """Return what sweeps a plan with these states between and along the seams."""
        external = np.concatenate([*air, *seams])[:, JOINTS:]
        follows = any(np.ptp(q[:, cell.first_turning :], axis=0).any() for q in seams)
        return cls(cell, part, external[0], more_mm, bool(np.ptp(external, axis=0).any()), follows)

    @cached_property
    def _near(self) -> MotionChecker:
        """What checks lines and arcs: the torch may come as near as it does at seams."""
        cell = _looser(self.cell)
        cell = cell if cell.has_two_robots else with_torch_at(cell, -DIGITS_MM)
        return MotionChecker(cell, CellClearance(cell, self.part))

    @cached_property
    def _air(self) -> MotionChecker:
        """What checks moves through the air: the wire is a body of the torch."""
        cell = with_wire(self._near.cell, 0.0, self.more_wire_mm)
        return MotionChecker(cell, CellClearance(cell, self.part, like=self._near.clearance))

    @cached_property
    def _free_ways(self) -> dict[bool, FreeWays]:
        """What tells whether moves are free, by whether they are moves by the joints."""
        return {True: FreeWays(self._air), False: FreeWays(self._near)}

    def legs(
        self, motions: Sequence[Motion], start: FloatArray | None = None
    ) -> Iterator[tuple[Motion, FloatArray | None]]:
        """Yield motions with their states; None where the arm does not get there.

        `start`: shape (k,). Where it is before, or near to it, rad and mm.
        """
        before = self.external if start is None else start[JOINTS:]
        outer = list(accumulate(motions, lambda at, one: self._external(one.place.external, at), initial=before))
        ways, q = self._followed(self._ways(motions, outer, start)), start
        for row, motion in enumerate(motions):
            states = np.full((1, len(self.cell.home)), np.nan)
            if motion.kind == "J" and motion.joints is not None:
                end = np.concatenate([np.radians(motion.joints), outer[row + 1]])
                states = np.array([end] if q is None else [q, end])
            elif q is not None and row in ways:
                external, branches = ways[row]
                followed = np.concatenate([_nearest(branches, q[:JOINTS]), external], axis=1)
                states = np.concatenate([q[None], followed])
            q = states[-1] if np.isfinite(states).all() else None
            yield motion, None if q is None else states

    def meetings(self, motions: Sequence[Motion], start: FloatArray | None = None) -> Iterator[Meeting]:
        """Yield where motions are not free, in their order; after the first of a row of like motions the next row.

        `start`: shape (k,). As for `legs`, rad and mm.
        """
        legs = list[Leg]()
        for motion, states in self.legs(motions, start):
            if states is None:
                yield Meeting(motion, "the arm does not get there in the branch in which it is")
            else:
                legs.append((motion, states))
        if legs and self.cell.goes_from_home and (what := self._way_from_home(legs[0][1][-1])):
            yield Meeting(legs[0][0], f"on the way there from home {what}")
        air = self._through_air([motion for motion, _ in legs])
        yield from self._corners(legs, air)
        groups = [
            (is_air, [leg for _, leg in group])
            for is_air, group in groupby(zip(air, legs, strict=True), key=lambda pair: pair[0])
        ]
        free = {kind: self._is_free([group for is_air, group in groups if is_air == kind], kind) for kind in set(air)}
        for is_air, group in groups:
            if not free[is_air]:
                yield from self._row(group, self._air if is_air else self._near)

    def _corners(self, legs: Sequence[Leg], air: Sequence[bool]) -> Iterator[Meeting]:
        """Yield moves by the joints whose zones, in which the next one begins, are not free."""
        for row, ((_, before), (motion, states), (after, behind)) in enumerate(
            zip(legs, legs[1:], legs[2:], strict=False)
        ):
            if motion.place.blends and motion.kind == after.kind == "J":
                q = np.array([before[-1], states[-1], behind[-1]])
                checker = self._air if all(air[row + 1 : row + 3]) else self._near
                if not checker.is_free_between(self.corner(q, *motion.place.zone)):
                    yield Meeting(motion, "the zone at its end is not free")

    def is_free_along(self, T: FloatArray, vias: FloatArray, axes: FloatArray) -> bool:
        """Tell whether lines and arcs are free.

        `T`, `axes`: shapes (m, 4, 4) and (m, k). Where they begin and end, as `PlannedMoves.is_carried` positions are.
        `vias`: shape (m - 1, 3). Points on arcs; NaN for lines.
        """
        ways = dict(enumerate(self._lines(T[:-1], T[1:], vias, [*pairwise(axes[:, JOINTS:])])))
        rows = [np.column_stack([_nearest(q, axes[row, :JOINTS]), at]) for row, (at, q) in self._followed(ways).items()]
        states = np.concatenate(rows)
        is_there = np.isfinite(states).all() and not self._beyond(states).any()
        return bool(is_there and self._near.check(states).is_free)

    def _through_air(self, motions: Sequence[Motion]) -> list[bool]:
        """Tell which moves by the joints lead through the air: two robots weld so, and go so to and from the seam."""
        if not self.cell.has_two_robots:
            return [motion.kind == "J" for motion in motions]
        seams = [0, *(motion.seam for motion in motions), 0]
        return [motion.kind == "J" and not any(seams[row : row + 3]) for row, motion in enumerate(motions)]

    def _way_from_home(self, q: FloatArray) -> str:
        """Say what meets what where all axes go from home to `q`, shape (k,), evenly; empty where nothing does."""
        found = self._air.check(np.array([self.cell.home, q]))
        return "" if found.is_free else self._air.nearest(found.states[[int(np.argmin(found.margin_mm))]])

    def _is_free(self, groups: Sequence[Sequence[Leg]], is_air: bool) -> bool:
        """Tell whether all motions of a kind are free, measured together; otherwise each row is judged alone.

        What the text of another language did before, within the digits of both, is not measured again.
        """
        rows = [
            np.concatenate([states[row > 0 and len(states) > 1 :] for row, (_, states) in enumerate(group)])
            for group in groups
        ]
        if not rows:
            return True
        states = np.concatenate(rows)
        gaps = np.zeros(len(states) - 1, dtype=bool)
        gaps[np.cumsum([len(each) for each in rows])[:-1] - 1] = True
        if self._beyond(states).any():
            return False
        return self._free_ways[is_air].is_free(states, gaps)

    def _beyond(self, states: FloatArray) -> BoolArray:
        """Tell at which states a joint is beyond its limits, shape (n,)."""
        low, high = self.cell.limits
        return np.asarray(((states < low - LIMIT_RAD) | (states > high + LIMIT_RAD)).any(axis=1))

    def _row(self, legs: Sequence[Leg], checker: MotionChecker) -> Iterator[Meeting]:
        """Yield the first place of motions that follow one another."""
        states = np.concatenate([each for _, each in legs])
        own = np.repeat(np.arange(len(legs)), [len(each) for _, each in legs])
        beyond = self._beyond(states)
        if beyond.any():
            yield Meeting(legs[own[int(np.argmax(beyond))]][0], "a joint is beyond its limits")
            return
        found = checker.check(states)
        if not found.is_free:
            row = int(np.argmin(found.margin_mm))
            last = min(int(np.ceil(found.at[row])), len(own) - 1)
            yield Meeting(legs[own[last]][0], f"on the move there {checker.nearest(found.states[row][None])}")

    def _ways(self, motions: Sequence[Motion], outer: Rows, start: FloatArray | None) -> dict[int, Way]:
        """Return where motions lead the tool, by their rows; not from or to unknown places.

        `outer`: shapes (k - 6,). The external axes before all motions, and after each.
        """
        at_via = [self._external(each.place.via_external, end) for each, end in zip(motions, outer[1:], strict=True)]
        goals = self._places([(each.goal, each.joints) for each in motions], outer[1:])
        vias = self._places([(each.via, each.via_joints) for each in motions], at_via)
        first = None if start is None else np.degrees(start[:JOINTS])
        starts = np.concatenate([self._places([(None, first)], outer[:1]), goals[:-1]])
        is_near = np.linalg.norm(goals[:, :3, 3] - starts[:, :3, 3], axis=1) <= LARGEST_MOVE_MM
        is_line = np.array([motion.kind != "J" for motion in motions], dtype=bool)
        lines = np.flatnonzero(is_near & is_line).tolist()
        axes = [(outer[row], outer[row + 1]) for row in lines]
        along = self._lines(starts[lines], goals[lines], vias[lines, :3, 3], axes)
        ways = {row: (goals[row][None], outer[row + 1][None]) for row in np.flatnonzero(is_near & ~is_line).tolist()}
        return ways | {row: (T[1:], external[1:]) for row, (T, external) in zip(lines, along, strict=True)}

    def _lines(
        self, starts: FloatArray, goals: FloatArray, vias: FloatArray, axes: Sequence[tuple[FloatArray, FloatArray]]
    ) -> list[Way]:
        """Return lines and arcs step by step; `axes`: the external axes at both ends of each."""
        least = np.array([self._steps(after - before) for before, after in axes])
        along = poses_along(starts, goals, vias, STEP_MM, STEP_RAD, least)
        return [(T, self._outer(*ends, len(T))) for T, ends in zip(along, axes, strict=True)]

    def _places(self, written: Sequence[tuple[FloatArray | None, FloatArray | None]], external: Rows) -> FloatArray:
        """Return places in what leads the tool, shape (n, 4, 4), of poses or of joints, deg, in a text; else NaN."""
        T = np.full((len(written), 4, 4), np.nan)
        q = np.column_stack([np.full((len(written), JOINTS), np.nan), external])
        for row, (pose, joints_deg) in enumerate(written):
            if joints_deg is not None:
                q[row, :JOINTS] = np.radians(joints_deg)
            elif pose is not None:
                T[row] = pose
        T_part_base = inverse_pose(self._guide(q[:, JOINTS:]))
        T = T if self.is_carried else product(T_part_base, T)
        T_base_tool = product(self.cell.T_world_base.inverse().matrix, self.cell.tool_places(q))
        return np.where(np.isnan(q[:, :1, None]), T, product(T_part_base, T_base_tool))

    def _outer(self, before: FloatArray, external: FloatArray, count: int) -> FloatArray:
        """Return external axes from place to place, shape (count, k - 6): evenly, or as a line of the part asks."""
        if not self.holder_on_line:
            return np.linspace(before, external, count)
        ends = np.array([before, external])
        way = HolderPath(self.cell, np.array([0.0, 1.0]), ends, np.zeros((2, 3)), HolderMove.LINE)
        try:
            return way.joints_between(0.0, 1.0, np.linspace(0.0, 1.0, count))
        except GeometryError:
            return np.full((count, len(before)), np.nan)

    def _external(self, stated: Sequence[float], before: FloatArray) -> FloatArray:
        """Return where a motion brings the external axes, shape (k - 6,), rad and mm; not stated, they stay."""
        given = np.array(stated[: len(before)])
        return np.asarray(given / shown_units(self.cell)[JOINTS:] if len(given) == len(before) else before)

    def _steps(self, moved: FloatArray) -> float:
        """Return in how many steps external axes move as little as the tool on a line."""
        step = np.full(len(moved), STEP_RAD)
        step[: self.cell.first_turning - JOINTS] = STEP_MM
        return float((np.abs(moved) / step).max(initial=0.0))

    def _guide(self, external: FloatArray) -> FloatArray:
        """Return in what the tool is led, in the base at 0 mm of the rail, for external axes (n, k - 6); (n, 4, 4)."""
        if not self.follows:
            return np.broadcast_to(np.eye(4), (len(external), 4, 4))
        q = np.concatenate([np.zeros((len(external), JOINTS)), external], axis=1)
        return product(self.cell.T_world_base.inverse().matrix, self.cell.carrier_places(q))

    def corner(self, q: FloatArray, zone_mm: float, share: float) -> FloatArray:
        """Return states whose hull has every state of a rounded corner, shape (3, k).

        The tool leaves the first move where its centre point is within the zone, and is back on the second by its half.

        `q`: shape (3, k). Before, at and after the corner.
        """
        left = max(np.flatnonzero(self._inside(q, zone_mm)).tolist(), default=-1) + 1
        share = min(left / PARTS_OF_HALF * WHOLE_ZONE, share)
        return np.array([self._back(q, share), q[1], self._back(q[::-1], WHOLE_ZONE)])

    @staticmethod
    def _back(q: FloatArray, share: float) -> FloatArray:
        return np.asarray(q[1] + share * (q[0] - q[1]))

    def _inside(self, q: FloatArray, zone_mm: float) -> BoolArray:
        """Tell at which places of the half before a corner the tool is within a zone."""
        shares = np.linspace(0.0, WHOLE_ZONE, PARTS_OF_HALF + 1)[1:]
        p = self.cell.tool_places(np.array([self._back(q, share) for share in (0.0, *shares)]))[:, :3, 3]
        return np.asarray(np.linalg.norm(p[1:] - p[0], axis=1) <= zone_mm)

    def zones(self, q: FloatArray, *, most_mm: float) -> tuple[FloatArray, FloatArray]:
        """Return the largest free zones at joint moves through states of shape (m, k): mm, and shares of the moves.

        A zone is `most_mm`, or a half of it, and so on; zones of neighbours do not meet. Both ends have none.
        """
        mm, shares = np.zeros(len(q)), np.zeros(len(q))
        p = self.cell.tool_places(q)[:, :3, 3]
        room = np.linalg.norm(np.diff(p, axis=0), axis=1) * ROOM_OF_ZONE
        for row in range(1, len(q) - 1):
            zone_mm, around = most_mm, q[row - 1 : row + 2]
            while zone_mm >= LEAST_ZONE_MM:
                is_free = zone_mm <= room[row - 1 : row + 1].min()
                if is_free and self._air.is_free_between(self.corner(around, zone_mm, WHOLE_ZONE)):
                    first_out = int(np.argmin([*self._inside(around, zone_mm), False]))
                    mm[row], shares[row] = zone_mm, first_out / PARTS_OF_HALF * WHOLE_ZONE
                    break
                zone_mm /= 2.0
        return mm, shares

    def _followed(self, ways: Mapping[int, Way]) -> dict[int, tuple[FloatArray, FloatArray]]:
        """Return the external axes along each way and all branches of the arm there, (n, 8, 6): NaN out of reach."""
        if not ways:
            return {}
        T, external = (np.concatenate(each) for each in zip(*ways.values(), strict=True))
        rail = np.concatenate([np.zeros((len(T), JOINTS)), external], axis=1)
        T_base_rest = product(inverse_pose(self.cell.base_places(rail)), self.cell.T_world_base.matrix)
        T_base_tool = product(T_base_rest, product(self._guide(external), T))
        flange = T_base_tool @ self.cell.T_flange_tool.inverse().matrix
        known = np.isfinite(flange).all(axis=(1, 2))
        found = solve_inverse(self.cell.arm, flange[known]).joints
        branches = np.full((len(T), *found.shape[1:]), np.nan)
        branches[known] = found
        ends = np.cumsum([len(each) for each, _ in ways.values()])[:-1]
        return dict(zip(ways, zip(np.split(external, ends), np.split(branches, ends), strict=True), strict=True))


def _nearest(branches: FloatArray, near: FloatArray) -> FloatArray:
    """Return at each place of (n, 8, 6) the branch that is nearest to the one before, shape (n, 6)."""
    rows = list[FloatArray]()
    for each in branches:
        turned = each + TURN * np.rint((near - each) / TURN)
        off = np.where(np.isfinite(turned).all(axis=1), np.abs(turned - near).max(axis=1), np.inf)
        near = turned[int(np.argmin(off))]
        rows.append(near)
    return np.array(rows)


def _looser(cell: Cell) -> Cell:
    near = [shape.to_part_mm for shape in cell.torch]
    torch = [
        shape if mm is None else replace(shape, to_part_mm=mm - DIGITS_MM)
        for shape, mm in zip(cell.torch, near, strict=True)
    ]
    return replace(cell, d1_mm=max(cell.d1_mm - DIGITS_MM, 0.0), torch=tuple(torch))


MOST_MM = 0.05  #: Texts of one plan differ less, by their digits.


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """States that were measured and are free, shape (n, k), and least margins from each to the next, shape (n,), mm."""

    states: FloatArray
    margin_mm: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FreeWays:
    """Checks rows of moves, and does not measure again what is nearer to a free row than that is to anything."""

    checker: MotionChecker
    _ways: list[_Way] = field(default_factory=list)

    def is_free(self, states: FloatArray, gaps: BoolArray) -> bool:
        """Tell whether moves are free. `states`, `gaps`: shapes (n, k) and (n - 1,). As of `MotionChecker.check`."""
        gaps = np.append(gaps, True)
        for way in self._ways:
            if way.states.shape == states.shape:
                is_open = ~self._is_within(way, states, gaps)
                kept = is_open | np.append(False, (is_open & ~gaps)[:-1])
                rows = np.flatnonzero(kept)
                apart = (np.diff(rows) > 1) | ~is_open[rows[:-1]] | gaps[rows[:-1]]
                return not len(rows) or self.checker.check(states[rows], gaps=apart).is_free
        found = self.checker.check(states, gaps=gaps[:-1])
        if found.is_free:
            starts = np.searchsorted(found.at, np.arange(len(states)))
            self._ways.append(_Way(states, np.minimum.reduceat(found.margin_mm, starts)))
        return found.is_free

    def _is_within(self, way: _Way, states: FloatArray, gaps: BoolArray) -> BoolArray:
        """Tell of each state and the move to the next whether bodies are nearer to the way than that is to others."""
        off_mm = self.checker.motion_mm(states, way.states)
        after = [np.where(gaps, each, np.append(each[1:], each[-1])) for each in (off_mm, way.margin_mm)]
        return np.asarray(np.maximum(off_mm, after[0]) < np.minimum(np.minimum(way.margin_mm, after[1]), MOST_MM))
