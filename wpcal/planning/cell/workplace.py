"""The weld zone: the places between the robots where the weld may be, in the frame `middle` of the cell."""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import inverse_pose, length, product
from wpcal.planning.cell.cell import Cell
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.opw import OPWGeometry

ZONE_SIDE = 0.25
"""The zone extends from the middle by this part of the distance between the bases: towards both, and to both sides."""
ZONE_HEIGHTS = (0.25, 0.85)
"""Bottom and top of the zone above the bases, in parts of the shorter reach: from a low table to the shoulders."""
GRID = (np.array([0.1, 0.5, 0.9]), np.array([0.1, 0.5, 0.9]), np.array([0.1, 0.4, 0.7, 0.95]))
"""Candidate places, in parts of the zone."""


def reach_mm(arm: Arm) -> float:
    """Return the distance from the shoulder to the centre of the wrist of the stretched arm, mm."""
    g = OPWGeometry.of_chain(arm.as_nominal().chain)
    return g.c2 + length([g.a2, g.c3])


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
    g = OPWGeometry.of_chain(arm.as_nominal().chain)
    local = product(product(inverse_pose(g.T_base_opw), T_base_flange), inverse_pose(g.T_wrist_flange))
    across = np.sqrt(np.maximum(local[:, 0, 3] ** 2 + local[:, 1, 3] ** 2 - g.b**2, 0.0))
    kappa = length([g.a2, g.c3])
    distance = np.sqrt((across - g.a1) ** 2 + (local[:, 2, 3] - g.c1) ** 2)
    short = np.maximum(np.maximum(distance - g.c2 - kappa, abs(g.c2 - kappa) - distance), 0.0)
    return np.asarray(short, dtype=np.float64)
