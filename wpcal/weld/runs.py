"""What a torch does in one go: one bead along one stretch of a seam.

A weld with one bead and no stitches is the seam itself. Otherwise each bead is moved in the frame of the seam, and each
stretch is cut out of it. All stretches of a bead come before the next bead.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from wpcal.core.arrays import FloatArray
from wpcal.seam.seam import Seam, SeamFrames
from wpcal.weld.passes import Bead
from wpcal.weld.seam_weld import SeamWeld


@dataclass(frozen=True, slots=True, eq=False)
class WeldRun:
    """One bead along one stretch.

    Parameters
    ----------
    seam : Seam
        What is welded, under the name of the run: ``W1``, ``W1.p2`` (second pass), ``W1.s3`` (third stretch).
    weld : SeamWeld
    bead : Bead or None
        None for the only bead.
    u95_mm : ndarray, shape (n,), or None
        The 95 % error at the frames, mm.
    """

    seam: Seam
    weld: SeamWeld
    bead: Bead | None
    u95_mm: FloatArray | None


def weld_runs(seam: Seam, weld: SeamWeld, u95_mm: FloatArray | None = None) -> tuple[WeldRun, ...]:
    """Return the runs of a weld in the order of welding.

    Parameters
    ----------
    seam : Seam
        With n frames.
    weld : SeamWeld
        Of this seam.
    u95_mm : ndarray, shape (n,), optional
    """
    beads: tuple[Bead | None, ...] = weld.beads or (None,)
    runs = []
    for bead in beads:
        of_bead = f"{seam.name}.p{bead.number}" if bead is not None and len(beads) > 1 else seam.name
        for number, (start, end) in enumerate(weld.stretches_mm, 1):
            name = f"{of_bead}.s{number}" if len(weld.stretches_mm) > 1 else of_bead
            frames = seam.frames if bead is None else _moved(seam.frames, bead)
            moved = replace(seam, frames=frames, lean_rad=_leans(seam, weld, bead))
            is_whole = start <= 0.0 and end >= seam.length_mm
            if is_whole:
                runs.append(WeldRun(replace(moved, name=name), weld, bead, u95_mm))
            else:
                cut, u95 = cut_seam(moved, start, end, u95_mm)
                runs.append(WeldRun(replace(cut, name=name), weld, bead, u95))
    return tuple(runs)


def _leans(seam: Seam, weld: SeamWeld, bead: Bead | None) -> FloatArray | None:
    """Return the leans of the torch: those of the weld data where a straight torch is free, else those of the seam."""
    work = (weld.values.work_angle_deg or 0.0) + (0.0 if bead is None else bead.work_angle_deg)
    asked = np.radians([work, weld.values.travel_angle_deg or 0.0])
    if not asked.any():
        return seam.lean_rad
    if seam.lean_rad is None:
        return np.tile(asked, (len(seam.frames), 1))
    is_straight = (np.nan_to_num(seam.lean_rad) == 0.0).all(axis=1)
    return np.where(is_straight[:, None], asked, seam.lean_rad)


def _moved(frames: SeamFrames, bead: Bead) -> SeamFrames:
    p = frames.p + bead.y_mm * frames.R[:, :, 1] + bead.z_mm * frames.R[:, :, 2]
    return replace(frames, p=p)


def cut_seam(
    seam: Seam, start_mm: float, end_mm: float, u95_mm: FloatArray | None = None
) -> tuple[Seam, FloatArray | None]:
    """Cut a stretch out of a seam. Between two frames the position is on the chord, and the axes turn evenly.

    Parameters
    ----------
    seam : Seam
        With n frames.
    start_mm, end_mm : float
        Lengths from its start.
    u95_mm : ndarray, shape (n,), optional

    Returns
    -------
    seam : Seam
        Open, with lengths from its own start.
    u95_mm : ndarray or None
        At its frames.
    """
    frames = seam.frames
    own = frames.s_mm
    inner = own[(own > start_mm) & (own < end_mm)]
    s = np.concatenate([[start_mm], inner, [end_mm]])
    p = np.stack([np.interp(s, own, frames.p[:, axis]) for axis in range(3)], axis=1)
    R = Slerp(own, Rotation.from_matrix(frames.R))(np.clip(s, own[0], own[-1])).as_matrix()
    angle = np.interp(s, own, frames.angle_rad)
    nearest = np.abs(own[None, :] - s[:, None]).argmin(axis=1)
    cut = replace(
        seam,
        closed=False,
        length_mm=float(end_mm - start_mm),
        frames=SeamFrames(s - start_mm, p, R, angle, frames.frame),
        lean_rad=None if seam.lean_rad is None else seam.lean_rad[nearest],
        spin_rad=None if seam.spin_rad is None else seam.spin_rad[nearest],
    )
    return cut, None if u95_mm is None else np.interp(s, own, u95_mm)
