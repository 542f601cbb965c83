"""Poses of the tool on a seam at a grid of torch angles and spins, and which of them leave the torch free of the part.

Both depend on the part and the torch alone, so that they are found once per seam, whatever the positioner does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.same_bits import poses, product
from wpcal.planning.cell.bodies import stick_out_mm
from wpcal.planning.cell.cell_clearance import CellClearance, tool_capsules
from wpcal.planning.cell.closed_chain import COORDINATES, SPIN, TRAVEL, WORK, torch_on_seam
from wpcal.planning.cell.workplace import AIR_STEP_MM
from wpcal.planning.sequence.seam_task import SeamTask
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.seam.judge.material import WIRE_RADIUS_MM

SPINS = 16  #: Turns about the wire that are tried: the torch body reaches every side of the seam within 11 degrees.
TILTS = (0.0, 0.5, -0.5, 1.0, -1.0)
"""Deviations of the work and of the travel angle that are tried, in parts of their range."""


@dataclass(frozen=True, slots=True, eq=False)
class TorchPoses:
    """K poses at each of m rungs of a seam."""

    rungs: IntArray  #: shape (m,). Points of the seam.
    angles: FloatArray  #: shape (m, K, 3). Work, travel and spin, rad.
    T_part_tool: FloatArray  #: shape (m, K, 4, 4). mm.
    off_rad: FloatArray  #: shape (m, K). Root of the squared deviations of work and travel from their targets.
    is_free: BoolArray  #: shape (m, K). Whether the torch keeps its distances from the part.

    def select(self, rungs: IntArray | slice, poses: IntArray | BoolArray | slice = slice(None)) -> TorchPoses:
        """Return the poses at some of m `rungs`, shape (k,), of these those of the columns `poses`."""
        T, off = self.T_part_tool[rungs][:, poses], self.off_rad[rungs][:, poses]
        return TorchPoses(self.rungs[rungs], self.angles[rungs][:, poses], T, off, self.is_free[rungs][:, poses])

    def repeated(self, times: int) -> TorchPoses:
        """Return every pose several times in turn."""
        return self.select(slice(None), np.repeat(np.arange(self.is_free.shape[1]), times))


def torch_angles(task: SeamTask, rows: IntArray, targets: SequenceTargets) -> FloatArray:
    """Return the target work and travel angles at points of a seam, shape (k, 2), rad: the seam's leans come first."""
    lean = task.lean_rad[rows]
    asked = np.array([targets.work_rad, targets.travel_rad])
    leans = np.asarray(lean.any(axis=1))[:, None]
    return np.where(leans, lean, asked)


def angles_between(
    task: SeamTask, targets: SequenceTargets, rows: IntArray, rungs: IntArray, knots: FloatArray
) -> FloatArray:
    """Return work, travel and spin at points of a seam, shape (n, 3), rad.

    The torch goes with the leans of the seam, from frame to frame. How far it is off them, and its spin, change evenly
    from rung to rung.

    `rows`, `rungs`: shapes (n,) and (m,). Points of the seam.
    `knots`: shape (m, 3). Angles at the rungs.
    """
    off = np.unwrap(knots, axis=0)
    off[:, :2] -= torch_angles(task, rungs, targets)
    angles = np.stack([np.interp(task.s_mm[rows], task.s_mm[rungs], column) for column in off.T], axis=1)
    angles[:, :2] += torch_angles(task, rows, targets)
    return angles


def tool_on_seam(task: SeamTask, rows: IntArray, angles: FloatArray) -> FloatArray:
    """Return ``T_part_tool``, shape (n, 4, 4), mm.

    `rows`: shape (n,). Its points.
    `angles`: shape (n, 3). Work, travel and spin, rad.
    """
    coordinates = np.zeros((len(rows), COORDINATES))
    coordinates[:, [WORK, TRAVEL, SPIN]] = angles
    R = product(task.R[rows], torch_on_seam(coordinates))
    return poses(R, task.p[rows] - task.more_wire_mm * R[:, :, 2])


def torch_poses(task: SeamTask, targets: SequenceTargets, clearance: CellClearance, *, tilted: bool) -> TorchPoses:
    """Return the poses that a search tries."""
    rungs = task.rungs()
    tilts = np.array(TILTS if tilted and targets.torch_range_rad > 0.0 else (0.0,)) * targets.torch_range_rad
    spins = 2 * np.pi * np.arange(SPINS) / SPINS
    grid = np.stack(np.meshgrid(tilts, tilts, spins, indexing="ij"), axis=-1).reshape(-1, 3)
    centre = np.column_stack([torch_angles(task, rungs, targets), np.zeros(len(rungs))])
    angles = centre[:, None] + grid
    rows = np.repeat(rungs, len(grid))
    T = tool_on_seam(task, rows, angles.reshape(-1, 3))
    shape = (len(rungs), len(grid))
    free = torch_is_free(T, clearance)
    free[free] = wire_is_free(task, T[free], clearance)
    free = free.reshape(shape)
    for end in (0, -1):  # where the torch comes and goes along the wire
        back = T.reshape(*shape, 4, 4)[end, free[end]]
        back[:, :3, 3] -= AIR_STEP_MM * back[:, :3, 2]
        free[end, free[end]] = torch_is_free(back, clearance)
    off = np.broadcast_to(np.sqrt(grid[:, 0] ** 2 + grid[:, 1] ** 2), shape)
    return TorchPoses(rungs, angles, T.reshape(*shape, 4, 4), off, free)


def wire_is_free(task: SeamTask, T_part_tool: FloatArray, clearance: CellClearance) -> BoolArray:
    """Tell for poses of shape (n, 4, 4), mm, whether the wire is free beyond the joint that it welds; shape (n,)."""
    tip, mouth = task.more_wire_mm - task.wire_from_mm, -stick_out_mm(clearance.cell)
    if tip <= mouth:
        return np.ones(len(T_part_tool), dtype=bool)
    p, z = T_part_tool[:, None, :3, 3], T_part_tool[:, None, :3, 2]
    radius = np.array([WIRE_RADIUS_MM])
    return clearance.are_clear(p + tip * z, p + mouth * z, radius, np.zeros(1))


def torch_is_free(T_part_tool: FloatArray, clearance: CellClearance) -> BoolArray:
    """Tell for poses of shape (n, 4, 4), mm, whether the torch keeps its distances from the part; shape (n,)."""
    p, q, radius, needed = tool_capsules(clearance.cell)
    starts, ends = (
        np.einsum("nij,cj->nci", T_part_tool[:, :3, :3], local) + T_part_tool[:, None, :3, 3] for local in (p, q)
    )
    return clearance.are_clear(starts, ends, radius, needed)
