"""Whether a torch can reach a seam: straight lines out of the joint that leave the part."""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.rays import START_MM, is_bundle_blocked
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import rotation_from_zyx
from wpcal.seam.torch import USUAL_TORCH

WORK_RAD, TRAVEL_RAD = np.radians(15.0), np.radians(25.0)
"""Tilts of the torch across and along the seam: as far as welders go before they call a joint unreachable."""
TOUCH_MM = 1e-3
"""A nozzle that touches a face along a line is free, so rays around it are this much nearer to its axis."""
LEAST_FREE = 0.6
"""Share of the directions of the torch that must be free: one direction out through the end of a pipe is not enough."""


def cone_of_rays(R: FloatArray) -> FloatArray:
    """Return the z axis of each frame and four directions around it.

    Parameters
    ----------
    R : ndarray, shape (n, 3, 3)

    Returns
    -------
    ndarray, shape (n, 5, 3)
    """
    tilt = [(0.0, 0.0), (WORK_RAD, 0.0), (-WORK_RAD, 0.0), (0.0, TRAVEL_RAD), (0.0, -TRAVEL_RAD)]
    z = np.array([rotation_from_zyx(work, travel, 0.0)[:, 2] for work, travel in tilt])
    return np.asarray(np.einsum("nij,kj->nki", R, z), dtype=np.float64)


def free_share(
    graph: BrepGraph, trimmed: TrimmedFaces, p: FloatArray, R: FloatArray, *, start_mm: FloatArray | float = START_MM
) -> FloatArray:
    """Return the share of directions, for each frame, in which a torch reaches the seam; shape (n,).

    A direction is free if the ray of the wire leaves the part, and eight rays around it at the radius of the nozzle do.

    Parameters
    ----------
    graph, trimmed :
        The part.
    p : ndarray, shape (n, 3)
        Origins on the seam, in `part`, mm.
    R : ndarray, shape (n, 3, 3)
        Seam frames in `part`.
    start_mm : float or ndarray, shape (n,)
        How far out of the joint the rays of the wire start.
    """
    rays = cone_of_rays(R)
    n, k = rays.shape[:2]
    ways = rays.reshape(-1, 3)
    origins = np.repeat(p, k, axis=0)
    start = np.repeat(np.broadcast_to(np.asarray(start_mm, dtype=np.float64), n), k)
    side = np.repeat(R[:, :, 1], k, axis=0)
    across = np.cross(ways, side)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    side = np.cross(across, ways)
    radius = USUAL_TORCH.nozzle_radius_mm - TOUCH_MM
    mouth = origins + USUAL_TORCH.wire_mm * ways
    radius = USUAL_TORCH.nozzle_radius_mm - TOUCH_MM
    crossed = np.stack([across, -across, side, -side], axis=1)
    diagonal = np.sqrt(0.5) * np.stack([across + side, across - side, side - across, -across - side], axis=1)
    wire = (origins + start[:, None] * ways)[:, None]
    first = np.concatenate([wire, mouth[:, None] + radius * crossed], axis=1)
    free = ~is_bundle_blocked(graph, trimmed, first, ways, length_mm=USUAL_TORCH.length_mm)
    rows = np.flatnonzero(free)  # most of those that are blocked are so by the first rays
    more = mouth[rows, None] + radius * diagonal[rows]
    free[rows] = ~is_bundle_blocked(graph, trimmed, more, ways[rows], length_mm=USUAL_TORCH.length_mm)
    return np.asarray(free.reshape(n, k).mean(axis=1), dtype=np.float64)
