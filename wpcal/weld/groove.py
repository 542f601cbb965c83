"""The groove of a butt weld, measured from the faces of the model: angle, root face and gap.

The two plates are cut across the seam. Their outer surfaces, which are parallel, give the direction of depth. At every
height the distance between the plates is known exactly, because their outlines are straight. From the outer surface
down it narrows (the bevels), stays as it is (the root face), and may open again: then the weld is made from both sides.
Curved preparations (J and U) are not measured.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.seam.seam import Seam
from wpcal.weld.values import WeldKind

STATION = 0.43  #: Where along the seam the plates are cut: not in its middle, where models have edges and holes.
LEAST_BEVEL = math.tan(math.radians(2.0))  #: A side that leans by less is square: mills and saws are not better.
LEAST_MM = 0.02  #: Heights that differ by less are one; a gap of less is none.
LEAST_FACE_MM = 1.0  #: A shorter piece of an outline is no outer surface.
PARALLEL = math.cos(math.radians(3.0))  #: Outer surfaces of two plates in one line are parallel within this.
FACING = 0.3  #: The seam looks at the outer surface: least cosine between its z and the normal.
FAR_MM = 100.0  #: Outlines are looked at this far from the seam, either way.


@dataclass(frozen=True, slots=True)
class Groove:
    """A measured groove, in the cross-section of its seam."""

    kind: WeldKind
    angle_deg: float  #: Between both sides.
    left_share: float  #: Share of the angle at the side of -y, 0 to 1.
    #: `gap_mm`, `root_face_mm`: Of a weld from both sides the root face is half of that of the plates: each side welds
    #: its half.
    gap_mm: float
    root_face_mm: float
    #: From the outer surface to the root: to the end of the root face, or to its middle for a weld from both sides.
    depth_mm: float
    thickness_mm: float  #: Of the thinner plate.
    #: `y_mm`, `z_mm`: Middle of the gap at the root, in the frame of the seam.
    y_mm: float
    z_mm: float
    tilt_rad: float  #: From z of the seam to the direction of depth, outwards; positive towards -y.

    def values(self) -> dict[str, Any]:
        """Return the values of weld data that the model states, as JSON holds them."""
        found: dict[str, Any] = {"weld": self.kind.value}
        if self.depth_mm > LEAST_MM:
            found["depth_mm"] = round(self.depth_mm, 2)
        found |= {"thickness_mm": round(self.thickness_mm, 1), "root_gap_mm": round(self.gap_mm, 2)}
        if self.kind is not WeldKind.SQUARE:
            found |= {"groove_angle_deg": round(self.angle_deg, 1), "root_face_mm": round(self.root_face_mm, 2)}
        return found


@dataclass(frozen=True, slots=True)
class _Layer:
    """Heights between which both sides are straight: u of both at both heights, and slopes away from the groove."""

    low: float
    high: float
    left: tuple[float, float]
    right: tuple[float, float]

    @property
    def slopes(self) -> tuple[float, float]:
        height = self.high - self.low
        return (self.left[0] - self.left[1]) / height, (self.right[1] - self.right[0]) / height

    @property
    def way(self) -> int:
        """1: the groove becomes wider outwards; -1: narrower; 0: both sides are square."""
        slopes = self.slopes
        if max(abs(one) for one in slopes) < LEAST_BEVEL:
            return 0
        return 1 if min(slopes) > -LEAST_BEVEL else -1 if max(slopes) < LEAST_BEVEL else 2


def measure_groove(seam: Seam, mesh: PartMesh, T_frame_part: RigidTransform) -> Groove | None:
    """Measure the groove at a seam between two plates.

    Returns: None if the seam does not join two solids of the mesh, their outer surfaces are not in one line, or the
    sides are square all through or of another shape than bevels and a root face.
    """
    solids = [solid for solid in mesh.solids if solid.name in seam.solids]
    if len(solids) != 2 or len(seam.frames) < 2:
        return None
    outlines = [_outline(solid, seam, T_frame_part) for solid in solids]
    found = _outer_surface(*outlines)
    if found is None:
        return None
    top, tilt = found
    one, other = (_turned(outline, tilt) for outline in outlines)
    left, right = sorted((other, one), key=lambda outline: float(outline[:, :, 0].mean()))
    layers = list(_layers(left, right, top))
    if not layers or layers[-1].low > LEAST_MM or top < -LEAST_MM:
        return None  # the seam is not in the groove
    return _groove(layers, tilt, top - layers[-1].low)


def _outline(solid: SolidMesh, seam: Seam, T_frame_part: RigidTransform) -> FloatArray:
    """Return the cut of a solid across the seam: pieces (k, 2, 2) in y and z of its frame, material at the left."""
    frames = seam.frames
    s = float(frames.s_mm[0] + STATION * (frames.s_mm[-1] - frames.s_mm[0]))
    p = np.array([np.interp(s, frames.s_mm, frames.p[:, axis]) for axis in range(3)])
    R = frames.R[int(np.abs(frames.s_mm - s).argmin())]
    q = (T_frame_part.apply(solid.points) - p) @ R
    corners = q[solid.triangles]
    ahead = corners[:, :, 0] > 0.0
    cut = corners[ahead.any(axis=1) & ~ahead.all(axis=1)]
    cut = cut[(np.abs(cut[:, :, 1:]).min(axis=1) < FAR_MM).all(axis=1)]
    if not len(cut):
        return np.zeros((0, 2, 2))
    after = np.roll(cut, -1, axis=1)
    x0, x1 = cut[:, :, 0], after[:, :, 0]
    crosses = (x0 > 0.0) != (x1 > 0.0)
    share = np.where(crosses, x0 / np.where(crosses, x0 - x1, 1.0), 0.0)
    points = (cut + share[:, :, None] * (after - cut))[:, :, 1:]
    ends: FloatArray = points[crosses].reshape(len(cut), 2, 2)
    normal = np.cross(cut[:, 1] - cut[:, 0], cut[:, 2] - cut[:, 0])[:, 1:]
    along = ends[:, 1] - ends[:, 0]
    flip = along[:, 1] * normal[:, 0] - along[:, 0] * normal[:, 1] < 0.0
    ends[flip] = ends[flip, ::-1]
    return np.asarray(ends[np.linalg.norm(along, axis=1) > 0.0], dtype=np.float64)


def _normals(outline: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return outward normals (k, 2) and lengths (k,) of the pieces of an outline."""
    along = outline[:, 1] - outline[:, 0]
    length = np.linalg.norm(along, axis=1)
    return np.stack([along[:, 1], -along[:, 0]], axis=1) / length[:, None], length


def _outer_surface(first: FloatArray, second: FloatArray) -> tuple[float, float] | None:
    """Return the height of the surface that both plates have outside, and its tilt; None if there is none."""
    if not len(first) or not len(second):
        return None
    (n1, l1), (n2, l2) = _normals(first), _normals(second)
    fits = (n1 @ n2.T > PARALLEL) & (n1[:, 1] > FACING)[:, None] & (n2[:, 1] > FACING)[None, :]
    fits &= (l1 > LEAST_FACE_MM)[:, None] & (l2 > LEAST_FACE_MM)[None, :]
    h1, h2 = np.einsum("ij,ij->i", n1, first[:, 0]), np.einsum("ij,ij->i", n2, second[:, 0])
    fits &= (h1 > -LEAST_MM)[:, None] & (h2 > -LEAST_MM)[None, :]
    if not fits.any():
        return None
    row, column = np.unravel_index(np.argmax(np.where(fits, np.minimum(l1[:, None], l2[None, :]), -1.0)), fits.shape)
    y, z = n1[row]
    return float(min(h1[row], h2[column])), float(math.atan2(-y, z))


def _turned(outline: FloatArray, tilt_rad: float) -> FloatArray:
    """Express an outline in u across the groove and h outwards."""
    c, s = math.cos(tilt_rad), math.sin(tilt_rad)
    return np.asarray(outline @ np.array([[c, -s], [s, c]]), dtype=np.float64)


def _layers(left: FloatArray, right: FloatArray, top: float) -> Iterator[_Layer]:
    """Yield the layers between two plates from the outer surface down; equal ones are one."""
    bottom = max(left[:, :, 1].min(), right[:, :, 1].min())
    heights = np.unique(np.concatenate([left[:, :, 1].ravel(), right[:, :, 1].ravel(), [bottom, top]]))
    heights = heights[(heights >= bottom) & (heights <= top)][::-1]
    kept: list[float] = []
    for height in heights.tolist():
        if not kept or kept[-1] - height > LEAST_MM:
            kept.append(height)
    before: _Layer | None = None
    for high, low in pairwise(kept):
        quarter = (high - low) / 4.0
        ends = [(_side(left, h, np.max), _side(right, h, np.min)) for h in (low + quarter, high - quarter)]
        if None in ends[0] or None in ends[1]:
            break
        (l0, r0), (l1, r1) = ends
        own = _Layer(low, high, _extended(l0, l1), _extended(r0, r1))
        if before is not None and np.allclose(before.slopes, own.slopes, rtol=0.0, atol=LEAST_BEVEL / 4.0):
            before = _Layer(low, before.high, (own.left[0], before.left[1]), (own.right[0], before.right[1]))
        else:
            if before is not None:
                yield before
            before = own
    if before is not None:
        yield before


def _extended(quarter: Any, rest: Any) -> tuple[float, float]:
    """Return the ends of a straight side from its values at a quarter and at three quarters."""
    return quarter - (rest - quarter) / 2.0, rest + (rest - quarter) / 2.0


def _side(outline: FloatArray, height: float, nearest: Any) -> float | None:
    """Return where a plate ends towards the groove at a height."""
    h0, h1 = outline[:, 0, 1], outline[:, 1, 1]
    rows = (h0 > height) != (h1 > height)
    if not rows.any():
        return None
    share = (height - h0[rows]) / (h1[rows] - h0[rows])
    u = outline[rows, 0, 0] + share * (outline[rows, 1, 0] - outline[rows, 0, 0])
    return float(nearest(u))


def _groove(layers: Sequence[_Layer], tilt: float, thickness: float) -> Groove | None:
    """Return the groove that layers make, from the outer surface down."""
    ways = tuple(layer.way for layer in layers)
    if ways not in ((1,), (1, 0), (1, 0, -1), (1, -1), (0, -1), (-1,)):
        return None
    bevel = layers[0] if ways[0] == 1 else None
    root = next((layer for layer in layers if layer.way == 0), None)
    is_double = ways[-1] == -1 and bevel is not None
    low = layers[0].low if root is None else (root.low + root.high) / 2.0 if is_double else root.low
    at, end = root or layers[0], 0
    if ways == (-1,):  # from behind, where there is no root face
        low, end = layers[0].high, 1
    left, right = at.left[end], at.right[end]
    gap = right - left
    depth = layers[0].high - low
    kl, kr = (max(0.0, math.atan(one)) if one > LEAST_BEVEL else 0.0 for one in (bevel.slopes if bevel else (0.0, 0.0)))
    c, s = math.cos(tilt), math.sin(tilt)
    u = (left + right) / 2.0
    return Groove(
        _kind(is_bevel=not (kl and kr), is_double=is_double) if bevel else WeldKind.SQUARE,
        math.degrees(kl + kr),
        kl / (kl + kr) if bevel else 0.5,
        gap if gap > LEAST_MM else 0.0,
        0.0 if root is None or bevel is None else bevel.low - low,
        depth,
        thickness,
        u * c - low * s,
        u * s + low * c,
        tilt,
    )


def _kind(*, is_bevel: bool, is_double: bool) -> WeldKind:
    if is_bevel:
        return WeldKind.DOUBLE_BEVEL if is_double else WeldKind.SINGLE_BEVEL
    return WeldKind.DOUBLE_V if is_double else WeldKind.SINGLE_V
