"""The corners of a seam that is welded as one run: where it turns, and how far the torch is off the travel there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.seam.seam import SeamFrames

SHARP_RAD = float(np.radians(30.0))
"""A seam that turns by more between two steps has a corner there, as where seams are found."""
OFF_RAD = float(np.radians(0.5))
"""A torch that is less off the direction of travel goes with it: half a degree is what moves may be off, too."""


@dataclass(frozen=True, slots=True)
class TurnedCorner:
    """One corner of a run.

    Parameters
    ----------
    at_mm : float
        Length from the start of the seam.
    turn_rad : float
        By how much the seam turns there.
    low_mm, high_mm : float
        Between these lengths the torch turns round the corner.
    off_rad : float
        Largest angle between the x of the seam's frame, which the torch keeps to, and the direction of travel.
    """

    at_mm: float
    turn_rad: float
    low_mm: float
    high_mm: float
    off_rad: float

    def __str__(self) -> str:
        """Say it as the comment of a program."""
        turn, off = np.degrees([self.turn_rad, self.off_rad])
        return (
            f"corner of {turn:.0f} deg at {self.at_mm:.1f} mm: the torch turns from {self.low_mm:.1f} to "
            f"{self.high_mm:.1f} mm, up to {off:.0f} deg off the travel"
        )


def find_turned_corners(frames: SeamFrames) -> tuple[TurnedCorner, ...]:
    """Return the corners of a seam at which a torch turns before and after the corner.

    Parameters
    ----------
    frames : SeamFrames
        With n frames; between them the seam is straight.

    Examples
    --------
    A seam of two straight steps in one direction has none:

    >>> x, R = np.array([[0.0, 0, 0], [5, 0, 0], [9, 0, 0]]), np.tile(np.eye(3), (3, 1, 1))
    >>> find_turned_corners(SeamFrames(x[:, 0], x, R, np.full(3, 1.5), "part"))
    ()
    """
    chords = np.diff(frames.p, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    if len(chords) < 2 or not lengths.all():
        return ()
    travel = chords / lengths[:, None]
    turns = _angles(travel[:-1], travel[1:])
    x = frames.R[:, :, 0]
    before, after = travel[[0, *range(len(travel))]], travel[[*range(len(travel)), -1]]
    sides = _angles(x, before), _angles(x, after)
    off, most = np.minimum(*sides), np.maximum(*sides)
    found = []
    for row in (np.flatnonzero(turns > SHARP_RAD) + 1).tolist():
        low, high = row, row
        while low > 0 and off[low] > OFF_RAD:
            low -= 1
        while high < len(off) - 1 and off[high] > OFF_RAD:
            high += 1
        if low < high:
            at, first, last = (float(frames.s_mm[one]) for one in (row, low, high))
            found.append(
                TurnedCorner(at, float(turns[row - 1]), first, last, float(max(off[low : high + 1].max(), most[row])))
            )
    return tuple(found)


def _angles(a: FloatArray, b: FloatArray) -> FloatArray:
    across = np.linalg.norm(np.cross(a, b), axis=1)
    return np.asarray(np.arctan2(across, np.einsum("ij,ij->i", a, b)), dtype=np.float64)
