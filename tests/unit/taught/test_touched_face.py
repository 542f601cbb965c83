"""Which face is touched at a point of the model, and how far its border is."""

from pathlib import Path

import numpy as np
import pytest

from wpcal.brep.graph_file import read_graph
from wpcal.brep.trim import TrimmedFaces
from wpcal.taught.kinds import TouchKind
from wpcal.taught.touched_face import touched_face

GRAPHS = Path(__file__).parents[3] / "fixtures" / "graphs"
ROUND_OFF_MM = 1e-6
CHORD_MM = 1e-3  #: Borders are polylines: on a round face they are this near to the edge.


def test_the_middle_of_a_rectangle_is_half_its_shorter_side_from_its_border():
    block = TrimmedFaces.of(read_graph(GRAPHS / "plain-block.npz"))
    for face, (a, b) in enumerate(zip(*block.face_box, strict=True)):
        found = touched_face(block, (a + b) / 2.0)
        assert (found.face, found.kind) == (face, TouchKind.PLANE)
        assert np.linalg.norm(found.p_part - (a + b) / 2.0) <= ROUND_OFF_MM
        assert abs(found.border_mm - sorted(b - a)[1] / 2.0) <= ROUND_OFF_MM


def test_at_an_edge_the_normal_says_which_face_is_meant():
    block = TrimmedFaces.of(read_graph(GRAPHS / "plain-block.npz"))
    corner = block.face_box[1].max(axis=0)
    for axis, normal in enumerate(np.eye(3)):
        beside = corner - 0.1 * np.eye(3)[axis - 1] - 5.0 * np.eye(3)[axis - 2]
        found = touched_face(block, beside, normal)
        assert found.normal_part @ normal > 1.0 - ROUND_OFF_MM
        assert abs(found.border_mm - 0.1) <= ROUND_OFF_MM


@pytest.mark.parametrize(
    ("p", "kind", "border_mm"), [([40.0, 0.0, 5.0], TouchKind.PLANE, 5.0), ([20.0, 25.0, 5.0], TouchKind.HOLE, 5.0)]
)
def test_faces_of_the_tee_have_the_words_of_a_taught_table(p, kind, border_mm):
    tee = TrimmedFaces.of(read_graph(GRAPHS / "tee.npz"))
    found = touched_face(tee, np.array(p))
    assert found.kind is kind
    assert abs(found.border_mm - border_mm) <= CHORD_MM
