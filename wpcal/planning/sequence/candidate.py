"""`Candidate`: one way to weld one stretch of a seam."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.sequence.seam_task import SeamTask


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One way to weld a stretch of a seam: the arm stays in one branch, the external axes move evenly or not at all."""

    task: SeamTask  #: The stretch, in the direction of travel: n points.
    q: FloatArray  #: shape (n, k). All axes at the points, rad and mm.
    angles: FloatArray  #: shape (n, 3). Work, travel and spin, rad.
    branch: int
    off_position_rad: float  #: Largest distance from the asked weld position.
    off_torch_rad: float  #: Root mean square deviation of the torch from its target angles.
    is_reversed: bool = False  #: Whether it is welded against the direction of the file.

    def __len__(self) -> int:
        return len(self.q)

    @property
    def motion_rad_mm(self) -> float:
        """Root mean square of the joint rates along the seam, rad/mm, all joints alike."""
        steps, s = np.diff(self.q[:, :JOINTS], axis=0), np.diff(self.task.s_mm)
        return float(np.sqrt(((steps**2).sum(axis=1) / s).sum() / (JOINTS * self.task.length_mm)))

    def weld_speed(self, cell: Cell, asked_mm_s: float) -> tuple[float, str | None]:
        """Return the speed along the seam that every joint can follow, mm/s, and the joint that limits it."""
        asked_mm_s = self.task.speed_mm_s or asked_mm_s
        moves = np.abs(np.diff(self.q, axis=0))
        s = np.diff(self.task.s_mm)[:, None]
        allowed = np.divide(cell.speeds * s, moves, out=np.full(moves.shape, math.inf), where=moves > 0)
        row, column = np.unravel_index(int(np.argmin(allowed)), allowed.shape)
        if allowed[row, column] >= asked_mm_s:
            return asked_mm_s, None
        return float(allowed[row, column]), cell.axis_names[int(column)]

    def backwards(self) -> Candidate:
        """Return the same poses in the other direction; the torch angles change their signs."""
        angles = (self.angles * [-1.0, -1.0, 1.0] + [0.0, 0.0, math.pi])[::-1]
        return replace(
            self, task=self.task.backwards(), q=self.q[::-1], angles=angles, is_reversed=not self.is_reversed
        )
