"""What is planned: a seam, a cell and targets. Paths as numbers, and how far they are from being allowed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.motion import WELD_SPEED_MM_S
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.closed_chain import COORDINATES, PLACE, ROTATION, SLOPE, TRAVEL, WORK, SeamPath
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import LEAST_REGULARITY, regularity, weld_zone
from wpcal.planning.search.objectives import ATTITUDE, PathValues, WeldTargets, objective_values

ALLOWED_EXCESS = 1e-9  #: Round-off of an angle at the end of its range.

SearchProgress = Callable[[str, int, int], None]
"""Called with the name of the running step, how many of its parts are done, and of how many."""


@dataclass(frozen=True, slots=True, eq=False)
class CandidatePath:
    """A path as the search handles it: coordinates, the branches of both inverses, and the joints that follow."""

    coordinates: FloatArray  #: shape (n, 9). mm and rad, as in `wpcal.planning.cell.closed_chain`.
    branches: tuple[int, int]  #: Of robot 1 and robot 2.
    joints: FloatArray  #: shape (n, 12). Unwrapped, rad.


@dataclass(frozen=True, slots=True, eq=False)
class PlanningProblem:
    """A seam to be welded in a cell."""

    cell: Cell
    path: SeamPath  #: n points in `part`.
    targets: WeldTargets = field(default_factory=WeldTargets)
    speed_mm_s: float = WELD_SPEED_MM_S  #: Along the seam: no joint may need more than its largest speed.

    @property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest coordinates, shape (9,) each: the weld zone, and the ranges of the targets."""
        low, high = np.full(COORDINATES, -np.inf), np.full(COORDINATES, np.inf)
        low[PLACE], high[PLACE] = weld_zone(self.cell)
        low[ATTITUDE], high[ATTITUDE] = self.targets.attitude_box_rad
        return low, high

    def path_values(self, coordinates: FloatArray, joints: FloatArray) -> PathValues:
        """Return what objectives are functions of; shapes (..., n, 9) and (..., n, 12), mm and rad."""
        return PathValues(self.cell, self.targets, self.path.s_mm, coordinates, joints)

    def objectives(self, coordinates: FloatArray, joints: FloatArray) -> FloatArray:
        """Return the objectives of one path or of many, shape (..., len(OBJECTIVES)). In the order of `OBJECTIVES`.

        `coordinates`: ndarray, shape (..., n, 9).
        `joints`: shape (..., n, 12). Unwrapped, rad.
        """
        return objective_values(self.path_values(coordinates, joints))

    def regularity(self, joints: FloatArray) -> FloatArray:
        """Return how far both arms are from singular poses, shape (N, 6). The three measures of each arm.

        `joints`: shape (N, 12). Robot 1, then robot 2, rad.
        """
        one, _ = regularity(self.cell.arm, joints[:, :JOINTS])
        two, _ = regularity(self.cell.arm2, joints[:, JOINTS:])
        return np.concatenate([one, two], axis=1)

    def is_allowed(self, path: CandidatePath) -> bool:
        """Tell whether a path keeps all limits at its points."""
        return max(self.excesses(path).values()) <= ALLOWED_EXCESS

    def excesses(self, path: CandidatePath) -> dict[str, float]:
        """Return how far a path is beyond each kind of limit, by name; all zero for an allowed path.

        Returns dict. ``reach`` (share of points out of reach), ``joint limits`` (rad), ``singular poses`` (of
        `regularity`), ``joint speeds`` (parts of the largest), ``weld position`` and ``torch angles`` (rad), ``weld
        zone`` (mm), ``clearance`` (mm).
        """
        joints = path.joints
        missing = ~np.isfinite(joints).all(axis=-1)
        if missing.any():
            return {"reach": float(missing.mean())}
        low, high = self.cell.limits
        least, largest = self.box
        outside = np.maximum(path.coordinates - largest, least - path.coordinates).max(axis=0)
        rates = np.abs(np.diff(joints, axis=0)) / np.diff(self.path.s_mm)[:, None] * self.speed_mm_s
        found = {
            "reach": 0.0,
            "joint limits": np.maximum(joints - high, low - joints).max(),
            "singular poses": LEAST_REGULARITY - self.regularity(joints).min(),
            "joint speeds": (rates / self.cell.speeds).max() - 1.0,
            "weld position": outside[[SLOPE, ROTATION]].max(),
            "torch angles": outside[[WORK, TRAVEL]].max(),
            "weld zone": outside[PLACE].max(),
            "clearance": -capsule_clearance(self.cell, joints).margin_mm.min(),
        }
        return {name: max(float(value), 0.0) for name, value in found.items()}
