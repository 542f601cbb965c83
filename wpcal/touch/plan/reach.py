"""The arm that makes the searches: which of them it reaches, with which joints, and its ways between them.

During a search the arm keeps one branch of its inverse kinematics. Between searches it moves straight in its joints;
where that is not free, `wpcal.planning.sequence.air_path` finds another way. Every move in the air is proved free of
the part and of all bodies of the cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import LEAST_REGULARITY, regularity
from wpcal.planning.sequence.air_path import AirPlanner
from wpcal.planning.sequence.motion_check import MotionChecker
from wpcal.planning.sequence.order import axis_seconds
from wpcal.robot.kinematics.inverse import solve_inverse, turn_into_limits
from wpcal.touch.plan.displaced import STEP_MM, STEP_RAD
from wpcal.touch.plan.free import Strokes
from wpcal.touch.plan.order import LEVELS_MM, Air, shortest_order
from wpcal.touch.searches import Search, SearchKind, TouchPlan

SPINS = 12  #: Turns of the tool about the wire that are tried.
MOST_TURN_RAD = math.radians(40.0)
"""No joint turns by more between the approach and the start, or along the stroke: the branch would be near its end."""
MOST_RISE_RAD = math.radians(90.0)
"""No joint turns by more between an approach and the place above it: that would be another branch."""
ALONG = (0.0, 1 / 3, 2 / 3, 1.0)  #: Places on a straight way at which the bodies are measured: 10 mm apart.
TRIED = 6  #: Of the ways to hold the tool this many are compared with the bodies, those nearest to home.


@dataclass(frozen=True, slots=True, eq=False)
class ArmReach:
    """One arm in its cell with the part."""

    cell: Cell  #: With the part where it stands; its tool is the tip of the wire.
    clearance: CellClearance  #: With the part.
    around: CellClearance  #: Without the part, which the wire meets on its way.
    T_base_part: RigidTransform

    @classmethod
    def of(cls, cell: Cell, T_base_part: RigidTransform | None, part: TriangleMaterial | None) -> ArmReach:
        """Place the part in a cell.

        Raises `InputError` when neither the cell nor the caller knows the place of the part.
        """
        if T_base_part is not None:
            cell = cell.with_touched_part(T_base_part)
        q = _states(cell, cell.home[None, :JOINTS])
        T = np.linalg.inv(cell.base_places(q)[0]) @ cell.part_places(q)[0]
        place = RigidTransform.from_matrix(T, target="base", source="part")
        return cls(cell, CellClearance(cell, part), CellClearance(cell, None), place)

    @property
    def up_base(self) -> tuple[float, float, float]:
        """Direction against gravity in `base`."""
        x, y, z = (float(v) for v in self.cell.T_world_base.R[2])
        return x, y, z

    def turned(self, strokes: Strokes) -> tuple[Strokes, tuple[str, ...]]:
        """Turn the tool about the wire so that the arm reaches; leave out what it cannot reach.

        Returns `notes`: tuple of str. What was left out.
        Raises `GeometryError` when the arm reaches none.
        """
        points = np.stack([strokes.approach, strokes.at(strokes.before_mm), strokes.at(-strokes.after_mm)], axis=1)
        held = self._held(points, strokes.contacts.wire, strokes.bend, SPINS)
        rows = np.flatnonzero(held.reached)
        if len(rows) == 0:
            first = points[0, 1]
            at = " ".join(f"{v:.0f}" for v in self.T_base_part.apply(first))
            raise GeometryError(
                f"{self.cell.arm.name} reaches no start of a search, such as ({at}) in its base: {held.why}; move the "
                "part (`wpcal place`), or look at the tool",
                code=ErrorCode.JOINT_PATH,
            )
        some = strokes.select(rows)
        left = len(strokes) - len(rows)
        notes = () if left == 0 else (f"{self.cell.arm.name} does not reach {left} of {len(strokes)} searches",)
        return Strokes(some.contacts, some.radius_mm, some.before_mm, some.after_mm, held.bend[rows]), notes

    def with_joints(self, plan: TouchPlan, air: Air) -> TouchPlan:
        """Return the plan in the shortest order of the arm, with its joints and the ways between the searches.

        Raises `GeometryError` when a search of the plan is not reached, or no free way leads to it.
        """
        joints = [self._of_search(search) for search in plan.searches]
        posts = [k for k, search in enumerate(plan.searches) if search.kind is SearchKind.POST]
        others = [k for k in range(len(joints)) if k not in posts]
        home = self.cell.home
        at = np.stack([home, *(self._whole(joints[k][1][0]) for k in others)])
        n = len(at)
        first, second = np.indices((n, n)).reshape(2, -1)
        cost = axis_seconds(at[first], at[second], self.cell.speeds).reshape(n, n)
        order = [*posts, *(others[k - 1] for k in shortest_order(cost, first=0)[1:].tolist())]
        planner = AirPlanner(self.cell, MotionChecker(self.cell, self.clearance))
        searches, before, number = list[Search](), home, 0
        for k in order:
            search, own = joints[k]
            way = self._safe_way(planner, air, before, self._whole(own[0]), search.name)
            number += search.kind is SearchKind.PART
            name = f"T{number}" if search.kind is SearchKind.PART else search.name
            via = way[1:-1]
            searches.append(replace(search, name=name, via=self._places(via), via_joints=via[:, :JOINTS], joints=own))
            before = self._whole(own[0])
        notes = plan.notes
        if len(self._safe_way(planner, air, before, home, "home")) > 2:
            notes = (*notes, f"the straight way from {searches[-1].name} home is not free")
        arm = self.cell.arm
        return replace(plan, searches=tuple(searches), home_joints=home[:JOINTS], robot=arm.name, arm=arm, notes=notes)

    def _way(self, planner: AirPlanner, a: FloatArray, b: FloatArray, name: str) -> FloatArray:
        try:
            return planner.path(a, b).q
        except GeometryError as error:
            raise GeometryError(f"search {name}: {error}", code=ErrorCode.NO_FREE_WAY) from None

    def _safe_way(self, planner: AirPlanner, air: Air, a: FloatArray, b: FloatArray, name: str) -> FloatArray:
        """Return a way on which the torch passes the part wherever it stands: the shortest, or one over the part."""
        way = self._way(planner, a, b, name)
        if self._passes(air, way):
            return way
        for higher in LEVELS_MM:
            tops = [self._above(air, q, higher) for q in (a, b)]
            if tops[0] is None or tops[1] is None:
                continue
            legs = [self._way(planner, q, r, name) for q, r in pairwise([a, tops[0], tops[1], b])]
            way = np.concatenate([legs[0], *(leg[1:] for leg in legs[1:])])
            if self._passes(air, way):
                return way
        raise GeometryError(
            f"search {name}: no way to it is free wherever the part may stand; a smaller --uncertainty-mm or "
            "--uncertainty-deg, or more room around the part, would help",
            code=ErrorCode.NO_FREE_WAY,
        )

    def _passes(self, air: Air, way: FloatArray) -> bool:
        """Tell whether the torch passes the part on a way of the joints, wherever the part stands.

        To a search the programs lead in lines, with the axes of `TouchPlan.axes`; home they move the joints.
        """
        from_home, to_home = ((q == self.cell.home).all() for q in way[[0, -1]])
        turned = 0 if from_home else (len(way) - 2) // 2
        ends = self._tools(way)
        R = ends[[0] * (1 + turned) + [-1] * (len(way) - 1 - turned), :3, :3]
        if not to_home and not air.part.lets_pass(air.torch, air.wire_mm, ends[:, :3, 3], R):
            return False
        states = [way[:1]]
        for a, b in pairwise(way):
            reach = float(np.linalg.norm(np.diff(self._tools(np.stack([a, b]))[:, :3, 3], axis=0)))
            turn = float(np.abs(b - a)[:JOINTS].max())
            count = max(1, math.ceil(max(reach / STEP_MM, turn / STEP_RAD)) * 2)  # the tip goes on an arc
            states.append(a + np.arange(1, count + 1)[:, None] / count * (b - a))
        T = self._tools(np.concatenate(states))
        return air.part.lets_through(air.torch, air.wire_mm, T[:, :3, 3], T[:, :3, :3])

    def _above(self, air: Air, q: FloatArray, higher_mm: float) -> FloatArray | None:
        """Return the joints with which the tool is above its place, on the safe level; None if it cannot be there."""
        T = self._tools(q[None])[0]
        T[:3, 3] = air.over(T[:3, 3], T[:3, 3], higher_mm)[0]
        flange = self.T_base_part.matrix @ T @ np.linalg.inv(self.cell.T_flange_tool.matrix)
        solved = solve_inverse(self.cell.arm, flange[None]).joints.reshape(-1, JOINTS)
        near = turn_into_limits(self.cell.arm, solved, q[:JOINTS])
        far = np.nan_to_num(np.abs(near - q[:JOINTS]).max(axis=1), nan=np.inf)
        best = int(np.argmin(far))
        return self._whole(near[best]) if far[best] <= MOST_RISE_RAD else None

    def _tools(self, q: FloatArray) -> FloatArray:
        """Return the poses of the tool in `part`, shape (k, 4, 4)."""
        return np.asarray(np.linalg.inv(self.cell.part_places(q)) @ self.cell.tool_places(q))

    def _of_search(self, search: Search) -> tuple[Search, FloatArray]:
        """Return a search with the axes of its tool, and the joints at approach, start and end, shape (3, 6)."""
        points = np.stack([search.approach, search.start, search.end])[None]
        wire, bend = search.R_part_tool[:, 2][None], search.R_part_tool[:, 0][None]
        held = self._held(points, wire, bend, SPINS if search.kind is SearchKind.POST else 1)
        if not held.reached[0]:
            at = " ".join(f"{v:.0f}" for v in self.T_base_part.apply(search.start))
            raise GeometryError(
                f"search {search.name}: {self.cell.arm.name} does not reach its start ({at}) in the base: {held.why}",
                code=ErrorCode.JOINT_PATH,
            )
        x, z = held.bend[0], wire[0]
        R = np.stack([x, np.cross(z, x), z], axis=1)
        return replace(search, R_part_tool=R), held.joints[0]

    def _held(self, points: FloatArray, wire: FloatArray, bend: FloatArray, spins: int) -> _Held:
        """Find how the arm holds the tool at n searches: `points` (n, 3, 3) are approach, start and end."""
        n = len(points)
        turns = np.arange(spins) * 2.0 * np.pi / spins
        x = np.stack([np.einsum("nij,nj->ni", np.stack([exp_rotation(t * w) for w in wire]), bend) for t in turns])
        z = np.broadcast_to(wire, x.shape)
        R = np.stack([x, np.cross(z, x), z], axis=-1).transpose(1, 0, 2, 3)  # (n, spins, 3, 3)
        q = self._joints(points, R)  # (n, spins, 8, 3, 6)
        home = self.cell.home[:JOINTS]
        far = np.abs(q - home).max(axis=(3, 4))
        turn = np.abs(np.diff(q, axis=3)).max(axis=(3, 4))
        far = np.where(np.isfinite(far) & (turn <= MOST_TURN_RAD), far, np.inf).reshape(n, -1)
        joints, found = np.full((n, 3, JOINTS), np.nan), np.zeros(n, dtype=bool)
        chosen = x[0].copy()
        reached = bool(np.isfinite(q).all(axis=(3, 4)).any())
        in_branch = bool(np.isfinite(far).any())
        for rank in range(min(TRIED, far.shape[1])):
            column = np.argsort(far, axis=1, kind="stable")[:, rank]
            rows = np.flatnonzero(~found & np.isfinite(far[np.arange(n), column]))
            own = q.reshape(n, -1, 3, JOINTS)[rows, column[rows]]
            free = self._are_free(own)
            joints[rows[free]], found[rows[free]] = own[free], True
            chosen[rows[free]] = x.transpose(1, 0, 2)[rows[free], column[rows[free]] // q.shape[2]]
        why = "it is out of reach or beyond a joint limit"
        if reached:
            why = "a body would be too near" if in_branch else "a joint would swing round on the way"
        return _Held(chosen, joints, found, why)

    def _joints(self, points: FloatArray, R: FloatArray) -> FloatArray:
        """Return the joints of all branches at the points of searches, shape (n, spins, 8, 3, 6); NaN out of reach."""
        n, spins = R.shape[:2]
        T = np.zeros((n, spins, 3, 4, 4))
        T[..., :3, :3] = R[:, :, None]
        T[..., :3, 3] = points[:, None]
        T[..., 3, 3] = 1.0
        flange = self.T_base_part.matrix @ T @ np.linalg.inv(self.cell.T_flange_tool.matrix)
        solved = solve_inverse(self.cell.arm, flange.reshape(-1, 4, 4)).joints.reshape(n, spins, 3, -1, JOINTS)
        first = turn_into_limits(self.cell.arm, solved[:, :, :1], self.cell.home[:JOINTS])
        following = turn_into_limits(self.cell.arm, solved[:, :, 1:], first)
        q = np.concatenate([first, following], axis=2).transpose(0, 1, 3, 2, 4)
        values, _ = regularity(self.cell.arm, np.nan_to_num(q).reshape(-1, JOINTS))
        regular = np.reshape(np.all(values >= LEAST_REGULARITY, axis=1), q.shape[:-1])
        return np.asarray(np.where(regular[..., None], q, np.nan), dtype=np.float64)

    def _are_free(self, joints: FloatArray) -> BoolArray:
        """Tell at which searches no body is too near, from the approach to the end of the stroke, shape (n,)."""
        if len(joints) == 0:
            return np.zeros(0, dtype=bool)
        approach, start, end = joints.transpose(1, 0, 2)
        free = np.ones(len(joints), dtype=bool)
        for clearance, a, b in ((self.clearance, approach, start), (self.around, start, end)):
            way = np.stack([a + share * (b - a) for share in ALONG], axis=1)
            clear = clearance.margins(_states(self.cell, way.reshape(-1, JOINTS))).is_clear
            free &= np.all(clear.reshape(len(joints), -1), axis=1)
        return free

    def _whole(self, joints: FloatArray) -> FloatArray:
        return np.asarray(_states(self.cell, joints[None])[0], dtype=np.float64)

    def _places(self, q: FloatArray) -> FloatArray:
        """Return places of the tip of the wire in `part`, shape (k, 3)."""
        if len(q) == 0:
            return np.empty((0, 3))
        return self._tools(q)[:, :3, 3]


@dataclass(frozen=True, slots=True, eq=False)
class _Held:
    """How an arm holds the tool at n searches: x of the tool, joints, whether it reaches, and why it does not."""

    bend: FloatArray
    joints: FloatArray
    reached: BoolArray
    why: str


def _states(cell: Cell, joints: FloatArray) -> FloatArray:
    """Return all axes of a cell for joints of its arm, shape (n, k): the others are where the part is touched."""
    others = np.broadcast_to(cell.touched_at, (len(joints), len(cell.touched_at)))
    return np.concatenate([joints, others], axis=1)
