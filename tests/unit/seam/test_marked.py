"""Edges that are marked as seams, on saved graphs; `cad/test_marked_seams.py` has the marks in STEP files."""

import numpy as np

from tests.saved_graphs import saved_graph
from wpcal.brep.extend import add_edges, line
from wpcal.seam import detect_seams
from wpcal.seam.find.marked import MarkedEdges


def test_a_wire_without_a_face_says_so() -> None:
    wires = [
        line(np.array([0.0, 0, 50]), np.array([30.0, 0, 50])),
        line(np.array([80.0, 0, 0]), np.array([80.0, 0, 9])),
    ]
    wider, edges = add_edges(saved_graph("plain-block"), wires)
    seams = detect_seams(wider, marked=MarkedEdges(edges, ("a", "b")))
    assert [seam.solids for seam in seams] == [(), ()]
    assert all("no face beside it: z is up in part coordinates" in seam.reasons for seam in seams)
    for seam, z in zip(seams, ([0, 0, 1], [1, 0, 0]), strict=True):
        np.testing.assert_allclose(
            seam.frames.R[:, :, 2], np.broadcast_to(z, (len(seam.frames), 3)), rtol=0, atol=1e-12
        )
