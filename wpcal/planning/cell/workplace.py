"""The weld zone: the places between the robots where the weld may be, in the frame `middle` of the cell.

Also here: the distance from singular poses, where a small motion of the tool needs a large motion of a joint.

An arm of the OPW family has three kinds: the wrist straight (axes 4 and 6 collinear), the elbow stretched, and the
centre of the wrist on axis 1. Each kind has a measure that is zero there and changes its sign between branches of the
inverse, so a path whose measures stay away from zero keeps its branch.
"""

from __future__ import annotations

import math

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.same_bits import arc_tangent, inverse_pose, length, product, sine_cosine, solve
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import TURN, family_of, solve_inverse, turn_into_limits
from wpcal.robot.kinematics.offset_wrist import OffsetWrist
from wpcal.robot.kinematics.opw import OPWGeometry

ZONE_SIDE = 0.25
"""The zone extends from the middle by this part of the distance between the bases: towards both, and to both sides."""
ZONE_HEIGHTS = (0.25, 0.85)
"""Bottom and top of the zone above the bases, in parts of the shorter reach: from a low table to the shoulders."""
GRID = (np.array([0.1, 0.5, 0.9]), np.array([0.1, 0.5, 0.9]), np.array([0.1, 0.4, 0.7, 0.95]))
"""Candidate places, in parts of the zone."""
AIR_STEP_MM = 10.0  #: Of approach and retract: the tip leaves its line by some hundredths of a millimetre on it.
LARGEST_AIR_MOVE_RAD = math.radians(20.0)
"""A step of 10 mm turns a joint by more only near a singular pose: the approach then begins after that pose."""


def reach_mm(arm: Arm) -> float:
    """Return the distance from the shoulder to the centre of the wrist of the stretched arm, mm."""
    family = family_of(arm.as_nominal().chain)
    if isinstance(family, OffsetWrist):
        return family.reach_mm
    return family.c2 + length([family.a2, family.c3])


def weld_zone(cell: Cell) -> tuple[FloatArray, FloatArray]:
    """Return the least and largest place of the weld point, shape (3,) each, mm in `middle`."""
    side = ZONE_SIDE * length(cell.T_base1_base2.t_mm)
    reach = min(reach_mm(cell.arm), reach_mm(cell.arm2))
    low, high = (reach * height for height in ZONE_HEIGHTS)
    return np.array([-side, -side, low]), np.array([side, side, high])


def candidate_places(cell: Cell) -> FloatArray:
    """Return places in the zone from which a search can start, shape (k, 3), mm in `middle`."""
    low, high = weld_zone(cell)
    parts = np.stack([grid.ravel() for grid in np.meshgrid(*GRID, indexing="ij")], axis=1)
    return np.asarray(low + parts * (high - low), dtype=np.float64)


def reach_shortage(arm: Arm, T_base_flange: FloatArray) -> FloatArray:
    """Return how far the centre of the wrist is outside the shell that an arm reaches.

    `T_base_flange`: shape (N, 4, 4). mm.
    Returns ndarray, shape (N,). mm; zero within the shell.
    """
    g = family_of(arm.as_nominal().chain)
    if isinstance(g, OffsetWrist):
        return g.shortage(T_base_flange)
    local = product(product(inverse_pose(g.T_base_opw), T_base_flange), inverse_pose(g.T_wrist_flange))
    across = np.sqrt(np.maximum(local[:, 0, 3] ** 2 + local[:, 1, 3] ** 2 - g.b**2, 0.0))
    kappa = length([g.a2, g.c3])
    distance = np.sqrt((across - g.a1) ** 2 + (local[:, 2, 3] - g.c1) ** 2)
    short = np.maximum(np.maximum(distance - g.c2 - kappa, abs(g.c2 - kappa) - distance), 0.0)
    return np.asarray(short, dtype=np.float64)


LEAST_REGULARITY = 0.1
"""Measures stay above this (a wrist bent by six degrees): joint rates are then at most ten times the tool's rate."""


def regularity(arm: Arm, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Measure the distance from singular poses.

    `q`: shape (n, 6). Shown angles, rad.
    Returns `values`: ndarray, shape (n, c). Three of an arm with a spherical wrist. Wrist: sine of its bend. Elbow:
    sine of the angle off the stretched arm. Shoulder: distance of the wrist's centre from axis 1 in the plane of the
    arm, in parts of the reach. Of another arm one: the cube root of the determinant that for the first ones is the
    product of the three. Absolute values.
    Returns `slopes`: ndarray, shape (n, c, 6). Derivatives with respect to the shown angles, per rad.
    """
    g = family_of(arm.as_nominal().chain)
    if isinstance(g, OffsetWrist):
        steps = SLOPE_STEP_RAD * np.concatenate([np.eye(JOINTS), -np.eye(JOINTS)])
        ends = _determinant(arm, g, (q[:, None] + steps).reshape(-1, JOINTS)).reshape(len(q), 2, 1, JOINTS)
        return _determinant(arm, g, q)[:, None], (ends[:, 0] - ends[:, 1]) / (2.0 * SLOPE_STEP_RAD)
    theta = arm.model_angles(q) * g.signs + g.offsets
    values, (c5, c3, c2, c23), (upper, fore) = _three_measures(g, theta)
    slopes = np.zeros((len(theta), 3, 6))
    slopes[:, 0, 4] = c5
    slopes[:, 1, 2] = c3
    slopes[:, 2, 2] = fore * c23
    slopes[:, 2, 1] = upper * c2 + slopes[:, 2, 2]
    signs = np.sign(values)
    return np.abs(values), product(signs[:, :, None] * (slopes * g.signs), arm.coupling_matrix)


SLOPE_STEP_RAD = 1e-5  #: Of central differences of the determinant.


def _three_measures(g: OPWGeometry, theta: FloatArray) -> tuple[FloatArray, FloatArray, tuple[float, float]]:
    """Return wrist, elbow and shoulder with their signs, the cosines that their slopes need, and the arm's shares."""
    t2, t3, t5 = theta[:, 1], theta[:, 2], theta[:, 4]
    kappa, bend = length([g.a2, g.c3]), arc_tangent(g.a2, g.c3)
    upper, fore = g.c2 / (g.c2 + kappa), kappa / (g.c2 + kappa)
    (s5, s3, s2, s23), cosines = sine_cosine(np.stack([t5, t3 + bend, t2, t2 + t3 + bend]))
    return np.stack([s5, s3, g.a1 / (g.c2 + kappa) + upper * s2 + fore * s23], axis=1), cosines, (upper, fore)


def _determinant(arm: Arm, g: OffsetWrist, q: FloatArray) -> FloatArray:
    """Return the cube root of the determinant of the Jacobian, in parts of the lengths of the arm, shape (n,)."""
    upper, fore = g.arm_lengths_mm
    _, det = solve(arm.jacobian(q), np.zeros((len(q), JOINTS, 1)))
    return np.cbrt(det / (upper * fore * (upper + fore)))


def is_within_turns(arm: Arm, q: FloatArray) -> BoolArray:
    """Tell which joints some whole turns bring within the limits, shape (...).

    `q`: shape (..., 6). Shown angles, rad; NaN where there are none.
    """
    low, high = arm.limits
    with np.errstate(invalid="ignore"):
        return np.asarray((np.ceil((low - q) / TURN) <= np.floor((high - q) / TURN)).all(axis=-1))  # NaN: none


def is_usable(arm: Arm, q: FloatArray) -> BoolArray:
    """Tell which joints, shape (..., 6), whole turns bring within the limits, and are away from singular poses."""
    usable = is_within_turns(arm, q)
    usable[usable] = is_regular(arm, q[usable])
    return usable


def is_regular(arm: Arm, q: FloatArray) -> BoolArray:
    """Tell which joints are away from singular poses, shape (...).

    `q`: shape (..., 6). Shown angles, rad; NaN where there are none.
    """
    g, rows = family_of(arm.as_nominal().chain), np.nan_to_num(q).reshape(-1, q.shape[-1])
    if isinstance(g, OffsetWrist):
        values = _determinant(arm, g, rows)[:, None]
    else:
        values = np.abs(_three_measures(g, arm.model_angles(rows) * g.signs + g.offsets)[0])
    return np.asarray((values.min(axis=1) >= LEAST_REGULARITY).reshape(q.shape[:-1])) & np.isfinite(q).all(axis=-1)


def least_shortage(cell: Cell, flanges: tuple[FloatArray, FloatArray]) -> tuple[int, float]:
    """Return the robot (0 or 1) that is out of reach where both robots are so by the least, and by how much, mm.

    `flanges`: shape (N, 4, 4) each. In the base of each robot, mm.
    """
    short = np.stack([reach_shortage(arm, T) for arm, T in zip((cell.arm, cell.arm2), flanges, strict=True)])
    best = short[:, np.argmin(short.max(axis=0))]
    return int(np.argmax(best)), float(best.max())


def back_along_wire(cell: Cell, joints: FloatArray, distance_mm: float) -> FloatArray:
    """Return joints at steps of `AIR_STEP_MM` away from n poses, against the wire, shape (n, a, 6).

    NaN from where a way is not reached. `joints`: shape (n, 6). Of the robot with the torch, rad; nothing else moves.
    """
    n, count = len(joints), math.ceil(distance_mm / AIR_STEP_MM)
    if count == 0:
        return np.empty((n, 0, joints.shape[1]))
    back = np.linspace(0.0, distance_mm, count + 1)[1:]
    flange = cell.arm.forward(joints)
    T = np.repeat(flange[:, None], count, axis=1)
    T[:, :, :3, 3] -= back[:, None] * product(flange[:, :3, :3], cell.T_flange_tool.R[:, 2])[:, None]
    every = solve_inverse(cell.arm, T.reshape(-1, 4, 4)).joints.reshape(n, count, -1, joints.shape[1])
    found, last = np.full((n, count, joints.shape[1]), np.nan), joints
    for step in range(count):
        near = turn_into_limits(cell.arm, every[:, step], last[:, None])
        move = np.nan_to_num(np.abs(near - last[:, None]).max(axis=2), nan=np.inf)
        best = np.argmin(move, axis=1)
        goes = move[np.arange(n), best] <= LARGEST_AIR_MOVE_RAD
        last = np.where(goes[:, None], near[np.arange(n), best], np.nan)
        found[:, step] = last
    return found
