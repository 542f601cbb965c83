"""Faults of coordinated programs of two robots: their motion, read from the text, against the planned seam."""

from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation, Slerp

from tests.coordinated_programs import READERS, WRITTEN_MM, Array, followed

WRITTEN_DEG = 5e-3  #: Rounding of the files, as `WRITTEN_MM`.


class Seam(NamedTuple):
    """What was planned: the seam in the part, its directions of travel, the wire, and the part in the world."""

    s: Array
    p: Array
    heading: Array
    wire: Array
    part: Array


def curve_of(seam: Seam) -> tuple[Array, Array]:
    """The seam at every 0.02 mm: lengths and places."""
    fine = np.linspace(seam.s[0], seam.s[-1], int(50 * (seam.s[-1] - seam.s[0])) + 2)
    return fine, CubicHermiteSpline(seam.s, seam.p, seam.heading)(fine)


def chord_error_mm(seam: Seam) -> float:
    """How far the lines between its frames are from the seam."""
    fine, curve = curve_of(seam)
    chords = np.stack([np.interp(fine, seam.s, column) for column in seam.p.T], axis=1)
    return float(KDTree(curve).query(chords)[0].max())


def deviations(torch: Array, seam: Seam) -> tuple[Array, Array, Array]:
    """How far the tip is from the seam, mm, and the wire from the planned one, deg; and where on the seam, mm."""
    fine, curve = curve_of(seam)
    off, row = KDTree(curve).query(torch[:, :3, 3])
    wire = np.stack([np.interp(fine[row], seam.s, column) for column in seam.wire.T], axis=1)
    wire /= np.linalg.norm(wire, axis=1, keepdims=True)
    angle = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", wire, torch[:, :3, 2]), -1.0, 1.0)))
    return off, angle, fine[row]


def faults(files: dict[str, str], name: str, cell: Any, seam: Seam, *, most_mm: float = 0.05) -> list[str]:
    """What is wrong with the programs of one language; empty if nothing is."""
    try:
        read = READERS[name](files, cell)
    except (TypeError, KeyError, ValueError, StopIteration, AttributeError) as error:
        return [f"cannot be read: {error!r}"]
    found = list(read.wrong)
    torch, part, burns = followed(read, cell)
    if not burns.any():
        return [*found, "the arc never burns"]
    off, angle, s = deviations(torch[burns], seam)
    if off.max() > most_mm + WRITTEN_MM:
        found.append(f"the tip is {off.max():.3f} mm off the seam")
    if angle.max() > 0.5 + WRITTEN_DEG:
        found.append(f"the wire is {angle.max():.2f} deg off")
    ends = [np.linalg.norm(torch[burns][row][:3, 3] - seam.p[row]) for row in (0, -1)]
    if max(ends) > most_mm + WRITTEN_MM:
        found.append("the arc does not burn from the start of the seam to its end")
    planned = Slerp(seam.s, Rotation.from_matrix(seam.part[:, :3, :3]))(s)
    turned = np.degrees((planned.inv() * Rotation.from_matrix(part[burns][:, :3, :3])).magnitude())
    is_end = (s < seam.s[0] + 1.0) | (s > seam.s[-1] - 1.0)  # of a closed seam: one place, two attitudes
    if turned[~is_end].max(initial=0.0) > 1.0 + WRITTEN_DEG:
        found.append(f"the part is {turned[~is_end].max():.2f} deg from its planned attitude")
    is_closed = np.linalg.norm(seam.p[0] - seam.p[-1]) < 1.0
    if not is_closed and (np.diff(s) < -2 * WRITTEN_MM - 0.05).any():
        found.append("the torch goes back along the seam")
    return found
