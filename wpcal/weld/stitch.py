"""Stretches of an intermittent weld, in closed form: ISO 2553 writes n × l (e) with e = pitch - length.

Only whole stretches are laid. Without an offset the same length is left free at both ends of an open seam. Around a
closed seam the pitch is made a little larger, so that the stretches are at equal distances.
"""

import math

from wpcal.core.errors import InputError
from wpcal.weld.values import Stitch

ROUND_OFF = 1e-9  #: Relative: a last stretch that ends at the end of the seam is not lost to it.
MOST_STRETCHES = 10_000  #: More stretches on one seam are a mistake: a pitch in metres, for example.


def stretches(stitch: Stitch | None, length_mm: float, *, closed: bool = False) -> tuple[tuple[float, float], ...]:
    """Return where a seam is welded: lengths from its start, mm, in order.

    Raises `InputError` if the pitch is shorter than the stretch, the offset leaves no room for one, or there are more
    than 10 000.

    >>> stretches(Stitch(50.0, 100.0), 300.0)
    ((25.0, 75.0), (125.0, 175.0), (225.0, 275.0))
    """
    if stitch is None:
        return ((0.0, length_mm),)
    length, pitch, offset = stitch.length_mm, stitch.pitch_mm, stitch.offset_mm
    if pitch < length:
        raise InputError(f"stitch: the pitch of {pitch:g} mm is shorter than the stretch of {length:g} mm")
    if offset is None and length >= length_mm:
        return ((0.0, length_mm),)
    room = length_mm - (offset or 0.0)
    if room < length:
        what = f"an offset of {offset:g} mm leaves no room for {length:g} mm on a seam of {length_mm:.1f} mm"
        raise InputError(f"stitch: {what}")
    fits = room / pitch if closed else (room - length) / pitch + 1.0
    count = max(1, math.floor(fits * (1.0 + ROUND_OFF)))
    if count > MOST_STRETCHES:
        raise InputError(f"stitch: a pitch of {pitch:g} mm makes {count} stretches on a seam of {length_mm:.1f} mm")
    if closed and offset is None:
        pitch = length_mm / count
    first = max(0.0, (length_mm - (count - 1) * pitch - length) / 2.0) if offset is None else offset
    return tuple((first + k * pitch, min(first + k * pitch + length, length_mm)) for k in range(count))
