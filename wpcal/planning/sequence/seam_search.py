"""How a seam can be welded: positions of the external axes, branches, torch angles and spins, by a ladder.

For each position of the external axes the closed form gives all joints of all poses that are tried at the rungs of the
seam. For the most promising branches the cheapest way over the rungs is filled in: the torch follows the leans of the
seam, and how far it is off them changes evenly. Every point is checked: limits, whole turns, singular poses, clearance.
What fails is removed from the ladder, and the ladder is climbed again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache, cached_property, partial
from itertools import groupby, islice

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.ladder import cheapest_way
from wpcal.core.same_bits import inverse_pose, product, sine_cosine
from wpcal.planning.cell.bodies import with_torch_at, with_wire
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import is_regular, is_usable
from wpcal.planning.sequence.external import ExternalAxes, axes_of, external_axes, values_along
from wpcal.planning.sequence.motion_check import MotionChecker
from wpcal.planning.sequence.seam_task import Candidate, SeamTask
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.planning.sequence.torch_poses import (
    TorchPoses,
    angles_between,
    tool_on_seam,
    torch_angles,
    torch_poses,
    wire_is_free,
)
from wpcal.planning.sequence.withdraw import Withdrawal, withdraw, withdraws
from wpcal.robot.kinematics.inverse import TURN, Broken, continue_branch, has_searched_roots, own_branch, solve_inverse
from wpcal.seam.options import Reach

MOST_CANDIDATES = 6  #: Kept per seam: the order of seams chooses among them.
POSES_AT_ONCE = 8192  #: Poses whose joints are solved together: 3 MB of joints.
TRIED = 6  #: Branches and positions of the external axes that are climbed per batch.
CLIMBS = 12  #: How often a ladder is climbed again after a state of its way was found to be unusable.
TILTED_AXES = 24  #: Positions of the external axes that are tried with the torch off its target angles.
STEP_WEIGHT = 1.0  #: Of the squared joint steps, rad², per rung ...
OFF_WEIGHT = 2.0
"""... and of the squared deviation of the torch from its target angles: a torch leans where that saves the arm more."""
FARTHER = 4.0  #: Times the usual distance: beside a high wall the torch is clear only above it.
LEAN_RAD_PER_MM = math.radians(Reach().lean_deg_per_mm)  #: As where seams are found.
ROUND_OFF_RAD = 1e-9
LARGEST_STEP_RAD = np.radians(75.0)
"""A joint that turns by more from one rung to the next swings through a singular pose."""

Steps = Callable[[int, IntArray, IntArray], FloatArray]
"""Costs from states of rung i - 1 to states of rung i, shape (now, before): of i and the rows of both."""


@dataclass(frozen=True, slots=True, eq=False)
class Climb:
    """What a ladder gave: the last point of the seam that it reaches, and the way to there."""

    last: int  #: Point of the seam; -1 if not even the first rung is reached.
    candidate: Candidate | None  #: The way from the first point to `last`, if there is one of two points or more.


@dataclass(frozen=True, slots=True, eq=False)
class _Ladder:
    """The poses of the torch at the rungs of a seam, in one branch and at one position of the external axes."""

    poses: TorchPoses
    values: FloatArray  #: shape (2, k - 6). External axes at the start and at the end of the seam.
    branch: int
    joints: FloatArray  #: shape (m, K, 6). rad.
    usable: BoolArray  #: shape (m, K).
    steps: Steps
    least_off_rad: float  #: Of all positions that are tried together, the least distance from the asked weld position.


Batches = Iterable[tuple[float, Iterable[_Ladder]]]  #: Ladders, and `least_off_rad` of each batch.


class SeamSearch:
    """Searches ways to weld seams in one cell."""

    def __init__(
        self, cell: Cell, clearance: CellClearance, targets: SequenceTargets, *, more_wire_mm: float = 0.0
    ) -> None:
        """Search in a cell; `more_wire_mm` is how much longer than usual the wire of a seam is at most."""
        self.cell, self.clearance, self.targets = cell, clearance, targets
        self.checker = MotionChecker(cell, clearance)
        self.more_wire_mm, self.most_back_mm = more_wire_mm, 0.0
        speeds = cell.speeds[:JOINTS]
        self.weights = speeds.min() / speeds if np.isfinite(speeds).all() else np.ones(JOINTS)

    @cached_property
    def air(self) -> MotionChecker:
        """What checks moves through the air: the wire is a body of the torch."""
        cell = with_wire(self.cell, self.targets.air_clearance_mm, self.more_wire_mm)
        return MotionChecker(cell, CellClearance(cell, self.clearance.part, like=self.clearance))

    @cached_property
    def closer(self) -> SeamSearch:
        """The same search with the torch as near to the part as the targets allow; the air keeps its distances."""
        cell = with_torch_at(self.cell, self.targets.seam_clearance_mm)
        clearance = CellClearance(cell, self.clearance.part, like=self.clearance)
        other = SeamSearch(cell, clearance, self.targets, more_wire_mm=self.more_wire_mm)
        other.__dict__["air"] = self.air
        return other

    @cached_property
    def farther(self) -> SeamSearch:
        """The closer search, whose torch goes on back along the wire where it is not clear at the usual distance."""
        other = copy(self.closer)
        other.most_back_mm = FARTHER * self.targets.approach_mm
        return other

    @cached_property
    def tighter(self) -> SeamSearch:
        """The farther search, whose torch comes as near to the part in the air as its wire may."""
        other = copy(self.farther)
        cell = with_torch_at(self.air.cell, self.targets.air_clearance_mm)
        other.__dict__["air"] = MotionChecker(cell, CellClearance(cell, self.clearance.part, like=self.clearance))
        return other

    def withdrawn(self, q: FloatArray) -> Withdrawal:
        """Go back along the wire from a state of a weld. `q`: shape (k,). All axes, rad and mm."""
        return withdraw(self.checker, self.air, q, self.targets.approach_mm, self.most_back_mm)

    def leaves(self, q: FloatArray) -> BoolArray:
        """Tell from which states of a weld, shape (n, k), the torch can go back along the wire; shape (n,)."""
        return withdraws(self.checker, self.air, q, max(self.targets.approach_mm, self.most_back_mm))

    def leaves_ends(self, ways: Sequence[Candidate]) -> BoolArray:
        """Tell from which ends of ways the torch can go back along the wire, shape (n, 2)."""
        return self.leaves(np.concatenate([way.q[[0, -1]] for way in ways])).reshape(-1, 2)

    def whole(
        self, task: SeamTask, most_axes: int | None = None, tilts: Sequence[bool] = (False, True)
    ) -> list[Candidate]:
        """Return ways to weld a whole seam, the most promising first; empty if none was found."""
        axes = external_axes(self.cell, task, self.targets).first(most_axes)
        for tilted in tilts:
            poses = torch_poses(task, self.targets, self.clearance, tilted=tilted)
            if not poses.is_free.any(axis=1).all():
                continue
            batches: Batches = self._batches(task, poses, axes, whole=True)
            for _ in range(3):  # most can leave, and to ask it of every pose of a rung takes long
                climbs = self._climbs(task, batches, whole=True)
                whole = ((ladder, climb.candidate) for ladder, climb in climbs if climb.last == len(task) - 1)
                ways = ((ladder, way) for ladder, way in whole if way is not None)
                found, still = list[Candidate](), list[tuple[_Ladder, BoolArray]]()
                while some := list(islice(ways, MOST_CANDIDATES - len(found))):
                    for (ladder, way), can in zip(some, self.leaves_ends([way for _, way in some]), strict=True):
                        if can.all():
                            found.append(way)
                        else:
                            still.append((ladder, ~can))
                if found:
                    return found
                held = (self._held(ladder, ends) for ladder, ends in still)
                batches = groupby(held, key=lambda ladder: ladder.least_off_rad)
        return []

    def longest(self, task: SeamTask) -> Climb:
        """Return the way that welds a seam farthest from its first point."""
        axes = external_axes(self.cell, task, self.targets)
        best = Climb(-1, None)
        for tilted in (False, True):
            poses = torch_poses(task, self.targets, self.clearance, tilted=tilted)
            for _, climb in self._climbs(task, self._batches(task, poses, axes, whole=False), whole=False):
                if climb.candidate is not None and climb.last > best.last:
                    best = climb
            if best.last == len(task) - 1:
                break
        return best

    def _climbs(self, task: SeamTask, batches: Batches, *, whole: bool) -> Iterator[tuple[_Ladder, Climb]]:
        """Yield what each ladder gives."""
        reached = False
        for least_off_rad, ladders in batches:
            if reached and least_off_rad > self.targets.position_tol_rad:
                return  # the rest is out of position
            for ladder in ladders:
                climb = self._climb(task, ladder, whole=whole)
                reached |= climb.last == len(task) - 1
                yield ladder, climb

    def _batches(self, task: SeamTask, poses: TorchPoses, axes: ExternalAxes, *, whole: bool) -> Batches:
        """Yield the ladders of positions of the external axes that are tried together, and the least `off_rad`."""
        most = len(axes) if poses.off_rad.max() == 0.0 else min(len(axes), TILTED_AXES)
        size = max(1, POSES_AT_ONCE // poses.is_free.size)
        for start in range(0, most, size):
            rows = slice(start, min(start + size, most))
            least = float(axes.off_rad[rows].min())
            yield least, self._ladders(task, poses, axes.values[rows], least, whole=whole)

    def _ladders(
        self, task: SeamTask, poses: TorchPoses, values: FloatArray, least_off_rad: float, *, whole: bool
    ) -> Iterator[_Ladder]:
        """Yield the most promising ladders at positions of the external axes, shape (C, 2, k - 6)."""
        joints, usable = self.states(task, poses, values)
        m = len(poses.rungs)
        if has_searched_roots(self.cell.arm):  # their numbers name no branch: all are states of one
            poses = poses.repeated(joints.shape[3])
            joints, usable = joints.reshape(len(values), m, -1, 1, JOINTS), usable.reshape(len(values), m, -1, 1)
        ways = np.asarray(usable.any(axis=2))  # (C, m, 8)
        prefix = np.where(ways.all(axis=1), m, np.argmin(ways, axis=1))  # (C, 8)
        fewest = usable.sum(axis=2).min(axis=1)
        score = prefix * (usable.shape[2] + 1) + np.where(prefix == m, fewest, 0)
        score = np.where(prefix == m if whole else prefix >= 1, score, -1)
        swift = partial(is_swift, task, poses) if poses.off_rad.any() else None
        for index in np.argsort(-score, axis=None, kind="stable")[:TRIED]:
            c, b = np.unravel_index(int(index), score.shape)
            if score[c, b] < 0:
                break
            q, can = joints[c, :, :, b], usable[c, :, :, b]
            steps = steps_of_branch(q, can, self.weights, swift)
            yield _Ladder(poses, values[c], int(b), q, can, steps, least_off_rad)

    def _held(self, ladder: _Ladder, ends: BoolArray) -> _Ladder:
        """Keep, at the first or the last rung (`ends`, shape (2,)), states from which the torch can go back."""
        for end in np.array([0, -1])[ends].tolist():
            _keep(ladder.usable[end], ladder.joints[end], ladder.values[end], self.leaves)
        return ladder

    def states(self, task: SeamTask, poses: TorchPoses, values: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the joints of all branches at poses of the torch, for C positions of the external axes.

        `values`: shape (C, 2, k - 6). External axes at the start and at the end of the seam.
        Returns `joints`: ndarray, shape (C, m, K, 8, 6). rad; NaN where a branch does not reach.
        Returns `usable`: ndarray of bool, shape (C, m, K, 8). Within limits, regular, and the torch free of the part.
        """
        m, K = poses.is_free.shape
        along = np.repeat(values_along(values, task, poses.rungs), K, axis=1)
        flange = self.flange_places(poses.T_part_tool.reshape(-1, 4, 4), along)
        joints = solve_inverse(self.cell.arm, flange.reshape(-1, 4, 4)).joints
        joints = joints.reshape(len(values), m, K, *joints.shape[1:])
        usable = is_usable(self.cell.arm, joints)
        return joints, usable & poses.is_free[None, :, :, None]

    def flange_places(self, T_part_tool: FloatArray, values: FloatArray) -> FloatArray:
        """Return ``T_base_flange`` for n poses (n, 4, 4) and external axes (C, n, k - 6); shape (C, n, 4, 4), mm."""
        T_part_flange = product(T_part_tool, self.cell.T_flange_tool.inverse().matrix)
        return product(self.part_places(values), T_part_flange)

    def part_places(self, values: FloatArray) -> FloatArray:
        """Return ``T_base_part`` at external axes (C, n, k - 6); shape (C, n, 4, 4), n is 1 where they stand still."""
        some = values[:, :1] if (values == values[:, :1]).all() else values
        q = axes_of(self.cell, some.reshape(some.shape[0] * some.shape[1], some.shape[2]))
        T_base_part = product(inverse_pose(self.cell.base_places(q)), self.cell.part_places(q))
        return T_base_part.reshape(*some.shape[:2], 4, 4)

    def _climb(self, task: SeamTask, ladder: _Ladder, *, whole: bool) -> Climb:
        usable, rungs, values = ladder.usable.copy(), ladder.poses.rungs, ladder.values
        best = Climb(-1, None)
        seen: set[int] = set()
        for _ in range(CLIMBS):
            way = cheapest_way(list(np.where(usable, OFF_WEIGHT * ladder.poses.off_rad**2, np.inf)), ladder.steps)
            if len(way) <= 1 or (whole and len(way) < len(rungs)):
                return best
            if int(rungs[len(way) - 1]) <= best.last:
                return best
            filled, bad = self._filled(task, ladder, way)
            if filled.last > best.last:
                best = filled
            if bad is None:
                return best
            rung = int(np.searchsorted(rungs, bad))  # the rung at or after the first bad point
            rows = {max(rung - 1, 0), min(rung, len(way) - 1)} if rungs[rung] != bad else {rung}
            for row in rows:
                usable[row, way[row]] = False
            for row in rows - seen:  # where one pose fails, its neighbours mostly do: all of the rung in one call
                external = values_along(values[None], task, rungs[row : row + 1])[0, 0]
                _keep(usable[row], ladder.joints[row], external, lambda q: self.clearance.margins(q).is_clear)
            seen |= rows
            if whole and not usable[sorted(rows)].any(axis=1).all():
                return best
        return best

    def _filled(self, task: SeamTask, ladder: _Ladder, way: list[int]) -> tuple[Climb, int | None]:
        """Return the way with all points between the rungs as far as it is good, and the first point that is not."""
        rungs = ladder.poses.rungs[: len(way)]
        rows = np.arange(int(rungs[-1]) + 1)
        angles = angles_between(task, self.targets, rows, rungs, ladder.poses.angles[np.arange(len(way)), way])
        found, bad = self.checked(task, angles, ladder.values, (ladder.branch, ladder.joints[0, way[0]]))
        last = len(rows) - 1 if bad is None else bad - 1
        if last < 1:
            return Climb(-1, None), bad
        short = task.part_of(0, last)
        return Climb(last, self.candidate(short, angles[: last + 1], found[: last + 1], ladder.branch)), bad

    def checked(
        self, task: SeamTask, angles: FloatArray, values: FloatArray, branch: tuple[int, FloatArray]
    ) -> tuple[FloatArray, int | None]:
        """Return all axes along the first points of a seam, and the first point that cannot be welded so.

        `angles`: shape (n, 3). Work, travel and spin at its first n points, rad.
        `values`: shape (2, k - 6). External axes at the start and at the end of the seam.
        `branch`: Its number, and joints at the first point.
        Returns `q`: ndarray, shape (n, k). rad and mm; up to the point before the returned one.
        """
        q, end = self.reached(task, angles, values, branch)
        if end == 0:
            return q, 0
        margins = self.clearance.margins(q)
        end = _leading(margins.is_clear)
        if end > 1 and not (moves := self.checker.check(q[:end], known=margins)).is_free:
            end = math.ceil(moves.at[np.argmax(moves.margin_mm <= 0.0)])
        return q[:end], None if end == len(angles) else end

    def reached(
        self, task: SeamTask, angles: FloatArray, values: FloatArray, branch: tuple[int, FloatArray]
    ) -> tuple[FloatArray, int]:
        """Return what `checked` does without a look at bodies: all axes up to the first bad point, and that point.

        `angles`, `values`: shapes (n, 3) and (2, k - 6). As for `checked`, and so is `branch`.
        """
        n = len(angles)
        T = tool_on_seam(task, np.arange(n), angles)
        external = values_along(values[None], task, np.arange(n))
        joints = own_branch(self.cell.arm, self.flange_places(T, external)[0], *branch)
        joints[~wire_is_free(task, T, self.clearance)] = np.nan
        path = continue_branch(self.cell.arm, joints, self.cell.home[:JOINTS])
        end = n
        while isinstance(path, Broken):
            end = path.row
            if end == 0:
                return np.zeros((0, JOINTS + values.shape[1])), 0
            path = continue_branch(self.cell.arm, joints[:end], self.cell.home[:JOINTS])
        end = _leading(is_regular(self.cell.arm, path))
        return np.concatenate([path[:end], external[0, :end]], axis=1), end

    def candidate(self, task: SeamTask, angles: FloatArray, q: FloatArray, branch: int) -> Candidate:
        """Return a way with what is said about it.

        `angles`: shape (n, 3). Work, travel and spin, rad.
        `q`: shape (n, k). All axes, rad and mm.
        """
        R_world_part = self.cell.part_places(q)[:, :3, :3]
        off = float(self.targets.off_position(product(R_world_part, task.R)).max())
        asked = torch_angles(task, np.arange(len(task)), self.targets)
        torch = float(np.sqrt(((angles[:, :2] - asked) ** 2).sum(axis=1).mean()))
        return Candidate(task, q, angles, branch, off, torch)


def _keep(
    usable: BoolArray, joints: FloatArray, external: FloatArray, holds: Callable[[FloatArray], BoolArray]
) -> None:
    """Keep of the usable states of one rung, shape (K,), those at which something holds.

    `joints`, `external`: shapes (K, 6) and (k - 6,).
    """
    rows = np.flatnonzero(usable)
    if len(rows):
        usable[rows] = holds(np.concatenate([joints[rows], np.repeat(external[None], len(rows), axis=0)], axis=1))


def _leading(good: BoolArray) -> int:
    """Return how many of the first values are true."""
    return len(good) if good.all() else int(np.argmin(good))


def is_swift(task: SeamTask, poses: TorchPoses, i: int, now: IntArray, before: IntArray) -> BoolArray:
    """Tell whether the torch leans faster from poses of a rung to those of the next, i, than seams allow and do.

    `now`, `before`: shapes (n,) and (m,). Poses at the two rungs.
    """
    rows = poses.rungs[[i - 1, i]]
    asked = LEAN_RAD_PER_MM * (task.s_mm[rows[1]] - task.s_mm[rows[0]])
    own = task.lean_rad[rows[1]] - task.lean_rad[rows[0]]
    most = max(asked, float(np.hypot(*own))) + ROUND_OFF_RAD
    a, b = poses.angles[i, now, :2].T, poses.angles[i - 1, before, :2].T
    return np.asarray(np.hypot(*(x[:, None] - y for x, y in zip(a, b, strict=True))) > most)


def steps_of_branch(
    joints: FloatArray,
    usable: BoolArray,
    weights: FloatArray,
    forbids: Callable[[int, IntArray, IntArray], BoolArray] | None = None,
) -> Steps:
    r"""Return the costs of the steps between the states of one branch; those between two rungs are found once.

    The cost is :math:`w_s \sum_{i,j} K_j (2 - 2 \cos \Delta q_{ij})`: the cosine is the squared step for small steps,
    the same for whole turns, and a product of matrices.

    `joints`: shape (m, K, 6). Of one branch, rad.
    `usable`: shape (m, K). States that a way may use, or some of them.
    `weights`: shape (6,). K_j, positive.
    `forbids`: From a rung, states at it, shape (n,), and at the one before it, (m,), to which steps may not be taken.
    """
    q = np.nan_to_num(joints)
    q -= TURN * np.rint(q / TURN)
    ring = np.concatenate(sine_cosine(q), axis=2) * np.sqrt(np.tile(weights, 2))
    states, at = [np.flatnonzero(each) for each in usable], np.cumsum(usable, axis=1) - 1

    @cache
    def every(i: int) -> FloatArray:
        now, before = states[i], states[i - 1]
        squares = 2.0 * weights.sum() - 2.0 * product(ring[i, now], ring[i - 1, before].T)
        swings = np.zeros(squares.shape, dtype=bool) if forbids is None else forbids(i, now, before)
        off = np.empty(squares.shape)  # of half a turn
        for here, there in zip(q[i, now].T, q[i - 1, before].T, strict=True):  # long rows
            np.abs(np.subtract(here[:, None], there, out=off), out=off)
            np.abs(np.subtract(off, np.pi, out=off), out=off)
            swings |= off < np.pi - LARGEST_STEP_RAD  # neither near nor round
        return np.where(swings, np.inf, STEP_WEIGHT * squares)

    return lambda i, now, before: every(i)[np.ix_(at[i, now], at[i - 1, before])]
