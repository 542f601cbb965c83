"""What members of a solid are by their sizes, at the borders; and what a set of members says of the solid."""

import math
from typing import Any

import numpy as np
import pytest

from wpcal.seam.find.built_up import FLATTEST, LEAST_BUILT_UP
from wpcal.seam.find.formed import MOULDED_MM
from wpcal.seam.member.heavy_bars import HEAVY_KG_M, SLAB_MM, SLAB_MM2, STEEL_KG_M_MM2
from wpcal.seam.member.member import (
    DRAWN_SOLID_MM,
    ENDS_TOGETHER,
    ONE_WALL,
    SLENDER_PLATE,
    SLENDER_WALL,
    THICKEST_BAR_MM,
    THINNEST_MM,
    Decomposition,
    Member,
    MemberKind,
)

PLATE, BAR, TUBE, ROUND, PROFILE, SHEET, BOX = MemberKind
ABOVE, BELOW = 1.001, 0.999
X, Y, Z = np.eye(3)


def member(
    kind: MemberKind,
    *section: float,
    thick: float = 8.0,
    length: float = 300.0,
    faces: Any = (),
    axis: Any = Z,
    **more: Any,
) -> Member:
    return Member(kind, frozenset(faces), axis, np.array(section or (30.0, 70.0)), thick, length, **more)


def of(*members: Member, share: float = 1.0, explained: Any = ()) -> Decomposition:
    return Decomposition(members, share, share, tuple(map(frozenset, explained)))


@pytest.mark.parametrize("kind", MemberKind)
def test_what_a_member_is_by_its_kind_and_thickness(kind: MemberKind) -> None:
    thin, thick, thicker = (member(kind, thick=mm) for mm in (DRAWN_SOLID_MM * BELOW, DRAWN_SOLID_MM, THICKEST_BAR_MM))
    assert [one.is_drawn_solid for one in (thin, thick, thicker)] == [False, *[kind in (PLATE, BOX)] * 2]
    assert [one.is_thicker_than_bars for one in (thin, thick, thicker)] == [False, False, kind in (PLATE, BOX)]
    assert member(kind, thick=THICKEST_BAR_MM * BELOW).is_thicker_than_bars is False
    wide = SLAB_MM2 / 500.0
    sizes = (SLAB_MM, wide, 500.0), (SLAB_MM * BELOW, wide, 500.0), (SLAB_MM, wide * BELOW, 500.0)
    slabs = [member(kind, a, b, length=length).is_slab for a, b, length in sizes]
    assert slabs == [kind in (PLATE, BAR, BOX), False, False]
    assert not member(kind, SLAB_MM, wide, length=500.0, thick=THICKEST_BAR_MM).is_slab or kind is BAR
    border = FLATTEST * math.sqrt(300.0 * 70.0)
    assert [member(kind, thick=border * by).is_stout for by in (BELOW, ABOVE)] == [False, kind is BAR]
    hollow = [member(kind, 30.0, 70.0, thick=mm).is_hollow for mm in (30.0 * BELOW, 30.0)]
    assert hollow == [kind in (PROFILE, ROUND, SHEET), kind in (PROFILE, SHEET)]
    heavy = math.sqrt(HEAVY_KG_M / STEEL_KG_M_MM2)  # not slender
    assert [member(kind, thick=heavy * by, length=50.0).is_beam for by in (BELOW, ABOVE)] == [False, True]
    assert member(kind, thick=MOULDED_MM * ABOVE, length=1e4).is_hollow == (kind in (PROFILE, ROUND, SHEET))


@pytest.mark.parametrize("kind", MemberKind)
@pytest.mark.parametrize(("section", "length"), [((90.0, 40.0), 300.0), ((300.0, 40.0), 90.0)])
def test_a_slender_member_is_thin_for_its_size_and_not_moulded(
    kind: MemberKind, section: tuple[float, float], length: float
) -> None:
    of_wall = kind in (TUBE, ROUND)
    most = SLENDER_WALL * section[0] if of_wall else SLENDER_PLATE * math.sqrt(300.0 * 40.0)
    assert [member(kind, *section, thick=most * by, length=length).is_slender for by in (BELOW, ABOVE)] == [True, False]
    assert [member(kind, 900.0, 900.0, thick=MOULDED_MM * by).is_slender for by in (1.0, ABOVE)] == [False, True]


def test_a_member_in_words() -> None:
    assert member(PROFILE, 50.0, 1204.0).in_words == "rolled profile 1200 x 50"


def test_one_member_is_the_whole_solid_if_it_explains_enough() -> None:
    assert of(member(BAR), share=LEAST_BUILT_UP).is_one
    assert not of(member(BAR), share=LEAST_BUILT_UP * BELOW).is_one
    assert of(member(SHEET), member(SHEET)).is_one
    assert not of(member(SHEET), member(PLATE)).is_one


def test_a_box_has_others_on_something_thicker_than_bars() -> None:
    thick, thin = member(BOX, thick=THICKEST_BAR_MM), member(PLATE)
    assert [of(*some).is_box for some in ((thick, thin), (thick,), (thin,), (thick, thick))] == [
        True,
        False,
        False,
        False,
    ]


def test_a_moulded_part_has_a_thin_wall_and_nothing_that_is_bought() -> None:
    thin, whole = member(PLATE, thick=THINNEST_MM * BELOW), member(PLATE, thick=THINNEST_MM)
    assert of(thin, whole).is_moulded
    assert not of(whole).is_moulded
    assert not of().is_moulded
    slender = member(PLATE, 900.0, 900.0, thick=MOULDED_MM * 2)
    others = (
        slender,
        member(PLATE, thick=DRAWN_SOLID_MM),
        *(member(kind, thick=100.0) for kind in (TUBE, ROUND, PROFILE)),
    )
    assert [of(thin, other).is_moulded for other in others] == [False] * 5
    assert of(thin, member(BAR, thick=100.0)).is_moulded


def test_members_of_one_wall_are_about_as_thick() -> None:
    border = 1.0 / (1.0 - ONE_WALL)
    own = [of(member(PLATE), member(BAR, thick=8.0 / border / by)) for by in (BELOW, ABOVE)]
    assert [one.is_of_one_wall for one in (*own, of())] == [True, False, True]


def test_plates_with_a_common_side_are_one_stepped_plate() -> None:
    low, high = member(PLATE, thick=8.0, faces=(1, 2)), member(PLATE, thick=20.0, faces=(1, 3))
    apart, leaning, bar = member(PLATE, faces=(5, 6)), member(PLATE, faces=(1, 7), axis=X), member(BAR, faces=(1, 4))
    assert [of(low, one).is_stepped_plate for one in (high, apart, leaning, bar)] == [True, False, False, False]


def test_faces_are_between_members_or_inside_one() -> None:
    slender, stout = member(PLATE, 900.0, 900.0), member(PLATE, thick=100.0)
    parts = of(slender, slender, stout, member(BOX, thick=DRAWN_SOLID_MM), explained=[(1, 2), (2, 3), (4,), (5,)])
    assert [parts.is_between(1, k) for k in (2, 3, 4, 5, 9)] == [False, True, False, True, False]
    assert [parts.is_joint(1, k) for k in (2, 3, 4, 9)] == [False, True, True, False]
    assert [parts.is_inside(1, k) for k in (2, 3, 9)] == [True, False, False]


def test_a_corner_inside_a_member_is_a_root_of_it_hardly_longer_than_the_member() -> None:
    profile = member(PROFILE, axis=X, length=200.0, roots=frozenset({(1, 2)}))
    longer = member(PROFILE, axis=X, length=200.0, roots_mm=500.0, roots=frozenset({(1, 2)}))
    plate = member(PLATE, axis=Z, thick=10.0, length=200.0, rims=frozenset({3, 4, 5}))
    sheet = member(SHEET, faces=(6, 7))
    for one, faces, way, most in ((profile, (2, 1), X, 200.0), (longer, (1, 2), -X, 500.0), (plate, (5, 3), Z, 10.0)):
        parts, border = of(sheet, one), (1.0 + ENDS_TOGETHER) * most
        found = [parts.around(faces, way, border * by, is_sharp=True) for by in (BELOW, ABOVE)]
        assert found == [one, None]
        assert parts.around(faces, Y, 1.0, is_sharp=True) is None
        assert parts.around((faces[0], 9), way, 1.0, is_sharp=True) is None
    assert [of(sheet).around((7, 6), X, 1e4, is_sharp=sharp) for sharp in (False, True)] == [sheet, None]
