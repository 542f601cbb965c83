r"""The cross-section of a weld between two straight sides, with its area in closed form.

At the height h above the root the section is :math:`b + 2 k \max(0, h - c)` wide (root gap b, root face c, mean slope
k of both sides), so the area below h is :math:`A(h) = b h + k \max(0, h - c)^2`. A fillet has b = c = 0, and k is the
tangent of half the angle between its plates. A groove with different bevels is skewed: its middle moves with the
height. A groove that was measured can be turned and moved in the frame of the seam.
"""

import math
from dataclasses import dataclass

from wpcal.core.errors import InputError
from wpcal.seam.seam import JointType, WeldType
from wpcal.weld.groove import Groove
from wpcal.weld.values import WeldKind, WeldValues

LEAST_FILLET_RAD, MOST_FILLET_RAD = math.radians(20.0), math.radians(160.0)
"""Between the plates of a fillet: outside this range no fillet is asked for by a throat or a leg."""
BEVELS = (WeldKind.SINGLE_BEVEL, WeldKind.DOUBLE_BEVEL)
GROOVES = (WeldKind.SINGLE_V, WeldKind.DOUBLE_V, *BEVELS)
BUTT_WELDS = (WeldKind.SQUARE, *GROOVES)  #: Kinds of welds with an angle at one side, with any angle, and in a butt.
USUAL_WIRE_MM = 1.2  #: Diameter of a wire that is not stated.
COPLANAR_RAD = math.radians(20.0)
"""Two faces whose normals differ by less are one surface: the seam is on the face of the groove, not at its root."""


@dataclass(frozen=True, slots=True)
class Section:
    """The cross-section of a weld in y and z of the seam frame. Raises `InputError` if the section has no area."""

    height_mm: float  #: From the root to the face: the throat of a fillet, the depth of a groove.
    slope: float  #: Change of the half width per height.
    #: `gap_mm`, `root_face_mm`: Width at the root, and the height up to which it stays so.
    gap_mm: float = 0.0
    root_face_mm: float = 0.0
    #: `root_z_mm`, `root_y_mm`: The middle of the root in the seam frame.
    root_z_mm: float = 0.0
    root_y_mm: float = 0.0
    skew: float = 0.0  #: Change of the middle per height above the root face, towards +y.
    tilt_rad: float = 0.0  #: From z of the seam to the direction of height; positive towards -y.
    least_aim_mm: float = 0.0  #: Height below which no wire gets: the root face, if the gap is narrower than the wire.
    is_groove: bool = False  #: Whether the torch is in a groove, where a side is opposite to the one that is welded.

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

    def middle(self, h_mm: float) -> float:
        """Where the middle is at a height, across."""
        return self.skew * max(0.0, h_mm - self.root_face_mm)

    def place(self, u_mm: float, h_mm: float) -> tuple[float, float]:
        """Return y and z in the seam frame of a place across and above the root."""
        c, s = math.cos(self.tilt_rad), math.sin(self.tilt_rad)
        return self.root_y_mm + u_mm * c - h_mm * s, self.root_z_mm + u_mm * s + h_mm * c

    def height_of(self, area_mm2: float) -> float:
        """Return the height below which there is an area: the inverse of `area_below`, in closed form."""
        straight = self.gap_mm * self.root_face_mm
        if area_mm2 <= straight or self.slope == 0.0:
            return area_mm2 / self.gap_mm if self.gap_mm > 0.0 else 0.0
        rest = area_mm2 - straight
        root = math.sqrt(self.gap_mm * self.gap_mm + 4.0 * self.slope * rest)
        return self.root_face_mm + 2.0 * rest / (self.gap_mm + root)


def section_of(
    values: WeldValues, *, joint: JointType, weld: WeldType, normals_rad: float, groove: Groove | None = None
) -> Section | None:
    """Return the section of a weld.

    Returns: None for a weld whose section is not stated: no size, flare welds, the outside of a corner, a square butt
    without a gap.
    """
    if groove is not None and values.weld in BUTT_WELDS:
        return _between_sides(values, groove.left_share, groove.y_mm, groove.z_mm, groove.tilt_rad)
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
    if values.weld not in GROOVES:
        return Section(values.depth_mm, 0.0, gap, root_z_mm=-values.depth_mm) if gap > 0.0 else None
    left = 0.0 if values.weld in BEVELS else 0.5
    return _between_sides(values, left, z_mm=-values.depth_mm)


def _between_sides(
    values: WeldValues, left_share: float, y_mm: float = 0.0, z_mm: float = 0.0, tilt_rad: float = 0.0
) -> Section | None:
    """Return the section between two sides; None without a gap and an angle, or without a depth."""
    angle = math.radians(values.groove_angle_deg or 0.0) if values.weld in GROOVES else 0.0
    left, right = math.tan(angle * left_share), math.tan(angle * (1.0 - left_share))
    gap, depth = values.root_gap_mm or 0.0, values.depth_mm
    if depth is None or (gap == 0.0 and left + right == 0.0):
        return None
    root_face = min(values.root_face_mm or 0.0, depth)
    skew, aim = (right - left) / 2.0, 0.0 if gap > (values.wire_mm or USUAL_WIRE_MM) else root_face
    return Section(depth, (left + right) / 2.0, gap, root_face, z_mm, y_mm, skew, tilt_rad, aim, is_groove=True)


def throat_of(values: WeldValues, between_rad: float) -> float | None:
    """Return the throat of a fillet with equal legs, mm: a = z cos(ψ/2) for the angle ψ between its plates.

    >>> round(throat_of(WeldValues(leg_mm=5.0), math.pi / 2), 3)
    3.536
    """
    if values.leg_mm is not None:
        return values.leg_mm * math.cos(between_rad / 2.0)
    return values.throat_mm
