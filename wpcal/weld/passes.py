"""Beads of a weld with several passes: equal areas, in layers from the root, placed in the frame of the seam.

Layers are parallel to the face of the weld. A layer of m beads is divided so that each bead takes the same share of the
width at every height: all areas then have a closed form, no bead leaves the section, and the areas add up to it.
"""

import math
from dataclasses import dataclass

from wpcal.core.errors import InputError
from wpcal.weld.section import Section

WIDTH_TO_HEIGHT = 2.0  #: A bead that is laid on others is about twice as wide as high.
MOST_PASSES = 200  #: More beads than in any weld that a robot lays in one run.


@dataclass(frozen=True, slots=True)
class Bead:
    """One bead in the cross-section of a seam."""

    #: `number`, `layer`: Counted from 1; the numbers are the order of welding.
    number: int
    layer: int
    #: `y_mm`, `z_mm`: Where the wire points, in the frame of the seam: the middle of the ground on which the bead is
    #: laid.
    y_mm: float
    z_mm: float
    area_mm2: float
    #: To be added to that of the weld: the wire halves the corner between a side of the groove and the last layer.
    work_angle_deg: float
    outline_mm: tuple[tuple[float, float], ...]  #: Corners (y, z) of its section.


def place_beads(section: Section, passes: int, *, first_side: int = -1) -> tuple[Bead, ...]:
    """Divide the section of a weld into beads of equal area. In the order of welding.

    Raises `InputError` if the number is not from 1 to 200.

    `first_side`: -1 or +1: each layer begins at the side of -y or of +y. In PB and PC this is the lower side.
    """
    if not 1 <= passes <= MOST_PASSES:
        raise InputError(f"passes: expected 1 to {MOST_PASSES}, got {passes}")
    area = section.area_mm2 / passes
    beads: list[Bead] = []
    for layer, (low, high, count) in enumerate(_layers(section, passes), 1):
        for place in range(count):
            share = (place, place + 1) if first_side < 0 else (count - place - 1, count - place)
            left, right = (2.0 * one / count - 1.0 for one in share)
            side = (left + right) / 2.0 * count / max(count - 1, 1)
            lean = side * _corner_angle_deg(section, low, side) if count > 1 else 0.0
            lean += math.degrees(section.tilt_rad)
            y, z = _place(section, (left + right) / 2.0, max(low, section.least_aim_mm))
            outline = _outline(section, (low, high), (left, right))
            beads.append(Bead(len(beads) + 1, layer, y, z, area, lean, outline))
    return tuple(beads)


def _layers(section: Section, passes: int) -> list[tuple[float, float, int]]:
    """Return least and greatest height and number of beads of every layer."""
    area = section.area_mm2 / passes
    width = math.sqrt(WIDTH_TO_HEIGHT * area)
    layers: list[tuple[float, float, int]] = []
    done, low = 0, 0.0
    while done < passes:
        middle = min(low + area / width / 2.0, section.height_mm)
        count = 1 if done == 0 else max(1, round(2.0 * section.half_width(middle) / width))
        count = min(count, passes - done)
        done += count
        high = section.height_mm if done == passes else section.height_of(area * done)
        layers.append((low, high, count))
        low = high
    return layers


def _corner_angle_deg(section: Section, low_mm: float, side: float) -> float:
    """Return by how much the wire leans to halve the corner between a side and the ground of a layer.

    In a groove it leans by at most half the angle of the other side, towards which the torch leans.
    """
    if low_mm < section.root_face_mm:
        return 0.0 if section.is_groove else 45.0
    sign = math.copysign(1.0, side)
    own, other = (math.atan(max(0.0, section.slope + turn * section.skew)) for turn in (sign, -sign))
    halved = (math.pi / 2.0 - own) / 2.0
    return math.degrees(min(halved, other / 2.0) if section.is_groove else halved)


def _outline(
    section: Section, heights: tuple[float, float], shares: tuple[float, float]
) -> tuple[tuple[float, float], ...]:
    (low, high), (left, right) = heights, shares
    corners = [(left, low), (right, low)]
    if low < section.root_face_mm < high:
        corners.append((right, section.root_face_mm))
    corners += [(right, high), (left, high)]
    if low < section.root_face_mm < high:
        corners.append((left, section.root_face_mm))
    return tuple(_place(section, share, h) for share, h in corners)


def _place(section: Section, share: float, h_mm: float) -> tuple[float, float]:
    """Return y and z of a share of the half width at a height."""
    return section.place(section.middle(h_mm) + share * section.half_width(h_mm), h_mm)
