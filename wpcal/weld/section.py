r"""The cross-section of a weld between two straight sides, with its area in closed form.

The section is symmetric about the z axis of the seam frame. At the height h above the root it is
:math:`b + 2 k \max(0, h - c)` wide (root gap b, root face c, slope k of each side), so the area below h is
:math:`A(h) = b h + k \max(0, h - c)^2`. A fillet has b = c = 0, and k is the tangent of half the angle between its
plates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from wpcal.core.errors import InputError
from wpcal.seam.seam import JointType, WeldType
from wpcal.weld.values import WeldKind, WeldValues

LEAST_FILLET_RAD, MOST_FILLET_RAD = math.radians(20.0), math.radians(160.0)
"""Between the plates of a fillet: outside this range no fillet is asked for by a throat or a leg."""
COPLANAR_RAD = math.radians(20.0)
"""Two faces whose normals differ by less are one surface: the seam is on the face of the groove, not at its root."""


@dataclass(frozen=True, slots=True)
class Section:
    """The cross-section of a weld in y and z of the seam frame.

    Parameters
    ----------
    height_mm : float
        From the root to the face: the throat of a fillet, the depth of a groove.
    slope : float
        Change of the half width per height.
    gap_mm, root_face_mm : float
        Width at the root, and the height up to which it stays so.
    root_z_mm : float
        z of the root in the seam frame; y is 0.

    Raises
    ------
    InputError
        If the section has no area.
    """

    height_mm: float
    slope: float
    gap_mm: float = 0.0
    root_face_mm: float = 0.0
    root_z_mm: float = 0.0

    def __post_init__(self) -> None:
        if not self.area_mm2 > 0.0:
            raise InputError("the section has no area; expected a root gap or an angle between its sides")

    @property
    def area_mm2(self) -> float:
        """Area of the whole section."""
        return self.area_below(self.height_mm)

    def area_below(self, h_mm: float) -> float:
        """Area between the root and a height."""
        above = max(0.0, h_mm - self.root_face_mm)
        return self.gap_mm * h_mm + self.slope * above * above

    def half_width(self, h_mm: float) -> float:
        """Half the width at a height."""
        return self.gap_mm / 2.0 + self.slope * max(0.0, h_mm - self.root_face_mm)

    def height_of(self, area_mm2: float) -> float:
        """Return the height below which there is an area: the inverse of `area_below`, in closed form."""
        straight = self.gap_mm * self.root_face_mm
        if area_mm2 <= straight or self.slope == 0.0:
            return area_mm2 / self.gap_mm if self.gap_mm > 0.0 else 0.0
        rest = area_mm2 - straight
        root = math.sqrt(self.gap_mm * self.gap_mm + 4.0 * self.slope * rest)
        return self.root_face_mm + 2.0 * rest / (self.gap_mm + root)


def section_of(values: WeldValues, *, joint: JointType, weld: WeldType, normals_rad: float) -> Section | None:
    """Return the section of a weld.

    Parameters
    ----------
    values : WeldValues
    joint, weld : JointType, WeldType
        Of the seam.
    normals_rad : float
        Angle between the outward normals of the two faces.

    Returns
    -------
    Section or None
        None for a weld whose section is not stated: no size, flare welds, the outside of a corner, a square butt
        without a gap.
    """
    if weld is WeldType.FILLET and values.weld is WeldKind.FILLET:
        between = math.pi - normals_rad
        height = throat_of(values, between)
        if height is None or not LEAST_FILLET_RAD <= between <= MOST_FILLET_RAD:
            return None
        return Section(height, math.tan(between / 2.0))
    is_butt = joint in (JointType.BUTT, JointType.EDGE) and normals_rad < COPLANAR_RAD
    if weld is not WeldType.GROOVE or not is_butt or values.depth_mm is None:
        return None
    gap = values.root_gap_mm or 0.0
    if values.weld is not WeldKind.SINGLE_V:
        return Section(values.depth_mm, 0.0, gap, root_z_mm=-values.depth_mm) if gap > 0.0 else None
    slope = math.tan(math.radians(values.groove_angle_deg or 0.0) / 2.0)
    if gap == 0.0 and slope == 0.0:
        return None
    root_face = min(values.root_face_mm or 0.0, values.depth_mm)
    return Section(values.depth_mm, slope, gap, root_face, -values.depth_mm)


def throat_of(values: WeldValues, between_rad: float) -> float | None:
    """Return the throat of a fillet with equal legs, mm: a = z cos(ψ/2) for the angle ψ between its plates.

    Examples
    --------
    >>> round(throat_of(WeldValues(leg_mm=5.0), math.pi / 2), 3)
    3.536
    """
    if values.leg_mm is not None:
        return values.leg_mm * math.cos(between_rad / 2.0)
    return values.throat_mm
