"""Surfaces that the kernel hands over as B-splines are recognised, also where another surface trims them."""

import numpy as np
import pytest
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_CylindricalSurface, Geom_RectangularTrimmedSurface
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Ax3

from cad.kernel.canonical import recognise_surface
from cad.kernel.to_brep import to_brep
from wpcal.brep import SurfaceKind


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
    assert found is not None
    assert found[0] == SurfaceKind.CYLINDER
    assert found[1].Radius() == pytest.approx(12.5, abs=1e-3)
    graph = to_brep([("part", face)])
    assert graph.face_kind.tolist() == [SurfaceKind.CYLINDER]
    assert np.isfinite(graph.face_param).all()
