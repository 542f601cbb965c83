"""A seam for scripts: its frames in the forms that others use, and its curve as the kernel's own."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cad
import wpcal
from cad.samples.parts import SAMPLES
from tests.few import few
from wpcal.brep.graph import CurveKind
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import read_finished
from wpcal.seam import Seam

ROUND_OFF = 1e-12
ON_CURVE_MM = 1e-6
LENGTH_MM = 1e-6
PEG_MM = 15.0
FIXTURES = Path(__file__).parents[2] / "fixtures"
T_BASE_PART = RigidTransform.from_six_tuple([900.0, -100.0, 50.0, 0.1, -0.2, 0.3], target="base", source="part")


def pegs_on_a_plate() -> list[object]:
    """A peg upright on a plate, which it meets in a circle, and a slanted one, which it meets in an ellipse."""
    from build123d import Box, Cylinder, Pos, Rot

    plate = Pos(0, 0, -5) * Box(200, 100, 10)
    slanted = Pos(50, 0, 0) * (Rot(0, 30, 0) * Cylinder(12, 200)) & Pos(0, 0, 30) * Box(400, 400, 60)
    return [plate, Pos(-50, 0, 20) * Cylinder(PEG_MM, 40), slanted]


@pytest.fixture(scope="module", params=few(["lap", *sorted({*SAMPLES, "pegs"} - {"lap"})], 1))
def found(request: pytest.FixtureRequest) -> tuple[tuple[Seam, ...], object]:
    step = FIXTURES / request.param / f"{request.param}.step"
    part = pegs_on_a_plate() if request.param == "pegs" else step
    return cad.find_seams(cad.open_workpiece(part), wpcal.SeamOptions())


def to_matrix(location: object) -> np.ndarray:
    trsf = location.wrapped.Transformation()
    return np.array([[trsf.Value(i, j) for j in range(1, 5)] for i in range(1, 4)] + [[0.0, 0.0, 0.0, 1.0]])


def test_locations_and_planes_are_the_frames(found) -> None:
    for seam in found[0]:
        frames = seam.frames.moved(T_BASE_PART)
        locations, planes = cad.seam_locations(frames), cad.seam_planes(frames)
        assert len(locations) == len(planes) == len(frames)
        for matrix, location, plane in zip(frames.matrices, locations, planes, strict=True):
            np.testing.assert_allclose(to_matrix(location), matrix, rtol=0, atol=ROUND_OFF)
            axes = np.array([tuple(plane.x_dir), tuple(plane.y_dir), tuple(plane.z_dir)]).T
            np.testing.assert_allclose(axes, matrix[:3, :3], rtol=0, atol=ROUND_OFF)
            np.testing.assert_allclose(tuple(plane.origin), matrix[:3, 3], rtol=0, atol=ROUND_OFF)


def test_the_wire_is_the_seam(found) -> None:
    seams, workpiece = found
    assert seams
    for seam in seams:
        wire = cad.seam_wire(workpiece.graph, seam)
        assert wire.is_valid
        assert wire.is_closed == seam.closed
        assert wire.length == pytest.approx(seam.length_mm, rel=0, abs=LENGTH_MM)
        assert len(wire.edges()) == len(seam.pieces)
        off = [wire.distance_to(point) for point in map(tuple, seam.frames.p)]
        assert max(off) <= ON_CURVE_MM


def test_the_wire_runs_in_the_direction_of_travel_and_can_be_in_base(found) -> None:
    seams, workpiece = found
    for seam in seams:
        wire = cad.seam_wire(workpiece.graph, seam, T_BASE_PART)
        frames = seam.frames.moved(T_BASE_PART)
        np.testing.assert_allclose(tuple(wire.position_at(0)), frames.p[0], rtol=0, atol=ON_CURVE_MM)
        np.testing.assert_allclose(tuple(wire.position_at(1)), frames.p[-1], rtol=0, atol=ON_CURVE_MM)
        assert np.dot(tuple(wire.tangent_at(0)), frames.R[0, :, 0]) > 0.99
        share = frames.s_mm[len(frames) // 2] / seam.length_mm
        np.testing.assert_allclose(tuple(wire.position_at(share)), frames.p[len(frames) // 2], rtol=0, atol=ON_CURVE_MM)


def test_a_circle_and_an_ellipse_stay_what_they_are() -> None:
    from build123d import GeomType

    seams, workpiece = cad.find_seams(cad.open_workpiece(pegs_on_a_plate()), wpcal.SeamOptions())
    kinds = [{edge.geom_type for edge in cad.seam_wire(workpiece.graph, seam).edges()} for seam in seams]
    assert sorted(kinds, key=str) == [{GeomType.CIRCLE}, {GeomType.ELLIPSE}]


def test_a_gap_between_pieces_becomes_a_vertex_of_that_size() -> None:
    seams, workpiece = cad.find_seams(cad.open_workpiece(pegs_on_a_plate()), wpcal.SeamOptions())
    (seam,) = (s for s in seams if (workpiece.graph.edge_kind[s.pieces.edge] == CurveKind.CIRCLE).all())
    pieces, gap_mm = seam.pieces, 0.01
    turn = np.copysign(gap_mm / PEG_MM, pieces.t1[0] - pieces.t0[0])
    shorter = replace(pieces, t1=pieces.t1 - [turn, 0.0])
    wire = cad.seam_wire(workpiece.graph, replace(seam, pieces=shorter))
    assert wire.is_valid
    assert wire.is_closed
    assert wire.length == pytest.approx(seam.length_mm - gap_mm, rel=0, abs=LENGTH_MM)


def test_a_seam_from_a_file_has_no_curve() -> None:
    seam = read_finished(FIXTURES / "tee" / "golden").seams[0]
    workpiece = cad.open_workpiece(FIXTURES / "tee" / "tee.step")
    with pytest.raises(wpcal.WpcalError, match="seam W1 has no curve: it was read from a file"):
        cad.seam_wire(workpiece.graph, seam)
