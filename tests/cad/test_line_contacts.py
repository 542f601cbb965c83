"""Members that touch along a line only, or are a root gap apart there: each side of the line is a weld.

The sections are in x and z, and the line runs along y at x = z = 0. Two sides of it are open, and there the welds are
expected, whatever the angles are.
"""

from collections.abc import Sequence

import numpy as np
import pytest
from build123d import Axis, Plane, Polyline, make_face, revolve

from cad.kernel.primitives import box, cut, cylinder, prism
from cad.kernel.to_brep import to_brep
from tests.few import few
from tests.samples.graphs import UP, graph_of
from wpcal.brep import BrepGraph
from wpcal.seam import Seam, detect_seams
from wpcal.seam.seam import JointType, WeldType

LENGTH_MM = 200.0
Section = Sequence[tuple[float, float]]
RIGHT: dict[str, Section] = {
    "V": [(0, 0), (100, 0), (100, 10), (10 * np.tan(np.radians(27)), 10)],
    "thin V": [(0, 0), (60, 0), (60, 4), (4 * np.tan(np.radians(33)), 4)],
    "square X": [(0, 0), (9, 9), (100, 9), (100, -9), (9, -9)],
    "X": [(0, 0), (7, 9), (100, 9), (100, -9), (7, -9)],
    "half V": [(0, 0), (100, 0), (100, 10), (9, 10)],
}
SQUARE: Section = [(0, 0), (0, 10), (-100, 10), (-100, 0)]
WEBS: dict[str, Section] = {
    "half V in a tee": [(0, 0), (12, 13), (12, 80), (0, 80)],
    "square K": [(0, 0), (6, 6), (6, 80), (-6, 80), (-6, 6)],
    "K": [(0, 0), (6, 7), (6, 80), (-6, 80), (-6, 7)],
}
FLAT: Section = [(-90, 0), (90, 0), (90, -12), (-90, -12)]


def plates(one: Section, other: Section, gap: tuple[float, float]) -> BrepGraph:
    moved = [[(x + gap[0], 0.0, z + gap[1]) for x, z in one], [(x, 0.0, z) for x, z in other]]
    return graph_of(*(prism(corners, (0.0, LENGTH_MM, 0.0)) for corners in moved))


def accepted(graph: BrepGraph) -> list[Seam]:
    return [seam for seam in detect_seams(graph) if seam.accepted]


def require_welds(found: list[Seam], gap: float, words: tuple[JointType, WeldType]) -> None:
    """Require a weld along the line on either side of it, each turned to its own side."""
    assert [(seam.joint, seam.weld) for seam in found] == [words, words]
    for seam in found:
        assert seam.length_mm == pytest.approx(LENGTH_MM, rel=0, abs=1e-6)
        assert np.abs(seam.frames.p[:, [0, 2]]).max() <= gap + 1e-9
        if not 0.0 < gap < 0.5:  # within the usual gap, that of opposed bevels is from face to face
            assert seam.gap_mm == pytest.approx((gap, gap, gap), rel=0, abs=1e-6)
    assert found[0].frames.R[0, :, 2] @ found[1].frames.R[0, :, 2] < 0.3


@pytest.mark.parametrize("gap", few([0.0, 3.0, 0.4, 1.5], 2))
@pytest.mark.parametrize("name", list(RIGHT))
def test_a_groove_without_a_root_face_is_a_butt_weld_from_either_side(name: str, gap: float) -> None:
    left = SQUARE if name == "half V" else [(-x, z) for x, z in RIGHT[name]]
    require_welds(accepted(plates(RIGHT[name], left, (gap, 0.0))), gap, (JointType.BUTT, WeldType.GROOVE))


@pytest.mark.parametrize("gap", [0.0, 2.0])
@pytest.mark.parametrize("name", list(WEBS))
def test_a_web_that_is_bevelled_to_an_edge_is_welded_on_either_side(name: str, gap: float) -> None:
    require_welds(accepted(plates(WEBS[name], FLAT, (0.0, gap))), gap, (JointType.TEE, WeldType.FILLET))


@pytest.mark.parametrize("name", [*RIGHT, *WEBS])
def test_beyond_a_root_gap_there_is_no_joint(name: str) -> None:
    other = SQUARE if name == "half V" else [(-x, z) for x, z in RIGHT[name]] if name in RIGHT else FLAT
    gap = (3.6, 0.0) if name in RIGHT else (0.0, 3.6)
    assert detect_seams(plates({**RIGHT, **WEBS}[name], other, gap)) == ()


def test_a_plate_that_stands_on_its_edge_is_welded_where_it_is_open() -> None:
    c = np.sqrt(0.5)
    leaning = [(0.0, 0.0), (80 * c, 80 * c), (70 * c, 90 * c), (-10 * c, 10 * c)]
    found = detect_seams(plates(leaning, FLAT, (0.0, 0.0)))
    assert len(found) == 2  # under the plate, where no torch gets, and before its end
    assert [seam.frames.R[0, 0, 2] < 0 for seam in found if seam.accepted] == [True]


@pytest.mark.parametrize("gap", few([2.5, 0.0], 1))
def test_pipes_with_bevelled_ends_are_welded_from_outside(gap: float) -> None:
    outline = [(50, gap / 2), (58, gap / 2 + 5), (58, 100), (50, 100), (50, gap / 2)]
    pipes = [
        revolve(make_face(Plane.XZ * Polyline(*[(x, way * z) for x, z in outline])), Axis.Z) for way in (1.0, -1.0)
    ]
    found = accepted(to_brep([(str(k), pipe.solid().wrapped) for k, pipe in enumerate(pipes)]))
    assert [(seam.joint, seam.closed) for seam in found] == [(JointType.BUTT, True)]
    assert found[0].length_mm == pytest.approx(100 * np.pi, rel=1e-6)
    assert (np.einsum("ki,ki->k", found[0].frames.R[:, :2, 2], found[0].frames.p[:, :2]) > 0).all()


def test_planes_of_two_members_that_overlap_are_no_butt_joint() -> None:
    plate = cut(box(200, 200, 12, (-100, -100, 0)), cylinder(37, 12, (0, 0, 0), UP))
    tube = cut(cylinder(41, 90, (0, 0, 0), UP), cylinder(37, 90, (0, 0, 0), UP))  # into the plate, flush below
    flush = [seam for seam in detect_seams(graph_of(plate, tube)) if np.abs(seam.frames.p[:, 2]).max() < 1e-9]
    assert not any(seam.accepted for seam in flush)


def test_what_lies_beside_a_bevel_is_not_joined_to_it() -> None:
    chamfered = [(2, 0), (38, 0), (40, 2), (40, 30), (0, 30), (0, 2)]
    beside = [(-x - 4.0, z) for x, z in chamfered]
    assert detect_seams(plates(chamfered, beside, (0.0, 0.0))) == ()


@pytest.mark.parametrize("gap", [0.0, 2.0])
def test_a_blade_on_a_plate_is_not_welded(gap: float) -> None:
    blade = [(0, 0), (8, 40), (-8, 40)]  # 22.6 degrees
    assert detect_seams(plates(blade, FLAT, (0.0, gap))) == ()
