"""Beads and stretches: the areas add up, no bead leaves the section, and stitches have the lengths that were asked."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wpcal.core.errors import InputError
from wpcal.seam.seam import JointType, WeldType
from wpcal.weld.passes import place_beads
from wpcal.weld.section import COPLANAR_RAD, LEAST_FILLET_RAD, MOST_FILLET_RAD, Section, section_of
from wpcal.weld.values import Stitch, WeldKind, WeldValues, stretches

ROUND_OFF = 1e-9  #: Relative: all areas have a closed form.

LENGTH = st.floats(0.5, 30.0)
SECTIONS = st.one_of(
    st.builds(Section, LENGTH, st.floats(0.2, 3.0)),
    st.builds(lambda h, k, b, c: Section(h, k, b, c * h, -h), LENGTH, st.floats(0.0, 1.0), LENGTH, st.floats(0.0, 1.0)),
    st.builds(
        lambda h, k, b, skew, tilt: Section(h, k, b, 0.2 * h, -h, 0.3 * h, skew, tilt),
        *(LENGTH, st.floats(0.0, 1.0), LENGTH, st.floats(-0.5, 0.5), st.floats(-0.4, 0.4)),
    ),
)


def across_and_up(section, y, z):
    """Return where a place in the seam frame is across the section, from its middle there, and how high."""
    c, s = math.cos(section.tilt_rad), math.sin(section.tilt_rad)
    y, z = y - section.root_y_mm, z - section.root_z_mm
    u, h = c * y + s * z, c * z - s * y
    return u - section.skew * max(0.0, h - section.root_face_mm), h


@settings(max_examples=60, deadline=None)
@given(SECTIONS, st.floats(0.01, 1.0))
def test_a_section_is_as_wide_as_its_area_grows(section, share):
    h, step = share * section.height_mm, 1e-4 * section.height_mm
    grown = section.area_below(h + step) - section.area_below(max(0.0, h - step))
    assert grown / (h + step - max(0.0, h - step)) == pytest.approx(2 * section.half_width(h), rel=0.02)
    assert across_and_up(section, *section.place(section.middle(h), h)) == pytest.approx((0.0, h), abs=1e-9)


@pytest.mark.parametrize("kind", [WeldKind.SINGLE_V, WeldKind.SINGLE_BEVEL, WeldKind.DOUBLE_V, WeldKind.DOUBLE_BEVEL])
@pytest.mark.parametrize("left_share", [None, 0.0, 0.3, 1.0])
def test_the_sides_of_a_groove_lean_as_they_were_measured_or_as_its_kind_says(kind, left_share):
    values = WeldValues(weld=kind, depth_mm=11.0, root_gap_mm=2.3, root_face_mm=1.7, groove_angle_deg=50.0)
    groove = (
        left_share if left_share is None else SimpleNamespace(left_share=left_share, y_mm=0.7, z_mm=-9.0, tilt_rad=0.2)
    )
    at = {"joint": JointType.BUTT, "weld": WeldType.GROOVE, "normals_rad": 0.1, "groove": groove}
    section = section_of(values, **at)
    left = left_share if groove else {WeldKind.SINGLE_V: 0.5, WeldKind.DOUBLE_V: 0.5}.get(kind, 0.0)
    middle, half = section.middle(11.0), section.half_width(11.0)
    sides = [math.degrees(math.atan2(half + way * middle - 1.15, 11.0 - 1.7)) for way in (-1, 1)]
    assert sides == pytest.approx([50.0 * left, 50.0 * (1.0 - left)])
    place = (0.7, -9.0, 0.2) if groove else (0.0, -11.0, 0.0)
    assert (section.root_y_mm, section.root_z_mm, section.tilt_rad) == place
    assert (section.is_groove, section.root_face_mm, section.least_aim_mm) == (True, 1.7, 0.0)
    assert section_of(replace(values, root_gap_mm=1.2), **at).least_aim_mm == 1.7  # a gap as wide as the usual wire
    assert section_of(replace(values, root_gap_mm=1.2, wire_mm=1.0), **at).least_aim_mm == 0.0
    assert section_of(replace(values, root_face_mm=14.0), **at).root_face_mm == 11.0
    assert section_of(replace(values, depth_mm=None), **at) is None
    assert section_of(replace(values, root_gap_mm=None, groove_angle_deg=None), **at) is None


def test_welds_without_a_stated_section_have_none():
    square = WeldValues(weld=WeldKind.SQUARE, depth_mm=5.0, root_gap_mm=1.5)
    butt = {"joint": JointType.BUTT, "weld": WeldType.GROOVE, "normals_rad": 0.0}
    found = section_of(square, **butt)
    assert (found.height_mm, found.slope, found.gap_mm, found.root_z_mm) == (5.0, 0.0, 1.5, -5.0)
    assert section_of(square, **{**butt, "joint": JointType.EDGE}).area_mm2 == 7.5
    assert section_of(replace(square, root_gap_mm=0.0), **butt) is None
    for change in ({"joint": JointType.TEE}, {"weld": WeldType.FLARE_V}, {"normals_rad": COPLANAR_RAD}):
        assert section_of(square, **{**butt, **change}) is None
    angles = np.array([0.99 * LEAST_FILLET_RAD, LEAST_FILLET_RAD, MOST_FILLET_RAD, 1.01 * MOST_FILLET_RAD])
    fillet, values = (JointType.TEE, WeldType.FILLET), WeldValues(weld=WeldKind.FILLET, throat_mm=4.0)
    found = [section_of(values, joint=fillet[0], weld=fillet[1], normals_rad=math.pi - angle) for angle in angles]
    assert [one is None for one in found] == [True, False, False, True]
    with pytest.raises(InputError, match="no area"):
        Section(4.0, 0.0)


def area(outline):
    y, z = np.array(outline).T
    return abs(float(np.sum(y * np.roll(z, -1) - np.roll(y, -1) * z))) / 2.0


@settings(max_examples=60, deadline=None)
@given(SECTIONS, st.integers(1, 40), st.sampled_from([-1, 1]))
def test_the_beads_fill_the_section_and_none_is_outside_of_it(section, passes, side):
    beads = place_beads(section, passes, first_side=side)
    assert [bead.number for bead in beads] == list(range(1, passes + 1))
    for bead in beads:
        assert area(bead.outline_mm) == pytest.approx(section.area_mm2 / passes, rel=1e-7)
        for place in (*bead.outline_mm, (bead.y_mm, bead.z_mm)):
            u, height = across_and_up(section, *place)
            assert -ROUND_OFF <= height / section.height_mm <= 1 + ROUND_OFF
            assert abs(u) <= section.half_width(height) + ROUND_OFF * section.height_mm
    assert sum(area(bead.outline_mm) for bead in beads) == pytest.approx(section.area_mm2, rel=1e-7)
    top = max(across_and_up(section, *place)[1] for bead in beads for place in bead.outline_mm)
    assert top == pytest.approx(section.height_mm, abs=1e-9)
    layers = [bead.layer for bead in beads]
    assert layers == sorted(layers)
    for layer in set(layers):
        ys = [across_and_up(section, bead.y_mm, bead.z_mm)[0] * -side for bead in beads if bead.layer == layer]
        assert ys == sorted(ys)


@settings(max_examples=40, deadline=None)
@given(SECTIONS, st.floats(0.01, 1.0))
def test_the_height_of_an_area_is_the_inverse_of_the_area_below_a_height(section, share):
    assert section.area_below(section.height_of(share * section.area_mm2)) == pytest.approx(share * section.area_mm2)


@settings(max_examples=60, deadline=None)
@given(st.floats(1.0, 60.0), st.floats(0.0, 100.0), st.floats(61.0, 5000.0), st.booleans())
def test_stitches_have_the_lengths_that_were_asked_and_the_same_free_at_both_ends(length, free, seam, closed):
    found = np.array(stretches(Stitch(length, length + free), seam, closed=closed))
    assert found[:, 1] - found[:, 0] == pytest.approx(length)
    assert (found[1:, 0] - found[:-1, 1] >= free - 1e-6).all()
    assert 0.0 <= found[0, 0] == pytest.approx(seam - found[-1, 1], abs=1e-6)
    at_ends = found[0, 0] + seam - found[-1, 1]
    assert at_ends <= (length + 2 * free + 1e-6)  # one more would not fit
    if closed:  # around a closed seam every gap is the same
        assert np.diff(found[:, 0]) == pytest.approx(seam / len(found)) or len(found) == 1


def test_stitches_begin_where_the_drawing_says():
    assert stretches(Stitch(50.0, 100.0, 0.0), 260.0) == ((0.0, 50.0), (100.0, 150.0), (200.0, 250.0))
    assert stretches(Stitch(50.0, 100.0), 40.0) == ((0.0, 40.0),)
    assert stretches(None, 40.0) == ((0.0, 40.0),)


@pytest.mark.parametrize(
    ("stitch", "message"),
    [
        (Stitch(50.0, 40.0), "the pitch of 40 mm is shorter than the stretch of 50 mm"),
        (Stitch(50.0, 100.0, 270.0), "an offset of 270 mm leaves no room for 50 mm on a seam of 300.0 mm"),
        (Stitch(0.001, 0.01), "makes 30000 stretches"),
    ],
)
def test_stitches_that_do_not_fit_are_refused(stitch, message):
    with pytest.raises(InputError, match=message):
        stretches(stitch, 300.0)
