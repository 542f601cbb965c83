"""Hulls of links from a URDF file: meshes and boxes, in the frames of the arm's own links."""

import struct
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from wpcal.core.errors import FormatError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import arm_frames
from wpcal.robot.kinematics.urdf import read_urdf
from wpcal.robot.kinematics.urdf_bodies import ROUND_CORNERS, _primitive, read_link_hulls

URDF = """<robot name="two">
  <link name="base_link"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
  <link name="one"><collision><origin xyz="0 0 0.05"/><geometry><mesh filename="one.stl"/></geometry></collision></link>
  <link name="two"><collision><geometry><cylinder radius="0.1" length="0.02"/></geometry></collision></link>
  <joint name="tilt" type="revolute"><parent link="base_link"/><child link="one"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 -1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="turn" type="revolute"><parent link="one"/><child link="two"/><origin xyz="0.1 0 0.2" rpy="0.3 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
</robot>"""
CUBE = np.array([[x, y, z] for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)])
ROUNDED_MM = 0.02  #: Corners are written with two decimals.


def write_stl(path, points):
    """Write a binary STL file whose triangles have all the points as corners."""
    rows = b"".join(
        struct.pack("<12fH", 0, 0, 0, *points[i], *points[(i + 1) % 8], *points[(i + 2) % 8], 0) for i in range(8)
    )
    path.write_bytes(bytes(80) + struct.pack("<I", 8) + rows)


@pytest.fixture
def urdf(tmp_path):
    write_stl(tmp_path / "one.stl", CUBE)
    path = tmp_path / "two.urdf"
    path.write_text(URDF, encoding="utf-8")
    return path


def test_corners_are_where_the_urdf_puts_them_at_every_joint_angle(urdf):
    arm = read_urdf(urdf)
    base, one, two = read_link_hulls(urdf, arm)
    assert [body.link for body in (base, one, two)] == [0, 1, 2]
    assert np.allclose(base.hull.min(axis=0), [-100, -100, -50], rtol=0, atol=ROUNDED_MM)
    tilt, turn = 0.4, -0.7
    c, s = np.cos(tilt), np.sin(tilt)
    R_tilt = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])  # about -y
    expected = 1000 * (CUBE + np.array([0, 0, 0.05])) @ R_tilt.T + np.array([0, 0, 400])
    place = RigidTransform.identity(target="world", source="base")
    frames = [f.matrices()[0] for f in arm_frames(arm, place, np.array([[tilt, turn]]))]
    found = one.hull @ frames[1][:3, :3].T + frames[1][:3, 3]
    order = [np.lexsort(np.round(points, 1).T) for points in (found, expected)]
    assert np.allclose(found[order[0]], expected[order[1]], rtol=0, atol=ROUNDED_MM)
    middle = two.hull.mean(axis=0) @ frames[2][:3, :3].T + frames[2][:3, 3]
    assert np.allclose(middle, np.array([100, 0, 200]) @ R_tilt.T + [0, 0, 400], rtol=0, atol=0.1)


def test_links_beyond_the_last_joint_of_the_arm_are_left_out(urdf):
    short = urdf.with_name("short.urdf")
    short.write_text(URDF.replace('"turn" type="revolute"', '"turn" type="fixed"'), encoding="utf-8")
    assert [body.link for body in read_link_hulls(urdf, read_urdf(short))] == [0, 1]


def test_a_text_stl_is_read_too(urdf):
    lines = ["solid x"]
    for i in range(8):
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(map(str, CUBE[(i + k) % 8])) for k in range(3)] + ["endloop", "endfacet"]
    binary = read_link_hulls(urdf, read_urdf(urdf))[1].hull
    urdf.with_name("one.stl").write_text("\n".join(lines), encoding="utf-8")
    assert np.allclose(read_link_hulls(urdf, read_urdf(urdf))[1].hull, binary, rtol=0, atol=ROUNDED_MM)


@pytest.mark.parametrize(
    ("old", "new", "error", "says"),
    [
        ("one.stl", "one.dae", FormatError, "only meshes in STL files are read"),
        ("one.stl", "package://x/one.stl", InputError, "not by a package"),
        ("one.stl", "none.stl", InputError, "none.stl"),
        ("<cylinder", "<cone", FormatError, "cannot read the shape"),
    ],
)
def test_a_shape_that_cannot_be_read_is_one_line(urdf, old, new, error, says):
    urdf.write_text(URDF.replace(old, new), encoding="utf-8")
    with pytest.raises(error, match=says):
        read_link_hulls(urdf, read_urdf(urdf))


def test_no_stl_is_told(urdf):
    urdf.with_name("one.stl").write_text("nothing", encoding="utf-8")
    with pytest.raises(FormatError, match="is not an STL file"):
        read_link_hulls(urdf, read_urdf(urdf))


@pytest.mark.parametrize(
    ("shape", "reach"),
    [
        ('<box size="0.02 0.05 0.3"/>', lambda d: np.abs(d) @ [10.0, 25.0, 150.0]),
        (
            '<cylinder radius="0.07" length="0.3"/>',
            lambda d: 70.0 * np.hypot(d[:, 0], d[:, 1]) + 150.0 * np.abs(d[:, 2]),
        ),
        ('<sphere radius="0.07"/>', lambda d: np.full(len(d), 70.0)),
    ],
)
def test_triangles_are_around_a_shape_and_near_it(shape, reach):
    """How far both reach in any direction; the polygon is around the circle, in a sphere twice."""
    d = np.random.default_rng(3).normal(size=(2000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    found = (_primitive(ET.fromstring(shape), Path("arm.urdf"), "one").reshape(-1, 3) @ d.T).max(axis=0)
    assert (found >= reach(d) * (1 - 1e-12)).all()
    assert (found <= reach(d) / np.cos(np.pi / ROUND_CORNERS) ** 2 * (1 + 1e-12)).all()
