"""The seams of a sequence, in the frame `part`: points close enough that a controller's linear moves are as planned.

Also here: `Candidate`: one way to weld one stretch of a seam.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.same_bits import product
from wpcal.core.tangent import exp_rotation
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.robot.moves.interpolation import swings_between
from wpcal.robot.torch.attitude import measure_torch
from wpcal.seam.judge.leans import back_directions
from wpcal.seam.judge.material import NEAR_ROOT_MM
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.seam import Seam, SeamFrames, WeldType
from wpcal.weld.runs import WeldRun

STEP_MM, STEP_RAD = 5.0, math.radians(3.0)
"""Between two points a seam is this short and turns this little: a joint then moves by some tenths of a degree."""
RUNG_MM, RUNG_RAD = 40.0, math.radians(20.0)
"""Between two rungs of a ladder; how far the torch is off its targets changes linearly from one to the next."""
LEAST_BEND = 1e-6  #: Change of the rate of a lean, rad/mm, that is not round-off.
LEAST_RUNGS = 3


@dataclass(frozen=True, slots=True, eq=False)
class SeamTask:
    """One seam to weld, or a stretch of one."""

    name: str
    s_mm: FloatArray  #: shape (n,). Arc length, increasing, mm.
    #: `p`, `R`: shapes (n, 3) and (n, 3, 3). Points (mm) and axes x (travel), y, z (out of the joint) in `part`.
    p: FloatArray
    R: FloatArray
    #: shape (n, 2). Work and travel angle with which a straight torch is free there; zero where no lean is needed.
    lean_rad: FloatArray
    is_source: BoolArray  #: shape (n,). Whether the point is one of the seam file.
    weld: WeldType = WeldType.UNKNOWN
    speed_mm_s: float | None = None  #: The speed that the weld data ask for; None: that of all seams.
    rank: int = 1  #: All seams of a lower rank are welded first.
    more_wire_mm: float = 0.0  #: The tool centre point stays back by this from the seam.
    wire_from_mm: float = NEAR_ROOT_MM  #: This far from the tip on the whole wire is compared with the part.
    position: str | None = None  #: The weld position that the weld data are for.

    def __len__(self) -> int:
        return len(self.s_mm)

    @property
    def length_mm(self) -> float:
        """From the first point to the last."""
        return float(self.s_mm[-1] - self.s_mm[0])

    @property
    def middle(self) -> FloatArray:
        """Mean of the points, shape (3,), mm."""
        return np.asarray(self.p.mean(axis=0), dtype=np.float64)

    def rungs(self) -> IntArray:
        """Return the points at which the search decides, shape (m,): the ends, and where a lean begins or ends."""
        turned = Rotation.from_matrix(product(np.swapaxes(self.R[:-1], 1, 2), self.R[1:])).magnitude()
        way = np.diff(self.s_mm) / RUNG_MM + turned / RUNG_RAD
        along = np.concatenate([[0.0], np.cumsum(way)])
        count = max(LEAST_RUNGS, math.ceil(along[-1]) + 1)
        even = np.searchsorted(along, np.linspace(0.0, along[-1], count) - 1e-9).clip(0, len(self) - 1)
        rows = np.flatnonzero(self.is_source)
        rates = np.diff(self.lean_rad[rows], axis=0) / np.diff(self.s_mm[rows])[:, None]
        bends = (np.abs(np.diff(rates, axis=0)) > LEAST_BEND).any(axis=1)
        return np.union1d(even, rows[1:-1][bends])

    def part_of(self, first: int, last: int) -> SeamTask:
        """Return the stretch from one point to another, both included."""
        rows = slice(first, last + 1)
        return replace(
            self,
            s_mm=self.s_mm[rows],
            p=self.p[rows],
            R=self.R[rows],
            lean_rad=self.lean_rad[rows],
            is_source=self.is_source[rows],
        )

    def backwards(self) -> SeamTask:
        """Return the same points in the other direction: x and y of the frames are turned about z."""
        return replace(
            self,
            s_mm=(self.s_mm[0] + self.s_mm[-1] - self.s_mm)[::-1],
            p=self.p[::-1],
            R=(self.R * [-1.0, -1.0, 1.0])[::-1],
            lean_rad=-self.lean_rad[::-1],
            is_source=self.is_source[::-1],
        )


def seam_task(seam: Seam, speed_mm_s: float | None = None, rank: int = 1, run: WeldRun | None = None) -> SeamTask:
    """Return a seam with points between those of the file where they are far apart.

    Raises `InputError` when it is given in another frame, or has fewer than two points.
    """
    frames = seam.frames
    if frames.frame != "part" or len(frames) < 2:
        raise InputError(f"seam {seam.name}: expected two or more frames in part, got {len(frames)} in {frames.frame}")
    rotations = Rotation.from_matrix(frames.R)
    lean = np.zeros((len(frames), 2)) if seam.lean_rad is None else np.nan_to_num(seam.lean_rad)
    wire = -back_directions(frames.R, lean)
    swing = swings_between(wire[:-1], wire[1:])
    turned = np.maximum((rotations[:-1].inv() * rotations[1:]).magnitude(), np.linalg.norm(swing, axis=1))
    parts = np.maximum(np.ceil(np.maximum(np.diff(frames.s_mm) / STEP_MM, turned / STEP_RAD)), 1.0).astype(int)
    at = np.concatenate([*(row + np.arange(count) / count for row, count in enumerate(parts)), [len(parts)]])
    number = np.arange(len(frames))
    s, p = np.interp(at, number, frames.s_mm), _on_curve(frames, at)
    R = Slerp(number, rotations)(at).as_matrix()
    lean = _leans_between(lean, wire, swing, R, at)
    from_mm = max(NEAR_ROOT_MM, start_mm(seam))
    more = seam.more_wire_mm, from_mm, None if run is None else run.weld.values.position
    return SeamTask(seam.name, s, p, R, lean, at == np.rint(at), seam.weld, speed_mm_s, rank, *more)


def _on_curve(frames: SeamFrames, at: FloatArray) -> FloatArray:
    """Return places between the frames of a seam, shape (n, 3), mm: on a cubic with their tangents, not on its chord.

    `at`: shape (n,). In numbers of frames. Where the tangents are not those of a smooth curve, the chord is taken.
    """
    row = np.minimum(at.astype(int), len(frames) - 2)
    t = (at - row)[:, None]
    start, chord = frames.p[row], frames.p[row + 1] - frames.p[row]
    way = np.linalg.norm(chord, axis=1, keepdims=True)
    off = [way * frames.R[row + k, :, 0] - chord for k in (0, 1)]
    bend = t * (1.0 - t) * ((1.0 - t) * off[0] - t * off[1])
    size = np.linalg.norm(np.stack([off[0], off[1], off[0] + off[1]]), axis=2)
    smooth = (size[:2].max(axis=0) < SMOOTH * way[:, 0]) & (size[2] <= 0.5 * size[:2].max(axis=0))
    return np.asarray(start + t * chord + np.where(smooth[:, None], bend, 0.0), dtype=np.float64)


def _leans_between(
    lean_rad: FloatArray, wire: FloatArray, swing: FloatArray, R: FloatArray, at: FloatArray
) -> FloatArray:
    """Return work and travel angles, shape (n, 2), rad, of a wire that turns as controllers turn it between frames.

    `lean_rad`, `wire`: shapes (m, 2) and (m, 3). At the frames; `wire` points towards its tip.
    `swing`: shape (m - 1, 3). Its turns between them, rotation vectors.
    `R`, `at`: shapes (n, 3, 3) and (n,). Axes of the seam at points, and their places in numbers of frames.
    """
    row = np.minimum(at.astype(int), len(swing) - 1)
    turned = exp_rotation(swing[row] * (at - row)[:, None])
    leans = np.asarray(lean_rad.any(axis=1))
    angles = np.stack(measure_torch(R, np.einsum("nij,nj->ni", turned, wire[row])), axis=1)
    return np.where((leans[row] | leans[row + 1])[:, None], np.round(angles, LEAN_DIGITS), 0.0)


LEAN_DIGITS = 9  #: Of leans, rad: where the torch is straight, round-off is no lean.
SMOOTH = 0.2  #: Sine of the angle between a tangent and a chord, up to which both are of one smooth curve.


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
        return speed_along(cell, self.q, self.task.s_mm, self.task.speed_mm_s or asked_mm_s)

    def backwards(self) -> Candidate:
        """Return the same poses in the other direction; the torch angles change their signs."""
        angles = (self.angles * [-1.0, -1.0, 1.0] + [0.0, 0.0, math.pi])[::-1]
        return replace(
            self, task=self.task.backwards(), q=self.q[::-1], angles=angles, is_reversed=not self.is_reversed
        )


def speed_along(cell: Cell, q: FloatArray, s_mm: FloatArray, asked_mm_s: float) -> tuple[float, str | None]:
    """Return the asked speed, or the largest that every axis can follow, mm/s, and the axis that limits it.

    `q`: shape (n, k). All axes, rad and mm, at the arc lengths `s_mm`, shape (n,).
    """
    allowed = cell.allowed_mm_s(q, s_mm)
    row, column = np.unravel_index(int(np.argmin(allowed)), allowed.shape)
    if allowed[row, column] >= asked_mm_s:
        return asked_mm_s, None
    return float(allowed[row, column]), cell.axis_names[int(column)]
