import io

import ezdxf
import numpy as np
import pytest
from ezdxf import recover

from cad.draw.dxf import MAGNIFIED, POINT_LAYER, REFERENCE_LAYER, RESIDUAL_LAYER, write_dxf
from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.core.transform import RigidTransform
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType

SAME_MM = 1e-9  #: The file keeps 16 digits of numbers up to 1000.


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
    np.testing.assert_allclose(found, program.paths[0].seam.frames.p, rtol=0, atol=SAME_MM)


def test_points_have_labels_and_magnified_residuals(program):
    space = read(write_dxf(program)["WPCAL.dxf"]).modelspace()
    points = {point.dxf.layer: np.array(point.dxf.location) for point in space.query("POINT")}
    (line,) = space.query("LINE")
    assert line.dxf.layer == RESIDUAL_LAYER
    np.testing.assert_allclose(points[POINT_LAYER], [1.0, 2.0, 3.0], rtol=0, atol=SAME_MM)
    np.testing.assert_allclose(points[REFERENCE_LAYER], [0.9, 2.0, 3.2], rtol=0, atol=SAME_MM)
    texts = {text.dxf.layer: text.dxf.text for text in space.query("TEXT")}
    assert texts[REFERENCE_LAYER] == "corner A"
    assert texts[RESIDUAL_LAYER] == "0.224"
    drawn = np.array(line.dxf.start) - np.array(line.dxf.end)
    np.testing.assert_allclose(drawn, MAGNIFIED * np.array([0.1, 0.0, -0.2]), rtol=0, atol=SAME_MM)


def test_text_is_a_hundredth_of_the_drawing_and_points_are_marked(program):
    document = read(write_dxf(program)["WPCAL.dxf"])
    heights = {text.dxf.height for text in document.modelspace().query("TEXT")}
    size = np.linalg.norm([100 / 3, 20 / 3 - 2.0, 3.0 + 3.25 / 3])
    assert [*heights] == [pytest.approx(0.01 * size, rel=0, abs=SAME_MM)]
    assert document.header["$PDMODE"] == 35
    assert document.header["$PDSIZE"] == pytest.approx(0.01 * size, rel=0, abs=SAME_MM)


def test_the_same_program_gives_the_same_bytes(program):
    assert write_dxf(program) == write_dxf(program)
    assert not ezdxf.options.write_fixed_meta_data_for_testing
