"""Sweep motions of an arm in its cell: every link, the torch and its wire against part, bench, floor and the arm.

Joints and external axes of the text are taken as they are; on lines and arcs the arm follows in the branch in which it
is, while a rail and a positioner move evenly. Where the positioner turns along seams, the torch is led in the part that
it carries. Between two states no body moves farther than is free around it (`wpcal.planning.sequence.motion_check`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.controllers.judge.swept import Meeting, poses_along
from wpcal.controllers.run.machine import WHOLE_ZONE
from wpcal.controllers.run.trace import Motion
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
LEAST_STATES = 2  #: Of a move.
LIMIT_RAD = 1e-5  #: The same for limits of joints.


Leg = tuple[Motion, FloatArray]  #: A motion with its states, shape (n, k).
Rows = Sequence[FloatArray]  #: States, shapes (n, k).


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
        """What checks moves by the joints: the wire is a body of the torch, but of two robots that weld so."""
        if self.cell.has_two_robots:
            return self._near
        cell = with_wire(self._near.cell, 0.0, self.more_wire_mm)
        return MotionChecker(cell, CellClearance(cell, self.part, like=self._near.clearance))

    def legs(
        self, motions: Sequence[Motion], start: FloatArray | None = None
    ) -> Iterator[tuple[Motion, FloatArray | None]]:
        """Yield motions with their states; None where the arm does not get there.

        `start`: shape (k,). Where it is before, or near to it, rad and mm.
        """
        q = start
        for motion in motions:
            states = self._states(motion, q)
            if states is not None and not np.isfinite(states).all():
                states = None
            q = None if states is None else states[-1]
            yield motion, states

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
        for (_, before), (motion, states), (after, behind) in zip(legs, legs[1:], legs[2:], strict=False):
            if motion.place.blends and motion.kind == after.kind == "J":
                q = np.array([before[-1], states[-1], behind[-1]])
                if not self._air.is_free_between(self.corner(q, *motion.place.zone)):
                    yield Meeting(motion, "the zone at its end is not free")
        free = {is_air: self._is_free(legs, is_air=is_air) for is_air in (True, False)}
        for is_air, group in groupby(legs, key=lambda leg: leg[0].kind == "J"):
            if not free[is_air]:
                yield from self._row(list(group), self._air if is_air else self._near)

    def _is_free(self, legs: Sequence[Leg], *, is_air: bool) -> bool:
        """Tell whether all motions of a kind are free, measured together; otherwise each row is judged alone."""
        rows = [
            np.concatenate([states for _, states in group])
            for kind, group in groupby(legs, key=lambda leg: leg[0].kind == "J")
            if kind == is_air
        ]
        if not rows:
            return True
        states = np.concatenate(rows)
        gaps = np.zeros(len(states) - 1, dtype=bool)
        gaps[np.cumsum([len(each) for each in rows])[:-1] - 1] = True
        if self._beyond(states).any() or len(states) < LEAST_STATES:
            return False
        return (self._air if is_air else self._near).check(states, gaps=gaps).is_free

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
        found = checker.check(states if len(states) > 1 else np.repeat(states, 2, axis=0))
        if not found.is_free:
            row = int(np.argmin(found.margin_mm))
            last = min(int(np.ceil(found.at[row])), len(own) - 1)
            yield Meeting(legs[own[last]][0], f"on the move there {checker.nearest(found.states[row][None])}")

    def _states(self, motion: Motion, q: FloatArray | None) -> FloatArray | None:
        """Return all axes from the start of a motion on, shape (n, k); None where nobody knows them."""
        before = self.external if q is None else q[JOINTS:]
        external = self._external(motion.place.external, before)
        if motion.kind == "J" and motion.joints is not None:
            end = np.concatenate([np.radians(motion.joints), external])
            return np.array([end] if q is None else [q, end])
        goal, via = (
            self._written(T, external) if joints is None else self._led(joints, self._external(outer, external))
            for T, joints, outer in (
                (motion.goal, motion.joints, ()),
                (motion.via, motion.via_joints, motion.place.via_external),
            )
        )
        if goal is None or q is None:
            return None
        if motion.kind == "J":
            return np.concatenate([q[None], self._followed(goal[None], q, external[None])])
        line = replace(motion, start=self._led(np.degrees(q[:JOINTS]), before), goal=goal, via=via)
        T = poses_along(line, STEP_MM, STEP_RAD, least=self._steps(external - before))
        return np.concatenate([q[None], self._followed(T, q, self._outer(before, external, len(T)))])

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

    def _written(self, T: FloatArray | None, external: FloatArray) -> FloatArray | None:
        """Return a pose of the text in what leads the tool."""
        return T if T is None or self.is_carried else inverse_pose(self._guide(external[None])[0]) @ T

    def _led(self, joints_deg: FloatArray, external: FloatArray) -> FloatArray:
        """Return the tool at joints of the arm in what leads it, shape (4, 4)."""
        q = np.concatenate([np.radians(joints_deg), external])[None]
        T_base_tool = product(self.cell.T_world_base.inverse().matrix, self.cell.tool_places(q))
        return np.asarray(product(inverse_pose(self._guide(external[None])), T_base_tool)[0])

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

    def _followed(self, T: FloatArray, q: FloatArray, external: FloatArray) -> FloatArray:
        """Return all axes at poses of the tool, each in the branch nearest to the one before; NaN out of reach.

        `T`, `external`: shapes (n, 4, 4) and (n, k - 6). Poses in what leads the tool, with the external axes there.
        """
        rail = np.concatenate([np.zeros((len(T), JOINTS)), external], axis=1)
        T_base_rest = product(inverse_pose(self.cell.base_places(rail)), self.cell.T_world_base.matrix)
        T_base_tool = product(T_base_rest, product(self._guide(external), T))
        found = solve_inverse(self.cell.arm, T_base_tool @ self.cell.T_flange_tool.inverse().matrix).joints
        near, rows = q[:JOINTS], list[FloatArray]()
        for branches in found:
            turned = branches + TURN * np.rint((near - branches) / TURN)
            off = np.where(np.isfinite(turned).all(axis=1), np.abs(turned - near).max(axis=1), np.inf)
            near = turned[int(np.argmin(off))]
            rows.append(near)
        return np.concatenate([np.array(rows), external], axis=1)


def _looser(cell: Cell) -> Cell:
    near = [shape.to_part_mm for shape in cell.torch]
    torch = [
        shape if mm is None else replace(shape, to_part_mm=mm - DIGITS_MM)
        for shape, mm in zip(cell.torch, near, strict=True)
    ]
    return replace(cell, d1_mm=max(cell.d1_mm - DIGITS_MM, 0.0), torch=tuple(torch))
