"""Beads and stretches: the areas add up, no bead leaves the section, and stitches have the lengths that were asked."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wpcal.core.errors import InputError
from wpcal.seam.seam import JointType, WeldType
from wpcal.weld.passes import place_beads
from wpcal.weld.section import Section, section_of, throat_of
from wpcal.weld.stitch import stretches
from wpcal.weld.values import Stitch, WeldKind, WeldValues

ROUND_OFF = 1e-9  #: Relative: all areas have a closed form.

LENGTH = st.floats(0.5, 30.0)
SECTIONS = st.one_of(
    st.builds(Section, LENGTH, st.floats(0.2, 3.0)),
    st.builds(lambda h, k, b, c: Section(h, k, b, c * h, -h), LENGTH, st.floats(0.0, 1.0), LENGTH, st.floats(0.0, 1.0)),
)


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
        for y, z in (*bead.outline_mm, (bead.y_mm, bead.z_mm)):
            height = z - section.root_z_mm
            assert -ROUND_OFF <= height <= section.height_mm * (1 + ROUND_OFF)
            assert abs(y) <= section.half_width(height) + ROUND_OFF * section.height_mm
    assert sum(area(bead.outline_mm) for bead in beads) == pytest.approx(section.area_mm2, rel=1e-7)
    top = max(z for bead in beads for _, z in bead.outline_mm)
    assert top == pytest.approx(section.root_z_mm + section.height_mm, abs=1e-9)
    layers = [bead.layer for bead in beads]
    assert layers == sorted(layers)
    for layer in set(layers):
        ys = [bead.y_mm * -side for bead in beads if bead.layer == layer]
        assert ys == sorted(ys)


@settings(max_examples=40, deadline=None)
@given(SECTIONS, st.floats(0.01, 1.0))
def test_the_height_of_an_area_is_the_inverse_of_the_area_below_a_height(section, share):
    assert section.area_below(section.height_of(share * section.area_mm2)) == pytest.approx(share * section.area_mm2)


def test_a_fillet_of_three_passes_has_its_root_in_the_corner_and_two_beads_on_it():
    root, first, second = place_beads(Section(8.0, 1.0), 3)
    assert (root.y_mm, root.z_mm, root.work_angle_deg) == (0.0, 0.0, 0.0)
    assert (first.layer, second.layer) == (2, 2)
    assert first.y_mm == -second.y_mm < 0.0
    assert first.z_mm == pytest.approx(8.0 / math.sqrt(3.0))  # a third of the area is below
    assert (first.work_angle_deg, second.work_angle_deg) == (-22.5, 22.5)
    third = place_beads(Section(8.0, 1.0), 6)[3:]  # the outer ones lean as much, however many are between them
    assert [bead.work_angle_deg for bead in third] == pytest.approx([-22.5, 0.0, 22.5])


def test_a_fillet_is_as_large_as_its_throat_or_its_leg():
    right = math.pi / 2
    at = {"joint": JointType.TEE, "weld": WeldType.FILLET, "normals_rad": right}
    assert section_of(WeldValues(weld=WeldKind.FILLET, leg_mm=6.0), **at).area_mm2 == pytest.approx(18.0)
    assert throat_of(WeldValues(leg_mm=6.0), right) == pytest.approx(6.0 / math.sqrt(2.0))
    assert section_of(WeldValues(weld=WeldKind.FILLET), **at) is None


def test_a_v_groove_begins_at_its_root_below_the_face_of_the_plates():
    values = WeldValues(weld=WeldKind.SINGLE_V, depth_mm=10.0, root_gap_mm=2.0, root_face_mm=2.0, groove_angle_deg=60.0)
    section = section_of(values, joint=JointType.BUTT, weld=WeldType.GROOVE, normals_rad=0.0)
    assert section.area_mm2 == pytest.approx(20.0 + 64.0 * math.tan(math.radians(30.0)))
    beads = place_beads(section, 4)
    assert (beads[0].y_mm, beads[0].z_mm) == (0.0, -10.0)
    assert beads[-1].outline_mm[-1][1] == pytest.approx(0.0)


@pytest.mark.parametrize("passes", [0, 201])
def test_a_number_of_passes_that_no_weld_has_is_refused(passes):
    with pytest.raises(InputError, match="expected 1 to 200"):
        place_beads(Section(4.0, 1.0), passes)


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
