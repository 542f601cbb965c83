"""Solids that run into each other: the kernel cuts them, and the seams are those of the trimmed solids."""

from types import SimpleNamespace

import pytest

from cad.kernel.to_brep import to_brep
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece
from tests.samples.graphs import saddle
from tests.saved_graphs import saved_seams
from wpcal.seam import SeamOptions

LENGTH_MM = 0.01  #: The agreed accuracy of a seam's length.


@pytest.mark.parametrize(("tilt_deg", "trimmed"), [(0.0, "saddle-90"), (30.0, "saddle-60")])
def test_an_untrimmed_branch_has_the_seams_of_the_trimmed_one(tilt_deg: float, trimmed: str) -> None:
    solids = saddle(tilt_deg, trimmed=False)
    workpiece = Workpiece(to_brep(solids), shapes=tuple(SimpleNamespace(wrapped=shape) for _, shape in solids))
    found, _ = find_seams(workpiece, SeamOptions())
    expected = saved_seams(trimmed)
    assert [seam.accepted for seam in found] == [True, False]
    for mine, other in zip(found, expected, strict=True):
        assert mine.closed
        assert mine.length_mm == pytest.approx(other.length_mm, rel=0, abs=LENGTH_MM)
