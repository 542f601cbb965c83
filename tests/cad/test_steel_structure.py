"""The structure that speed is measured on: its seams are those of the closed form."""

import pytest

from cad.kernel.to_brep import to_brep
from tests.samples.steel_structure import seam_counts, steel_structure
from wpcal.seam import detect_seams

BAYS = 2
FACES = 456  #: 3 frames of 2 plates of 10 faces, 4 tubes of 18 and a pipe of 4; 2 bays of 4 tubes and 2 gussets of 6.
LENGTH_MM = 1e-6  #: Straight edges and arcs: only round-off is in their lengths.


def test_every_seam_of_the_structure_is_found() -> None:
    graph = to_brep((name, shape) for name, shape, _ in steel_structure(BAYS))
    assert graph.face_count == FACES
    reached = [seam for seam in detect_seams(graph) if seam.accepted]
    count, length = seam_counts(BAYS)
    assert len(reached) == count
    assert sum(seam.length_mm for seam in reached) == pytest.approx(length, rel=0, abs=LENGTH_MM)
