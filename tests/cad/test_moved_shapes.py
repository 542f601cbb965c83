"""Shapes of a script after their bodies moved: each is where its touched corners are."""

import numpy as np
import pytest
from build123d import Box, Compound, Location, Pos

import cad
import wpcal
from cad.workpiece.calibrate import WorkpieceCalibration
from cad.workpiece.fit_taught import CalibrateOptions
from cad.workpiece.workpiece import Workpiece
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform

SIGMA_MM = 1e-4
NEAR_MM = 1e-3  #: The prior holds the bodies back by less than the stated error of the corners.
MOVED = (
    RigidTransform.from_six_tuple([800.0, -200.0, 150.0, 0.02, -0.01, 0.7], target="base", source="part"),
    RigidTransform.from_six_tuple([801.0, -200.5, 150.2, 0.022, -0.011, 0.702], target="base", source="part"),
    RigidTransform.from_six_tuple([799.5, -199.2, 150.6, 0.018, -0.008, 0.699], target="base", source="part"),
)


def plate_and_ribs() -> tuple[Box, Box, Box]:
    plate, left, right = (
        Pos(0, 0, -5) * Box(400, 300, 10),
        Pos(-90, 0, 40) * Box(8, 100, 80),
        Pos(90, 0, 40) * Box(8, 100, 80),
    )
    plate.label, left.label, right.label = "plate ü/1", "rib", "rib"
    return plate, left, right


def corners(shape: object) -> FloatArray:
    return np.array([tuple(vertex) for vertex in shape.vertices()])  # type: ignore[attr-defined]  # build123d


def calibrated(part: Workpiece) -> WorkpieceCalibration:
    names, points = [], []
    for solid, T in zip(part.graph.solid_names, MOVED, strict=True):
        for feature in [each for each in part.features if each.solid == solid and each.kind.name == "VERTEX"]:
            names.append(feature.name)
            points.append(T.apply(feature.p_mm[None])[0])
    options = CalibrateOptions(bodies=cad.BodiesOptions(), teaching=TeachingError(sigma_mm=SIGMA_MM))
    return cad.calibrate_workpiece(part, wpcal.TaughtPoints.of_features(names, points), options=options)


@pytest.mark.parametrize("as_assembly", [False, True])
def test_every_shape_is_where_its_body_is(as_assembly: bool) -> None:
    given = plate_and_ribs()
    inner = Compound(label="ribs", children=list(given[1:]))
    part = cad.open_workpiece(Compound(label="weldment", children=[given[0], inner]) if as_assembly else given)
    assert part.graph.solid_names == ("plate ü/1", "rib", "rib#2")
    shapes = calibrated(part).moved_shapes()
    if as_assembly:
        assert [shape.label for shape in shapes] == ["weldment"]
        shapes = list(shapes[0].children)
    assert [shape.label for shape in shapes] == ["plate ü/1", "rib", "rib"]
    for shape, model, T in zip(shapes, given, MOVED, strict=True):
        off_mm = corners(shape)[:, None] - T.apply(corners(model))
        assert np.linalg.norm(off_mm, axis=2).min(axis=1).max() < NEAR_MM


def test_the_name_of_an_assembly_is_that_of_parts_without_one() -> None:
    parts = [Box(10, 10, 10), Pos(20, 0, 0) * Box(10, 10, 10)]
    placed = Compound(label="feet", children=parts).located(Location((5, 0, 0)))
    assert cad.open_workpiece([placed]).graph.solid_names == ("feet", "feet#2")
