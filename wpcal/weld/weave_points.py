"""A weave as points along a seam, for languages that have no weave of their own.

A swing to and fro is cut into points across the seam. In a fillet the wire keeps to the two plates: it goes from one
plate over the root to the other. Every line between two points is then out of the plates, because the space between
them is convex. The number of swings is whole, so the wire begins and ends at the middle.
"""

from dataclasses import replace

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import InputError
from wpcal.seam.seam import SeamFrames
from wpcal.weld.passes import Bead
from wpcal.weld.values import Weave, WeaveShape

LEAST_MM = 1.0  #: Between two points: shorter moves cannot be rounded at both ends, and robots stop at each of them.
ROUND_OFF_MM = 1e-9  #: Of a step that is just as long.
SINE_POINTS = 8
"""Per swing of a sine, where they are not too close: between two of them the line is at most 4 % of the width off."""
CORNER_RAD = float(np.radians(5.0))  #: Where a seam turns by more, the wire goes through its point, too.


def woven_frames(
    frames: SeamFrames, weave: Weave, speed_mm_s: float, *, bead: Bead | None = None, between_plates: bool = True
) -> SeamFrames:
    """Return the frames of a seam with a weave. m frames with the axes of the seam; `s_mm` is the way of the wire.

    Raises `InputError` if the weave is of another shape, its dwells are longer than a swing, or its points would be too
    close.
    """
    length = float(frames.s_mm[-1])
    swings = max(1, round(length / weave.length_mm))
    pitch = length / swings
    for points in (SINE_POINTS, 4) if weave.shape is WeaveShape.SINE else (4,):
        share, side = _swing(weave, speed_mm_s / pitch, points)
        steps = np.hypot(np.diff(share, prepend=0.0) * pitch, np.diff(side, prepend=0.0) * weave.width_mm / 2.0)
        if steps.min() >= LEAST_MM - ROUND_OFF_MM:
            break
    else:
        what = f"its points would be {steps.min():.2f} mm from each other; at least {LEAST_MM:g} mm are needed"
        raise InputError(f"weave: {what}; state a larger width_mm or length_mm")
    s = np.concatenate([[0.0], *((number + share) * pitch for number in range(swings))])
    y = np.concatenate([[0.0], np.tile(side, swings)]) * weave.width_mm / 2.0
    return _placed(frames, *_with_corners(frames, s, y), bead=bead, between_plates=between_plates)


def _swing(weave: Weave, swings_per_s: float, points: int) -> tuple[FloatArray, FloatArray]:
    """Return shares of a swing, and the side there from -1 to 1; the last one is the middle again."""
    if weave.shape not in (WeaveShape.ZIGZAG, WeaveShape.SINE):
        raise InputError(f"weave: a {weave.shape.value} cannot be written as points; state zigzag or sine")
    left, right = weave.dwell_left_s * swings_per_s, weave.dwell_right_s * swings_per_s
    quarter = (1.0 - left - right) / 4.0
    if quarter <= 0.0:
        raise InputError("weave: its dwells are longer than a swing")
    share = np.arange(1, points + 1) / points
    side = np.sin(2.0 * np.pi * share)
    side[-1] = side[points // 2 - 1] = 0.0
    if not left and not right:
        return share, side
    at = np.array([quarter, quarter + left, 2 * quarter + left, 3 * quarter + left, 1.0 - quarter, 1.0])
    kept = np.concatenate([np.diff(at) > 0.0, [True]])
    return at[kept], np.array([1.0, 1.0, 0.0, -1.0, -1.0, 0.0])[kept]


def _with_corners(frames: SeamFrames, s: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Add the corners of a seam, and leave out the points of the weave that are too close to them."""
    chords = np.diff(frames.p, axis=0)
    travel = chords / np.linalg.norm(chords, axis=1)[:, None]
    turn = np.arccos(np.clip(np.einsum("ij,ij->i", travel[:-1], travel[1:]), -1.0, 1.0))
    corners = frames.s_mm[1:-1][turn > CORNER_RAD]
    if not len(corners):
        return s, y
    near: BoolArray = np.abs(s[:, None] - corners).min(axis=1) < LEAST_MM
    near[[0, -1]] = False
    all_s = np.union1d(s[~near], corners)
    return all_s, np.interp(all_s, s, y)


def _placed(frames: SeamFrames, s: FloatArray, y: FloatArray, *, bead: Bead | None, between_plates: bool) -> SeamFrames:
    p = np.stack([np.interp(s, frames.s_mm, frames.p[:, axis]) for axis in range(3)], axis=1)
    R = frames.axes_at(s)
    angle = np.interp(s, frames.s_mm, frames.angle_rad)
    z = np.zeros(len(s))
    if between_plates:
        y0, z0 = (0.0, 0.0) if bead is None else (bead.y_mm, bead.z_mm)
        z = np.maximum(0.0, np.abs(y0 + y) * np.tan(angle / 2.0) - z0)  # a plate is at (pi - angle) / 2 from z
    p = p + y[:, None] * R[:, :, 1] + z[:, None] * R[:, :, 2]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    return replace(frames, s_mm=way, p=p, R=R, angle_rad=angle)
