"""`part.glb`: what was written comes back, the container is glTF's, and a broken file is refused."""

import json
import shutil
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh import PartMesh, SolidMesh, vertex_normals
from wpcal.brep.mesh_glb import STEPS, STEPS_PER_DEFLECTION, read_part_glb, write_part_glb
from wpcal.brep.moved_mesh import moved_glb, read_moved_glb
from wpcal.core.errors import FormatError
from wpcal.core.transform import RigidTransform

HALF_STEP = 0.5001  #: Of a solid's own grid: rounding to the nearest step, and round-off.
COLOUR_DIGIT = 2e-4  #: Colours are stored with 6 digits of linear light and given back with 4 of sRGB.
TURN = 1e-12  #: Round-off of normals.


def box(name: str, size: tuple[float, float, float], color: tuple[float, float, float] | None = None) -> SolidMesh:
    """A box whose faces share no point, as the tessellation gives it."""
    points, triangles, edges = [], [], []
    for axis in range(3):
        for side in (0.0, 1.0):
            a, b = (axis + 1) % 3, (axis + 2) % 3
            corners = np.zeros((4, 3))
            corners[:, axis] = side
            corners[1:3, a] = 1.0
            corners[2:, b] = 1.0
            start = 4 * len(points)
            order = [0, 1, 2, 0, 2, 3] if side else [0, 2, 1, 0, 3, 2]
            triangles.append(np.array(order).reshape(2, 3) + start)
            edges.append(np.array([[0, 1], [1, 2], [2, 3], [3, 0]]) + start)
            points.append(corners * size)
    return SolidMesh(name, np.concatenate(points), np.concatenate(triangles), np.concatenate(edges), color)


def document_of(data: bytes) -> dict[str, Any]:
    length = struct.unpack_from("<I", data, 12)[0]
    document: dict[str, Any] = json.loads(data[20 : 20 + length])
    return document


@given(size=st.tuples(*[st.floats(0.1, 5000.0)] * 3), shift=st.tuples(*[st.floats(-1e4, 1e4)] * 3))
def test_what_is_written_comes_back(size: tuple[float, float, float], shift: tuple[float, float, float]) -> None:
    plain = box("plate <1>", size)
    solid = replace(plain, points=plain.points + np.array(shift))
    mesh = PartMesh((solid, box("ü", (1.0, 2.0, 3.0), (0.8, 0.1, 0.0))), 0.05, 0.35, "ab12")
    found = read_part_glb(write_part_glb(mesh))
    assert (found.deflection_mm, found.angle_rad, found.sha256) == (0.05, 0.35, "ab12")
    assert [one.name for one in found.solids] == ["plate <1>", "ü"]
    step = max(max(size) / STEPS, 0.05 / STEPS_PER_DEFLECTION)
    np.testing.assert_allclose(found.solids[0].points, solid.points, rtol=0, atol=HALF_STEP * step)
    np.testing.assert_array_equal(found.solids[0].triangles, solid.triangles)
    np.testing.assert_array_equal(found.solids[0].edges, solid.edges)
    assert found.solids[0].color_rgb is None
    np.testing.assert_allclose(found.solids[1].color_rgb, (0.8, 0.1, 0.0), rtol=0, atol=COLOUR_DIGIT)


def test_the_container_is_what_gltf_asks_for() -> None:
    data = write_part_glb(PartMesh((box("a", (10.0, 20.0, 5.0)),), 0.1, 0.35))
    document = document_of(data)
    assert struct.unpack_from("<4sII", data) == (b"glTF", 2, len(data))
    assert len(data) % 4 == 0
    root = document["nodes"][0]
    to_metres = np.array(root["matrix"]).reshape(4, 4).T
    np.testing.assert_allclose(to_metres @ [1000.0, 2000.0, 3000.0, 1.0], [1.0, 3.0, -2.0, 1.0], rtol=0, atol=TURN)
    for view in document["bufferViews"]:
        assert view["byteOffset"] % 4 == 0
        assert view.get("byteStride", 4) % 4 == 0
        assert view["byteOffset"] + view["byteLength"] <= document["buffers"][0]["byteLength"]
    positions = [accessor for accessor in document["accessors"] if "min" in accessor]
    assert positions[0]["min"] == [0, 0, 0]
    assert positions[0]["max"] == [1000, 2000, 500]  # in steps of a tenth of the deflection


def test_a_large_solid_gets_wide_indices() -> None:
    grid = np.stack(np.meshgrid(np.arange(300.0), np.arange(300.0), [0.0]), axis=-1).reshape(-1, 3)
    triangles = np.array([[0, 1, 70_000], [89_998, 300, 89_999]])
    mesh = PartMesh((SolidMesh("wide", grid, triangles, np.zeros((0, 2), dtype=np.int64)),), 0.1, 0.3)
    found = read_part_glb(write_part_glb(mesh)).solids[0]
    np.testing.assert_array_equal(found.triangles, triangles)
    assert len(found.edges) == 0


def test_a_triangle_without_area_has_some_normal() -> None:
    n = vertex_normals(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    np.testing.assert_array_equal(n, [[0.0, 0.0, 1.0]] * 3)


@pytest.mark.parametrize(
    "broken",
    [
        lambda data: b"",
        lambda data: data[:-4],
        lambda data: b"glXF" + data[4:],
        lambda data: data.replace(b'"deflection_mm"', b'"deflection_xx"'),
        lambda data: data.replace(b'"POSITION"', b'"POSITIOM"'),
    ],
)
def test_a_broken_file_is_refused_by_name(broken: Any) -> None:
    data = write_part_glb(PartMesh((box("a", (1.0, 1.0, 1.0)),), 0.1, 0.35))
    with pytest.raises(FormatError, match=r"some\.glb"):
        read_part_glb(broken(data), path="some.glb")


GOLDEN = Path(__file__).parents[3] / "fixtures" / "uprights" / "golden"
STEP_MM = 0.01  #: Larger than the step of the coordinates in the file.


def test_every_solid_is_where_its_body_is(golden: Any) -> None:
    data = (GOLDEN / "part.glb").read_bytes()
    calibration = json.loads((GOLDEN / "calibration.json").read_text())
    motion = {body["name"]: np.array(body["T_part_moved"]) for body in calibration["bodies"]["bodies"]}
    model, moved = read_part_glb(data), read_part_glb(moved_glb(data, calibration))
    assert moved.sha256 == model.sha256
    for old, new in zip(model.solids, moved.solids, strict=True):
        T = motion[old.name]
        np.testing.assert_allclose(new.points, old.points @ T[:3, :3].T + T[:3, 3], rtol=0, atol=STEP_MM)
        assert new.color_rgb == old.color_rgb
        assert len(new.triangles) == len(old.triangles)
    assert max(np.abs(new.points - old.points).max() for old, new in zip(model.solids, moved.solids, strict=True)) > 0.2
    place = RigidTransform(np.eye(3)[[1, 2, 0]], [7.0, -9, 5], "base", "part")
    normals = [vertex_normals(each.points, each.triangles) for each in moved.solids]
    golden([model, moved, normals, TriangleMaterial.of(moved, place)])


def test_a_rigid_part_stays_as_it_is() -> None:
    data = (GOLDEN / "part.glb").read_bytes()
    assert moved_glb(data, {"schema": "wpcal/calibration/1"}) is data


def test_triangles_without_a_calibration_beside_them_stay(tmp_path: Path) -> None:
    shutil.copy(GOLDEN / "part.glb", tmp_path)
    assert read_moved_glb(tmp_path / "part.glb") == (GOLDEN / "part.glb").read_bytes()
    shutil.copy(GOLDEN / "calibration.json", tmp_path)
    assert read_moved_glb(tmp_path / "part.glb") != (GOLDEN / "part.glb").read_bytes()
