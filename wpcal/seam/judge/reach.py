"""Whether a torch can reach a seam: straight lines out of the joint that leave the part."""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.near_groups import first_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
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
    graph: BrepGraph, trimmed: TrimmedFaces, seam: IntArray, p: FloatArray, R: FloatArray, *, start_mm: FloatArray
) -> FloatArray:
    """Return the share of directions, for each frame, in which a torch reaches the seam; shape (n,).

    A direction is free if the ray of the wire leaves the part, and eight rays around it at the radius of the nozzle do.

    Parameters
    ----------
    graph, trimmed :
        The part.
    seam : ndarray of int, shape (n,)
        Number of the seam, ascending.
    p : ndarray, shape (n, 3)
        Origins on the seam, in `part`, mm.
    R : ndarray, shape (n, 3, 3)
        Seam frames in `part`.
    start_mm : ndarray, shape (n,)
        How far out of the joint the rays of the wire start.
    """
    rays = cone_of_rays(R)
    n, k = rays.shape[:2]
    ways = np.moveaxis(rays, 1, 0).reshape(-1, 3)
    origins, start, side = np.tile(p, (k, 1)), np.tile(start_mm, k), np.tile(R[:, :, 1], (k, 1))
    owner = np.add.outer(np.arange(k) * (n and seam[-1] + 1), seam).ravel()
    free = np.ones(len(owner), dtype=bool)
    wire = (origins + start[:, None] * ways)[:, None]
    free &= first_faces(graph, trimmed, owner, wire, ways, np.maximum(USUAL_TORCH.wire_mm - start, 0.0)) < 0
    rows = np.flatnonzero(free)
    across = np.cross(ways[rows], side[rows])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    side = np.cross(across, ways[rows])
    radius = USUAL_TORCH.nozzle_radius_mm - TOUCH_MM
    mouth = origins[rows] + USUAL_TORCH.wire_mm * ways[rows]
    slant, other = np.sqrt(0.5) * (across + side), np.sqrt(0.5) * (across - side)
    offsets = [0.0 * side, *(sign * rim for rim in (across, side, slant, other) for sign in (1.0, -1.0))]
    bundle = np.stack([mouth + radius * offset for offset in offsets], axis=1)
    length = np.full(len(rows), USUAL_TORCH.length_mm)
    free[rows] = first_faces(graph, trimmed, owner[rows], bundle, ways[rows], length) < 0
    return np.asarray(free.reshape(k, n).mean(axis=0), dtype=np.float64)
