"""Straight tubes with flat ends against triangles, and the lines that stand for a tube against exact faces."""

from typing import TypeAlias

import numpy as np

from wpcal.brep.boxes import BoxTree
from wpcal.brep.surfaces import square_to
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

CHUNK = 20_000  #: Pairs of a tube and a triangle in one array: they stay in the processor's cache.
ROUND_OFF_MM = 1e-6  #: Of places along the axes of a tube.
EDGE_ON = 1e-9  #: An axis runs along a triangle of which it sees less than this share of its square: the chords tell.
LEAST_MM = 1e-12  #: Of a segment seen along the axis of a cone: a shorter one is a point, and its width a jump.
Radius: TypeAlias = float | tuple[float, float]  #: Of a tube, or of a cone where it begins and where it ends, mm.
LINES_MM = 4.0  #: Neighbouring lines of a tube are at most this far apart: less than the thinnest rod that is welded.


def tube_triangles(
    corners: FloatArray,
    tree: BoxTree,
    tips: FloatArray,
    back: FloatArray,
    ends_mm: tuple[FloatArray, FloatArray],
    radius_mm: Radius,
) -> IntArray:
    """Find what straight tubes or cones meet: the triangle nearest to the axis, of a cone nearest to its surface.

    Each triangle is cut off at both ends of the tube; what remains is compared with the radius. Of equally near
    triangles the last is taken.

    Returns ndarray of int, shape (n,). The triangle; -1 for a tube that meets none.

    `corners`: shape (m, 3, 3). The three corners of each triangle, mm.
    `tips`: shape (n, 3). Points on the axes, in the frame of the corners, mm.
    `back`: shape (n, 3). Unit vectors along the axes.
    `ends_mm`: shapes (n,). Where each tube begins and ends, mm from the tip.
    """
    low, high = ends_mm
    first, last = radius_mm if isinstance(radius_mm, tuple) else (radius_mm, radius_mm)
    slope = None if first == last else (last - first) / np.where(high > low, high - low, np.inf)
    wide = max(first, last)
    starts, ends = tips + low[:, None] * back, tips + high[:, None] * back
    row, triangle = tree.meeting(np.minimum(starts, ends) - wide, np.maximum(starts, ends) + wide)
    best, nearest = np.full(len(tips), np.nextafter(first, 0.0)), np.full(len(tips), -1)
    frames = tube_frames(back)
    at = np.einsum("nij,nj->in", frames, tips)
    box = at - wide - ROUND_OFF_MM, at + wide + ROUND_OFF_MM
    box[0][2], box[1][2] = at[2] + low - ROUND_OFF_MM, at[2] + high + ROUND_OFF_MM
    corner_rows, frame_rows = (np.ascontiguousarray(each.transpose(1, 2, 0)) for each in (corners, frames))
    for begin in range(0, len(row), CHUNK):
        own, which = row[begin : begin + CHUNK], triangle[begin : begin + CHUNK]
        kept = _reach_in(corner_rows[:, :, which], frame_rows[:, :, own], box[0][:, own], box[1][:, own])
        own, which = own[kept], which[kept]
        kept = _comes_near(starts[own], ends[own], corners[which], wide)
        own, which = own[kept], which[kept]
        placed = np.einsum("kcj,kij->kci", corners[which] - tips[own, None], frames[own])
        found = _axis_distances(placed, low[own], high[own], None if slope is None else slope[own])
        order = np.argsort(-found, kind="stable")  # the nearest of each tube is written last
        closer = order[found[order] <= best[own[order]]]
        best[own[closer]], nearest[own[closer]] = found[closer], which[closer]
    return nearest


def _reach_in(corners: FloatArray, axes: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Tell which triangles reach into boxes, shape (k,): all others are beside the axes, or beyond an end.

    `corners`, `axes`: shape (3, 3, k). The three of each, their coordinates on the second axis.
    `low`, `high`: shape (3, k). Where the boxes begin and end along their axes.
    """
    met = np.ones(corners.shape[2], dtype=bool)
    for (x, y, z), least, most in zip(axes, low, high, strict=True):
        a, b, c = (corner[0] * x + corner[1] * y + corner[2] * z for corner in corners)
        met &= (np.minimum(np.minimum(a, b), c) <= most) & (np.maximum(np.maximum(a, b), c) >= least)
    return met


def _comes_near(starts: FloatArray, ends: FloatArray, corners: FloatArray, radius_mm: float) -> BoolArray:
    """Tell which axes come within a radius of the plane of a triangle, shape (k,): the others are not compared."""
    a, b, c = np.moveaxis(corners, 1, 0)
    normal = np.cross(b - a, c - a)
    far = radius_mm * np.sqrt(np.einsum("ki,ki->k", normal, normal))
    first, last = np.einsum("ki,ki->k", starts - a, normal), np.einsum("ki,ki->k", ends - a, normal)
    return np.asarray((np.minimum(first, last) <= far) & (np.maximum(first, last) >= -far), dtype=np.bool_)


def tube_lines(back: FloatArray, radius_mm: float) -> FloatArray:
    """Return where the lines of tubes begin: on the axis, and on circles around it.

    The outermost circle is wider than the tube, so that no plane reaches into the tube between two lines.

    `back`: shape (n, 3). Unit vectors along the axes.
    Returns ndarray, shape (n, k, 3). Relative to the axis, mm; the axis first.
    """
    circles = int(np.ceil(1.05 * radius_mm / LINES_MM))
    u = square_to(back)
    w = np.cross(back, u)
    lines = [np.zeros((len(back), 1, 3))]
    for circle in range(1, circles + 1):
        turn = np.arange(6 * circle)[:, None] * (2.0 * np.pi / (6 * circle))
        rim = np.cos(turn) * u[:, None] + np.sin(turn) * w[:, None]
        wider = 1.0 / np.cos(np.pi / (6 * circle)) if circle == circles else 1.0
        lines.append(wider * radius_mm * circle / circles * rim)
    return np.concatenate(lines, axis=1)


def _axis_distances(placed: FloatArray, low: FloatArray, high: FloatArray, slope: FloatArray | None) -> FloatArray:
    """Return how near triangles come to the z axis between two heights; infinity if not between.

    `placed`: shape (k, 3, 3). Corners in the frames of the tubes.
    `slope`: shape (k,), optional. Of a cone: what it is wider per height is taken off the distance. On a plane this is
    linear along lines from where the axis meets the plane, so its least value on a triangle is on the border.
    """
    flat, z = placed[..., :2], placed[..., 2]
    best = np.full(len(placed), np.inf)
    cuts: list[tuple[FloatArray, BoolArray]] = []
    for k in range(3):
        a, b, za, zb = flat[:, k], flat[:, (k + 1) % 3], z[:, k], z[:, (k + 1) % 3]
        best = np.minimum(best, edge_distances((a, b), (za, zb), low, high, slope))
        rise = np.where(za == zb, 1.0, zb - za)
        for height in (low, high):
            share = (height - za) / rise
            cuts.append((a + share[:, None] * (b - a), (za != zb) & (share >= 0.0) & (share <= 1.0)))
    for end in (0, 1):  # the chords in which the ends of the tube cut the triangle
        ends = cuts[end::2]
        wider = 0.0 if slope is None else slope * end * (high - low)
        for i, j in ((0, 1), (1, 2), (2, 0)):
            both = ends[i][1] & ends[j][1]
            best = np.where(both, np.minimum(best, _from_origin(ends[i][0], ends[j][0]) - wider), best)
    return np.where(_axis_goes_through(flat, z, low, high), -np.inf if slope is not None else 0.0, best)


def edge_distances(
    ends: tuple[FloatArray, FloatArray],
    heights: tuple[FloatArray, FloatArray],
    low: FloatArray,
    high: FloatArray,
    slope: FloatArray | None = None,
) -> FloatArray:
    """Return how near segments come to the origin of the plane, shape (k,), between two heights; else infinity.

    `ends`, `heights`: Where segments begin and end beside the axis, shapes (k, 2), and along it, shapes (k,).
    `slope`: shape (k,), optional. Of a cone (`_axis_distances`).
    """
    (a, b), (za, zb) = ends, heights
    is_level = za == zb
    rise = np.where(is_level, 1.0, zb - za)
    t = np.sort(np.stack([(low - za) / rise, (high - za) / rise]), axis=0)
    level = is_level & (za >= low) & (za <= high)
    t0 = np.where(is_level, np.where(level, 0.0, 2.0), np.maximum(t[0], 0.0))
    t1 = np.where(is_level, 1.0, np.minimum(t[1], 1.0))
    first, last = a + t0[:, None] * (b - a), a + t1[:, None] * (b - a)
    if slope is None:
        return np.where(t0 <= t1, _from_origin(first, last), np.inf)
    widths = [slope * (za + share * (zb - za) - low) for share in (t0, t1)]
    return np.where(t0 <= t1, _from_cone(first, last, *widths), np.inf)


def tube_frames(back: FloatArray) -> FloatArray:
    """Return axes of tubes as rows, shape (n, 3, 3): two across, and `back` (n, 3), unit vectors along them."""
    side = np.cross(back, np.where(np.abs(back[:, :1]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]]))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return np.stack([side, np.cross(back, side), back], axis=1)


def _from_origin(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the distances of plane segments from the origin, shape (k,)."""
    span = b - a
    squared = np.maximum((span**2).sum(axis=1), np.finfo(float).tiny)
    t = np.clip(-(a * span).sum(axis=1) / squared, 0.0, 1.0)
    return np.asarray(np.linalg.norm(a + t[:, None] * span, axis=1), dtype=np.float64)


def _from_cone(a: FloatArray, b: FloatArray, wa: FloatArray, wb: FloatArray) -> FloatArray:
    r"""Return the least distance of plane segments from the origin, less a width that changes along them, shape (k,).

    With :math:`\rho = \sqrt{d^2 + s^2}` at the length s from the foot, and the width w s, the least value is at
    :math:`s = w d / \sqrt{1 - w^2}`, and at an end where the width grows faster than the distance can.

    `a`, `b`: shape (k, 2). `wa`, `wb`: shape (k,). The width at both ends, mm.
    """
    span = b - a
    length = np.maximum(np.linalg.norm(span, axis=1), LEAST_MM)
    way = span / length[:, None]
    foot = -(a * way).sum(axis=1)
    off, grows = np.linalg.norm(a + foot[:, None] * way, axis=1), (wb - wa) / length
    inner = np.abs(grows) < 1.0
    ahead = off * grows / np.sqrt(np.where(inner, 1.0 - grows**2, 1.0))
    s = np.clip(np.where(inner, foot + ahead, np.where(grows > 0.0, length, 0.0)), 0.0, length)
    return np.asarray(np.linalg.norm(a + s[:, None] * way, axis=1) - (wa + s * grows), dtype=np.float64)


def _axis_goes_through(flat: FloatArray, z: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    weights = np.stack(
        [
            flat[:, (k + 1) % 3, 0] * flat[:, (k + 2) % 3, 1] - flat[:, (k + 1) % 3, 1] * flat[:, (k + 2) % 3, 0]
            for k in range(3)
        ],
        axis=1,
    )
    total = weights.sum(axis=1)
    real = np.abs(total) > EDGE_ON * (flat**2).sum(axis=(1, 2))
    weights = weights / np.where(real, total, 1.0)[:, None]
    height = (weights * z).sum(axis=1)
    return np.asarray(real & (weights >= 0.0).all(axis=1) & (height >= low) & (height <= high), dtype=np.bool_)
