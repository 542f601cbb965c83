"""The closed chain of both arms, exact by construction: nine coordinates of each point give all joints.

A point of a path is determined by the place of the weld point, the attitude of the seam and the attitude of the torch:

====  ==========  =================================================================================
0-2   x, y, z     weld point in the frame `middle` of the cell, mm
3     yaw         direction of travel about the vertical in `middle`, rad
4     slope       of the weld axis, rad (θ of Hou 2018, §1.2.1)
5     rotation    of the joint about the weld axis, rad (-φ of Hou 2018)
6     work        work angle of the torch, rad
7     travel      travel angle of the torch, rad
8     spin        turn of the torch about its wire, rad (γ of Hou 2018, §1.2.2: without effect on the weld)
====  ==========  =================================================================================

They determine the poses of the seam, the part and the tool, and the closed-form inverses of both arms give the joints.
For all values of the nine coordinates the tip of the wire is on the weld point (Hou 2018, eq. 5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.same_bits import poses, product, sine_cosine, solve
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import TURN, solve_inverse
from wpcal.seam.seam import SeamFrames

COORDINATES = 9
PLACE, YAW, SLOPE, ROTATION, WORK, TRAVEL, SPIN = slice(0, 3), 3, 4, 5, 6, 7, 8  #: Columns of the coordinates.


@dataclass(frozen=True, slots=True, eq=False)
class SeamPath:
    """The points of one seam in the frame `part`."""

    name: str
    s_mm: FloatArray  #: shape (n,). Arc length, increasing, mm.
    p: FloatArray  #: shape (n, 3). Points of the seam, mm.
    R: FloatArray  #: shape (n, 3, 3). Columns x (travel), y, z (out of the joint).

    @classmethod
    def of_frames(cls, name: str, frames: SeamFrames) -> SeamPath:
        """Take the frames of a seam, which must be given in `part`.

        Raises `InputError` when they are given in another frame, or are fewer than two.
        """
        if frames.frame != "part":
            raise InputError(f"seam {name}: expected frames in part, got {frames.frame}")
        if len(frames) < 2:
            raise InputError(f"seam {name}: a path needs at least two points, got {len(frames)}")
        return cls(name, frames.s_mm, frames.p, frames.R)

    def __len__(self) -> int:
        return len(self.s_mm)

    def select(self, rows: IntArray) -> SeamPath:
        """Return the points at `rows`, of any shape (k,); a row may appear more than once."""
        return SeamPath(self.name, self.s_mm[rows], self.p[rows], self.R[rows])


def seam_in_middle(coordinates: FloatArray) -> FloatArray:
    """Return the axes of the seam in `middle`, ``Rz(yaw) Ry(-slope) Rx(rotation)``; shape (N, 3, 3)."""
    return rotation_from_zyx(coordinates[:, ROTATION], -coordinates[:, SLOPE], coordinates[:, YAW])


def torch_on_seam(coordinates: FloatArray) -> FloatArray:
    """Return the axes of the tool in the seam frame, ``Rx(work) Ry(-travel) Rx(π) Rz(spin)``; shape (N, 3, 3)."""
    zero = np.zeros(len(coordinates))
    worked = rotation_from_zyx(coordinates[:, WORK], zero, zero)
    turned = product(worked, rotation_from_zyx(zero, -coordinates[:, TRAVEL], zero)) * [1.0, -1.0, -1.0]
    return product(turned, rotation_from_zyx(zero, zero, coordinates[:, SPIN]))


def flange_poses(cell: Cell, path: SeamPath, coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the poses of both flanges.

    `coordinates`: ndarray, shape (N, 9).
    Returns `T_base1_flange1, T_base2_flange2`: ndarray, shape (N, 4, 4). mm.
    """
    R_middle_seam = seam_in_middle(coordinates)
    R_middle_part = product(R_middle_seam, np.swapaxes(path.R, 1, 2))
    origin = coordinates[:, PLACE] - np.einsum("nij,nj->ni", R_middle_part, path.p)
    T_middle_part = poses(R_middle_part, origin)
    T_middle_tool = poses(product(R_middle_seam, torch_on_seam(coordinates)), coordinates[:, PLACE])
    T_base1_middle, T_base2_middle = (
        T.inverse() @ cell.T_world_middle for T in (cell.T_world_base, cell.T_world_base2)
    )
    flange1 = product(product(T_base1_middle.matrix, T_middle_tool), cell.T_flange_tool.inverse().matrix)
    flange2 = product(product(T_base2_middle.matrix, T_middle_part), cell.T_part.inverse().matrix)
    return flange1, flange2


def all_joints(cell: Cell, path: SeamPath, coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the joints of all eight branches of both arms, each angle in the turn around zero.

    `coordinates`: ndarray, shape (N, 9).
    Returns `joints1, joints2`: ndarray, shape (N, 8, 6). rad; NaN where a branch does not reach.
    """
    flange1, flange2 = flange_poses(cell, path, coordinates)
    return solve_inverse(cell.arm, flange1).joints, solve_inverse(cell.arm2, flange2).joints


def joints_along(
    cell: Cell, path: SeamPath, coordinates: FloatArray, branches: tuple[int, int], near: FloatArray
) -> FloatArray:
    """Return the unwrapped joints of one pair of branches along a path.

    `coordinates`: ndarray, shape (n, 9).
    `near`: shape (12,). The whole turns of the first point are those nearest to these joints, rad.
    Returns ndarray, shape (n, 12). Robot 1, then robot 2; NaN where a branch does not reach.
    """
    one, two = all_joints(cell, path, coordinates)
    both = np.concatenate([one[:, branches[0]], two[:, branches[1]]], axis=1)
    return unwrap(both, near)


def unwrap(joints: FloatArray, near: FloatArray) -> FloatArray:
    """Add whole turns so that each step is the shorter way, and the first row is nearest to `near`, shape (n, k), rad.

    Between neighbouring points of a path a joint turns by less than π, so the shorter step is the right one. The angle
    may grow over several turns.

    `joints`: shape (n, k). rad.
    `near`: shape (k,). rad.
    """
    steps = np.diff(joints, axis=0, prepend=np.broadcast_to(near, (1, joints.shape[1])))
    return np.asarray(near + np.cumsum(steps - TURN * np.rint(steps / TURN), axis=0), dtype=np.float64)


def joint_slopes(cell: Cell, coordinates: FloatArray, joints: FloatArray) -> FloatArray:
    """Return the derivative of all joints with respect to the nine coordinates.

    `coordinates`: ndarray, shape (n, 9).
    `joints`: shape (n, 12). The joints that belong to the coordinates, rad.
    Returns ndarray, shape (n, 12, 9). rad per mm and rad per rad; large but finite near a singular pose.
    """
    seam, tool = _turning_axes(coordinates)
    motion2 = np.zeros((len(joints), 6, COORDINATES))
    motion2[:, :3, YAW : ROTATION + 1] = seam
    motion2[:, 3:, PLACE] = np.eye(3)
    motion1 = motion2.copy()
    motion1[:, :3, WORK : SPIN + 1] = tool
    tip = np.broadcast_to(cell.T_flange_tool.t_mm, (len(joints), 3))
    T_middle_base1, T_middle_base2 = (
        cell.T_world_middle.inverse() @ T for T in (cell.T_world_base, cell.T_world_base2)
    )
    T_middle_flange2 = product(T_middle_base2.matrix, cell.arm2.forward(joints[:, JOINTS:]))
    weld = np.einsum("nji,nj->ni", T_middle_flange2[:, :3, :3], coordinates[:, PLACE] - T_middle_flange2[:, :3, 3])
    slopes = [
        _solved(cell.arm, joints[:, :JOINTS], T_middle_base1.R, tip, motion1),
        _solved(cell.arm2, joints[:, JOINTS:], T_middle_base2.R, weld, motion2),
    ]
    return np.concatenate(slopes, axis=1)


def _turning_axes(coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Axes in `middle` about which yaw, slope, rotation turn the seam, and work, travel, spin the tool; (n, 3, 3)."""
    R_seam = seam_in_middle(coordinates)
    zero = np.zeros(len(coordinates))
    up = np.stack([zero, zero, zero + 1.0], axis=1)
    (yaw_sine, work_sine), (yaw_cosine, work_cosine) = sine_cosine(coordinates[:, [YAW, WORK]].T)
    level = np.stack([yaw_sine, -yaw_cosine, zero], axis=1)  # -Rz(yaw) e_y
    worked = np.stack([zero, -work_cosine, -work_sine], axis=1)  # -Rx(work) e_y
    wire = torch_on_seam(coordinates)[:, :, 2]
    tool = [R_seam[:, :, 0], np.einsum("nij,nj->ni", R_seam, worked), np.einsum("nij,nj->ni", R_seam, wire)]
    return np.stack([up, level, R_seam[:, :, 0]], axis=2), np.stack(tool, axis=2)


LEAST_PIVOT = 1e-6
"""Damping of the squared, length-scaled Jacobian: near a singular pose the slopes are steep but finite."""
ARM_LENGTH_MM = 1000.0  #: Scale that makes millimetres at the end of an arm comparable with radians.


def _solved(arm: Arm, q: FloatArray, R_middle_base: FloatArray, point: FloatArray, motion: FloatArray) -> FloatArray:
    """Return joint slopes (n, 6, 9) for motions of the flange (n, 6, 9) given in `middle` at a point of the flange."""
    J = arm.jacobian(q, point=point.T)
    scale = np.array([1.0, 1.0, 1.0, *(1.0 / ARM_LENGTH_MM,) * 3])[:, None]
    local = np.concatenate([product(R_middle_base.T, part) for part in (motion[:, :3], motion[:, 3:])], axis=1) * scale
    J = J * scale
    Jt = np.swapaxes(J, 1, 2)
    slopes, size = solve(J, local)
    flat = size <= LEAST_PIVOT
    slopes[flat] = solve(product(Jt, J)[flat] + LEAST_PIVOT * np.eye(6), product(Jt, local)[flat])[0]
    return slopes
