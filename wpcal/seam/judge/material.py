"""Which poses have the tip, the wire or the nozzle inside material, and inside which solid."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wpcal.brep.material import FAR_MM, Material, find_solids_around
from wpcal.brep.rays import START_MM
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.torch import USUAL_TORCH, StraightTorch

AROUND = 8
"""Rays on each circle of the nozzle: 4 mm apart on the inner and 8 mm on the outer circle of a nozzle of 20 mm."""


class TorchPart(Enum):
    """What of a torch is inside material; the order is from the seam outwards."""

    TIP = "tip"
    WIRE = "wire"
    NOZZLE = "nozzle"


@dataclass(frozen=True, slots=True, eq=False)
class PosesInMaterial:
    """The poses at which a torch is inside material, one row each, by number of the pose.

    Parameters
    ----------
    row : ndarray of int, shape (k,)
        Numbers of the poses.
    solid : tuple of str, length k
        The solid that is hit first, from the tip outwards.
    part : tuple of TorchPart, length k
        The part of the torch nearest to the tip that is inside.
    """

    row: IntArray
    solid: tuple[str, ...]
    part: tuple[TorchPart, ...]

    def __len__(self) -> int:
        return len(self.row)


def find_poses_in_material(
    material: Material,
    p: FloatArray,
    back: FloatArray,
    torch: StraightTorch = USUAL_TORCH,
    *,
    start_mm: FloatArray | float = START_MM,
) -> PosesInMaterial:
    """Find the poses at which the tip, the wire or the nozzle of a torch is inside material.

    Parameters
    ----------
    material : Material
        `ExactMaterial` of a graph, or `TriangleMaterial` of a `part.glb`.
    p : ndarray, shape (n, 3)
        Tips of the wire in `part`, mm.
    back : ndarray, shape (n, 3)
        Unit directions in `part` from the tip along the wire to the torch: z of a seam frame if the torch is not
        tilted.
    torch : StraightTorch
    start_mm : float or ndarray, shape (n,)
        The tip is in contact with the joint, so the wire is felt from this far away from its tip. On a modelled bead
        the tip is below the face of the bead; use `stations.BEAD_MM` there.

    Returns
    -------
    PosesInMaterial

    Notes
    -----
    The wire is a line. The nozzle is felt along its axis and 16 lines around it, to the end of the torch.
    """
    n = len(p)
    start = np.broadcast_to(np.asarray(start_mm, dtype=np.float64), n)
    free = np.ones(n, dtype=bool)
    found: list[tuple[int, int, TorchPart]] = []
    for part, rows, solids in _inside(material, p, back, torch, start, free):
        for row, solid in zip(rows.tolist(), solids.tolist(), strict=True):
            if free[row]:
                free[row] = False
                found.append((row, solid, part))
    found.sort(key=lambda item: item[0])
    names = tuple(material.names[solid] for _, solid, _ in found)
    return PosesInMaterial(np.array([item[0] for item in found], dtype=np.int64), names, tuple(t for *_, t in found))


def _inside(
    material: Material, p: FloatArray, back: FloatArray, torch: StraightTorch, start: FloatArray, free: BoolArray
) -> Iterator[tuple[TorchPart, IntArray, IntArray]]:
    """Yield parts of the torch from the tip outwards, with the poses and solids; only poses still free are asked."""
    point, solid = find_solids_around(material, p + start[:, None] * back)
    yield TorchPart.TIP, point, solid
    rows = np.flatnonzero(free)
    length = np.maximum(torch.stickout_mm - start[rows], 0.0)
    hits = material.hits(p[rows] + start[rows, None] * back[rows], back[rows], length)
    yield TorchPart.WIRE, rows[hits.ray], hits.solid
    rows = np.flatnonzero(free)
    arms = nozzle_arms(back[rows], torch.nozzle_mm / 2.0)
    k = arms.shape[1]
    mouth = np.maximum(torch.stickout_mm, start[rows])
    origins = p[rows, None] + mouth[:, None, None] * back[rows, None] + arms
    hits = material.hits(origins.reshape(-1, 3), np.repeat(back[rows], k, axis=0), FAR_MM)
    first = np.diff(hits.ray, prepend=-1) > 0
    reached = hits.at_mm <= np.repeat(torch.length_mm - mouth, k)[hits.ray]
    within = np.flatnonzero(reached | (first & (hits.way > 0)))
    nearest = within[np.argsort(hits.at_mm[within], kind="stable")]
    yield TorchPart.NOZZLE, rows[hits.ray[nearest] // k], hits.solid[nearest]


def nozzle_arms(back: FloatArray, radius_mm: float) -> FloatArray:
    """Return the places on the mouth of a nozzle from which its rays start, relative to its centre.

    Parameters
    ----------
    back : ndarray, shape (n, 3)
        Unit directions along the nozzle.
    radius_mm : float

    Returns
    -------
    ndarray, shape (n, 17, 3)
        The centre, eight places at half the radius and eight on the rim, mm.
    """
    least = np.eye(3)[np.argmin(np.abs(back), axis=1)]
    u = np.cross(back, least)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    w = np.cross(back, u)
    turn = np.arange(AROUND) * 2.0 * np.pi / AROUND
    rim = np.cos(turn)[:, None] * u[:, None] + np.sin(turn)[:, None] * w[:, None]
    return np.asarray(radius_mm * np.concatenate([np.zeros((len(back), 1, 3)), rim / 2.0, rim], axis=1))
