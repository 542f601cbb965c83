"""Where the part or the robot should stand so that most length of the seams is reachable.

A seam counts as reachable if one branch of the arm reaches its ends and its middle with the torch at its target angles,
within limits and away from singular poses, and no body of the cell is in the way there. The ways between these points
are not looked at: a plan at the best place does that.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.options import opt
from wpcal.core.progress import Progress, no_progress
from wpcal.core.same_bits import inverse_pose, product
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.bodies import with_torch_at
from wpcal.planning.cell.cell import CARRIER, TOOL, Cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import is_usable
from wpcal.planning.sequence.external import axes_of, external_axes, values_along
from wpcal.planning.sequence.remedies import Help, changed_cell
from wpcal.planning.sequence.seam_task import SeamTask, seam_task
from wpcal.planning.sequence.sequence_input import PlannedSeam
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.planning.sequence.torch_poses import TorchPoses, torch_poses
from wpcal.robot.kinematics.inverse import solve_inverse

PLACE_SCHEMA = "wpcal/place/1"
TURNS_DEG = (0.0, 90.0, 180.0, 270.0)  #: Turns of the part about the vertical that are tried at every place.
MOST_AXES = 12  #: Positions of the external axes that are tried per seam and place.
MOST_WAYS = 4
"""Branches, with positions of the external axes, that are compared with the bodies of the cell per seam and place."""
HEIGHT_STEP_MM = 200.0  #: Between heights that are tried: tables and risers are built in such steps.
POSES_AT_ONCE = 16384  #: Poses whose joints are solved together: 6 MB of joints.
MOST_SPINS = 4  #: Poses of the torch that are compared per point of a seam: quarter turns about the wire.
WHOLE = 1.0 - 1e-9  #: A larger share is all seams, but for round-off.
RUNGS = 3  #: Points of a seam that are looked at: its ends and its middle.


class Moved(Enum):
    """What is moved over the map."""

    PART = "part"
    ROBOT = "robot"


@dataclass(frozen=True, slots=True, kw_only=True)
class MapOptions:
    """Which places are compared."""

    moved: Moved = opt(Moved.PART, "What is moved over the map: the part, with its positioner, or the robot.", "--move")
    range_mm: float = opt(600.0, "Largest move in x and y.", least=50.0, most=3000.0)
    step_mm: float = opt(100.0, "Step of the map.", "--map-step-mm", least=10.0, most=1000.0)
    height_mm: float = opt(
        600.0,
        "Largest move up, and down as far as floor and fixtures leave room, in steps of 200 mm: tried if no place at "
        "the height of the cell reaches all seams. By default as far as the map; 0: only that height.",
        least=0.0,
        most=2000.0,
    )


USUAL_MAP = MapOptions()


class MapPlace(NamedTuple):
    """A place from where the cell has it: moves in `world`, and the turn of the part about the vertical."""

    x_mm: float
    y_mm: float
    height_mm: float
    turn_deg: float
    share: float  #: Part of the length of all seams that is reachable, 0 to 1.

    def words(self, moved: Moved) -> str:
        """Say what is moved, and how."""
        how = "raised" if self.height_mm > 0 else "lowered"
        raised = f", {how} by {abs(self.height_mm):g} mm" if self.height_mm else ""
        turned = f", turned by {self.turn_deg:g} deg about the vertical" if self.turn_deg else ""
        return f"the {moved.value} moved by {self.x_mm:g}, {self.y_mm:g} mm in x, y of world{raised}{turned}"


@dataclass(frozen=True, slots=True, eq=False)
class PlaceMap:
    """The reachable part of all seams over a grid of places."""

    moved: Moved
    starts: Mapping[float, RigidTransform]
    """By turn of the part: where the part, its positioner or the robot is in the cell, to be moved."""
    #: `x_mm`, `y_mm`: shapes (a,) and (b,). Moves in `world` from where the cell has it.
    x_mm: FloatArray
    y_mm: FloatArray
    height_mm: FloatArray  #: shape (a, b). Another than 0 only where more is reachable than anywhere at 0.
    #: shape (a, b). The best turn of the part about the vertical at each place; 0 where the robot is moved.
    turn_deg: FloatArray
    share: FloatArray  #: shape (a, b). Part of the length of all seams that is reachable, 0 to 1.
    now: float  #: The same where the cell has it.

    @property
    def best(self) -> MapPlace:
        """The best place: of equally good ones, where most is around."""
        good = self.share >= self.share.max() - 1e-9
        padded = np.pad(self.share, 1)
        around = sum(
            padded[i : i + self.share.shape[0], j : j + self.share.shape[1]] for i in range(3) for j in range(3)
        )
        off = np.hypot(self.x_mm[:, None], self.y_mm)
        rank = np.where(good, around - 1e-6 * off, -np.inf)
        i, j = np.unravel_index(int(np.argmax(rank)), rank.shape)
        return MapPlace(float(self.x_mm[i]), float(self.y_mm[j]), *(float(each[i, j]) for each in self._maps.values()))

    @property
    def best_at(self) -> RigidTransform:
        """Where the part, its positioner or the robot stands at the best place."""
        start = self.starts[self.best.turn_deg]
        return replace(start, t_mm=start.t_mm + np.array(self.best[:3]))

    @property
    def _maps(self) -> dict[str, FloatArray]:
        return {"height_mm": self.height_mm, "turn_deg": self.turn_deg, "share": self.share}

    def to_record(self, cell: str) -> dict[str, Any]:
        """Return the record ``wpcal/place/1``."""
        return {
            "schema": PLACE_SCHEMA,
            "cell": cell,
            "moved": self.moved.value,
            "now_share": self.now,
            "best": {**self.best._asdict(), "at": self.best_at.to_record()},
            "x_mm": self.x_mm.tolist(),
            "y_mm": self.y_mm.tolist(),
            **{name: map_.tolist() for name, map_ in self._maps.items()},
        }


def map_places(
    cell: Cell,
    part: TriangleMaterial | None,
    seams: Sequence[PlannedSeam],
    targets: SequenceTargets,
    options: MapOptions = USUAL_MAP,
    *,
    progress: Progress = no_progress,
) -> PlaceMap:
    """Measure how much of the seams is reachable over a grid of places.

    Only places that the arm reaches, and that could be better than with the part turned otherwise, are compared with
    the bodies of the cell: at most `RUNGS` times `MOST_WAYS` times `MOST_SPINS` states per seam. At other heights only
    those are looked at that could be better than every place so far, the seams that the fewest places reach first.
    """
    clearance = CellClearance(with_torch_at(cell, targets.seam_clearance_mm), part)
    tasks = [seam_task(seam.seam) for seam in seams]
    whole, reached = sum(task.length_mm for task in tasks), np.zeros(len(tasks))
    rows = [(task, _poses(task, targets, clearance), task.length_mm / whole) for task in tasks]
    moved, steps = options.moved, round(options.range_mm / options.step_mm)
    grid = np.asarray(options.step_mm * np.arange(-steps, steps + 1), dtype=np.float64)
    turns = TURNS_DEG if moved is Moved.PART and cell.carrier is None else (0.0,)
    points = np.concatenate([task.p for task in tasks])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    turned = {turn: changed_cell(cell, Help("", turn_deg=turn), middle) for turn in turns}
    best = np.zeros((3, len(grid), len(grid)))  # height, turn and share
    for height, turn in itertools.product(_heights(cell, part, options), turns):
        if height and best[2].max() > WHOLE:
            break
        one = _Grid(clearance.standing_as(turned[turn]), turned[turn], targets, moved, grid, turn, height)
        least = np.full_like(best[2], best[2].max()) if height else best[2]
        found = _shares(one, rows, reached, least, progress)
        best = np.where(found > least + 1e-9, np.stack(np.broadcast_arrays(height, turn, found)), best)
        if height == turn == 0.0:
            now = float(found[steps, steps])
    starts = {turn: _moving(each, moved) for turn, each in turned.items()}
    return PlaceMap(moved, starts, grid, grid, best[0], best[1], best[2], now)


def _shares(
    one: _Grid, seams: Sequence[tuple[SeamTask, TorchPoses, float]], seen: FloatArray, least: FloatArray, say: Progress
) -> FloatArray:
    """Return the reachable share at each place, shape (a, b), a part of it where it is no more than `least`.

    `seams`: With their share of the length. `seen`: How many places reached each; counted on here, the fewest first.
    """
    found, rest, at = np.zeros_like(least), 1.0, f", height {one.height_mm:+g} mm" if one.height_mm else ""
    for count, row in enumerate(np.argsort(seen, kind="stable"), start=1):
        say(f"places: seam {count} of {len(seams)}, part turned by {one.turn_deg:g} deg{at}")
        task, poses, share = seams[row]
        is_reached = one.reached(task, poses, found + rest > least + 1e-9)
        found, rest = found + share * is_reached, rest - share
        seen[row] += is_reached.sum()
    return found


def _heights(cell: Cell, part: TriangleMaterial | None, options: MapOptions) -> list[float]:
    """Return the heights that are tried, the nearest first.

    A part goes down until its lowest point is level with the floor or the lowest top of a fixture; a positioner and a
    robot do not: they stand on something.
    """
    down = 0.0
    if options.moved is Moved.PART and cell.carrier is None and part is not None:
        T = cell.part_places(cell.home[None])[0]
        low = float((part.corners @ T[2, :3]).min() + T[2, 3])
        down = low - max([cell.floor_z_mm, *(min(shape.box[1][2], low) for shape in cell.bench)])
    steps = np.arange(1, int(options.height_mm / HEIGHT_STEP_MM) + 1) * HEIGHT_STEP_MM
    return [0.0, *(up for step in steps.tolist() for up in (step, -step) if up > 0.0 or step <= down)]


def _moving(cell: Cell, moved: Moved) -> RigidTransform:
    """Return where what is moved is in `world`."""
    if moved is Moved.ROBOT:
        return cell.T_world_base
    return cell.T_part if cell.carrier is None else cell.carrier.T_world_base


def _poses(task: SeamTask, targets: SequenceTargets, clearance: CellClearance) -> TorchPoses:
    """Return poses at the ends and in the middle of a seam; off the target angles only where the torch needs it."""
    poses = torch_poses(task, targets, clearance, tilted=False)
    rows = np.unique(np.linspace(0, len(poses.rungs) - 1, RUNGS).round().astype(int))
    if not poses.is_free[rows].any(axis=1).all():
        poses = torch_poses(task, targets, clearance, tilted=True)
    return poses.select(rows)


@dataclass(frozen=True, slots=True)
class _Grid:
    """The cell at every place of the map, with the part turned in one way and at one height."""

    clearance: CellClearance
    cell: Cell
    targets: SequenceTargets
    moved: Moved
    mm: FloatArray
    turn_deg: float
    height_mm: float

    def reached(self, task: SeamTask, poses: TorchPoses, asked: BoolArray) -> FloatArray:
        """Return 1 where one branch reaches a seam, free of collision; shape (a, b), 0 where `asked` is not."""
        cell, grid = self.cell, self.mm
        values = external_axes(cell, task, self.targets).values[:MOST_AXES]
        T_base_world = inverse_pose(cell.base_places(axes_of(cell, values[:, 0])))
        along = np.repeat(values_along(values, task, poses.rungs), poses.is_free.shape[1], axis=1)
        axes = axes_of(cell, along.reshape(along.shape[0] * along.shape[1], along.shape[2]))
        places = cell.part_places(axes).reshape(*along.shape[:2], 4, 4)
        T_part_flange = product(poses.T_part_tool.reshape(-1, 4, 4), cell.T_flange_tool.inverse().matrix)
        T_flange = product(T_base_world[:, None], product(places, T_part_flange))
        shape = (len(values), *poses.is_free.shape)
        outer = axes[:, JOINTS:].reshape(*shape, -1)
        every: IntArray = np.argwhere(asked)
        found = np.zeros(asked.shape)
        most = max(1, POSES_AT_ONCE // math.prod(shape))
        for first in range(0, len(every), most):
            some = every[first : first + most]
            moves = np.column_stack([grid[some], np.full(len(some), self.height_mm)])
            shift = np.einsum("cij,bj->bci", T_base_world[:, :3, :3], moves if self.moved is Moved.PART else -moves)
            T = np.repeat(T_flange[None], len(some), axis=0)
            T[..., :3, 3] += shift[:, :, None]
            joints = solve_inverse(cell.arm, T.reshape(-1, 4, 4)).joints
            joints = joints.reshape(len(some), *shape, *joints.shape[1:])
            usable = is_usable(cell.arm, joints) & poses.is_free[..., None]
            rows = np.flatnonzero(np.any(np.all(np.any(usable, axis=3), axis=2), axis=(1, 2)))
            found[tuple(some[rows].T)] = self._has_free_way(moves[rows], usable[rows], joints[rows], outer)
        return found

    def _has_free_way(self, moves: FloatArray, usable: BoolArray, joints: FloatArray, outer: FloatArray) -> BoolArray:
        """Tell at which places one branch reaches all points of a seam without collision, shape (p,).

        `moves`: shape (p, 3). In `world`, mm.
        `usable`: shape (p, c, m, K, 8). For each position of the external axes, point, pose of the torch and branch.
        `joints`: shape (p, c, m, K, 8, 6). rad.
        `outer`: shape (c, m, K, e). External axes, rad and mm.
        """
        fewest = usable.sum(axis=3).min(axis=2)  # poses at the point that has the fewest
        counts = fewest.reshape(len(moves), usable.shape[1] * usable.shape[4])
        ways = np.argsort(-counts, axis=1, kind="stable")[:, :MOST_WAYS]
        found = np.zeros(len(moves), dtype=np.bool_)
        frames = slice(CARRIER, None) if self.moved is Moved.PART else slice(TOOL + 1)
        for way in ways.T:
            rows = np.flatnonzero(~found & (counts[np.arange(len(way)), way] > 0))
            value, branch = np.divmod(way[rows], usable.shape[4])
            own = usable[rows, value, :, :, branch]  # (r, m, K)
            number = own.sum(axis=2)
            tried = np.minimum(number, MOST_SPINS)
            clear = np.zeros(number.shape, dtype=np.bool_)
            for k in range(MOST_SPINS):
                hopeful = (clear | (tried > k)).all(axis=1)
                at, rung = np.nonzero(~clear & hopeful[:, None])
                if not len(at):
                    break
                rank = (k * (number - 1)[at, rung]) // np.maximum(tried[at, rung] - 1, 1)
                pose = np.argmax(np.cumsum(own[at, rung], axis=1) > rank[:, None], axis=1)
                q = joints[rows[at], value[at], rung, pose, branch[at]]
                q = np.concatenate([q, outer[value[at], rung, pose]], axis=1)
                clear[at, rung] = self.clearance.margins(q, moved=(frames, moves[rows[at]])).is_clear
            found[rows] = clear.all(axis=1)
        return found
