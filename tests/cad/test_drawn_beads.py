"""Beads that a designer drew flat: one seam each, at the root, and none along their own edges."""

from functools import reduce
from math import sqrt

import pytest

from cad.kernel.modelling import fused
from cad.kernel.primitives import box, prism
from tests.samples.graphs import graph_of, nothing_crosses
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam import SeamOptions, SeamSource
from wpcal.seam.search import find_part_candidates

MEMBERS = [box(200, 100, 10, (0, 0, 0)), box(200, 8, 80, (0, 46, 10))]
BEADS = [prism([(0, y, 10), (0, y + leg, 10), (0, y, 16)], (200, 0, 0)) for y, leg in ((46, -6), (54, 6))]


@pytest.mark.parametrize("bodies", [[*MEMBERS, *BEADS], [reduce(fused, [*MEMBERS, *BEADS])]], ids=["bodies", "fused"])
def test_a_bead_is_one_seam_at_its_root(bodies: list[object]) -> None:
    graph = graph_of(*bodies)
    found = find_part_candidates(graph, TrimmedFaces.of(graph), SeamOptions(), cross=nothing_crosses)
    seams = [one for one in found.judged(SeamOptions()) if one.accepted]
    assert [one.source for one in seams] == [SeamSource.DRAWN, SeamSource.DRAWN]
    for seam, y in zip(seams, (46.0, 54.0), strict=True):
        assert seam.frames.p[0] == pytest.approx([0.0, y, 10.0], abs=1e-6)
        assert (seam.length_mm, seam.bead_mm) == (pytest.approx(200.0), pytest.approx(6.0 / sqrt(2.0), abs=0.01))
