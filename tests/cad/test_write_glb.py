"""A part written as GLB, and sections and frames as DXF, read back by other libraries."""

import io
import json
import struct

import ezdxf
import numpy as np
import pytest
from ezdxf import recover

from cad.draw.dxf import MAGNIFIED, POINT_LAYER, REFERENCE_LAYER, RESIDUAL_LAYER, write_dxf
from cad.draw.glb import TRIAD_MM, write_glb
from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.brep.mesh_glb import write_part_glb
from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.core.transform import RigidTransform
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType

SAME_MM = 1e-4  #: 32-bit numbers of metres: 6e-8 of 0.5 m.
STEP_M = 2e-6  #: A step of `part.glb`: 100 mm / 65535, and round-off of 32-bit metres.
LINES = 1


def parse(data):
    """Segments by name of node, back in mm with z up."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    json_length, _ = struct.unpack_from("<I4s", data, 12)
    document = json.loads(data[20 : 20 + json_length])
    binary = data[28 + json_length :]
    found = {}
    for node in document["nodes"]:
        if "mesh" not in node:
            continue
        (primitive,) = document["meshes"][node["mesh"]]["primitives"]
        assert primitive["mode"] == LINES
        accessor = document["accessors"][primitive["attributes"]["POSITION"]]
        start = document["bufferViews"][accessor["bufferView"]].get("byteOffset", 0) + accessor.get("byteOffset", 0)
        x, y, z = np.frombuffer(binary, "<f4", 3 * accessor["count"], start).reshape(-1, 3).T
        found[node["name"]] = 1000.0 * np.stack([x, -z, y], axis=1).reshape(-1, 2, 3)
    return found


def test_seams_and_triads_are_named_nodes_in_metres_with_y_up():
    p = np.stack([np.linspace(400, 500, 6), np.full(6, 20.0), np.full(6, -3.25)], axis=1)
    R = np.broadcast_to(np.diag([1.0, -1.0, -1.0]), (6, 3, 3))
    none = np.zeros(1, dtype=np.int64)
    pieces = SeamPieces(none, none, none, none, none, np.zeros((1, 3)))
    frames = SeamFrames(np.arange(4.0), p[1:-1], R[1:-1], np.ones(4), "base")
    seam = Seam("Naht ä", JointType.TEE, WeldType.FILLET, (), pieces, False, 60.0, True, True, (), frames)
    program = WeldProgram((WeldPath(seam, p, R, None),), RigidTransform.identity(target="base", source="part"))
    found = parse(write_glb(program)["WPCAL.glb"])
    expected = np.stack([p[1:-2], p[2:-1]], axis=1)
    np.testing.assert_allclose(found["Naht ä"], expected, rtol=0, atol=SAME_MM)
    axes = found["Naht ä triads"].reshape(4, 3, 2, 3)
    np.testing.assert_allclose(axes[:, :, 0], np.repeat(p[1:-1, None], 3, axis=1), rtol=0, atol=SAME_MM)
    drawn = (axes[:, :, 1] - axes[:, :, 0]) / TRIAD_MM
    np.testing.assert_allclose(drawn, np.swapaxes(R[1:-1], 1, 2), rtol=0, atol=SAME_MM)


def placed_triangles(data, name):
    """Corners of a node's triangles, metres with y up, through the matrices of its parents."""
    json_length, _ = struct.unpack_from("<I4s", data, 12)
    document = json.loads(data[20 : 20 + json_length])
    binary = data[28 + json_length :]
    nodes = document["nodes"]
    parents = {child: number for number, node in enumerate(nodes) for child in node.get("children", ())}
    (number,) = [number for number, node in enumerate(nodes) if node.get("name") == name]
    (primitive,) = document["meshes"][nodes[number]["mesh"]]["primitives"]

    def numbers(accessor, kind, width):
        view = document["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(binary, kind, accessor["count"] * width, start).reshape(-1, width)

    p = numbers(document["accessors"][primitive["attributes"]["POSITION"]], "<f4", 3).astype(float)
    corners = document["accessors"][primitive["indices"]]
    rows = numbers(corners, {5125: "<u4", 5123: "<u2"}[corners["componentType"]], 1).ravel()
    while True:
        matrix = np.array(nodes[number].get("matrix", np.eye(4).ravel())).reshape(4, 4).T
        p = p @ matrix[:3, :3].T + matrix[:3, 3]
        if number not in parents:
            return p[rows].reshape(-1, 3, 3), document["materials"][primitive["material"]]
        number = parents[number]


def test_the_part_hangs_under_a_node_with_its_pose():
    corners = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 50.0, 0.0], [0.0, 0.0, 20.0]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    none = np.zeros((0, 2), dtype=np.int64)
    solids = (
        SolidMesh("W1", corners, triangles, none, (1.0, 0.0, 0.0)),
        SolidMesh("web", corners + 7, triangles, none),
    )
    T = RigidTransform.from_six_tuple([800.0, -200.0, 150.0, 0.3, -0.2, 0.6], target="base", source="part")
    p = np.array([[400.0, 0.0, 0.0]] * 4)
    R = np.broadcast_to(np.eye(3), (4, 3, 3))
    row = np.zeros(1, dtype=np.int64)
    frames = SeamFrames(np.arange(2.0), p[1:-1], R[1:-1], np.ones(2), "base")
    pieces = SeamPieces(row, row, row, row, row, np.zeros((1, 3)))
    seam = Seam("W1", JointType.TEE, WeldType.FILLET, (), pieces, False, 1.0, True, True, (), frames)
    program = WeldProgram((WeldPath(seam, p, R, None),), T, part_glb=write_part_glb(PartMesh(solids, 0.01, 0.6)))
    (data,) = write_glb(program).values()
    found, material = placed_triangles(data, "W1#2")  # the seam keeps its name
    x, y, z = (T.apply(corners) / 1000.0).T
    expected = np.stack([x, z, -y], axis=1)[triangles]
    np.testing.assert_allclose(found, expected, rtol=0, atol=STEP_M)
    np.testing.assert_allclose(material["pbrMetallicRoughness"]["baseColorFactor"], [1, 0, 0, 1], rtol=0, atol=0.01)
    found, _ = placed_triangles(data, "web")
    x, y, z = (T.apply(corners + 7.0) / 1000.0).T
    np.testing.assert_allclose(found, np.stack([x, z, -y], axis=1)[triangles], rtol=0, atol=STEP_M)


DRAWN_MM = 1e-9  #: The file keeps 16 digits of numbers up to 1000.


@pytest.fixture
def program():
    p = np.stack([np.linspace(0, 100, 5), np.full(5, 20.0), np.full(5, -3.25)], axis=1) / 3.0
    R = np.broadcast_to(np.eye(3), (5, 3, 3))
    none = np.zeros(1, dtype=np.int64)
    paths = []
    for name, joint in (("W1", JointType.TEE), ("weld/2;ä", JointType.LAP)):
        frames = SeamFrames(np.arange(5.0), p, R, np.ones(5), "base")
        pieces = SeamPieces(none, none, none, none, none, np.zeros((1, 3)))
        seam = Seam(name, joint, WeldType.FILLET, (), pieces, False, 33.0, True, True, (), frames)
        paths.append(WeldPath(seam, p, R, None))
    points = [{"name": "corner A", "p_base_mm": [1.0, 2.0, 3.0], "residual_mm": [0.1, 0.0, -0.2]}]
    T = RigidTransform.identity(target="base", source="part")
    return WeldProgram(tuple(paths), T, calibration={"points": points})


def read(text):
    document, auditor = recover.read(io.BytesIO(text.encode()))
    assert not auditor.errors
    assert not auditor.fixes
    return document


def test_seams_are_polylines_on_a_layer_each_coloured_by_joint(program):
    document = read(write_dxf(program)["WPCAL.dxf"])
    assert document.header["$INSUNITS"] == 4
    lines = document.modelspace().query("POLYLINE")
    assert [line.dxf.layer for line in lines] == ["W1", "weld_2_a"]
    assert [document.layers.get(line.dxf.layer).color for line in lines] == [3, 5]
    found = np.array([vertex.dxf.location for vertex in lines[0].vertices])
    np.testing.assert_allclose(found, program.paths[0].seam.frames.p, rtol=0, atol=DRAWN_MM)


def test_points_have_labels_and_magnified_residuals(program):
    space = read(write_dxf(program)["WPCAL.dxf"]).modelspace()
    points = {point.dxf.layer: np.array(point.dxf.location) for point in space.query("POINT")}
    (line,) = space.query("LINE")
    assert line.dxf.layer == RESIDUAL_LAYER
    np.testing.assert_allclose(points[POINT_LAYER], [1.0, 2.0, 3.0], rtol=0, atol=DRAWN_MM)
    np.testing.assert_allclose(points[REFERENCE_LAYER], [0.9, 2.0, 3.2], rtol=0, atol=DRAWN_MM)
    texts = {text.dxf.layer: text.dxf.text for text in space.query("TEXT")}
    assert texts[REFERENCE_LAYER] == "corner A"
    assert texts[RESIDUAL_LAYER] == "0.224"
    drawn = np.array(line.dxf.start) - np.array(line.dxf.end)
    np.testing.assert_allclose(drawn, MAGNIFIED * np.array([0.1, 0.0, -0.2]), rtol=0, atol=DRAWN_MM)


def test_text_is_a_hundredth_of_the_drawing_and_points_are_marked(program):
    document = read(write_dxf(program)["WPCAL.dxf"])
    heights = {text.dxf.height for text in document.modelspace().query("TEXT")}
    size = np.linalg.norm([100 / 3, 20 / 3 - 2.0, 3.0 + 3.25 / 3])
    assert [*heights] == [pytest.approx(0.01 * size, rel=0, abs=DRAWN_MM)]
    assert document.header["$PDMODE"] == 35
    assert document.header["$PDSIZE"] == pytest.approx(0.01 * size, rel=0, abs=DRAWN_MM)


def test_the_same_program_gives_the_same_bytes(program):
    assert write_dxf(program) == write_dxf(program)
    assert not ezdxf.options.write_fixed_meta_data_for_testing
