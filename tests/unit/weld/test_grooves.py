"""Grooves measured from the model: V, half V, X and K, against the numbers that they were built of."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.brep.mesh_glb import write_part_glb
from wpcal.core.transform import RigidTransform
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType
from wpcal.weld.find import _in_groove, find_welds
from wpcal.weld.groove import measure_groove
from wpcal.weld.place import StatedWeld
from wpcal.weld.rules import shipped_rules
from wpcal.weld.values import WeldKind

ATOL = 1e-4  #: Triangles of the model are kept with 32-bit numbers.
LENGTH, WIDTH = 120.0, 50.0


def prism(name, outline):
    """A plate from its outline in y and z, counter-clockwise, along x."""
    k = len(outline)
    caps = [[0, i, i + 1] for i in range(1, k - 1)]
    near = np.array([[0.0, y, z] for y, z in outline])
    far = near + np.array([LENGTH, 0, 0])
    triangles = [[a, c, b] for a, b, c in caps] + [[a + k, b + k, c + k] for a, b, c in caps]
    for i in range(k):
        j = (i + 1) % k
        triangles += [[i, j, j + k], [i, j + k, i + k]]
    centre = np.mean(near, axis=0) + np.array([LENGTH / 2, 0, 0])
    points = np.concatenate([near, far])
    fixed = []
    for a, b, c in triangles:  # outwards: the outlines are star-shaped about their middle, seen along each face
        normal = np.cross(points[b] - points[a], points[c] - points[a])
        fixed.append([a, b, c] if normal @ (points[a] - centre) >= 0 else [a, c, b])
    return SolidMesh(name, points, np.array(fixed), np.zeros((0, 2), dtype=np.int64))


def plate(side, t, angle_deg, face, gap, *, both):
    k = math.tan(math.radians(angle_deg))
    if both:
        h = (t - face) / 2
        edge = [(gap / 2 + h * k, 0.0), (gap / 2, h), (gap / 2, h + face), (gap / 2 + h * k, t)]
    else:
        edge = [(gap / 2, 0.0), (gap / 2, face), (gap / 2 + (t - face) * k, t)]
    rows = [*dict.fromkeys(edge), (WIDTH, t), (WIDTH, 0.0)]
    return [(side * y, z) for y, z in rows]


def groove(left, right, face, gap, t=12.0, *, both=False, at="root edge"):
    """A mesh of two plates, and the seam as it is found: along the upper edge of a root face, or on the surface."""
    a = prism("a", plate(-1, t, left, face, gap, both=both))
    b = prism("b", plate(1, t, right, face, gap, both=both))
    root = (t + face) / 2 if both else face
    y, z = {"root edge": (gap / 2, root), "surface": (0.0, t), "back": (gap / 2, 0.0)}[at]
    x = np.linspace(0, LENGTH, 7)
    up = Rotation.from_euler("x", 0 if at != "back" else 180, degrees=True)
    lean = Rotation.from_euler("x", 17 if at == "root edge" else 0, degrees=True)  # bisectors are not plumb
    R = np.tile((up * lean).as_matrix(), (7, 1, 1))
    pieces = SeamPieces(*(np.zeros(1, dtype=np.int64),) * 5, np.full((1, 3), gap))
    frames = SeamFrames(x, np.stack([x, 0 * x + y, 0 * x + z], axis=1), R, np.full(7, 2.0), "base")
    seam = Seam("W1", JointType.BUTT, WeldType.GROOVE, ("a", "b"), pieces, False, LENGTH, True, True, (), frames)
    return PartMesh((a, b), 0.01, 0.5, None), seam


PLACE = RigidTransform.identity(target="base", source="part")
KINDS = {
    "V": (30, 30, 2.0, 2.0, False, WeldKind.SINGLE_V),
    "V without gap": (27.5, 27.5, 1.5, 0.0, False, WeldKind.SINGLE_V),
    "V to the edge": (30, 30, 0.0, 1.0, False, WeldKind.SINGLE_V),
    "uneven V": (20, 35, 1.0, 3.0, False, WeldKind.SINGLE_V),
    "half V": (0, 45, 2.0, 2.0, False, WeldKind.SINGLE_BEVEL),
    "half V the other way": (50, 0, 1.0, 2.5, False, WeldKind.SINGLE_BEVEL),
    "X": (30, 30, 2.0, 2.0, True, WeldKind.DOUBLE_V),
    "K": (0, 45, 2.0, 3.0, True, WeldKind.DOUBLE_BEVEL),
}


@pytest.mark.parametrize("at", ["root edge", "surface"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_groove_has_the_numbers_it_was_built_of(kind, at, golden):
    left, right, face, gap, both, expected = KINDS[kind]
    t = 12.0
    mesh, seam = groove(left, right, face, gap, t, both=both, at=at)
    found = measure_groove(seam, mesh, PLACE)
    assert found.kind is expected
    golden(found)
    depth = t / 2 if both else t
    numbers = [found.angle_deg, found.gap_mm, found.root_face_mm, found.depth_mm, found.thickness_mm]
    np.testing.assert_allclose(numbers, [left + right, gap, face / (1 + both), depth, t], rtol=0, atol=ATOL)
    assert found.left_share == pytest.approx(left / (left + right), abs=1e-6)
    R, p = seam.frames.R[3], seam.frames.p[3]
    root = p + R @ [0, found.y_mm, found.z_mm]
    np.testing.assert_allclose(root[1:], [0.0, t / 2 if both else 0.0], rtol=0, atol=ATOL)
    laid = _in_groove(seam, found).frames.R
    np.testing.assert_allclose(laid[:, :, 2], np.tile([0.0, 0.0, 1.0], (len(laid), 1)), rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_the_beads_fill_the_groove_that_the_model_has(kind):
    left, right, face, gap, both, expected = KINDS[kind]
    mesh, seam = groove(left, right, face, gap, both=both)
    (weld,) = find_welds([seam], PLACE, shipped_rules(), part_glb=write_part_glb(mesh)).welds
    assert weld.values.weld is expected
    names = ("weld", "depth_mm", "root_gap_mm", "thickness_mm", "groove_angle_deg")
    assert {weld.origins[name].source.value for name in names} == {"model"}
    depth, c = (6.0, face / 2) if both else (12.0, face)
    k = (math.tan(math.radians(left)) + math.tan(math.radians(right))) / 2
    area = gap * depth + k * (depth - c) ** 2
    assert sum(bead.area_mm2 for bead in weld.beads) == pytest.approx(area, rel=0.005)  # values have two decimals
    assert weld.values.passes == len(weld.beads)
    R, p = seam.frames.R[0], seam.frames.p[0]
    for bead in weld.beads:
        for y, z in (*bead.outline_mm, (bead.y_mm, bead.z_mm)):
            _, u, h = p + R @ [0, y, z]
            h -= 6.0 if both else 0.0
            sides = [gap / 2 + math.tan(math.radians(angle)) * max(0.0, h - c) for angle in (left, right)]
            assert -0.01 <= h <= depth + 0.01
            assert -sides[0] - 0.02 <= u <= sides[1] + 0.02
        lean = math.radians(bead.work_angle_deg)
        wire = R @ [0, math.sin(lean), -math.cos(lean)]
        leans = math.degrees(math.atan2(wire[1], -wire[2]))  # towards +y; the torch leans the other way
        assert -right / 2 - 0.1 <= leans <= left / 2 + 0.1


def test_the_wire_does_not_aim_into_a_root_face_that_is_narrower_than_itself():
    for gap, height in ((0.0, 2.0), (1.0, 2.0), (2.0, 0.0)):
        mesh, seam = groove(30, 30, 2.0, gap)
        (weld,) = find_welds([seam], PLACE, shipped_rules(), part_glb=write_part_glb(mesh)).welds
        root = weld.beads[0]
        place = seam.frames.p[0] + seam.frames.R[0] @ [0, root.y_mm, root.z_mm]
        np.testing.assert_allclose(place[1:], [0.0, height], rtol=0, atol=0.01)


@pytest.mark.parametrize(("face", "gap"), [(2.0, 2.0), (0.0, 0.0), (0.0, 1.5)])
def test_the_other_side_of_a_groove_is_a_run_along_its_root_face_or_as_thick_as_the_plates(face, gap):
    mesh, seam = groove(30, 30, face, gap, at="back")
    found = measure_groove(seam, mesh, PLACE)
    assert (found.kind, found.angle_deg) == (WeldKind.SQUARE, 0.0)
    np.testing.assert_allclose([found.depth_mm, found.gap_mm], [face, gap], rtol=0, atol=ATOL)
    assert face or (found.thickness_mm == pytest.approx(12.0, abs=ATOL) and "depth_mm" not in found.values())


def test_what_a_person_states_counts_before_the_model():
    mesh, seam = groove(30, 30, 2.0, 2.0)
    stated = StatedWeld("W1", None, {"groove_angle_deg": 40.0, "passes": 1})
    (weld,) = find_welds([seam], PLACE, shipped_rules(), part_glb=write_part_glb(mesh), stated=[stated]).welds
    assert (weld.values.groove_angle_deg, weld.origins["groove_angle_deg"].source.value) == (40.0, "user")
    (bead,) = weld.beads
    assert bead.area_mm2 == pytest.approx(24 + math.tan(math.radians(20)) * 100)


@pytest.mark.parametrize(("left", "right", "gap"), [(0, 0, 2.0), (0, 0, 0.0), (0.5, 0.5, 1.0)])
def test_square_plates_have_no_groove(left, right, gap):
    mesh, seam = groove(left, right, 2.0, gap)
    assert measure_groove(seam, mesh, PLACE) is None


def test_plates_that_are_not_in_one_line_have_no_groove():
    upright = prism("b", [(0.0, 0.0), (8.0, 0.0), (8.0, 60.0), (0.0, 60.0)])
    flat = prism("a", [(-50.0, -10.0), (50.0, -10.0), (50.0, 0.0), (-50.0, 0.0)])
    _, seam = groove(30, 30, 2.0, 2.0)
    assert measure_groove(seam, PartMesh((flat, upright), 0.01, 0.5, None), PLACE) is None
    assert measure_groove(seam, PartMesh((flat,), 0.01, 0.5, None), PLACE) is None
