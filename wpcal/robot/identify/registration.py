"""The pose of the arm in the frame of the measurement and the tool on its flange: a start for identification.

The measured pose of row i is ``X · FK(q_i) · Y`` with an unknown base X and an unknown tool Y. With full poses both
follow from linear equations; with positions only, X and the offset on the flange are found in turns.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel
from wpcal.robot.kinematics.forward import MDHChain, forward_kinematics

ALTERNATIONS = 100
"""Rounds of base and offset in turns: only a start is wanted, and each round takes well under a millisecond."""
ALTERNATION_MM = 1e-3
"""The rounds stop when no offset moves by more: far inside the reach of the least squares that follow."""


def register(
    chain: MDHChain, theta: FloatArray, observations: PoseObservations, *, free_base: bool, free_tool: bool
) -> KinematicModel:
    """Estimate the base and the tool (or reflectors) that the links of a chain need to meet the measurements.

    `theta`: shape (N, n). Model angles of the rows, rad.
    `free_base`, `free_tool`: Which of the two is unknown; what is known stays as the chain has it. An unknown tool is a
    pose where orientations were measured, and one offset a reflector where not.
    """
    T = forward_kinematics(chain, theta)
    R, p = T[:, :3, :3], T[:, :3, 3]
    reflectors = np.zeros((len(observations.reflectors), 3))
    if observations.R_base_flange is not None:
        R_x, R_y = _rotations(R, observations.R_base_flange, free_base=free_base, free_tool=free_tool)
        t_x, t_y = _translations(R_x @ R, p @ R_x.T, observations.p_base, free_base=free_base, free_tool=free_tool)
    else:
        R_x, t_x, reflectors = _in_turns(R, p, observations, free_base=free_base, free_tool=free_tool)
        R_y, t_y = np.eye(3), np.zeros(3)
    T_x, T_0, T_n = (R_x, t_x), chain.T_base_dh0, chain.T_dhn_flange
    base = RigidTransform(T_x[0] @ T_0.R, T_x[0] @ T_0.t_mm + T_x[1], T_0.target, T_0.source)
    tool = RigidTransform(T_n.R @ R_y, T_n.R @ t_y + T_n.t_mm, T_n.target, T_n.source)
    return KinematicModel(replace(chain, T_base_dh0=base, T_dhn_flange=tool), reflectors)


def _rotations(
    R: FloatArray, measured: FloatArray, *, free_base: bool, free_tool: bool
) -> tuple[FloatArray, FloatArray]:
    """Rotations of X and Y in ``measured_i = R_X R_i R_Y``."""
    if free_base and free_tool:
        # measured_i R_Yᵀ = R_X R_i is linear in the 18 numbers of both; the answer spans the null space
        n = len(R)
        left = np.einsum("nij,kl->nikjl", measured, np.eye(3)).reshape(9 * n, 9)
        right = np.einsum("ij,nlk->nikjl", np.eye(3), R).reshape(9 * n, 9)
        v = np.linalg.svd(np.concatenate([left, -right], axis=1), full_matrices=False)[2][-1]
        R_yt, R_x = v[:9].reshape(3, 3), v[9:].reshape(3, 3)
        sign = np.sign(np.linalg.det(R_x))
        return _nearest_rotation(sign * R_x), _nearest_rotation(sign * R_yt).T
    if free_base:
        return _nearest_rotation(np.einsum("nij,nkj->ik", measured, R)), np.eye(3)
    if free_tool:
        return np.eye(3), _nearest_rotation(np.einsum("nji,njk->ik", R, measured))
    return np.eye(3), np.eye(3)


def _nearest_rotation(M: FloatArray) -> FloatArray:
    """Rotation nearest to a matrix in the sum of squares (orthogonal Procrustes)."""
    U, _, Vt = np.linalg.svd(M)
    return np.asarray(U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt, dtype=np.float64)


def _translations(
    R: FloatArray, p: FloatArray, measured: FloatArray, *, free_base: bool, free_tool: bool
) -> tuple[FloatArray, FloatArray]:
    """Shifts of X and Y in ``measured_i = R_i t_Y + p_i + t_X`` by linear least squares."""
    A = np.zeros((len(R), 3, 6))
    if free_base:
        A[:, :, :3] = np.eye(3)
    if free_tool:
        A[:, :, 3:] = R
    # the shortest solution: zero for what is known
    t = np.asarray(np.linalg.lstsq(A.reshape(-1, 6), (measured - p).ravel(), rcond=None)[0], dtype=np.float64)
    return t[:3], t[3:]


def _in_turns(
    R: FloatArray, p: FloatArray, observations: PoseObservations, *, free_base: bool, free_tool: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Base rotation and shift, and reflector offsets, from positions only."""
    R_x, t_x = np.eye(3), np.zeros(3)
    offsets = np.zeros((len(observations.reflectors), 3))
    for _ in range(ALTERNATIONS):
        seen = p + np.einsum("nij,nj->ni", R, offsets[observations.reflector])
        if free_base:
            middle, target = seen.mean(axis=0), observations.p_base.mean(axis=0)
            R_x = _nearest_rotation((observations.p_base - target).T @ (seen - middle))
            t_x = target - R_x @ middle
        if not free_tool:
            break
        left = np.einsum("nji,nj->ni", R_x @ R, observations.p_base - p @ R_x.T - t_x)
        rows = [observations.reflector == k for k in range(len(offsets))]
        new = np.array([left[row].mean(axis=0) if row.any() else np.zeros(3) for row in rows])
        moved, offsets = float(np.abs(new - offsets).max()), new
        if moved < ALTERNATION_MM:
            break
    return R_x, t_x, offsets
