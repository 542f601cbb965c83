"""A weldment that was fused to one solid is searched for its own seams also where other solids touch it."""

import pytest

from cad.kernel.call import KernelObject
from cad.kernel.primitives import box, cut, cylinder
from cad.kernel.to_brep import to_brep
from wpcal.seam import detect_seams

UP = (0.0, 0.0, 1.0)
BOLTS_MM = [(x, y) for x in (20.0, 280.0) for y in (20.0, 180.0)]


def bolted(shape: KernelObject, z: float) -> KernelObject:
    return cut(shape, *(cylinder(6, 40, (x, y, z), UP) for x, y in BOLTS_MM))


def fused_subframe() -> KernelObject:
    """Return a plate of 300 x 200 x 8 with two ribs of 160 x 8 x 72 on it, all in one."""
    columns = [box(wide, 200, 72, (x, 0, 8)) for x, wide in ((0, 40), (48, 202), (258, 42))]
    rows = [box(300, 20, 72, (0, y, 8)) for y in (0, 180)]
    return cut(box(300, 200, 80, (0, 0, 0)), *columns, *rows)


def test_the_ribs_of_a_fused_subframe_that_is_bolted_on_are_welded() -> None:
    floor = bolted(box(400, 300, 10, (-50, -50, -10)), -20.0)
    seams = detect_seams(to_brep([("subframe", bolted(fused_subframe(), -20.0)), ("floor", floor)]))
    inner = [seam for seam in seams if seam.solids == ("subframe",)]
    assert [seam.length_mm for seam in inner if seam.accepted] == pytest.approx([160.0] * 4)
    assert {(seam.joint.value, seam.accepted or bool(seam.wrap_of)) for seam in inner} == {("tee", True)}
    assert not any(seam.accepted for seam in seams if seam not in inner)  # what is bolted is not welded
