"""Members, as they are bought or cut, and the members that one solid was made of."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from itertools import combinations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.wording import short
from wpcal.seam.find.built_up import FLATTEST, LEAST_BUILT_UP
from wpcal.seam.find.formed import MOULDED_MM
from wpcal.seam.member.heavy_bars import HEAVY_KG_M, SLAB_MM, SLAB_MM2, STEEL_KG_M_MM2

ON_MM, ON_COS = 0.02, 0.999
"""A point is on a plane, or in a slab, within this; normals are parallel within 2.6 degrees."""
ENDS_TOGETHER = 0.2
"""The sides of a profile with sharp roots go on beyond its ends by less than this share of its length: otherwise they
are plates on which others stand."""
SLENDER_PLATE, SLENDER_WALL = 0.12, 0.2
"""A slender plate, bar or profile is thinner than this share of the root of its area; a slender tube has a wall thinner
than this share of its height."""
DRAWN_SOLID_MM = 150.0  #: Plates are sold up to this thickness; what is thicker was a box, and was drawn solid.
THICKEST_BAR_MM = 250.0  #: Bars are rolled, and boards are cut, up to this thickness.
SMALL_MM, SMALL_THICK_MM, MANY_SMALL, SMALL_SHARE = 18.0, 3.5, 3, 0.2
"""A case has this many ribs, and more than this share of its members, that are smaller (root of the area; of a bar, its
length) and thinner: 20 weldments have one each at most. Tabs of plate may be as small, but are thicker."""
ONE_WALL = 0.1  #: Walls of a moulded tray differ by less than this share; sheets are sold in larger steps.
THINNEST_MM = 1.2  #: An arc burns through sheet that is thinner than the usual wire.


class MemberKind(Enum):
    """What a member is, as it is bought or cut."""

    PLATE = "plate"
    BAR = "bar"
    TUBE = "tube"
    ROUND = "round bar or tube"
    PROFILE = "rolled profile"
    SHEET = "formed sheet"
    BOX = "box drawn solid"


FLAT = (MemberKind.PLATE, MemberKind.BAR)
COST = dict.fromkeys(MemberKind, 1.0) | {MemberKind.SHEET: 0.5}
"""Members that a hypothesis counts as: a formed sheet has two sides, and each is one."""


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """One member of a solid."""

    kind: MemberKind
    faces: frozenset[int]  #: Its sides.
    axis: FloatArray  #: shape (3,). Along it; of a plate, across it.
    #: shape (2,). Sides of the box around its section, mm; of a plate, its thickness and the root of its area.
    section: FloatArray
    thickness_mm: float
    length_mm: float
    roots: frozenset[tuple[int, int]] = frozenset()  #: Pairs of faces at corners that are inside the member.
    rims: frozenset[int] = frozenset()  #: Of a plate, the faces of its outline.
    roots_mm: float = 0.0  #: How far its roots go on, also where something else stands on the member.

    @property
    def is_drawn_solid(self) -> bool:
        """Tell whether it is so thick that it was built up of plates round a hollow, and drawn without it."""
        return self.kind in (MemberKind.PLATE, MemberKind.BOX) and self.thickness_mm >= DRAWN_SOLID_MM

    @property
    def is_thicker_than_bars(self) -> bool:
        """Tell whether it is too thick for a board or a wall, too."""
        return self.is_drawn_solid and self.thickness_mm >= THICKEST_BAR_MM

    @property
    def is_slab(self) -> bool:
        """Tell whether it is a thick board of some size."""
        is_board = self.kind in (MemberKind.PLATE, MemberKind.BAR, MemberKind.BOX) and not self.is_thicker_than_bars
        return is_board and self.section[0] >= SLAB_MM and self.section[1] * self.length_mm >= SLAB_MM2

    @property
    def is_beam(self) -> bool:
        """Tell whether it is as thick both ways as a solid bar of which nobody builds a frame of steel."""
        return not self.is_slender and self.thickness_mm**2 * STEEL_KG_M_MM2 >= HEAVY_KG_M

    @property
    def is_stout(self) -> bool:
        """Tell whether it is a bar about as thick as it is long."""
        is_thin = self.thickness_mm <= FLATTEST * np.sqrt(self.length_mm * self.section[1])
        return self.kind is MemberKind.BAR and not is_thin

    @property
    def is_hollow(self) -> bool:
        """Tell whether it is a tube, a rolled section, a bent plate or a ring: nobody makes such things of wood."""
        is_tube = self.kind is MemberKind.ROUND and self.thickness_mm < self.section[0]
        return self.kind in (MemberKind.PROFILE, MemberKind.SHEET) or is_tube

    @property
    def stoutness(self) -> float:
        """How thick it is for its size; the thickest slender member has 1."""
        if self.kind in (MemberKind.TUBE, MemberKind.ROUND):  # a wall
            return float(self.thickness_mm / (SLENDER_WALL * self.section[0]))
        area = max(self.length_mm, self.section[0]) * self.section[1]
        return float(self.thickness_mm / (SLENDER_PLATE * np.sqrt(area)))

    @property
    def is_slender(self) -> bool:
        """Tell whether it is so thin for its size that it was hardly milled, and too thick to be moulded."""
        return self.thickness_mm > MOULDED_MM and self.stoutness <= 1.0

    @property
    def in_words(self) -> str:
        """What the member is, with its section: ``rolled profile 100 x 50``."""
        return f"{self.kind.value} {short(self.section[1])} x {short(self.section[0])}"


@dataclass(frozen=True, slots=True, eq=False)
class Decomposition:
    """The members of a solid."""

    members: tuple[Member, ...]
    share: float  #: Of the surface that they explain.
    straight_share: float  #: That is explained without formed sheets.
    explained: tuple[frozenset[int], ...] = ()  #: Of each member, the faces that it explains.

    @property
    def is_one(self) -> bool:
        """Tell whether one member explains the solid; the two sides of a formed sheet are one."""
        return sum(COST[one.kind] for one in self.members) <= 1.0 and self.share >= LEAST_BUILT_UP

    @property
    def is_box(self) -> bool:
        """Tell whether others stand on a box drawn solid that is thicker than bars: its thickness says nothing."""
        solid = [one.is_thicker_than_bars for one in self.members]
        return any(solid) and not all(solid)

    @property
    def is_moulded(self) -> bool:
        """Tell whether there are walls so thin that an arc burns through, and no member that is bought or cut."""
        stock = (MemberKind.TUBE, MemberKind.ROUND, MemberKind.PROFILE)
        is_stock = any(one.is_slender or one.is_drawn_solid or one.kind in stock for one in self.members)
        return not is_stock and min(self.thick_mm, default=THINNEST_MM) < THINNEST_MM

    @property
    def has_ribs(self) -> bool:
        """Tell whether many of its plates, bars and sheets are as small and thin as the ribs of a moulded case."""
        cut = [one for one in self.members if one.kind in (*FLAT, MemberKind.SHEET)]
        sizes = [(max(one.section[1], one.length_mm), one.thickness_mm) for one in cut]
        small = sum(mm < SMALL_MM and thick <= SMALL_THICK_MM for mm, thick in sizes)
        return bool(small >= MANY_SMALL and small > SMALL_SHARE * len(self.members))

    @property
    def thick_mm(self) -> list[float]:
        """How thick its members are, mm."""
        return [one.thickness_mm for one in self.members]

    @property
    def is_of_one_wall(self) -> bool:
        """Tell whether all members are about as thick."""
        return max(self.thick_mm, default=0.0) * (1.0 - ONE_WALL) <= min(self.thick_mm, default=0.0)

    @property
    def is_stepped_plate(self) -> bool:
        """Tell whether there are only parallel plates, two of them with a side in common."""
        return self.are_parallel_plates and any(a.faces & b.faces for a, b in combinations(self.members, 2))

    @property
    def are_parallel_plates(self) -> bool:
        """Tell whether there is nothing but parallel plates."""
        axes = np.array([one.axis for one in self.members]).reshape(-1, 3)
        is_plates = {one.kind for one in self.members} == {MemberKind.PLATE}
        return is_plates and bool((np.abs(axes @ axes[0]) > ON_COS).all())

    def is_between(self, one: int, other: int) -> bool:
        """Tell whether two faces are on different members, both slender, or boxes of plates."""
        own = self._holding(one, other)
        plates = [any(self.members[k].is_slender or self.members[k].is_drawn_solid for k in held) for held in own]
        return all(plates) and not own[0] & own[1]

    def is_joint(self, one: int, other: int) -> bool:
        """Tell whether two faces are on different members."""
        own = self._holding(one, other)
        return all(own) and not own[0] & own[1]

    def _holding(self, *faces: int) -> list[set[int]]:
        """Return the numbers of the members that explain each face."""
        return [{k for k, held in enumerate(self.explained) if face in held} for face in faces]

    def is_inside(self, one: int, other: int) -> bool:
        """Tell whether one member explains two faces: a corner between them was rolled, bent or cut with it."""
        return any(one in faces and other in faces for faces in self.explained)

    def around(self, faces: tuple[int, int], way: FloatArray, length_mm: float, *, is_sharp: bool) -> Member | None:
        """Return the member inside which a straight corner between two faces is.

        `way`: shape (3,). Along the corner, a unit vector. A member holds corners along its axis, hardly longer:
        something may stand beside its end. A plate holds those of its outline, and a
        formed sheet the round ones between its faces, which run smoothly into each other: a sharp one closes the sheet.
        """
        pair = (min(faces), max(faces))
        for one in self.members:
            if one.kind is MemberKind.SHEET and not is_sharp and one.faces.issuperset(pair):
                return one
            is_outline = one.rims.issuperset(pair)
            own_mm = one.thickness_mm if is_outline else max(one.length_mm, one.roots_mm)
            most_mm = (1.0 + ENDS_TOGETHER) * own_mm
            if (is_outline or pair in one.roots) and abs(one.axis @ way) > ON_COS and length_mm <= most_mm:
                return one
        return None
