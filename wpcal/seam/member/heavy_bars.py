"""Furniture, windows and doors: solid bars with slabs on them, or frames that were cut from solid bar in one piece.

Whoever builds a frame of steel takes tube or rolled profile where a solid bar would weigh more than it carries. Nothing
in a file without names says wood; the sections do. Solid bars alone are no evidence: many people draw a tube as a solid
bar. So the part must have no hollow section and no thin plate, and either a slab on its bars that one person cannot
lift, or several closed frames of solid bar.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.seam.find.built_up import sampled_surface

STEEL_KG_M_MM2 = 7.85e-3  #: Weight of a steel bar, kg per metre of length and mm² of section.
HEAVY_KG_M = 10.0  #: A solid bar that would weigh as much as a tube of 80 x 80 x 4: from 36 x 36 mm on.
PLUMP = 4.0  #: Thickness and width of a bar are less than this apart; a plate is wider.
SLENDER = 6.0  #: A bar is longer than this, in widths.
THIN_MM = 9.0  #: Steel parts with heavy bars have tubes, profiles, gussets or foot plates that are thinner.
FEWEST = 2  #: One solid bar may be a shaft or a rail, one frame may be fused.
SPREAD = 3.0  #: A body is a frame if its box is wider than this, in widths of its bar, across its longest side, too.
SLAB_MM, SLAB_MM2 = 20.0, 0.25e6
"""A slab is thicker and larger than this: as steel it would weigh 39 kg. Foot plates and table tops of steel are
thinner or smaller."""
LEAST_SHARE = 0.1  #: A thickness counts if this much of the plane surface has it or less: not a notch or a chamfer.
ACROSS_COS = 0.3  #: Faces are across to each other within 17 degrees of square.


@dataclass(frozen=True, slots=True)
class Bar:
    """The section of a solid that is bounded by planes, mm: thickness, width, and the two longest sides of its box.

    The width of a board is infinite: too little of its surface is across to the rest to feel it.
    """

    thick: float
    wide: float
    long: float
    across: float

    @property
    def kg_m(self) -> float:
        """Weight per metre if it were of steel."""
        return self.thick * self.wide * STEEL_KG_M_MM2

    @property
    def is_heavy(self) -> bool:
        """Tell whether nobody would take a solid steel bar of this section for a frame."""
        return self.kg_m >= HEAVY_KG_M and self.wide <= PLUMP * self.thick and self.long >= SLENDER * self.wide

    @property
    def is_frame(self) -> bool:
        """Tell whether the solid is a frame of several such bars."""
        return self.across >= SPREAD * self.wide

    @property
    def is_slab(self) -> bool:
        """Tell whether the solid is a thick board of some size."""
        return np.isinf(self.wide) and self.thick >= SLAB_MM and self.long * self.across >= SLAB_MM2


def why_timber(graph: BrepGraph, trimmed: TrimmedFaces, solids: Iterable[int]) -> str | None:
    """Tell why solids that touch each other are rather a frame of timber than a weldment; None if they may be one."""
    heavy, slabs = dict[int, Bar](), 0
    for solid in solids:
        bar = find_bar(graph, trimmed, solid)
        if bar is not None and bar.thick < THIN_MM:
            return None
        if bar is not None and bar.is_heavy:
            heavy[solid] = bar
        slabs += bar is not None and bar.is_slab
    frames = sum(bar.is_frame for bar in heavy.values())
    if frames < FEWEST and (slabs == 0 or len(heavy) < FEWEST):
        return None
    solid, bar = max(heavy.items(), key=lambda item: item[1].kg_m)
    return (
        f"the part has no tube and no plate under {THIN_MM:g} mm, but {'closed frames' if frames else 'a slab'} and "
        f"solid bars such as {graph.solid_names[solid]}, {bar.thick:.0f} x {bar.wide:.0f} mm, which would weigh "
        f"{bar.kg_m:.0f} kg per metre as steel: it looks like timber"
    )


def find_bar(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> Bar | None:
    """Return the section of a solid whose surface is mostly plane; None for another one.

    The thickness is felt through the material, so that a ring of one section, such as the frame of a window, is a bar.
    """
    own = np.flatnonzero(graph.face_solid == solid)
    if (graph.face_kind[own] >= SurfaceKind.NURBS).any():
        return None
    surface = sampled_surface(graph, trimmed, solid)
    plane = np.flatnonzero(graph.face_kind[surface.face] == SurfaceKind.PLANE)
    thick, normal = np.where(surface.flat, surface.thick, np.inf)[plane], surface.normal[plane]
    first = _least(thick)
    if first is None:
        return None
    second = _least(np.where(np.abs(normal @ normal[first]) < ACROSS_COS, thick, np.inf))
    wide = np.inf if second is None else float(thick[second])
    box = np.sort(trimmed.solid_sides_mm[solid])
    return Bar(float(thick[first]), wide, float(box[2]), float(box[1]))


def _least(thick: FloatArray) -> int | None:
    """Return the point with the least thickness that `LEAST_SHARE` of the surface has, or less."""
    row = int(np.ceil(LEAST_SHARE * len(thick))) - 1
    least = int(np.argsort(thick, kind="stable")[row]) if len(thick) else 0
    return least if len(thick) and np.isfinite(thick[least]) else None
