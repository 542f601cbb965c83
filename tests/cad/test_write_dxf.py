import io

import ezdxf
import numpy as np
import pytest
from ezdxf import recover

from cad.write_dxf import MAGNIFIED, POINT_LAYER, RESIDUAL_LAYER, write_dxf
from wpcal.core.transform import RigidTransform
from wpcal.export import WeldPath, WeldProgram
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType

SAME_MM = 1e-9
"""The file keeps 16 digits of numbers up to 1000."""


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
    (point,) = space.query("POINT")
    (line,) = space.query("LINE")
    assert (point.dxf.layer, line.dxf.layer) == (POINT_LAYER, RESIDUAL_LAYER)
    assert "corner A" in [text.dxf.text for text in space.query("TEXT")]
    drawn = np.array(line.dxf.start) - np.array(line.dxf.end)
    np.testing.assert_allclose(drawn, MAGNIFIED * np.array([0.1, 0.0, -0.2]), rtol=0, atol=SAME_MM)


def test_the_same_program_gives_the_same_bytes(program):
    assert write_dxf(program) == write_dxf(program)
    assert not ezdxf.options.write_fixed_meta_data_for_testing
