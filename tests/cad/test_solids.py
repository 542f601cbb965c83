"""Solids, names and features of files as the kernel reads them."""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build123d import Box, Compound, Pos, Spline, export_step
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_CylindricalSurface, Geom_RectangularTrimmedSurface
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Ax3
from OCP.TopoDS import TopoDS_Edge

from cad.kernel.call import kernel_call, step_settings
from cad.kernel.canonical import recognise_surface
from cad.kernel.to_brep import curve_row, to_brep
from cad.kernel.topology import compound
from cad.samples.parts import box
from cad.step.read import read_step
from cad.step.solids import leaf_shapes
from cad.workpiece.features import list_features
from cad.workpiece.workpiece import open_workpiece
from wpcal.brep import CurveKind, SurfaceKind
from wpcal.core.errors import KernelError
from wpcal.taught.features import Ease, FeatureKind, HoleForm, feature_named


def solid_of(faces: list[Any]) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

    builder, shell, solid = BRep_Builder(), TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    builder.MakeSolid(solid)
    for face in faces:
        builder.Add(shell, face)
    builder.Add(solid, shell)
    return solid


def faces() -> list[Any]:
    from cad.kernel.topology import FACE, sub_shape_uses

    return [face for face, _ in sub_shape_uses(box(30, 20, 10, (0, 0, 0)), FACE)]


@pytest.mark.parametrize(
    ("solid", "codes"),
    [
        (solid_of(faces()), []),
        (solid_of(faces()[1:]), ["invalid-shape"]),
        (solid_of([faces()[0].Reversed(), *faces()[1:]]), ["invalid-shape"]),
    ],
    ids=["box", "open", "one face turned"],
)
def test_what_is_wrong_with_a_solid(solid: Any, codes: list[str]) -> None:
    found = leaf_shapes("plate", compound([solid]))
    assert [issue.code for issue in found.issues] == codes


def named(label: str, x: float) -> Compound:
    solid = (Pos(x, 0, 0) * Box(10, 10, 10)).solid()
    solid.label = label
    return solid


def test_the_nearest_product_with_a_given_name_names_a_body(tmp_path: Path) -> None:
    rail = Compound(label="left rail", children=[named("Pad001", 0), named("Boss-Extrude2", 20), named("stop", 40)])
    frame = Compound(label="frame", children=[rail, named("Body7", 60), named("foot", 80)])
    export_step(frame, str(tmp_path / "frame.step"))
    names = [solid.name for solid in read_step(tmp_path / "frame.step").solids]
    assert names == ["left rail", "left rail#2", "stop", "Body7", "foot"]  # the name of the whole part names no body


ROUND_OFF_MM = 1e-9  #: Coordinates of some hundred mm through a few products in double precision.
TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"


def test_nist_ftc_06_has_twelve_holes_and_eight_bosses(shared_step: Path) -> None:
    features = open_workpiece(shared_step / "nist_ftc_06_asme1_ap242-e2.stp").features
    kinds = Counter(feature.kind for feature in features)
    assert kinds[FeatureKind.BOSS] == 8
    holes = [feature for feature in features if feature.kind is FeatureKind.HOLE]
    assert Counter((hole.form, hole.is_through) for hole in holes) == {
        (HoleForm.COUNTERBORE, True): 10,
        (HoleForm.PLAIN, False): 2,
    }
    diameters = [step.diameter_mm / 25.4 for step in feature_named(features, "H1").steps]
    np.testing.assert_allclose(diameters, [0.625, 0.415], rtol=0, atol=ROUND_OFF_MM)


def test_the_easiest_come_first() -> None:
    judged, _ = list_features(TEE)
    assert [item.ease for item in judged] == sorted(item.ease for item in judged)
    assert {item.feature.kind for item in judged if item.ease is Ease.SHARP} == {FeatureKind.VERTEX, FeatureKind.HOLE}


def spline_of_a_cylinder(radius: float) -> object:
    whole = Geom_RectangularTrimmedSurface(Geom_CylindricalSurface(gp_Ax3(), radius), 0.2, 2.0, 0.0, 30.0)
    return GeomConvert.SurfaceToBSplineSurface_s(whole)


@pytest.mark.parametrize("is_trimmed", [False, True])
def test_a_cylinder_written_as_a_spline_is_recognised(is_trimmed: bool) -> None:
    surface = spline_of_a_cylinder(12.5)
    if is_trimmed:
        surface = Geom_RectangularTrimmedSurface(surface, 0.4, 1.5, 5.0, 25.0)
    face = BRepBuilderAPI_MakeFace(surface, 1e-6).Face()
    found = recognise_surface(face)
    assert found[0] == SurfaceKind.CYLINDER
    assert found[1].Radius() == pytest.approx(12.5, abs=1e-3)
    graph = to_brep([("part", face)])
    assert graph.face_kind.tolist() == [SurfaceKind.CYLINDER]
    assert np.isfinite(graph.face_param).all()


def test_a_piece_of_a_spline_too_short_to_be_cut_from_it_is_a_line() -> None:
    corners = [(0.0, 0.0, 0.0), (90.0, 10.0, 4.0), (120.0, 80.0, -6.0), (-20.0, 60.0, 3.0)]
    curve = BRep_Tool.Curve_s(Spline(corners, periodic=True).wrapped, 0.0, 1.0)
    edge, last = TopoDS_Edge(), curve.LastParameter()
    BRep_Builder().MakeEdge(edge, curve, 1e-3)
    BRep_Builder().Range(edge, last - 2e-9 * last, last)
    (kind, _, _), span, nurbs = curve_row(edge)
    assert (kind, nurbs) == (CurveKind.LINE, None)
    assert 0.0 < span[1] - span[0] < 1e-5


def unit() -> str:
    from OCP.Interface import Interface_Static

    return str(Interface_Static.CVal_s("write.step.unit"))


def test_settings_are_restored_after_use_and_after_an_exception() -> None:
    with step_settings({"write.step.unit": "MM"}):
        before = unit()
        with step_settings({"write.step.unit": "INCH", "write.step.schema": 5}):
            assert unit() == "INCH"
        assert unit() == before
        with pytest.raises(ZeroDivisionError), step_settings({"write.step.unit": "INCH"}):
            raise ZeroDivisionError
        assert unit() == before


@pytest.mark.parametrize("settings", [{"no.such.setting": 1}, {"write.step.unit": "PARSEC"}])
def test_a_setting_that_the_kernel_does_not_take_is_said(settings: dict[str, int | str]) -> None:
    with pytest.raises(KernelError, match=next(iter(settings))), step_settings(settings):
        pass


def test_an_exception_of_the_kernel_is_a_kernel_error() -> None:
    from OCP.gp import gp_Dir

    with pytest.raises(KernelError, match="drawing a line: the CAD kernel failed"), kernel_call("drawing a line"):
        gp_Dir(0.0, 0.0, 0.0)
